//! A machine that follows G-code and remembers its strokes.

use super::arc::arc;
use super::firmware::{State, checksum, keeps_state, moves_by, moves_origin};
use super::kept::{Kept, Modes};
use super::strokes::Strokes;
use super::words::{Words, no_word, words};
use super::{damaged, unsupported};
use crate::error::{Error, Place, Result};
use crate::geometry::vector::Vec3;
use crate::io::accept;
use crate::io::sniff::plain_text;
use crate::io::toolpath::Toolpath;
use crate::notice::Notice;
use crate::units::Length;

/// Commands whose numbers are no place on a path: dwells, retraction, homing, probing, bed levelling and its trim, the origin.
const NO_PLACE: &[f64] = &[4.0, 10.0, 11.0, 28.0, 29.0, 29.1, 29.2, 30.0, 31.0, 32.0, 92.0, 380.0];

/// How files begin that hold G-code in other ways: the blocks of PrusaSlicer's `.bgcode`, and a package such as `.gcode.3mf`.
const NO_TEXT: [(&[u8], &str); 2] = [(b"GCDE", "binary G-code (.bgcode)"), (b"PK\x03\x04", "a package (.zip, .3mf)")];

/// Most whole turns of one arc.
const MOST_TURNS: f64 = 100.0;

/// Modes that may stand before a move on its line and leave the path as it is.
const MODES: &[f64] = &[
    15.0, 17.0, 20.0, 21.0, 40.0, 49.0, 50.0, 54.0, 61.0, 64.0, 69.0, 80.0, 90.0, 91.0, 91.1, 93.0, 94.0, 95.0, 97.0,
    98.0, 99.0,
];

/// How coordinates are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    Absolute,
    Relative,
}

/// The plane that arcs lie in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Plane {
    Xy,
    Other,
}

/// The path of a G-code file: its depositing moves, or its feed moves if it deposits nothing (milling).
///
/// Read are G0 to G3 with arcs in the xy plane (I J or R, of one turn at most; of P turns where they end over their start and deposit nothing), G20, G21, G28, G90 to G92, M82 and M83. Commands that do not
/// move the tool along a path are passed over, with their numbers; those that move it in other ways, or change what
/// coordinates mean, are refused. A G command of none of these kinds is passed over with a notice. Arcs become chords within 0.001 mm,
/// which the path tells.
///
/// E is relative where two of three firmwares take it so: Marlin goes by the last of G90, G91, M82 and M83, RepRapFirmware by the last of M82 and
/// M83, Klipper by that and by G91. Where they differ and a move depends on it, a notice says so.
///
/// # Errors
/// [`Error::Damaged`](crate::Error::Damaged) naming the line of a bad number or arc, or of a move with two numbers for one axis;
/// [`Error::Unsupported`](crate::Error::Unsupported) for arcs in other planes, splines, cycles, subprograms, other coordinates and rotary axes;
/// [`Error::NoGeometry`](crate::Error::NoGeometry) without moves; [`Error::TooLarge`](crate::Error::TooLarge) beyond 2²⁶ corners.
///
/// # Source
/// ISO 6983-1:2009; for E, M82 and M83 the G-code references of Marlin, Klipper (whose `G1` takes E to be relative under G91 or M83) and
/// RepRapFirmware, 2024.
///
/// ```
/// let path = amcheck::io::gcode::read(b"G1 X0 Y0 F1800\nG1 X10 E1 ; a bead\nG0 Y5\nG1 X0 E2\n")?;
/// assert_eq!((path.strokes.len(), path.length_mm()), (2, 20.0));
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<Toolpath> {
    for (magic, what) in NO_TEXT {
        if bytes.starts_with(magic) {
            let (what, place) = (format!("{what} for the text of G-code"), Place::Whole);
            return Err(Error::Unsupported {
                what,
                place,
                remedy: "let the slicer write text (.gcode), or take that out of it".into(),
            });
        }
    }
    let mut machine = Machine::new();
    let bytes = plain_text(bytes);
    // Lines end in a line feed, after a carriage return or not; or, throughout the file, in a carriage return alone.
    let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    for (number, line) in bytes.split(|&b| b == end).enumerate() {
        for part in line.split(|&b| b == b'\r') {
            machine.line(number as u64 + 1, part)?;
            if machine.ended {
                return machine.finish();
            }
        }
    }
    machine.finish()
}

/// Where the machine is, and what it has done.
pub(super) struct Machine {
    /// World position, mm.
    pub(super) at: Vec3,
    /// World position of the origin that coordinates are counted from.
    pub(super) origin: Vec3,
    pub(super) filament: f64,
    unit: f64,
    pub(super) moves: Mode,
    plane: Plane,
    /// The last of M82 and M83, if there was one.
    pub(super) extrusion: Option<Mode>,
    /// Whether Marlin takes E to be relative.
    pub(super) marlin: Mode,
    /// The first line whose deposit depends on the firmware, how it was taken, and in which it is otherwise.
    disputed: Option<(u64, Mode, &'static str)>,
    /// G commands that were passed over, each with its first line.
    passed_over: Vec<(f64, u64)>,
    /// Whether the program has ended: what follows in the file is none of it.
    ended: bool,
    /// The last of G0 to G3, which stays in force on lines that name only coordinates.
    motion: Option<u32>,
    deposits: Strokes,
    feeds: Strokes,
    /// Modes, origin, filament and place as `SAVE_GCODE_STATE` keeps them, by its name.
    pub(super) saved: Vec<(Vec<u8>, Kept)>,
    /// The modes of moves and of E that M120 of RepRapFirmware keeps, last in first out.
    pub(super) pushed: Vec<Modes>,
    /// Whether G60 has kept a place.
    has_place: bool,
}

impl Machine {
    fn new() -> Self {
        Machine {
            at: [0.0; 3],
            origin: [0.0; 3],
            filament: 0.0,
            unit: 1.0,
            moves: Mode::Absolute,
            plane: Plane::Xy,
            extrusion: None,
            marlin: Mode::Absolute,
            disputed: None,
            passed_over: Vec::new(),
            ended: false,
            motion: None,
            deposits: Strokes::default(),
            feeds: Strokes::default(),
            saved: Vec::new(),
            pushed: Vec::new(),
            has_place: false,
        }
    }

    fn line(&mut self, number: u64, line: &[u8]) -> Result<()> {
        let words = words(number, line)?;
        if calls(line) {
            return Err(unsupported(number, "a subprogram, branch or loop (O)"));
        }
        checksum(number, line)?;
        if let Some(what) = moves_origin(line) {
            return Err(unsupported(number, what));
        }
        match keeps_state(line) {
            Some(State::Save(name)) => self.save(name),
            Some(State::Restore { name, moves }) => self.restore(number, &name, moves)?,
            None => {}
        }
        let mut motion = words.go_on().then_some(self.motion).flatten();
        for &(letter, code) in &words.commands {
            match (letter, code) {
                (b'G', 0.0 | 1.0 | 2.0 | 3.0) => motion = Some(code as u32),
                (b'G', _) => {
                    self.preparatory(number, code, &words)?;
                    if NO_PLACE.contains(&code) {
                        return Ok(());
                    }
                }
                (b'M', 82.0) => self.extrude(Mode::Absolute),
                (b'M', 83.0) => self.extrude(Mode::Relative),
                (b'M', 2.0 | 30.0) => self.ended = true,
                (b'M', 120.0) => self.push_modes(),
                (b'M', 121.0) => self.pop_modes(number)?,
                (b'M', 206.0 | 218.0 | 290.0 | 428.0) if moves_by(code, line) => {
                    return Err(unsupported(number, &format!("another origin (M{code})")));
                }
                (b'M', 97.0 | 98.0) => return Err(unsupported(number, &format!("a subprogram (M{code})"))),
                _ => {}
            }
        }
        match motion {
            Some(motion) => {
                if let Some(stray) = words.stray {
                    return Err(no_word(number, stray, line));
                }
                self.motion = Some(motion);
                self.motion(number, motion, &words)
            }
            None => Ok(()),
        }
    }

    /// A G command that is no motion.
    fn preparatory(&mut self, line: u64, code: f64, words: &Words) -> Result<()> {
        match code {
            5.0..6.0 => return Err(unsupported(line, "a spline (G5)")),
            17.0 => self.plane = Plane::Xy,
            18.0 | 19.0 => self.plane = Plane::Other,
            90.1 => return Err(unsupported(line, "centres of arcs in absolute coordinates (G90.1)")),
            41.0..43.0 => return Err(unsupported(line, "a path beside the tool's (G41, G42)")),
            7.0 => return Err(unsupported(line, "diameters for radii (G7)")),
            16.0 => return Err(unsupported(line, "polar coordinates (G16)")),
            43.0..45.0 => return Err(unsupported(line, "an offset by the tool's length (G43, G44)")),
            52.0..54.0 | 55.0..60.0 => return Err(unsupported(line, "another origin (G52, G53, G55 to G59)")),
            70.0 | 71.0 => return Err(unsupported(line, "G70 or G71, a unit on some machines and a cycle on others,")),
            92.0 if b"XYZEABCUVW".iter().all(|&letter| words.get(letter).is_none()) => {
                return Err(unsupported(
                    line,
                    "a G92 without axes, which sets all to 0 on some machines and none on others,",
                ));
            }
            92.1 | 92.2 | 92.3 => return Err(unsupported(line, "an origin cancelled or restored (G92.1 to G92.3)")),
            51.0 | 68.0..69.0 => return Err(unsupported(line, "turned or scaled coordinates (G51, G68)")),
            10.0 if words.get(b'P').is_some() && words.position().iter().flatten().any(|&by| by != 0.0) => {
                return Err(unsupported(line, "an offset of a tool (G10 P)"));
            }
            60.0 => {
                self.has_place = true;
                self.pass_over(code, line);
            }
            61.0 if self.has_place => return Err(unsupported(line, "a move to a place that was kept (G61 after G60)")),
            10.0 if words.get(b'L').is_some() => return Err(unsupported(line, "coordinates set by a table (G10 L)")),
            20.0 => self.unit = 25.4,
            21.0 => self.unit = 1.0,
            28.0 => self.home(words),
            90.0 => (self.moves, self.marlin) = (Mode::Absolute, Mode::Absolute),
            91.0 => (self.moves, self.marlin) = (Mode::Relative, Mode::Relative),
            92.0 => self.set_origin(words),
            _ if NO_PLACE.contains(&code) || MODES.contains(&code) => {}
            _ if words.position().iter().any(Option::is_some) => {
                return Err(unsupported(line, &format!("a move by G{code}")));
            }
            _ => self.pass_over(code, line),
        }
        Ok(())
    }

    fn pass_over(&mut self, code: f64, line: u64) {
        if !self.passed_over.iter().any(|&(passed, _)| passed == code) {
            self.passed_over.push((code, line));
        }
    }

    fn extrude(&mut self, mode: Mode) {
        (self.extrusion, self.marlin) = (Some(mode), mode);
    }

    /// How two of three firmwares take E at least, and which takes it otherwise.
    fn mode_of_extrusion(&self) -> (Mode, Option<&'static str>) {
        let stated = self.extrusion.unwrap_or(Mode::Absolute);
        let klipper = if self.moves == Mode::Relative { Mode::Relative } else { stated };
        let all = [("Marlin", self.marlin), ("Klipper", klipper), ("RepRapFirmware", stated)];
        let relative = all.iter().filter(|f| f.1 == Mode::Relative).count();
        let mode = if relative >= 2 { Mode::Relative } else { Mode::Absolute };
        (mode, all.iter().find(|f| f.1 != mode).map(|f| f.0))
    }

    /// What a move pushes out of the nozzle, mm of filament; what has been pushed is kept as it is written, so that the same number again
    /// pushes nothing.
    fn push(&mut self, line: u64, words: &Words) -> f64 {
        let Some(e) = words.get(b'E').map(|e| e * self.unit) else { return 0.0 };
        let (mode, otherwise) = self.mode_of_extrusion();
        if let (None, Some(firmware)) = (self.disputed, otherwise) {
            self.disputed = Some((line, mode, firmware));
        }
        let before = self.filament;
        match mode {
            Mode::Absolute => {
                self.filament = e;
                e - before
            }
            Mode::Relative => {
                self.filament = before + e;
                e
            }
        }
    }

    /// Homing: the axes named, or all, are at zero; the stroke ends.
    fn home(&mut self, words: &Words) {
        let named = words.position();
        let all = named.iter().all(Option::is_none);
        for ((at, origin), axis) in self.at.iter_mut().zip(&mut self.origin).zip(named) {
            if all || axis.is_some() {
                (*at, *origin) = (0.0, 0.0);
            }
        }
        (self.deposits.broken, self.feeds.broken) = (true, true);
    }

    /// Calls the present place by other coordinates.
    fn set_origin(&mut self, words: &Words) {
        for ((at, origin), value) in self.at.iter().zip(&mut self.origin).zip(words.position()) {
            if let Some(value) = value {
                *origin = at - value * self.unit;
            }
        }
        if let Some(value) = words.get(b'E') {
            self.filament = value * self.unit;
        }
    }

    /// A move by G0 to G3.
    fn motion(&mut self, line: u64, motion: u32, words: &Words) -> Result<()> {
        if let Some(&axis) = b"ABCUVW".iter().find(|&&axis| words.get(axis).is_some()) {
            return Err(unsupported(line, &format!("the axis {}", char::from(axis))));
        }
        if let Some(letter) = words.twice {
            return Err(damaged(line, format!("a move with two numbers for {}", char::from(letter))));
        }
        if motion > 1 && self.plane == Plane::Other {
            return Err(unsupported(line, "an arc in another plane than xy (G18, G19)"));
        }
        let from = self.at;
        let mut to = from;
        for ((to, origin), value) in to.iter_mut().zip(self.origin).zip(words.position()) {
            if let Some(value) = value {
                *to = value * self.unit + if self.moves == Mode::Absolute { origin } else { *to };
            }
        }
        if let Some(problem) = accept::point_problem(to) {
            return Err(damaged(line, problem));
        }
        let pushed = self.push(line, words);
        let turns = words.get(b'P').filter(|&turns| motion > 1 && turns != 0.0);
        // Circles before the arc in Marlin, turns altogether in LinuxCNC: the same where nothing is left for the arc, but for what is deposited.
        let told = |turns: f64| turns.fract() == 0.0 && (1.0..=MOST_TURNS).contains(&turns);
        if turns.is_some_and(|turns| pushed > 0.0 || from[..2] != to[..2] || !told(turns)) {
            return Err(unsupported(line, "the turns of an arc (P)"));
        }
        self.at = to;
        let (chords, beside) = if motion < 2 {
            (vec![to], 0.0)
        } else {
            let turns = if motion == 3 { 1.0 } else { -1.0 } * turns.unwrap_or(1.0);
            arc(line, from, to, turns, words, self.unit)?
        };
        let mut last = from;
        for corner in chords {
            for strokes in self.strokes_of(motion, pushed) {
                strokes.add(last, corner, beside)?;
            }
            last = corner;
        }
        Ok(())
    }

    /// The strokes that a motion is part of.
    fn strokes_of(&mut self, motion: u32, pushed: f64) -> impl Iterator<Item = &mut Strokes> {
        let deposits = (pushed > 0.0).then_some(&mut self.deposits);
        deposits.into_iter().chain((motion > 0).then_some(&mut self.feeds))
    }

    fn finish(self) -> Result<Toolpath> {
        let mut notices = Vec::new();
        if let Some((line, mode, otherwise)) = self.disputed {
            let [taken, other] = match mode {
                Mode::Absolute => ["absolute", "relative"],
                Mode::Relative => ["relative", "absolute"],
            };
            let text =
                format!("line {line}: E was taken to be {taken}, as most firmwares do; in {otherwise} it is {other}");
            notices.push(Notice::new("extrusion-mode", text));
        }
        if let Some(&(_, first)) = self.passed_over.first() {
            let codes: Vec<String> = self.passed_over.iter().map(|(code, _)| format!("G{code}")).collect();
            let text =
                format!("passed over, as no motion that is known here: {} (first in line {first})", codes.join(", "));
            notices.push(Notice::new("passed-over", text));
        }
        let strokes = if self.deposits.done.is_empty() {
            if !self.feeds.done.is_empty() {
                notices.push(Notice::new("no-extrusion", "the G-code deposits nothing: all feed moves were read"));
            }
            self.feeds
        } else {
            self.deposits
        };
        Toolpath { strokes: strokes.done, beside: Length::mm(strokes.beside), notices }.with_strokes("the G-code")
    }
}

/// Whether a line begins with an O that is more than the number of a program.
fn calls(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    let Some((b'O' | b'o', rest)) = line.split_first() else { return false };
    let rest = rest.trim_ascii_start();
    let digits = rest.iter().position(|b| !b.is_ascii_digit()).unwrap_or(rest.len());
    let after = rest.get(digits..).unwrap_or_default().trim_ascii();
    !(digits > 0 && (after.is_empty() || after.starts_with(b"(") || after.starts_with(b";")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;
    use crate::io::gcode::arc::SAGITTA;

    fn path(text: &str) -> Toolpath {
        read(text.as_bytes()).unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    #[test]
    fn a_state_that_is_taken_back_leaves_the_path_where_it_was() {
        let pause = "G90\nM82\nG1 X0 Y0 Z0.2\nG1 X10 E1\nSAVE_GCODE_STATE NAME=p\nG91\nG1 Z5\nG1 X3 E-2\n";
        let row = vec![vec![[0.0, 0.0, 0.2], [10.0, 0.0, 0.2], [30.0, 0.0, 0.2]]];
        assert_eq!(path(&format!("{pause}RESTORE_GCODE_STATE NAME=p MOVE=1\nG1 X30 E2\n")).strokes, row);
        // Without a move the nozzle stays, and goes on from there.
        let stays = path(&format!("{pause}RESTORE_GCODE_STATE NAME=p\nG1 X30 E2\n"));
        assert_eq!(stays.strokes[1], [[13.0, 0.0, 5.2], [30.0, 0.0, 5.2]]);
        for text in [
            "G1 X1 E1\nRESTORE_GCODE_STATE NAME=p\n",
            "M120\nG91\nM121\nG1 X1 E1\n",
            "M206 X5\nG1 X1 E1\n",
            "M218 T1 X20\nG1 X1 E1\n",
            "G10 P1 X20\nG1 X1 E1\n",
            "G60\nG1 X1 E1\nG61 X\n",
        ] {
            assert!(matches!(read(text.as_bytes()), Err(Error::Unsupported { .. })), "{text}");
        }
        assert_eq!(path("M120\nG1 X1 E1\nM121\nG10 P1 S200\nG61\nG1 X2 E2\n").strokes.len(), 1);
        for bytes in [&b"GCDE\x01\0\0\0"[..], b"PK\x03\x04"] {
            assert!(read(bytes).unwrap_err().to_string().contains("for the text of G-code"));
        }
    }

    #[test]
    fn arcs_that_deposit_nothing_do_not_blur_what_is_deposited() {
        let lift = path("G1 X0 Y0 Z0.2\nG1 X10 E1\nG3 X10 Y0 Z0.6 I2 J0\nG1 Z0.2\nG1 X20 E2\n");
        assert_eq!((lift.strokes.len(), lift.beside.as_mm()), (1, 0.0));
        assert!(path("G1 X0 Y0\nG2 X2 Y0 I1 J0 E1\n").beside.as_mm() > 0.0);
    }

    #[test]
    fn only_what_deposits_is_a_stroke() {
        let p = path(
            "M82\nG28\nG92 E0\nG1 Z0.2\nG1 X10 Y0 E0\nN5 g1x20 e1.5*24\nG1 Y10 E2 ; on\nG1 E1\nG0 X0\nG1 E2\nG1 X5 E2.5\nX6 E3\n",
        );
        assert_eq!(
            p.strokes,
            [
                vec![[10.0, 0.0, 0.2], [20.0, 0.0, 0.2], [20.0, 10.0, 0.2]],
                vec![[0.0, 10.0, 0.2], [5.0, 10.0, 0.2], [6.0, 10.0, 0.2]]
            ]
        );
        assert_eq!(path("G18\nG1 X1 E1\nG17\nG2 X2 I0.5 E2\n").strokes.len(), 1);
        let relative = path("G91\nG1 X1 E1\nG1 Y1 E1\nG90\nG1 X0 E0\n");
        assert_eq!((relative.strokes.len(), relative.length_mm()), (1, 2.0));
        let inches = path("G20\nG1 X1 E1\n");
        assert_eq!(inches.length_mm(), 25.4);
        let shifted = path("G1 X5 Y5\nG92 X0 Y0\nG1 X1 Y0 E1\n");
        assert_eq!(shifted.strokes, [vec![[5.0, 5.0, 0.0], [6.0, 5.0, 0.0]]]);
    }

    #[test]
    fn milling_is_read_by_its_feeds_and_messages_do_not_move() {
        let p =
            path("%\n(a pocket)\nG17 G21 G90\nM117 X5 Y5\nSTART_PRINT E=1\nG0 X1\nG1 X2 F100\nM3 S1000\nG1 X2 Y2\n");
        assert_eq!((p.strokes.len(), p.length_mm(), p.notices[0].code.as_str()), (1, 3.0, "no-extrusion"));
    }

    #[test]
    fn what_has_been_pushed_out_is_what_was_written() {
        let p = path("G92 E0\nG1 E-1.42\nG1 X10 E0.76521\nG1 Y50 E0.76521\nG1 X20 E5\n");
        assert_eq!((p.strokes.len(), p.length_mm()), (2, 20.0));
        // Lines that name only E, or only the centre of an arc, go on with the motion.
        assert_eq!(path("G1 X10 E1\nE2\nX20 E2\nX25 E3\n").strokes.len(), 2);
        let circles = path("G1 X10\nG3 X10 Y0 I-5 J0 E1\nI-3 J0 E2\nP0 I-3 J0 E3\n").length_mm();
        assert!((circles - 22.0 * std::f64::consts::PI).abs() < 0.1, "{circles}");
        // Numbers of other commands do not.
        assert_eq!(path("G1 X10 E1\nM201 E5\nM106 S3 E9\nX20 E2\n").length_mm(), 20.0);
    }

    #[test]
    fn probing_and_retraction_leave_the_path_alone() {
        let p = path("G1 X1 E1\nG29 X50 Y50\nG29.1 Z0.02\nG30 X9\nG10 S1\nG4 P200\nG1 X2 E2\nG17 G90 X3 E3\n");
        assert_eq!(p.strokes, [vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]]);
    }

    #[test]
    fn a_spiral_lift_and_a_bed_that_is_felt_for_deposit_nothing() {
        let lifted = path("M83\nG1 X10 Z0.2 E1\nG2 Z0.6 I1.2 J0 P1 F60000\nG380 S2 Z30 F1200\nG1 Y5 E1\n");
        let ends = [[0.0; 3], [10.0, 0.0, 0.2], [10.0, 5.0, 0.6]];
        assert_eq!((lifted.strokes[0][1], lifted.strokes[1].last()), (ends[1], Some(&ends[2])));
        assert_eq!(lifted.strokes.len(), 2);
        // Milled, a helix has as many turns as are told.
        let [once, thrice] =
            [1, 3].map(|turns| path(&format!("G1 X1\nG3 X1 Y0 Z-3 I-1 J0 P{turns} F100\n")).length_mm() - 1.0);
        let helix = |turns: f64| (2.0 * std::f64::consts::PI * turns).hypot(3.0);
        assert!((once - helix(1.0)).abs() < 0.01 && (thrice - helix(3.0)).abs() < 0.03, "{once} {thrice}");
    }

    #[test]
    fn macros_whose_names_begin_like_words_are_no_moves() {
        let plain = path("G1 X1 E1\nG1 X2 E2\n");
        for name in ["E3D_PURGE", "Y2_TEST", "N7 Y2_TEST A=1", "e3d_purge X=5", "X9Y ; a macro", "E3D"] {
            assert_eq!(path(&format!("G1 X1 E1\n{name}\nG1 X2 E2\n")), plain, "{name}");
        }
    }

    #[test]
    fn lines_end_as_they_do_on_any_system_and_machine_words_may_stand_before_a_move() {
        let lines = ["M83", "G1 X1 E1", "M8 G1 X2 E1", "M117 G1 X9 E1", "G1 Y1 E1"];
        let expected = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0]];
        for end in ["\n", "\r\n", "\r"] {
            assert_eq!(path(&lines.join(end)).strokes, std::slice::from_ref(&expected), "{end:?}");
        }
        assert_eq!(read(b"G1 X1 E1\rG1 X1,5\r").unwrap_err().place(), Some("line 2".into()));
        assert_eq!(path("G1 X1 E1\nG1 X2 E2\rG1 X3 E3\n").length_mm(), 3.0);
        assert_eq!(path("G1 X 1 E 1\ng 1\ty\t2e +2\n").strokes, [vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0]]]);
    }

    #[test]
    fn where_firmwares_differ_on_e_the_reading_is_said() {
        let codes = |text: &str| path(text).notices.into_iter().map(|n| n.code).collect::<Vec<_>>();
        // M83 stands: the second move deposits too.
        let kept = path("M83\nG91\nG1 X1 E1\nG90\nG1 X5 E1\n");
        assert_eq!((kept.length_mm(), kept.notices.len()), (5.0, 1));
        let said = "line 5: E was taken to be relative, as most firmwares do; in Marlin it is absolute";
        assert_eq!(kept.notices[0].message, said);
        // Under G91 alone, and under M82 before it, all but RepRapFirmware extrude 1 mm twice.
        for text in ["G91\nG1 X1 E1\nG1 X1 E1\n", "M82\nG90\nG1 X0 E0\nG91\nG1 X1 E1\nG1 X1 E1\n"] {
            let relative = path(text);
            assert_eq!((relative.length_mm(), codes(text)), (2.0, vec!["extrusion-mode".to_string()]), "{text}");
            assert!(relative.notices[0].message.ends_with("in RepRapFirmware it is absolute"), "{text}");
        }
        for agreed in
            ["G90\nM83\nG1 X1 E1\n", "M82\nG90\nG1 X1 E1\n", "G91\nG1 Z1\nG90\nG1 X1 E1\n", "G91\nM83\nG1 X1 E1\n"]
        {
            assert!(codes(agreed).is_empty(), "{agreed}");
        }
    }

    #[test]
    fn what_is_passed_over_is_said_once_with_its_place() {
        let p = path("O1234 (a program)\nG1 X1 E1\nG12\nG12\nG1 X2 E2\nG27\n");
        assert_eq!((p.length_mm(), p.notices.len()), (2.0, 1));
        assert!(p.notices[0].message.contains("G12, G27 (first in line 3)"), "{:?}", p.notices);
    }

    #[test]
    fn a_program_ends_where_it_says_so() {
        for end in ["M2", "M30", "M30 (end)", "M02"] {
            assert_eq!(path(&format!("G1 X10 E1\n{end}\nG1 X30 E2\n")).length_mm(), 10.0, "{end}");
        }
        assert_eq!(path("G1 X10 E1\nM3\nM300\nG1 X30 E2\n").length_mm(), 30.0);
    }

    #[test]
    fn arcs_become_chords_of_the_right_length() {
        let half = std::f64::consts::PI * 10.0;
        for (text, length) in [
            ("G1 X10\nG3 X-10 Y0 I-10 J0 E1\n", half),
            ("G1 X10\nG2 X-10 Y0 I-10 J0 E1\n", half),
            ("G1 X10\nG3 X10 Y0 I-10 J0 E1\n", 2.0 * half),
            ("G1 X10\nG3 X0 Y10 R10 E1\n", 0.5 * half),
            ("G1 X10\nG3 X0 Y10 R-10 E1\n", 1.5 * half),
        ] {
            let p = path(text);
            // Chords within the sagitta s of radius r are short by a share of s/(3r) at most.
            let found = p.length_mm();
            assert!(found <= length + 1e-9 && found > length * (1.0 - SAGITTA / 30.0) - 1e-9, "{text}: {found}");
            let off =
                |c: &Vec3| (c[0].hypot(c[1]) - 10.0).abs() > 1e-9 && (c[0] - 10.0).hypot(c[1] - 10.0) - 10.0 > 1e-9;
            assert!(!p.strokes.iter().flatten().any(off), "{text}");
        }
        // Counter-clockwise from +x passes +y.
        assert!(path("G1 X10\nG3 X-10 Y0 I-10 J0 E1\n").strokes[0].iter().any(|c| c[1] > 9.9));
    }

    #[test]
    fn faults_name_their_line() {
        for (text, line) in [
            ("G1 X0\nG1 X1,5 E1\n", 2),
            ("G1 Xabc\n", 1),
            ("G1 X9999999999999999\n", 1),
            ("G2 X1 Y1\n", 1),
            ("G1 X0\nG3 X10 R1 E1\n", 2),
            ("G18\nG1 X1 E1\nG2 X2 I0.5 E2\n", 3),
            ("G1 X1 E1\nSET_GCODE_OFFSET Z=0.2\n", 2),
            ("G5 X1\n", 1),
            ("G5.1 X10 Y5 I2 J2\n", 1),
            ("G1 X10\nG90.1\nG3 X-10 I0 J0 E1\n", 2),
            ("G1 X10\nG3 X-10 Y0 I-3 J0 E1\n", 2),
            ("G1 X1\nG81 X20 Y20 Z-5 R1\n", 2),
            ("G10 L2 P1 X50\n", 1),
            ("G41\n", 1),
            ("G68 X0 Y0 R30\n", 1),
            ("G1 X1 A30\n", 1),
            ("G1 X1 U30\n", 1),
            ("G1 X1 Z0\nG3 X1 Y0 I-1 J0 Z4 P4 E1\n", 2),
            ("G92 X5\nG92.1\n", 2),
            ("G1 X1 E1\nG92\n", 2),
            ("G1 X1 E1\nG16\n", 2),
            ("G43 H1\n", 1),
            ("G55\n", 1),
            ("G59.3\n", 1),
            ("G70\n", 1),
            ("M98 P100\n", 1),
            ("G1 X1\no<loop> while [#1 LT 5]\n", 2),
            ("O100 call\n", 1),
            ("G1 X1 X2 E1\n", 1),
            // In Marlin a circle before the arc, in LinuxCNC the arc's own turn.
            ("G1 X1\nG3 X-1 Y0 I-1 J0 P1\n", 2),
            ("G1 X1\nG2 I-1 J0 P0.5\n", 2),
            ("G1 X1\nG2 I-1 J0 P1000\n", 2),
            ("G1 X1 E1\nX1,5 E2\n", 2),
            ("G1 X1 E1\nX5 Y2_TEST\n", 2),
        ] {
            let e = read(text.as_bytes()).unwrap_err();
            assert_eq!(e.place(), Some(format!("line {line}")), "{text}: {e}");
        }
        assert!(matches!(read(b"; nothing\nG28\n"), Err(Error::NoGeometry { .. })));
    }
}
