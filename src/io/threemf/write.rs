//! Writing 3MF.

use crate::geometry::TriangleMesh;
use std::io::{Cursor, Result, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

const TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>
"#;
const RELATIONS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
"#;

/// Writes a mesh in millimetres as a 3MF package of one object, built once where it stands.
///
/// Coordinates have as many digits as give the same f64 again. The same mesh makes the same bytes: the
/// archive carries no clock.
///
/// # Errors
/// Those of `out`.
///
/// # Cost
/// The package is deflated in memory before it is written.
///
/// ```
/// use amcheck::io::threemf;
/// let mesh = amcheck::geometry::TriangleMesh::weld([[[0.1; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
/// let mut bytes = Vec::new();
/// threemf::write(&mesh, &mut bytes).unwrap();
/// assert_eq!(threemf::read(&bytes)?.mesh, mesh);
/// # Ok::<(), amcheck::Error>(())
/// ```
pub fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> Result<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in [("[Content_Types].xml", TYPES), ("_rels/.rels", RELATIONS)] {
        archive.start_file(name, options)?;
        archive.write_all(text.as_bytes())?;
    }
    archive.start_file("3D/3dmodel.model", options)?;
    model(mesh, &mut std::io::BufWriter::new(&mut archive))?;
    out.write_all(archive.finish()?.get_ref())
}

fn model(mesh: &TriangleMesh, out: &mut impl Write) -> Result<()> {
    write!(
        out,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xml:lang=\"en-US\" \
         xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n<resources>\n\
         <object id=\"1\" type=\"model\">\n<mesh>\n<vertices>\n"
    )?;
    for [x, y, z] in &mesh.vertices {
        writeln!(out, "<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")?;
    }
    write!(out, "</vertices>\n<triangles>\n")?;
    for [a, b, c] in &mesh.triangles {
        writeln!(out, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>")?;
    }
    write!(
        out,
        "</triangles>\n</mesh>\n</object>\n</resources>\n<build>\n<item objectid=\"1\"/>\n</build>\n</model>\n"
    )?;
    out.flush()
}
