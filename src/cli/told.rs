//! What is said of a made shape.

use crate::error::{escaped, printable};
use crate::geometry::vector::Vec3;
use crate::notice::Notice;
use crate::operate::Operated;
use crate::units::{Length, Volume, enclosed, short};
use std::fmt::Write;
use std::path::PathBuf;

/// A bracket wider than this share of the volume is told as one that says little.
const WIDE: f64 = 0.5;

/// What was made, in a few lines; `told` are more.
pub fn summary(made: &Operated, spacing: Length, notices: &[Notice], told: &str, written: &[PathBuf]) -> String {
    let [volume, low, high] = enclosed(made.volume.as_mm3(), made.bracket.map(|v| v.as_mm3()));
    let (lo, hi) = made.mesh.bounds().unwrap_or_default();
    let point = |p: Vec3| p.map(short).join(", ");
    let mut text = String::new();
    let _ = writeln!(text, "volume     {volume} mm³, certified {low} … {high} mm³");
    let _ = writeln!(text, "box        {} … {} mm", point(lo), point(hi));
    let _ = writeln!(text, "path       {} at {spacing}", made.path);
    let _ = writeln!(text, "triangles  {}", made.mesh.triangles.len());
    text += told;
    if let Some(doubt) = doubt(made.volume, made.bracket) {
        let _ = writeln!(text, "note       {doubt}; a smaller --voxel says more");
    }
    for notice in notices {
        let _ = writeln!(text, "note       {}", escaped(&notice.message));
    }
    for path in written {
        let _ = writeln!(text, "written    {}", printable(&path.to_string_lossy()));
    }
    text
}

/// What a bracket leaves open, if it is much.
fn doubt(volume: Volume, bracket: [Volume; 2]) -> Option<&'static str> {
    let ([low, high], volume) = (bracket.map(|v| v.as_mm3()), volume.as_mm3());
    match (low <= 0.0, high - low > WIDE * volume) {
        (true, _) => Some("no volume of it is certain at this spacing"),
        (false, true) => Some("its certified volumes differ by more than half of it at this spacing"),
        (false, false) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bracket_is_told_as_wide_by_more_than_half_of_the_volume() {
        let doubt = |volume: f64, bracket: [f64; 2]| doubt(Volume::mm3(volume), bracket.map(Volume::mm3));
        assert_eq!(doubt(10.0, [8.0, 12.9]), None);
        assert!(doubt(10.0, [8.0, 13.1]).is_some_and(|said| said.contains("half")));
        assert!(doubt(0.24, [1e-9, 23.0]).is_some_and(|said| said.contains("half")));
        assert!(doubt(0.24, [0.0, 0.25]).is_some_and(|said| said.contains("no volume")));
    }
}
