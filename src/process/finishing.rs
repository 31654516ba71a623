//! Where finishing tools come from, and which faces they have to touch: data only, in the frame of the file.

use crate::error::{Error, Result, printable};
use crate::geometry::vector::{Vec3, dot, norm};
use crate::units::Angle;

/// Directions on a sphere, at most: each is a cast of the part.
const MOST_DIRECTIONS: usize = 1000;

/// A set of directions that point from a tool's tip to its hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Approach {
    /// The 26 between the faces, edges and corners of a cube about the part as it is built.
    Cube,
    /// The six axis directions of the part as it is built.
    Axes,
    /// So many, evenly over the sphere.
    Sphere(usize),
    /// The outward normals of the part's largest flat faces.
    Faces,
    /// One direction of the file.
    Along(Vec3),
}

impl Approach {
    /// `cube`, `axes`, `faces`, `sphere:162`, or a direction as [`direction`] reads it.
    ///
    /// # Errors
    /// [`Error::Usage`] for anything else.
    ///
    /// ```
    /// use amcheck::process::Approach;
    /// assert_eq!(Approach::parse("sphere:162").unwrap(), Approach::Sphere(162));
    /// assert_eq!(Approach::parse("-x").unwrap(), Approach::Along([-1.0, 0.0, 0.0]));
    /// assert!(Approach::parse("sphere:0").is_err());
    /// ```
    pub fn parse(text: &str) -> Result<Self> {
        let even = |n: &str| n.parse().ok().filter(|n| (1..=MOST_DIRECTIONS).contains(n));
        match text.trim() {
            "cube" => Ok(Approach::Cube),
            "axes" => Ok(Approach::Axes),
            "faces" => Ok(Approach::Faces),
            other => other
                .strip_prefix("sphere:")
                .and_then(even)
                .map(Approach::Sphere)
                .or_else(|| direction(other).map(Approach::Along))
                .ok_or_else(|| Error::Usage {
                    problem: format!("`{}` names no directions of a tool", printable(text)),
                    remedy: format!(
                        "use cube, axes, faces, sphere:N with N from 1 to {MOST_DIRECTIONS}, +z, or three numbers such as 1,0,1"
                    ),
                }),
        }
    }
}

/// Faces that a tool has to touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FaceChoice {
    /// Those whose outward normal is within an angle (radians) of a direction.
    Facing { direction: Vec3, within: f64 },
    /// What lies in a box.
    Inside { lo: Vec3, hi: Vec3 },
}

impl FaceChoice {
    /// `DIRECTION:ANGLE` (`+z:30deg`) or `box:X,Y,Z:X,Y,Z` in millimetres.
    ///
    /// # Errors
    /// [`Error::Usage`] for anything else, an angle that is not above 0° and at most 180°, and a box whose second corner is not above
    /// its first.
    ///
    /// ```
    /// use amcheck::process::FaceChoice;
    /// let top = FaceChoice::parse("+z:30deg").unwrap();
    /// assert!(top.holds([5.0, 5.0, 2.0], [0.0, 0.0, 1.0]) && !top.holds([5.0, 5.0, 0.0], [0.0, 0.0, -1.0]));
    /// let near = FaceChoice::parse("box:0,0,0:10,10,4").unwrap();
    /// assert!(near.holds([5.0, 5.0, 2.0], [1.0, 0.0, 0.0]) && !near.holds([5.0, 5.0, 8.0], [1.0, 0.0, 0.0]));
    /// ```
    pub fn parse(text: &str) -> Result<Self> {
        let words: Vec<&str> = text.split(':').collect();
        let read = match words.as_slice() {
            ["box", lo, hi] => numbers(lo)
                .zip(numbers(hi))
                .filter(|(lo, hi)| (0..3).all(|a| lo[a] < hi[a]))
                .map(|(lo, hi)| FaceChoice::Inside { lo, hi }),
            [towards, angle] => direction(towards)
                .zip(Angle::parse(angle).ok().map(Angle::as_radians))
                .filter(|(_, a)| *a > 0.0 && *a <= std::f64::consts::PI)
                .map(|(direction, within)| FaceChoice::Facing { direction, within }),
            _ => None,
        };
        read.ok_or_else(|| Error::Usage {
            problem: format!("`{}` names no faces", printable(text)),
            remedy: "use a direction and an angle such as +z:30deg, or box:X,Y,Z:X,Y,Z with the lower corner first"
                .into(),
        })
    }

    /// Whether a place of the surface with an outward unit normal is chosen.
    pub fn holds(&self, at: Vec3, normal: Vec3) -> bool {
        match *self {
            FaceChoice::Inside { lo, hi } => (0..3).all(|a| (lo[a]..=hi[a]).contains(&at[a])),
            FaceChoice::Facing { direction: d, within } => {
                // A billionth of cosine is rounding.
                dot(d, normal) >= norm(d) * within.cos() - 1e-9
            }
        }
    }
}

/// How surfaces are finished: where tools come from, and what they have to touch.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Finishing {
    /// Where tools come from; nothing says the cube's 26 directions.
    pub from: Vec<Approach>,
    /// The furthest that a tool leans from the build's up, radians: what a machine's head or table can do.
    pub tilt: Option<f64>,
    /// The faces to be touched; nothing says all.
    pub faces: Vec<FaceChoice>,
}

impl Finishing {
    /// Reads one entry, `from`, `faces` or `tilt`; of several tilts the last holds.
    ///
    /// # Errors
    /// As [`Approach::parse`], [`FaceChoice::parse`], and [`Error::Usage`] for an angle that is not from 0° to 180°.
    pub fn set(&mut self, key: &str, words: &[&str]) -> Result<()> {
        match key {
            "from" => self.from = words.iter().map(|w| Approach::parse(w)).collect::<Result<_>>()?,
            "faces" => self.faces = words.iter().map(|w| FaceChoice::parse(w)).collect::<Result<_>>()?,
            _ => {
                for word in words {
                    self.tilt = Some(tilt(word)?);
                }
            }
        }
        Ok(())
    }

    /// Whether a place of the surface has to be touched; both in the frame of the file.
    pub fn wants(&self, at: Vec3, normal: Vec3) -> bool {
        self.faces.is_empty() || self.faces.iter().any(|f| f.holds(at, normal))
    }
}

/// An angle from 0° to 180°, in radians.
fn tilt(text: &str) -> Result<f64> {
    let angle = Angle::parse(text)?.as_radians();
    match (0.0..=std::f64::consts::PI).contains(&angle) {
        true => Ok(angle),
        false => Err(Error::Usage {
            problem: format!("a tool cannot lean by {}", printable(text)),
            remedy: "give an angle from 0deg to 180deg".into(),
        }),
    }
}

/// A direction: `+z`, `z`, `-x`, …, or three numbers of which one at least is not 0.
pub fn direction(text: &str) -> Option<Vec3> {
    let axis = |name: &str| ["x", "y", "z"].iter().position(|a| *a == name);
    let (sign, name) = text.strip_prefix('-').map_or((1.0, text.strip_prefix('+').unwrap_or(text)), |n| (-1.0, n));
    match axis(name) {
        Some(a) => Some([0, 1, 2].map(|i| if i == a { sign } else { 0.0 })),
        None => numbers(text).filter(|d| d.iter().any(|c| *c != 0.0)),
    }
}

/// Three finite numbers between commas.
fn numbers(text: &str) -> Option<Vec3> {
    let list: Vec<f64> =
        text.split(',').map(|c| c.trim().parse().ok().filter(|c: &f64| c.is_finite())).collect::<Option<_>>()?;
    <Vec3>::try_from(list).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_or_refused_with_a_remedy() {
        assert_eq!(direction("y"), Some([0.0, 1.0, 0.0]));
        assert_eq!(direction("1, 0,-2"), Some([1.0, 0.0, -2.0]));
        for wrong in ["", "w", "0,0,0", "1,2", "1,2,3,4", "1,nan,0", "+-z"] {
            assert_eq!(direction(wrong), None, "{wrong}");
        }
        for wrong in ["", "cubes", "sphere:", "sphere:1001", "sphere:-4", "0,0,0"] {
            assert!(matches!(Approach::parse(wrong), Err(Error::Usage { .. })), "{wrong}");
        }
        for wrong in ["", "+z", "+z:0deg", "+z:181deg", "box:0,0,0", "box:0,0,0:1,0,1", "+w:3deg", "box:a,0,0:1,1,1"] {
            assert!(matches!(FaceChoice::parse(wrong), Err(Error::Usage { .. })), "{wrong}");
        }
        assert!(tilt("181deg").is_err() && tilt("-1deg").is_err() && tilt("ten").is_err());
        assert!((tilt("90deg").unwrap() - 0.5 * std::f64::consts::PI).abs() < 1e-12);
        assert!(Finishing::default().wants([0.0; 3], [0.0, 0.0, 1.0]));
    }
}
