//! What goes to standard output.

use crate::error::{Error, Result, printable};
use std::io::{ErrorKind, Write};

/// Writes to standard output at once; a reader that has gone away (`| head`) is no error.
///
/// # Errors
/// [`Error::CannotWrite`] for everything else that keeps the text from getting there, such as a full disk.
pub fn put(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    outcome(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// What has become of something written to standard output, as [`put`] says it.
///
/// # Errors
/// As [`put`].
pub fn outcome(written: std::io::Result<()>) -> Result<()> {
    match written {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Error::CannotWrite { path: "standard output".into(), reason: printable(&e.to_string()) })
        }
        _ => Ok(()),
    }
}
