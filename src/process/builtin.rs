//! The profiles inside the binary: data only.

use crate::error::{Error, Result, nearest, printable};

/// Name and text of every built-in profile.
pub const BUILTIN: &[(&str, &str)] = &[
    ("fdm", include_str!("builtin/fdm.toml")),
    ("sla", include_str!("builtin/sla.toml")),
    ("sls", include_str!("builtin/sls.toml")),
    ("mjf", include_str!("builtin/mjf.toml")),
    ("lpbf", include_str!("builtin/lpbf.toml")),
    ("binder-jet", include_str!("builtin/binder-jet.toml")),
];

/// The text of a built-in profile.
///
/// # Errors
/// [`Error::UnknownName`] with the nearest name.
pub fn builtin(name: &str) -> Result<&'static str> {
    BUILTIN.iter().find(|(n, _)| *n == name).map(|(_, text)| *text).ok_or_else(|| Error::UnknownName {
        what: "process",
        given: printable(name),
        nearest: nearest(name, BUILTIN.iter().map(|(n, _)| *n)),
        known: BUILTIN.iter().map(|(n, _)| n.to_string()).collect(),
    })
}

#[cfg(test)]
mod tests {
    use crate::process::{BUILTIN, LimitBasis, Process};

    #[test]
    fn every_profile_reads_and_every_limit_has_a_source_or_a_reason() {
        for (name, _) in BUILTIN {
            let p = Process::named(name).unwrap();
            assert_eq!(p.name, *name);
            for (key, l) in &p.limits {
                assert!(!l.source.is_empty(), "{name} {key}");
                assert!(l.basis != LimitBasis::User && !l.overridden, "{name} {key}");
                assert!(l.fail.is_some() || l.warn.is_some(), "{name} {key}");
            }
        }
        assert!(Process::named("fdn").unwrap_err().remedy().contains("fdm"));
    }

    #[test]
    fn a_file_inherits_and_overrides() {
        let p = Process::from_toml("mine.toml", "inherits = \"fdm\"\n[limits.thin-wall]\nfail = \"0.4mm\"\n").unwrap();
        let wall = &p.limits["thin-wall"];
        assert_eq!((wall.fail, wall.warn, wall.overridden, p.layer_height_mm), (Some(0.4), Some(1.2), true, 0.2));
        assert_eq!(p.limits["overhang"].warn, Some(45.0));
        // The parent's title says how wide its own bead is.
        let wide = Process::from_toml("mine.toml", "inherits = \"fdm\"\n[element]\nwidth_mm = 0.8\n").unwrap();
        assert_eq!(wide.title, format!("{}, as mine changes it", p.title));
        // The warn limit of 1.2 mm would never be reached beside this one.
        let p = Process::from_toml("mine.toml", "inherits = \"fdm\"\n[limits.thin-wall]\nfail = \"2mm\"\n").unwrap();
        assert_eq!((p.limits["thin-wall"].fail, p.limits["thin-wall"].warn), (Some(2.0), None));
    }

    #[test]
    fn bad_profiles_name_line_and_remedy() {
        let cases = [
            ("inherits = \"fdm\"\n[limits.thinwall]\nfail = \"1mm\"\n", "line 2", "thin-wall"),
            ("inherits = \"fdm\"\n[limits.thin-wall]\nfial = \"1mm\"\n", "line 3", "fail"),
            ("inherits = \"fdm\"\n[limits.thin-wall]\nfail = \"1,5mm\"\n", "line 2", "point"),
            ("inherits = \"fdm\"\n[limits.thin-wall]\nfail = \"2mm\"\nwarn = \"1mm\"\n", "line 2", "stricter"),
            ("inherits = \n", "line 1", "TOML"),
            ("title = \"mine\"\ninherits = \"fdn\"\n", "line 2", "fdm"),
            ("[machine]\nlayer_height_mm = 0.2\n", "line 1", "inherits"),
            ("inherits = \"fdm\"\n[machine]\nlayer_height_mm = 12\n", "line 3", "at least as wide"),
            ("inherits = \"fdm\"\n[limits.bed-contact]\nwarn = \"2\"\n", "line 2", "from 0 to 1"),
        ];
        for (text, place, remedy) in cases {
            let e = Process::from_toml("mine.toml", text).unwrap_err();
            assert_eq!(e.place().as_deref(), Some(place), "{text}: {e}");
            assert!(e.remedy().contains(remedy), "{text}: {}", e.remedy());
            assert_eq!(e.exit_code(), 2);
        }
    }

    #[test]
    fn the_command_line_sets_all_kinds_of_a_check() {
        let mut p = Process::named("fdm").unwrap();
        p.override_limit("narrow-gap=0.25mm").unwrap();
        assert_eq!(p.limits["narrow-gap"].fail, Some(0.25));
        assert_eq!(
            (p.limits["narrow-gap.between-bodies"].fail, p.limits["narrow-gap.between-bodies"].warn),
            (Some(0.25), Some(0.5))
        );
        p.override_limit("thin-wall=2mm").unwrap();
        assert_eq!(p.limits["thin-wall"].warn, None, "a weaker warning is dropped");
        for bad in
            ["thin-wall", "thinwall=1mm", "thin-wall=-1mm", "overhang=91deg", "thin-wall=1mm,0.5mm", "thin-wall=nan"]
        {
            assert!(p.override_limit(bad).is_err(), "{bad}");
        }
    }
}
