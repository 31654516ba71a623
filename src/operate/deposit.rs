//! What a toolpath leaves behind, and how that departs from the design it came from.

use super::operated::Operated;
use super::shape::{checked, with_surface};
use crate::error::Result;
use crate::field::Indicator;
use crate::geometry::vector::bounds;
use crate::geometry::{InsideRule, Primitive, TriangleMesh, voxelize};
use crate::grid::Grid;
use crate::io::toolpath::Toolpath;
use crate::morphology::{Sandwich, Sides, deposit as deposited, deposit_surface};
use crate::units::{Length, Volume};

/// A deposited shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Deposit {
    /// Its surface and its volume.
    pub shape: Operated,
    /// Its samples and cubes.
    pub sides: Sides,
}

/// Where a deposited shape departs from its design; each as estimate, lower and upper bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Departure {
    /// Volume of the design that no bead covers: under-deposition.
    pub missing: [Volume; 3],
    /// Volume of the beads outside the design: over-deposition.
    pub over: [Volume; 3],
}

/// What a bead deposits along a path, `∪ { p + B }`: the support of δ on the path convolved with the bead.
///
/// Its surface lies where the distance to the bead on its way vanishes, whatever the phase of the lattice; what its volume is certainly, and what lies
/// in it or not, is told by samples and cubes. The bead is centred on the path. A nozzle's path runs along the top of what it deposits, so a bead of G-code hangs
/// below it: lower its strokes by half its height first.
///
/// # Errors
/// As [`crate::morphology::deposit()`]; [`crate::Error::NoGeometry`] where the spacing is too large to see the bead.
///
/// # Cost
/// As there, and the surface.
///
/// ```
/// use amcheck::{geometry::Primitive, io::gcode, operate::deposit, units::Length};
/// let path = gcode::read(b"G1 Z0.2\nG1 X0 Y0\nG1 X5 E1\nG1 Y3 E2\n")?;
/// let made = deposit(&path, &Primitive::parse("cylinder:r0.25h0.2mm")?, Length::mm(0.05))?;
/// // Two legs of 5 mm and 3 mm, round ends, once the common corner.
/// let truth = 0.2 * (0.5 * 8.0 + std::f64::consts::PI * 0.25 * 0.25 * 1.25 - 0.25 * 0.25);
/// let [low, high] = made.shape.bracket.map(|v| v.as_mm3());
/// assert!(low < truth && truth < high);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn deposit(path: &Toolpath, bead: &Primitive, spacing: Length) -> Result<Deposit> {
    // The lowest face of the deposit lies on faces of cubes, and with it every layer that is a multiple of the spacing.
    let lowest = bounds(path.strokes.iter().flatten().copied()).map_or(0.0, |(lo, _)| lo[2] - bead.half_extent()[2]);
    let phase = [0.25, 0.25, (lowest / spacing.as_mm() + 0.5).rem_euclid(1.0)];
    let sides = deposited(&path.strokes, bead, spacing, (phase, path.beside))?;
    let volume = [sides.full.volume(), sides.touched.volume()];
    let same = Sandwich { lower: sides.points.clone(), upper: sides.points.clone(), volume, paths: Vec::new() };
    let mesh = deposit_surface(&path.strokes, bead, &sides)?;
    let shape = with_surface(same, mesh, sides.points.clone(), "exact distances along the path".into());
    Ok(Deposit { shape: checked("deposit", shape)?, sides })
}

impl Deposit {
    /// Where the deposit departs from a design in the same frame.
    ///
    /// # Errors
    /// As [`voxelize()`].
    ///
    /// # Cost
    /// One cast of the design.
    pub fn departure(&self, design: &TriangleMesh) -> Result<Departure> {
        let own = self.sides.points.grid();
        let grid = around(own, design)?;
        let solid = voxelize(design, &grid, InsideRule::Crossings)?;
        let first = [0, 1, 2].map(|a| ((own.origin()[a] - grid.origin()[a]) / grid.h()).round() as isize);
        let placed = |set: &Indicator| set.placed(first.map(|i| -i), grid);
        let Sides { full, points, touched } = &self.sides;
        let [full, points, touched] = [placed(full)?, placed(points)?, placed(touched)?];
        let without = |a: &Indicator, b: &Indicator| Ok(a.difference(b)?.volume());
        Ok(Departure {
            missing: [
                without(&solid.centres, &points)?,
                without(&solid.inner, &touched)?,
                without(&solid.outer, &full)?,
            ],
            over: [without(&points, &solid.centres)?, without(&full, &solid.outer)?, without(&touched, &solid.inner)?],
        })
    }
}

/// The lattice of a grid, wide enough for a mesh as well.
fn around(grid: &Grid, mesh: &TriangleMesh) -> Result<Grid> {
    let Some((lo, hi)) = mesh.bounds() else { return Ok(*grid) };
    let (lo, hi) = (grid.continuous_index(lo), grid.continuous_index(hi));
    let last = grid.dims().map(|n| n as f64 - 1.0);
    let before = [0, 1, 2].map(|a| (2.0 - lo[a]).max(0.0).ceil() as usize);
    let after = [0, 1, 2].map(|a| (hi[a] + 2.0 - last[a]).max(0.0).ceil() as usize);
    grid.padded(before, after)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::gcode;

    /// A block of 12 × 8 × 2 mm with its lowest corner at the origin, and the G-code of its solid layers: lines of
    /// 0.5 mm a line width apart, from wall to wall, 0.25 mm layers.
    fn block() -> (TriangleMesh, String) {
        let mesh = Primitive::parse("box:12x8x2mm").unwrap().mesh(Length::mm(1.0));
        let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut code = String::from("G21\nG90\nM83\n");
        for layer in 1..=8 {
            code += &format!("G0 Z{}\n", 0.25 * f64::from(layer));
            for line in 0..16 {
                let y = 0.25 + 0.5 * f64::from(line);
                code += &format!("G0 X0.25 Y{y}\nG1 X11.75 E1\n");
            }
        }
        (mesh.transformed(still, [6.0, 4.0, 1.0]), code)
    }

    fn laid(code: &str, bead: &str, height: f64) -> Deposit {
        let mut path = gcode::read(code.as_bytes()).unwrap();
        path.strokes.iter_mut().flatten().for_each(|p| p[2] -= 0.5 * height);
        deposit(&path, &Primitive::parse(bead).unwrap(), Length::mm(0.05)).unwrap()
    }

    fn encloses([estimate, low, high]: [Volume; 3], truth: f64) -> f64 {
        let [estimate, low, high] = [estimate, low, high].map(|v| v.as_mm3());
        assert!(low <= truth + 1e-6 && truth <= high + 1e-6, "{truth} not in {low} … {high}");
        assert!(low <= estimate && estimate <= high);
        estimate
    }

    #[test]
    fn square_beads_from_wall_to_wall_fill_the_design() {
        let (design, code) = block();
        let made = laid(&code, "box:0.5x0.5x0.25mm", 0.25);
        let [low, high] = made.shape.bracket.map(|v| v.as_mm3());
        assert!(low <= 192.0 && 192.0 <= high, "{low} … {high}");
        let departure = made.departure(&design).unwrap();
        assert!(encloses(departure.missing, 0.0) < 1e-9 && encloses(departure.over, 0.0) < 1e-9);
    }

    #[test]
    fn round_beads_miss_what_their_ends_leave_open() {
        let (design, code) = block();
        let made = laid(&code, "cylinder:r0.25h0.25mm", 0.25);
        // 16 lines × 2 ends × 8 layers, each short of a square by r²·(2 − π/2).
        let open = 16.0 * 2.0 * 2.0 * 0.0625 * (2.0 - std::f64::consts::PI / 2.0);
        let departure = made.departure(&design).unwrap();
        let missing = encloses(departure.missing, open);
        assert!((missing / open - 1.0).abs() < 0.1, "{missing} {open}");
        assert!(encloses(departure.over, 0.0) < 1e-9);
    }

    #[test]
    fn a_stroke_lies_where_it_is_at_any_turn_and_spacing() {
        // 20 mm long, round ends of 0.2 mm, 0.2 mm high; a box of the same width leaves its corners.
        let round = 0.2 * (20.0 * 0.4 + std::f64::consts::PI * 0.04);
        for degrees in [0.0f64, 30.0, 45.0, 77.0] {
            let (s, c) = degrees.to_radians().sin_cos();
            let code = format!("G0 X0.113 Y-0.029 Z0.2\nG1 X{:.9} Y{:.9} E1\n", 0.113 + 20.0 * c, -0.029 + 20.0 * s);
            let square = 0.2 * (20.0 * 0.4 * (s + c) + 0.16);
            for (bead, volume) in [("cylinder:r0.2h0.2mm", round), ("box:0.4x0.4x0.2mm", square)] {
                for h in [0.05, 0.0371] {
                    let path = gcode::read(code.as_bytes()).unwrap();
                    let made = deposit(&path, &Primitive::parse(bead).unwrap(), Length::mm(h)).unwrap().shape;
                    let [low, high] = made.bracket.map(|v| v.as_mm3());
                    assert!(low < volume && volume < high, "{bead}, {degrees}, {h}: {volume} not in {low} … {high}");
                    let off = made.volume.as_mm3() / volume - 1.0;
                    assert!(off.abs() < 0.002, "{bead}, {degrees}, {h}: {:?} for {volume}, {off}", made.volume);
                    let (lo, hi) = made.mesh.bounds().unwrap();
                    let ends = [[-0.087, 20.0 * c + 0.313], [-0.229, 20.0 * s + 0.171], [0.1, 0.3]];
                    let far = (0..3).map(|a| (lo[a] - ends[a][0]).abs().max((hi[a] - ends[a][1]).abs()));
                    let far = far.fold(0.0, f64::max);
                    assert!(far < 0.05 * h, "{bead}, {degrees}, {h}: {far} off");
                    assert_eq!(made.crossings().count, 0, "{bead}, {degrees}, {h}");
                }
            }
        }
    }

    #[test]
    fn a_path_that_was_shifted_or_scaled_is_seen() {
        let (design, code) = block();
        let made = laid(&code, "box:0.5x0.5x0.25mm", 0.25);
        let still = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let moved = made.departure(&design.transformed(still, [1.0, 0.0, 0.0])).unwrap();
        assert!(
            (encloses(moved.missing, 16.0) - 16.0).abs() < 1e-6 && (encloses(moved.over, 16.0) - 16.0).abs() < 1e-6
        );
        let half = made.departure(&Primitive::parse("box:1x1x1mm").unwrap().mesh(Length::mm(1.0))).unwrap();
        assert!(encloses(half.over, 192.0 - 0.125) > 191.0);
    }

    #[test]
    fn a_circle_holds_what_its_chords_miss() {
        // Beads of 0.1 mm around a circle of 0.2 mm; the design is that ring, its 720 sides within a millionth.
        let path = gcode::read(b"G1 X0.2 Z0.1\nG3 X0.2 I-0.2 J0 E1\n").unwrap();
        assert!(path.beside.as_mm() > 0.0);
        let bead = Primitive::parse("cylinder:r0.05h0.1mm").unwrap();
        let made = deposit(&path, &bead, Length::mm(0.002)).unwrap();
        let truth = std::f64::consts::PI * (0.25f64.powi(2) - 0.15f64.powi(2)) * 0.1;
        let [low, high] = made.shape.bracket.map(|v| v.as_mm3());
        assert!(low < truth && truth < high, "{truth} not in {low} … {high}");
        // No cube that lies in the deposit for certain leaves the ring of the true circle.
        let grid = made.sides.full.grid();
        let farthest = made.sides.full.iter().map(|at| grid.position(grid.index(at))).map(|p| p[0].hypot(p[1]));
        assert!(farthest.fold(0.0, f64::max) < 0.25 - 0.001);
    }
}
