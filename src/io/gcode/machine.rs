//! A machine that follows G-code and remembers its strokes.

use super::arc::arc;
use super::words::{Words, words};
use super::{damaged, unsupported};
use crate::error::Result;
use crate::geometry::vector::Vec3;
use crate::io::accept;
use crate::io::rows::rows_fit;
use crate::io::toolpath::Toolpath;
use crate::notice::Notice;

/// Commands whose numbers are no place on a path: dwells, retraction, homing, probing, bed levelling, the origin.
const NO_PLACE: &[f64] = &[4.0, 10.0, 11.0, 28.0, 29.0, 30.0, 31.0, 32.0, 92.0];

/// Modes that may stand before a move on its line and leave the path as it is.
const MODES: &[f64] = &[
    15.0, 17.0, 20.0, 21.0, 40.0, 49.0, 50.0, 54.0, 61.0, 64.0, 69.0, 80.0, 90.0, 91.0, 91.1, 93.0, 94.0, 95.0, 97.0,
    98.0, 99.0,
];

/// How coordinates are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Absolute,
    Relative,
}

/// The path of a G-code file: its depositing moves, or its feed moves if it deposits nothing (milling).
///
/// Read are G0 to G3 with arcs in the xy plane (I J or R), G20, G21, G28, G90 to G92, M82 and M83. Commands that do not
/// move the tool along a path are passed over, with their numbers; those that move it in other ways, or change what
/// coordinates mean, are refused. Arcs become chords within 0.005 mm.
///
/// # Errors
/// [`Error::Damaged`](crate::Error::Damaged) naming the line of a bad number or arc; [`Error::Unsupported`](crate::Error::Unsupported) for arcs in other
/// planes, splines, cycles, other coordinates and rotary axes; [`Error::NoGeometry`](crate::Error::NoGeometry) without moves; [`Error::TooLarge`](crate::Error::TooLarge) beyond 2²⁶ corners.
///
/// # Source
/// ISO 6983-1:2009; the dialect of Marlin and RepRap printers for E, M82 and M83.
///
/// ```
/// let path = amcheck::io::gcode::read(b"G1 X0 Y0 F1800\nG1 X10 E1 ; a bead\nG0 Y5\nG1 X0 E2\n")?;
/// assert_eq!((path.strokes.len(), path.length_mm()), (2, 20.0));
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<Toolpath> {
    let mut machine = Machine::new();
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    for (number, line) in bytes.split(|&b| b == b'\n').enumerate() {
        machine.line(number as u64 + 1, line)?;
    }
    machine.finish()
}

/// Where the machine is, and what it has done.
struct Machine {
    /// World position, mm.
    at: Vec3,
    /// World position of the origin that coordinates are counted from.
    origin: Vec3,
    filament: f64,
    unit: f64,
    moves: Mode,
    extrusion: Mode,
    /// The last of G0 to G3, which stays in force on lines that name only coordinates.
    motion: Option<u32>,
    deposits: Strokes,
    feeds: Strokes,
}

/// Strokes under way: a move that starts where the last one ended goes on with it.
#[derive(Default)]
struct Strokes {
    done: Vec<Vec<Vec3>>,
    corners: usize,
    broken: bool,
}

impl Strokes {
    fn add(&mut self, from: Vec3, to: Vec3) -> Result<()> {
        if from == to {
            return Ok(());
        }
        rows_fit(self.corners, 24)?;
        match self.done.last_mut().filter(|_| !self.broken) {
            Some(stroke) if stroke.last() == Some(&from) => stroke.push(to),
            _ => self.done.push(vec![from, to]),
        }
        self.corners += 1;
        self.broken = false;
        Ok(())
    }
}

impl Machine {
    fn new() -> Self {
        Machine {
            at: [0.0; 3],
            origin: [0.0; 3],
            filament: 0.0,
            unit: 1.0,
            moves: Mode::Absolute,
            extrusion: Mode::Absolute,
            motion: None,
            deposits: Strokes::default(),
            feeds: Strokes::default(),
        }
    }

    fn line(&mut self, number: u64, line: &[u8]) -> Result<()> {
        let words = words(number, line)?;
        let mut motion = words.position().iter().any(Option::is_some).then_some(self.motion).flatten();
        for &(letter, code) in &words.commands {
            match (letter, code) {
                (b'G', 0.0 | 1.0 | 2.0 | 3.0) => motion = Some(code as u32),
                (b'G', _) => {
                    self.preparatory(number, code, &words)?;
                    if NO_PLACE.contains(&code) {
                        return Ok(());
                    }
                }
                (b'M', 82.0) => self.extrusion = Mode::Absolute,
                (b'M', 83.0) => self.extrusion = Mode::Relative,
                _ => {}
            }
        }
        match motion {
            Some(motion) => {
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
            18.0 | 19.0 => return Err(unsupported(line, "a plane of arcs other than xy")),
            90.1 => return Err(unsupported(line, "centres of arcs in absolute coordinates (G90.1)")),
            41.0..43.0 => return Err(unsupported(line, "a path beside the tool's (G41, G42)")),
            51.0 | 68.0..69.0 => return Err(unsupported(line, "turned or scaled coordinates (G51, G68)")),
            10.0 if words.get(b'L').is_some() => return Err(unsupported(line, "coordinates set by a table (G10 L)")),
            20.0 => self.unit = 25.4,
            21.0 => self.unit = 1.0,
            28.0 => self.home(words),
            90.0 => (self.moves, self.extrusion) = (Mode::Absolute, Mode::Absolute),
            91.0 => (self.moves, self.extrusion) = (Mode::Relative, Mode::Relative),
            92.0 => self.set_origin(words),
            _ if NO_PLACE.contains(&code) || MODES.contains(&code) => {}
            _ if words.position().iter().any(Option::is_some) => {
                return Err(unsupported(line, &format!("a move by G{code}")));
            }
            _ => {}
        }
        Ok(())
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
        if let Some(axis) = [b'A', b'B', b'C'].into_iter().find(|&axis| words.get(axis).is_some()) {
            return Err(unsupported(line, &format!("the axis {}", char::from(axis))));
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
        let pushed = words.get(b'E').map_or(0.0, |e| match self.extrusion {
            Mode::Absolute => e * self.unit - self.filament,
            Mode::Relative => e * self.unit,
        });
        self.filament += pushed;
        self.at = to;
        let chords = if motion < 2 {
            vec![to]
        } else {
            arc(line, from, to, if motion == 3 { 1.0 } else { -1.0 }, words, self.unit)?
        };
        let mut last = from;
        for corner in chords {
            if pushed > 0.0 {
                self.deposits.add(last, corner)?;
            }
            if motion > 0 {
                self.feeds.add(last, corner)?;
            }
            last = corner;
        }
        Ok(())
    }

    fn finish(self) -> Result<Toolpath> {
        let mut notices = Vec::new();
        let strokes = if self.deposits.done.is_empty() {
            if !self.feeds.done.is_empty() {
                notices.push(Notice::new("no-extrusion", "the G-code deposits nothing: all feed moves were read"));
            }
            self.feeds.done
        } else {
            self.deposits.done
        };
        Toolpath { strokes, notices }.with_strokes("the G-code")
    }
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
    fn only_what_deposits_is_a_stroke() {
        let p = path(
            "M82\nG28\nG92 E0\nG1 Z0.2\nG1 X10 Y0 E0\nN5 g1x20 e1.5*71\nG1 Y10 E2 ; on\nG1 E1\nG0 X0\nG1 E2\nG1 X5 E2.5\nX6 E3\n",
        );
        assert_eq!(
            p.strokes,
            [
                vec![[10.0, 0.0, 0.2], [20.0, 0.0, 0.2], [20.0, 10.0, 0.2]],
                vec![[0.0, 10.0, 0.2], [5.0, 10.0, 0.2], [6.0, 10.0, 0.2]]
            ]
        );
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
    fn probing_and_retraction_leave_the_path_alone() {
        let p = path("G1 X1 E1\nG29 X50 Y50\nG30 X9\nG10 S1\nG4 P200\nG1 X2 E2\nG17 G90 X3 E3\n");
        assert_eq!(p.strokes, [vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]]);
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
            ("G18\n", 1),
            ("G5 X1\n", 1),
            ("G5.1 X10 Y5 I2 J2\n", 1),
            ("G1 X10\nG90.1\nG3 X-10 I0 J0 E1\n", 2),
            ("G1 X10\nG3 X-10 Y0 I-3 J0 E1\n", 2),
            ("G1 X1\nG81 X20 Y20 Z-5 R1\n", 2),
            ("G10 L2 P1 X50\n", 1),
            ("G41\n", 1),
            ("G68 X0 Y0 R30\n", 1),
            ("G1 X1 A30\n", 1),
        ] {
            let e = read(text.as_bytes()).unwrap_err();
            assert_eq!(e.place(), Some(format!("line {line}")), "{text}: {e}");
        }
        assert!(matches!(read(b"; nothing\nG28\n"), Err(Error::NoGeometry { .. })));
    }
}
