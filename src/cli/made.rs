//! The files that a made shape goes to: a mesh, and fields and a picture where they are asked for.

use super::args::How;
use super::deliver::{Delivery, spare};
use super::words::one_of;
use crate::error::{Error, Result, printable};
use crate::field::Field;
use crate::geometry::TriangleMesh;
use crate::io::glb::{self, Scene};
use crate::io::{Content, npy, nrrd, obj, ply, stl, threemf, vti, write_together};
use crate::notice::{Notice, number_of};
use crate::operate::{Operated, solid_volume};
use crate::report::render::{Panel, side_by_side};
use crate::units::enclosed;
use std::path::{Path, PathBuf};

/// Suffixes that a mesh is written by.
const MESHES: &[&str] = &["stl", "glb", "obj", "ply", "3mf"];
const FIELDS: &[&str] = &["npy", "nrrd", "vti"];
const PICTURES: &[&str] = &["png"];

/// Width and height of each half of a picture.
const PANEL: [usize; 2] = [560, 460];

/// Places for the mesh and what else was asked for, known to take it before the work starts.
pub struct Outputs {
    mesh: Option<Destination>,
    fields: Vec<Destination>,
    picture: Option<Destination>,
}

/// What a picture shows before the operation, and its name.
pub struct Before {
    pub mesh: TriangleMesh,
    pub title: String,
}

impl Outputs {
    /// Looks at the suffixes and tries that a file can be made at each place.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a suffix that is not known; [`Error::CannotWrite`] naming the place.
    pub fn open(how: &How) -> Result<Self> {
        let open = |option, known| move |path: &PathBuf| Destination::open(path.clone(), option, known);
        Ok(Outputs {
            mesh: how.out.as_ref().map(open("suffix for --out", MESHES)).transpose()?,
            fields: how.fields.iter().map(open("suffix for --field", FIELDS)).collect::<Result<_>>()?,
            picture: how.picture.as_ref().map(open("suffix for --picture", PICTURES)).transpose()?,
        })
    }

    /// The place of the mesh where none was named.
    ///
    /// # Errors
    /// As [`Outputs::open`].
    pub fn or_at(mut self, path: String) -> Result<Self> {
        if self.mesh.is_none() {
            self.mesh = Some(Destination::open(path.into(), "suffix for --out", MESHES)?);
        }
        Ok(self)
    }

    /// The same places, where none of them is read from.
    ///
    /// # Errors
    /// As [`spare`].
    pub fn sparing(self, inputs: &[&Path]) -> Result<Self> {
        let places = self.mesh.iter().chain(&self.fields).chain(&self.picture);
        places.into_iter().try_for_each(|to| spare(&to.path, inputs))?;
        Ok(self)
    }

    /// Whether a picture was asked for.
    pub fn has_picture(&self) -> bool {
        self.picture.is_some()
    }

    /// What the format of the mesh loses of a surface, if it loses anything.
    pub fn loses(&self, mesh: &TriangleMesh) -> Option<Notice> {
        let merged = match &self.mesh {
            Some(to) if to.suffix == "stl" => stl::merged(mesh) as u64,
            _ => 0,
        };
        let (lo, hi) = mesh.bounds().unwrap_or_default();
        let longest = (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max);
        let is_far = (0..3).any(|a| lo[a].max(-hi[a]) > longest);
        let nearer = if is_far { ", or move the part nearer to the origin" } else { "" };
        let so = format!(
            "on another in STL's numbers of seven digits: facets may lose their area and edges meet; write PLY, OBJ, 3MF or GLB with --out{nearer}"
        );
        let text = number_of(merged, [&format!("vertex falls {so}"), &format!("vertices fall {so}")]);
        (merged > 0).then(|| Notice::new("merged-vertices", text).counted(merged))
    }

    /// Writes everything, all of it or none, and returns where.
    ///
    /// # Errors
    /// As [`write_together`] and [`Operated::field`].
    pub fn write(self, made: &Operated, before: &[Before]) -> Result<Vec<PathBuf>> {
        let picture = self.picture.as_ref().map(|to| (to, picture(made, before)));
        let field = if self.fields.is_empty() { None } else { Some(made.field()?) };
        let mut files: Vec<(&Path, Content)> = Vec::new();
        if let Some(to) = &self.mesh {
            files.push((&to.path, Box::new(move |out| to.mesh(&made.mesh, out))));
        }
        for (to, field) in self.fields.iter().zip(std::iter::repeat(field.as_deref()).flatten()) {
            files.push((&to.path, Box::new(move |out| to.field(field, out))));
        }
        if let Some((to, png)) = &picture {
            files.push((&to.path, Box::new(move |out| out.write_all(png))));
        }
        let places = files.iter().map(|(path, _)| path.to_path_buf()).collect();
        write_together(files)?;
        Ok(places)
    }
}

/// What there was before, each in a panel, and what was made.
fn picture(made: &Operated, before: &[Before]) -> Vec<u8> {
    let [volume, low, high] = enclosed(made.volume.as_mm3(), made.bracket.map(|v| v.as_mm3()));
    let after = format!("{volume} mm³, certified {low} to {high} mm³");
    let caption = |b: &Before| {
        let volume = solid_volume(&b.mesh).map_or_else(String::new, |volume| format!("{volume}, "));
        format!("{volume}{} facets", b.mesh.triangles.len())
    };
    let captions: Vec<String> = before.iter().map(caption).collect();
    let mut panels: Vec<Panel> =
        (before.iter().zip(&captions)).map(|(b, caption)| Panel { mesh: &b.mesh, title: &b.title, caption }).collect();
    panels.push(Panel { mesh: &made.mesh, title: "result", caption: &after });
    side_by_side(&panels, PANEL)
}

/// A place for one file.
struct Destination {
    path: PathBuf,
    suffix: &'static str,
    /// Takes a folder that was made for nothing away again.
    _folder: Delivery,
}

impl Destination {
    fn open(path: PathBuf, option: &'static str, known: &'static [&'static str]) -> Result<Self> {
        let suffix = path.extension().map_or_else(String::new, |s| s.to_string_lossy().to_lowercase());
        let suffix = one_of(option, &[suffix], known)?.first().copied().unwrap_or("stl");
        if path.is_dir() {
            let shown = printable(&path.to_string_lossy());
            return Err(Error::CannotWrite { path: shown, reason: "it is a folder".into() });
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Ok(Destination { _folder: Delivery::open(folder)?, suffix, path })
    }

    fn mesh(&self, mesh: &TriangleMesh, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        match self.suffix {
            "glb" => glb::write(&Scene { mesh, colours: None, attributes: &[] }, out),
            "obj" => obj::write(mesh, out),
            "ply" => ply::write(mesh, out),
            "3mf" => threemf::write(mesh, out),
            _ => stl::write(mesh, out),
        }
    }

    fn field(&self, field: &Field<f32>, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        match self.suffix {
            "npy" => npy::write(field.into(), out),
            "nrrd" => nrrd::write(field.into(), out),
            _ => vti::write(field.into(), "signed_distance_mm", out),
        }
    }
}
