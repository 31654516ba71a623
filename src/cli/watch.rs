//! `amcheck PART --watch`: judges again whenever a file has changed, and says what became different.

use super::args::Arguments;
use super::command;
use super::complaint::Answer;
use super::judge::{Judged, judged, said};
use super::stdout::put;
use crate::error::printable;
use crate::report::baseline::{self, compare};
use crate::report::terminal;
use sha2::{Digest, Sha256};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Time between two looks at the files.
const LOOK: Duration = Duration::from_millis(250);

/// Judges a part now and after every change of it, of its process file or of its acceptances; returns only when the first
/// run fails, or what is said cannot be written. Ctrl-C ends it.
///
/// # Errors
/// Those of the first run; later ones are printed, because a file may be looked at while it is being saved.
pub fn watch(a: &Arguments) -> Answer<(String, u8)> {
    let files = files(a);
    let mut seen = Seen::of(&files);
    let mut last = judged(a)?;
    put(&said(a, &last))?;
    put(&format!("watching {}; Ctrl-C ends\n", count(files.len())))?;
    loop {
        std::thread::sleep(LOOK);
        match seen.look(&files) {
            Sight::Same => {}
            Sight::Gone(file) => {
                let name = printable(&file.to_string_lossy());
                let text = format!("note: {name} is gone; it is judged again when it is back\n");
                let _ = std::io::stderr().lock().write_all(text.as_bytes());
            }
            Sight::Changed => match judged(a) {
                Ok(now) => {
                    put(&difference(a, &last, &now))?;
                    last = now;
                }
                Err(complaint) => command::complain(&complaint),
            },
        }
    }
}

/// The verdict and what changed since the last run.
fn difference(a: &Arguments, last: &Judged, now: &Judged) -> String {
    if a.json {
        return said(a, now);
    }
    let palette = command::palette(std::io::stdout().is_terminal());
    let changes = compare(&last.report, &now.report);
    let mut text = format!("\n{}", terminal::verdict_line(&now.report, palette));
    if !a.quiet {
        let what = if changes.is_same() { "no finding changed\n".into() } else { baseline::text(&changes, palette) };
        text.push_str(&what);
    }
    text
}

/// Every file that the answer depends on.
fn files(a: &Arguments) -> Vec<PathBuf> {
    let process = Path::new(&a.how.process);
    let named = a.part.iter().chain(&a.how.accept).cloned();
    named.chain(process.is_file().then(|| process.to_path_buf())).collect()
}

fn count(files: usize) -> String {
    if files == 1 { "1 file".into() } else { format!("{files} files") }
}

/// Time of change and length of each file; `None` for one that is not there.
type Marks = Vec<Option<(SystemTime, u64)>>;

/// What the files were when they were last judged.
struct Seen {
    marks: Marks,
    digest: Vec<u8>,
    /// Whether it was told that one of them is gone.
    told: bool,
}

/// What a look at the files shows.
enum Sight<'f> {
    /// Nothing that is to be judged or told.
    Same,
    /// A file that was there is not, as is told once.
    Gone(&'f Path),
    /// Other bytes than last time.
    Changed,
}

impl Seen {
    fn of(files: &[PathBuf]) -> Self {
        Seen { marks: marks(files), digest: digest(files), told: false }
    }

    /// Looks whether the files have other bytes than last time and have come to rest.
    fn look<'f>(&mut self, files: &'f [PathBuf]) -> Sight<'f> {
        let now = marks(files);
        if now == self.marks {
            self.told = false;
            return Sight::Same;
        }
        std::thread::sleep(LOOK);
        // Still being written, or between being removed and written anew: look again later.
        if marks(files) != now {
            return Sight::Same;
        }
        if let Some((file, _)) = files.iter().zip(&now).find(|(_, mark)| mark.is_none()) {
            return if std::mem::replace(&mut self.told, true) { Sight::Same } else { Sight::Gone(file) };
        }
        (self.marks, self.told) = (now, false);
        let digest = digest(files);
        if std::mem::replace(&mut self.digest, digest) == self.digest { Sight::Same } else { Sight::Changed }
    }
}

fn marks(files: &[PathBuf]) -> Marks {
    let mark = |file: &PathBuf| {
        let about = std::fs::metadata(file).ok()?;
        Some((about.modified().ok()?, about.len()))
    };
    files.iter().map(mark).collect()
}

fn digest(files: &[PathBuf]) -> Vec<u8> {
    let mut all = Sha256::new();
    for file in files {
        // A file that cannot be read counts as empty here; judging it says why.
        all.update(Sha256::digest(std::fs::read(file).unwrap_or_default()));
    }
    all.finalize().to_vec()
}
