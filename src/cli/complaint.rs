//! An error with the file it is about.

use crate::error::Error;
use std::path::{Path, PathBuf};

/// What a command hands back: its result, or what is to be said instead.
pub type Answer<T> = Result<T, Complaint>;

/// What is said when a command fails.
#[derive(Debug)]
pub struct Complaint {
    pub error: Box<Error>,
    /// The file in which the trouble sits, where it sits in one.
    pub file: Option<PathBuf>,
    /// What else has to be known.
    pub note: Option<String>,
}

impl Complaint {
    /// An error in a file.
    pub fn about(file: Option<&Path>, error: Error) -> Self {
        Complaint { error: Box::new(error), file: file.map(Path::to_path_buf), note: None }
    }
}

impl From<Error> for Complaint {
    fn from(error: Error) -> Self {
        Complaint { error: Box::new(error), file: None, note: None }
    }
}
