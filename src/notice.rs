//! What a stage noticed on its way and the report must repeat: never an error, never silent.

use serde::{Deserialize, Serialize};

/// One remark about the input or about how it was analysed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Notice {
    /// Stable short name, such as `open-edges` or `units-guess`.
    pub code: String,
    /// One sentence for a person, with the numbers in it.
    pub message: String,
    /// How many of the thing there are, where it can be counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u64>,
    /// The worst place in the frame of the input file, millimetres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_mm: Option<[f64; 3]>,
}

impl Notice {
    /// A notice without count or place.
    pub fn new(code: &str, message: impl Into<String>) -> Self {
        Notice { code: code.into(), message: message.into(), count: None, at_mm: None }
    }

    /// That a file of a format carries no unit.
    pub fn units_assumed(format: &str) -> Self {
        Notice::new("units-assumed", format!("{format} carries no unit; millimetres were assumed"))
    }

    /// The same notice, said to be of what was read and not of what was made of it.
    pub fn as_read(self) -> Self {
        Notice { message: format!("as read: {}", self.message), ..self }
    }

    /// The same notice with a count.
    pub fn counted(mut self, count: u64) -> Self {
        self.count = Some(count);
        self
    }

    /// The same notice with a place in millimetres.
    pub fn at(mut self, place_mm: [f64; 3]) -> Self {
        self.at_mm = Some(place_mm);
        self
    }
}

/// A count with the words for one and for several of what is counted.
///
/// ```
/// use amcheck::notice::number_of;
/// assert_eq!(number_of(1, ["edge is open", "edges are open"]), "1 edge is open");
/// assert_eq!(number_of(576, ["edge is open", "edges are open"]), "576 edges are open");
/// ```
pub fn number_of(count: u64, [one, several]: [&str; 2]) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}
