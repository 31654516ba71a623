//! Commands of firmware that are words, not letters with numbers, and what it keeps beside the path.

use super::damaged;
use crate::error::Result;

/// What a line of Klipper's moves that coordinates are counted from, if it does: `SET_GCODE_OFFSET` with anything but zeros, and
/// `SET_KINEMATIC_POSITION`.
///
/// # Source
/// Klipper documentation, *G-Codes*, 2024.
pub(super) fn moves_origin(line: &[u8]) -> Option<&'static str> {
    let text = String::from_utf8_lossy(line).to_ascii_uppercase();
    let code = text.split(';').next().unwrap_or_default();
    let mut words = code.split_ascii_whitespace();
    match words.next()? {
        "SET_KINEMATIC_POSITION" => Some("another place of the machine (SET_KINEMATIC_POSITION)"),
        "SET_GCODE_OFFSET" => {
            let moves = |word: &str| {
                let (name, value) = word.split_once('=').unwrap_or((word, ""));
                let axis = ["X", "Y", "Z"].contains(&name.trim_end_matches("_ADJUST"));
                axis && value.parse() != Ok(0.0)
            };
            words.any(moves).then_some("another origin (SET_GCODE_OFFSET)")
        }
        _ => None,
    }
}

/// A line of Klipper's that keeps modes, origin and place, or takes them back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum State {
    Save(Vec<u8>),
    /// Whether the machine moves back to the place as well.
    Restore {
        name: Vec<u8>,
        moves: bool,
    },
}

/// What a line keeps or takes back: `SAVE_GCODE_STATE` and `RESTORE_GCODE_STATE`.
///
/// # Source
/// Klipper documentation, *G-Codes*, 2024.
pub(super) fn keeps_state(line: &[u8]) -> Option<State> {
    let text = String::from_utf8_lossy(line).to_ascii_uppercase();
    let code = text.split(';').next().unwrap_or_default();
    let mut words = code.split_ascii_whitespace();
    let command = words.next()?;
    let named: Vec<(&str, &str)> = words.filter_map(|word| word.split_once('=')).collect();
    let of = |name: &str| named.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
    let name = of("NAME").unwrap_or("DEFAULT").as_bytes().to_vec();
    match command {
        "SAVE_GCODE_STATE" => Some(State::Save(name)),
        "RESTORE_GCODE_STATE" => Some(State::Restore { name, moves: of("MOVE").is_some_and(|m| m != "0") }),
        _ => None,
    }
}

/// Whether an M command that moves an origin moves it: M428 always, the others by anything but zeros.
pub(super) fn moves_by(code: f64, line: &[u8]) -> bool {
    // Blanks between a letter and its number say nothing, nor need there be any between words.
    let text: String = String::from_utf8_lossy(line).to_ascii_uppercase().split_ascii_whitespace().collect();
    let words = text.split([';', '*', '(']).next().unwrap_or_default();
    let moves = |(at, _): (usize, &str)| {
        let by = words.get(at + 1..).unwrap_or_default();
        by.split(|c: char| c.is_ascii_alphabetic()).next().is_some_and(|by| by.parse() != Ok(0.0))
    };
    code == 428.0 || words.match_indices(['X', 'Y', 'Z', 'S']).any(moves)
}

/// Refuses a numbered line whose checksum, `*` and the exclusive or of the bytes before it, is another.
///
/// # Errors
/// [`Error::Damaged`](crate::Error::Damaged) naming the line.
pub(super) fn checksum(number: u64, line: &[u8]) -> Result<()> {
    let line = line.split(|&b| b == b';').next().unwrap_or_default();
    let numbered = line.trim_ascii_start().first().is_some_and(|b| b.eq_ignore_ascii_case(&b'N'));
    let Some(at) = line.iter().rposition(|&b| b == b'*').filter(|_| numbered) else { return Ok(()) };
    let (summed, told) = line.split_at(at);
    let told = String::from_utf8_lossy(told.get(1..).unwrap_or_default()).trim().parse::<u32>();
    let sum = |bytes: &[u8]| bytes.iter().fold(0, |sum, b| sum ^ u32::from(*b));
    match told {
        Ok(told) if told != sum(summed) && told != sum(summed.trim_ascii_start()) => {
            Err(damaged(number, format!("the checksum {told} of a line that has {}", sum(summed))))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_is_kept_by_its_name() {
        let restore = |name: &str, moves| Some(State::Restore { name: name.into(), moves });
        for (line, state) in [
            ("SAVE_GCODE_STATE", Some(State::Save("DEFAULT".into()))),
            ("save_gcode_state name=pause ; x", Some(State::Save("PAUSE".into()))),
            ("RESTORE_GCODE_STATE NAME=pause MOVE=1 MOVE_SPEED=60", restore("PAUSE", true)),
            ("RESTORE_GCODE_STATE MOVE=0", restore("DEFAULT", false)),
            ("G1 X1 ; SAVE_GCODE_STATE", None),
        ] {
            assert_eq!(keeps_state(line.as_bytes()), state, "{line}");
        }
    }

    #[test]
    fn false_checksums_are_refused_and_stars_elsewhere_are_none() {
        let sum = |text: &str| text.bytes().fold(0u8, |sum, b| sum ^ b);
        for text in ["N3 T0", "N5 G1 X20 E1.5"] {
            let right = format!("{text}*{}", sum(text));
            assert!(checksum(1, right.as_bytes()).is_ok() && checksum(1, format!("{right} ; 5*6").as_bytes()).is_ok());
            assert!(checksum(1, format!("{text}*{}", sum(text) ^ 1).as_bytes()).is_err());
        }
        assert!(checksum(1, b"G1 X1*99").is_ok() && checksum(1, b"N1 (2*3)").is_ok());
    }

    #[test]
    fn offsets_of_the_home_and_of_tools_move_unless_they_are_zero() {
        for (code, line, moves) in [
            (206.0, "M206 X1", true),
            (206.0, "M206 X0 Y0.0", false),
            (206.0, "N7 m206x0y-5 (home)", true),
            (206.0, "M206 X 0 (X5)", false),
            (218.0, "M218 T1 X20.5", true),
            (218.0, "M218 T1", false),
            (290.0, "M290 S0.05", true),
            (428.0, "M428", true),
        ] {
            assert_eq!(moves_by(code, line.as_bytes()), moves, "{line}");
        }
    }

    #[test]
    fn offsets_of_zero_move_nothing() {
        for (line, moves) in [
            ("SET_GCODE_OFFSET Z=0.2 MOVE=1", true),
            ("set_gcode_offset z_adjust=-0.05 ; lower", true),
            ("SET_GCODE_OFFSET X={x}", true),
            ("SET_GCODE_OFFSET X=0 Y=0.0 Z=0 MOVE=1", false),
            ("SET_GCODE_OFFSET_MACRO Z=1", false),
            ("SET_KINEMATIC_POSITION X=0", true),
            ("G1 X1 ; SET_GCODE_OFFSET Z=1", false),
            ("", false),
        ] {
            assert_eq!(moves_origin(line.as_bytes()).is_some(), moves, "{line}");
        }
    }
}
