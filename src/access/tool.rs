//! Tools from their descriptions.

use super::meridian::{Meridian, Outline, Piece, Role, Support};
use crate::error::{Error, Place, Result, ToolFault, escaped, printable};
use crate::geometry::vector::Vec3;
use crate::geometry::{Health, MeshDistance, TriangleMesh, revolved};
use crate::process::ToolChoice;
use serde::Deserialize;

/// Where a tool's sizes come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// A standard or a maker's table, named beside it.
    Sourced,
    /// Ours, with its reason.
    Convention,
    /// The user's own.
    User,
}

/// A point of the cutter that is meant to touch. Of a coaxial tool it is a whole circle about the axis.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SharpPoint {
    pub name: String,
    /// In the frame of the tool: tip at the origin, axis +z.
    pub at_mm: Vec3,
}

/// A sharp point that is further off the surface than this share of the tool's longest side touches nothing: coordinates are rounded by less.
const OFF_SURFACE: f64 = 1e-3;

/// The shape of a tool.
#[derive(Debug, Clone, PartialEq)]
pub enum Body {
    /// Coaxial pieces about the z axis, held from above.
    Coaxial(Meridian),
    /// Any closed shape, in the frame of the tool.
    Solid(TriangleMesh),
}

/// A tool: tip at the origin, axis +z towards the hand or the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Tool {
    pub name: String,
    pub title: String,
    pub basis: Basis,
    /// Source of the sizes, or the reason of a convention.
    pub source: String,
    pub body: Body,
    /// Named points that are meant to touch; empty where the whole cutter is.
    pub sharp: Vec<SharpPoint>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Described {
    title: Option<String>,
    basis: Option<Basis>,
    source: Option<String>,
    mesh: Option<String>,
    #[serde(default)]
    piece: Vec<DescribedPiece>,
    #[serde(default)]
    sharp: Vec<SharpPoint>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum DescribedRole {
    Cutter,
    Neck,
    Holder,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum DescribedShape {
    Cylinder,
    Cone,
    BallEnd,
    Ball,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DescribedPiece {
    role: DescribedRole,
    shape: Option<DescribedShape>,
    diameter_mm: f64,
    /// Upper diameter of a cone; diameter of the stem above a ball.
    upper_diameter_mm: Option<f64>,
    length_mm: Option<f64>,
    /// Height at which it begins, where that is not the end of the piece before.
    from_mm: Option<f64>,
}

impl Tool {
    /// A tool from its description; `load` reads the mesh that it may name.
    ///
    /// # Errors
    /// [`Error::Profile`] with the line of bad TOML, an unknown key or a size out of range; [`Error::Tool`] without a cutter,
    /// with a holder inside the cutter, or with an open mesh.
    ///
    /// ```
    /// use amcheck::access::Tool;
    /// let text = "[[piece]]\nrole = \"cutter\"\ndiameter_mm = 6\nlength_mm = 20\n";
    /// let mill = Tool::from_toml("mill", text, |_| unreachable!("it names no mesh"))?;
    /// assert_eq!(mill.cutter_width(), 6.0);
    /// # Ok::<(), amcheck::Error>(())
    /// ```
    pub fn from_toml(name: &str, text: &str, load: impl Fn(&str) -> Result<TriangleMesh>) -> Result<Self> {
        let described: Described = toml::from_str(text).map_err(|e| {
            let line = e.span().map(|s| 1 + text[..s.start.min(text.len())].matches('\n').count() as u64);
            let problem = escaped(e.message().lines().next().unwrap_or_default());
            bad(name, line.map_or(Place::Whole, Place::Line), problem)
        })?;
        let title = described.title.clone().unwrap_or_else(|| name.to_string());
        let (basis, source) = (described.basis.unwrap_or(Basis::User), described.source.clone().unwrap_or_default());
        let with = |body, sharp| Tool { name: name.into(), title, basis, source, body, sharp };
        if described.sharp.iter().any(|s| s.at_mm.iter().any(|c| !c.is_finite())) {
            return Err(bad(name, Place::Key("sharp".into()), "a sharp point is not finite".into()));
        }
        match &described.mesh {
            Some(_) if !described.piece.is_empty() => {
                Err(bad(name, Place::Key("mesh".into()), "a tool is either a mesh or a stack of pieces".into()))
            }
            Some(path) => Tool::from_mesh(name, load(path)?, described.sharp).map(|t| with(t.body, t.sharp)),
            None => Ok(with(Body::Coaxial(meridian(name, &described.piece)?), described.sharp)),
        }
    }

    /// A tool of any shape, from its mesh in its own frame (tip at the origin, axis +z) and the points that are meant to touch.
    ///
    /// # Errors
    /// [`Error::Tool`] for an open mesh, without any sharp point, as it has no cutter then, and for one that is not on the surface.
    pub fn from_mesh(name: &str, mesh: TriangleMesh, sharp: Vec<SharpPoint>) -> Result<Self> {
        let health = Health::of(&mesh);
        let fault = |fault| Error::Tool { tool: printable(name), fault };
        if !health.is_solid() {
            return Err(fault(ToolFault::OpenMesh { edges: health.open_edges.count.max(1) }));
        }
        if sharp.is_empty() {
            return Err(fault(ToolFault::NoCutter));
        }
        let surface = MeshDistance::new(&mesh);
        let longest = mesh.bounds().map_or(0.0, |(lo, hi)| (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max));
        for SharpPoint { name, at_mm } in &sharp {
            let off_mm = surface.nearest(*at_mm, f64::INFINITY).map_or(f64::INFINITY, |n| n.distance);
            if off_mm > OFF_SURFACE * longest {
                return Err(fault(ToolFault::SharpOffSurface { name: printable(name), at_mm: *at_mm, off_mm }));
            }
        }
        let body = Body::Solid(health.outward(&mesh).into_owned());
        let source = "mesh file".to_string();
        Ok(Tool { name: name.into(), title: name.into(), basis: Basis::User, source, body, sharp })
    }

    /// The tool that a process or a user chose; one that is nothing but a mesh touches with its tip, at the origin.
    ///
    /// # Errors
    /// As [`Tool::from_toml`] and [`Tool::from_mesh`].
    pub fn chosen(choice: &ToolChoice) -> Result<Self> {
        if choice.text.is_empty() {
            let tip = vec![SharpPoint { name: "tip".into(), at_mm: [0.0; 3] }];
            return Tool::from_mesh(&choice.name, choice.mesh.clone().unwrap_or_default(), tip);
        }
        Tool::from_toml(&choice.name, &choice.text, |path| {
            choice
                .mesh
                .clone()
                .ok_or_else(|| bad(&choice.name, Place::Key("mesh".into()), format!("`{path}` was not read")))
        })
    }

    /// Greatest width of what may touch, millimetres.
    pub fn cutter_width(&self) -> f64 {
        match &self.body {
            Body::Coaxial(m) => 2.0 * m.cutter_radius(),
            Body::Solid(_) => 2.0 * self.sharp.iter().map(|s| s.at_mm[0].hypot(s.at_mm[1])).fold(0.0, f64::max),
        }
    }

    /// Whether the tool can be used on a part of this size.
    ///
    /// # Errors
    /// [`Error::Tool`] for a cutter wider than the longest side.
    pub fn fits(&self, extent_mm: Vec3) -> Result<()> {
        let (cutter_mm, part_mm) = (self.cutter_width(), extent_mm.into_iter().fold(0.0, f64::max));
        if cutter_mm > part_mm {
            let fault = ToolFault::LargerThanPart { cutter_mm, part_mm };
            return Err(Error::Tool { tool: self.name.clone(), fault });
        }
        Ok(())
    }

    /// What of the tool touches, in words: all of the cutter of a coaxial one, of any other the points that are meant to.
    pub fn touching(&self) -> String {
        match (&self.body, self.sharp.as_slice()) {
            (Body::Coaxial(_), _) => self.name.clone(),
            (Body::Solid(_), [SharpPoint { at_mm: [0.0, 0.0, 0.0], .. }]) => format!("the tip of {}", self.name),
            (Body::Solid(_), [point]) => format!("the point `{}` of {}", printable(&point.name), self.name),
            (Body::Solid(_), _) => format!("the sharp points of {}", self.name),
        }
    }

    /// The flat end of a coaxial tool that may touch with all of it.
    pub(super) fn flat_end(&self) -> Option<Support> {
        self.meridian().filter(|_| self.sharp.is_empty())?.support(0.0, 1.0).filter(|s| s.flat > 0.0)
    }

    /// The outline of a coaxial tool.
    pub fn meridian(&self) -> Option<&Meridian> {
        match &self.body {
            Body::Coaxial(m) => Some(m),
            Body::Solid(_) => None,
        }
    }

    /// The tool as a closed mesh about its axis; a coaxial one goes on upwards to `top_mm`, and its circles are inscribed
    /// polygons of `sides` corners.
    pub fn mesh(&self, top_mm: f64, sides: usize) -> TriangleMesh {
        match &self.body {
            Body::Solid(mesh) => mesh.clone(),
            Body::Coaxial(m) => revolved(&corners(m, top_mm), sides.max(3)),
        }
    }
}

fn bad(name: &str, place: Place, problem: String) -> Error {
    Error::Profile {
        file: printable(name),
        place,
        problem,
        remedy: "see `amcheck tools NAME` for the keys: [[piece]] role, shape, diameter_mm, length_mm; [[sharp]] name, at_mm"
            .into(),
    }
}

fn meridian(name: &str, described: &[DescribedPiece]) -> Result<Meridian> {
    let fault = |fault| Error::Tool { tool: printable(name), fault };
    let cutter = |p: &&DescribedPiece| matches!(p.role, DescribedRole::Cutter);
    if described.iter().find(cutter).is_none() {
        return Err(fault(ToolFault::NoCutter));
    }
    let mut pieces: Vec<Piece> = Vec::new();
    let (mut end, mut cutter_end) = (0.0, f64::NEG_INFINITY);
    for (i, p) in described.iter().enumerate() {
        let role = match p.role {
            DescribedRole::Cutter => Role::Cutter,
            DescribedRole::Neck => Role::Neck,
            DescribedRole::Holder => Role::Holder,
        };
        let from = p.from_mm.unwrap_or(end);
        let inside =
            |from_mm, cutter_end_mm| ToolFault::HolderInsideCutter { piece: role.word(), from_mm, cutter_end_mm };
        if role != Role::Cutter && from < cutter_end - 1e-9 {
            return Err(fault(inside(from, cutter_end)));
        }
        let above = described[i + 1..].iter().find(cutter);
        if role != Role::Cutter && above.is_some() {
            return Err(fault(inside(from, from + described[i + 1..].iter().filter_map(|d| d.length_mm).sum::<f64>())));
        }
        if (from - end).abs() > 1e-9 {
            return Err(bad(
                name,
                Place::Key("from_mm".into()),
                format!("a piece begins at {from} mm, the one before ends at {end}"),
            ));
        }
        let piece = piece(name, role, p, from)?;
        (end, cutter_end) = (piece.to, if role == Role::Cutter { piece.to } else { cutter_end });
        pieces.push(piece);
    }
    Ok(Meridian::new(pieces))
}

fn piece(name: &str, role: Role, p: &DescribedPiece, from: f64) -> Result<Piece> {
    let size = |key: &str, value: f64| {
        let fine = value.is_finite() && value > 0.0 && value < 1e5;
        fine.then_some(value)
            .ok_or_else(|| bad(name, Place::Key(key.into()), format!("{key} = {value} is no positive length")))
    };
    let needed = || {
        let length =
            p.length_mm.ok_or_else(|| bad(name, Place::Key("length_mm".into()), "a piece has no length_mm".into()))?;
        size("length_mm", length)
    };
    let shape = p.shape.unwrap_or(DescribedShape::Cylinder);
    let lower = match (shape, p.diameter_mm) {
        (DescribedShape::Cone, 0.0) => 0.0,
        (_, d) => 0.5 * size("diameter_mm", d)?,
    };
    let upper =
        p.upper_diameter_mm.map(|d| if d == 0.0 { Ok(0.0) } else { size("upper_diameter_mm", d) }).transpose()?;
    let (to, outline) = match shape {
        DescribedShape::Cylinder => (from + needed()?, Outline::Straight { lower, upper: lower }),
        DescribedShape::Cone => {
            let upper = 0.5
                * upper.ok_or_else(|| {
                    bad(name, Place::Key("upper_diameter_mm".into()), "a cone needs upper_diameter_mm".into())
                })?;
            (from + needed()?, Outline::Straight { lower, upper })
        }
        DescribedShape::BallEnd => (from + lower, Outline::LowerBall { radius: lower }),
        DescribedShape::Ball => {
            let stem = (0.5 * upper.unwrap_or(0.0)).min(lower);
            (from + lower + (lower * lower - stem * stem).sqrt(), Outline::Ball { radius: lower })
        }
    };
    if lower == 0.0 && upper.unwrap_or(0.0) == 0.0 {
        return Err(bad(name, Place::Key("diameter_mm".into()), "a piece has no width".into()));
    }
    Ok(Piece { role, from, to, outline })
}

/// Corners (radius, height) of a tool's outline, from the tip to its upper end.
fn corners(m: &Meridian, top: f64) -> Vec<[f64; 2]> {
    let mut list = vec![[0.0, 0.0]];
    let last = m.pieces().len().saturating_sub(1);
    for (i, p) in m.pieces().iter().enumerate() {
        let steps = if matches!(p.outline, Outline::Straight { .. }) { 1 } else { 24 };
        list.extend((0..=steps).map(|s| {
            let z = p.from + (p.to - p.from) * f64::from(s) / f64::from(steps);
            [p.radius(z), z]
        }));
        if i == last && top > p.to {
            list.push([p.radius(p.to), top]);
        }
    }
    let end = list.last().map_or(0.0, |c| c[1]);
    list.push([0.0, end]);
    list.dedup_by(|a, b| (a[0] - b[0]).abs() < 1e-12 && (a[1] - b[1]).abs() < 1e-12);
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Tool> {
        Tool::from_toml("mine", text, |_| Ok(TriangleMesh::default()))
    }

    #[test]
    fn a_stack_reads_and_its_mesh_is_closed() {
        let t = read(
            "title = \"x\"\n[[piece]]\nrole = \"cutter\"\nshape = \"ball-end\"\ndiameter_mm = 6\n[[piece]]\nrole = \"cutter\"\n\
             diameter_mm = 6\nlength_mm = 10\n[[piece]]\nrole = \"holder\"\ndiameter_mm = 20\nlength_mm = 30\n",
        )
        .unwrap();
        let mesh = t.mesh(60.0, 64);
        assert!(Health::of(&mesh).is_solid());
        // Half a ball, a cylinder of 10 mm, a holder of 47 mm; the polygons are inscribed.
        let pi = std::f64::consts::PI;
        let exact = 2.0 / 3.0 * pi * 27.0 + pi * 9.0 * 10.0 + pi * 100.0 * 47.0;
        let volume = mesh.signed_volume();
        assert!(volume < exact && volume > 0.995 * exact, "{volume} {exact}");
        assert!(t.fits([5.0, 6.0, 1.0]).is_ok());
    }

    #[test]
    fn every_built_in_tool_reads_and_says_where_its_sizes_come_from() {
        for (name, _) in crate::process::TOOLS {
            let t = Tool::chosen(&ToolChoice::named(name).unwrap()).unwrap();
            assert!(t.basis != Basis::User && !t.source.is_empty() && t.title != *name, "{name}");
            let m = t.meridian().unwrap();
            assert!(m.cutter_is_convex() && m.widest() > m.cutter_radius(), "{name}");
            assert!(Health::of(&t.mesh(m.length() + 50.0, 24)).is_solid(), "{name}");
        }
        assert!(ToolChoice::named("end-mil-6").unwrap_err().remedy().contains("end-mill-6"));
    }

    #[test]
    fn every_fault_is_an_error_of_its_own() {
        let piece = |role: &str, more: &str| format!("[[piece]]\nrole = \"{role}\"\ndiameter_mm = 6\n{more}\n");
        let fault = |text: &str| match read(text) {
            Err(Error::Tool { fault, .. }) => fault,
            other => panic!("{other:?}"),
        };
        assert_eq!(fault(&piece("neck", "length_mm = 3")), ToolFault::NoCutter);
        assert_eq!(fault(""), ToolFault::NoCutter);
        let inside = piece("cutter", "length_mm = 10") + &piece("holder", "length_mm = 10\nfrom_mm = 4");
        assert!(matches!(fault(&inside), ToolFault::HolderInsideCutter { from_mm: 4.0, cutter_end_mm: 10.0, .. }));
        let below = piece("neck", "length_mm = 10") + &piece("cutter", "length_mm = 4");
        assert!(matches!(fault(&below), ToolFault::HolderInsideCutter { piece: "neck", .. }));
        let wide = read(&piece("cutter", "length_mm = 10")).unwrap();
        let larger = wide.fits([5.0; 3]).unwrap_err();
        assert!(matches!(&larger, Error::Tool { fault: ToolFault::LargerThanPart { .. }, .. }));
        assert_eq!((larger.code(), larger.exit_code()), ("E004", 2));
        let cube = crate::geometry::Primitive::parse("box:2mm").unwrap().mesh(crate::units::Length::mm(1.0));
        let sharp = || vec![SharpPoint { name: "tip".into(), at_mm: [0.0; 3] }];
        let mut open = cube.clone();
        open.triangles.pop();
        let faults = [
            Tool::from_mesh("hook", open, sharp()),
            Tool::from_mesh("hook", cube.clone(), Vec::new()),
            Tool::from_mesh("hook", cube, sharp()),
        ];
        let faults = faults.map(|t| match t {
            Err(Error::Tool { fault, .. }) => fault,
            other => panic!("{other:?}"),
        });
        let [open, blunt, off] = faults;
        assert!(matches!((open, blunt), (ToolFault::OpenMesh { edges: 3 }, ToolFault::NoCutter)));
        // The middle of the cube.
        assert!(matches!(off, ToolFault::SharpOffSurface { off_mm, .. } if (off_mm - 1.0).abs() < 1e-9));
    }

    #[test]
    fn what_touches_is_called_what_it_is() {
        let cube = crate::geometry::cuboid([-1.0, -1.0, 0.0], [1.0, 1.0, 5.0]);
        let with = |points: &[(&str, [f64; 3])]| {
            let sharp = points.iter().map(|(name, at_mm)| SharpPoint { name: (*name).into(), at_mm: *at_mm }).collect();
            Tool::from_mesh("block", cube.clone(), sharp).unwrap().touching()
        };
        // The middle of a flat face is a tip, and nothing sharp.
        assert_eq!(with(&[("tip", [0.0; 3])]), "the tip of block");
        assert_eq!(with(&[("hook", [1.0, 0.0, 2.0])]), "the point `hook` of block");
        assert_eq!(with(&[("tip", [0.0; 3]), ("hook", [1.0, 0.0, 2.0])]), "the sharp points of block");
        assert_eq!(Tool::chosen(&ToolChoice::named("end-mill-6").unwrap()).unwrap().touching(), "end-mill-6");
    }

    #[test]
    fn what_cannot_be_read_names_its_place() {
        let cases = [
            ("[[piece]]\nrole = \"cuter\"\ndiameter_mm = 6\n", "line 2"),
            ("[[piece]]\nrole = \"cutter\"\ndiametre_mm = 6\n", "line"),
            ("[[piece]]\nrole = \"cutter\"\ndiameter_mm = -6\nlength_mm = 1\n", "diameter_mm"),
            ("[[piece]]\nrole = \"cutter\"\ndiameter_mm = 6\n", "length_mm"),
            ("[[piece]]\nrole = \"cutter\"\nshape = \"cone\"\ndiameter_mm = 0\nlength_mm = 4\n", "upper_diameter_mm"),
            ("mesh = \"a.stl\"\n[[piece]]\nrole = \"cutter\"\ndiameter_mm = 6\nlength_mm = 1\n", "mesh"),
        ];
        for (text, place) in cases {
            let e = read(text).unwrap_err();
            assert!(e.place().unwrap_or_default().contains(place), "{text}: {e} at {:?}", e.place());
        }
    }
}
