//! Commands of firmware that are words, not letters with numbers.

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

#[cfg(test)]
mod tests {
    use super::*;

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
