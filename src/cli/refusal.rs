//! What stands in the folder of a part that is refused: files that say so, for those who read no terminal.

use super::deliver::{Delivery, Files};
use super::named::Named;
use super::record::Record;
use crate::error::Error;
use crate::report::{badge, junit, sarif};
use std::path::{Path, PathBuf};

/// The formats that can say that a part was refused, and their files.
const TELLING: [(&str, &str); 3] = [("junit", "report.junit.xml"), ("sarif", "report.sarif"), ("badge", "badge.svg")];

/// The formats that tell of a part that was judged and of no other.
const OF_JUDGED: [&str; 3] = ["report.html", "report.json", "report.md"];

/// Whether what an earlier run says of a part no longer holds beside an error: not for wrong words, nor for a place that cannot be written.
pub fn is_of_part(error: &Error) -> bool {
    [4, 5, 70].contains(&error.exit_code())
}

/// The files of some formats that say that a part of these names was refused.
pub fn files(formats: &[&str], named: &Named, error: &Error) -> Files {
    let mut files = Files::default();
    for (format, name) in TELLING.iter().filter(|(format, _)| formats.contains(format)) {
        let text = match *format {
            "junit" => junit::refused(&named.name, error),
            "sarif" => sarif::refused(&named.file, error),
            _ => badge::not_judged(),
        };
        files.push(format, name, text.into_bytes());
    }
    files
}

/// Writes what says that a part was refused, in the formats that are asked for and in the place of what an earlier run left; the report of that run, if
/// there is one, stays and is returned.
pub fn tell(folder: &Path, formats: &[&str], part: &Path, error: &Error) -> Option<PathBuf> {
    let left = Record::of(folder).standing(folder);
    let stands = |name: &str| left.names().any(|n| n == name);
    let earlier = TELLING.iter().filter(|(_, name)| stands(name)).map(|(format, _)| *format);
    let wanted: Vec<&str> = formats.iter().copied().chain(earlier).collect();
    let files = files(&wanted, &Named::alone(part), error);
    let mut told = files.names();
    if !told.is_empty() && Delivery::open(folder).and_then(|delivery| delivery.deliver(files, &[part])).is_err() {
        // What cannot be written here is no worse than the refusal, which is told in any case.
        told.clear();
    }
    let others = TELLING.iter().map(|(_, name)| *name).filter(|name| !told.iter().any(|t| t == name));
    OF_JUDGED.into_iter().chain(others).find(|name| stands(name)).map(|name| folder.join(name))
}
