//! The tools inside the binary, and the ones a process or a user chooses: data only.

use super::finishing::Finishing;
use crate::error::{Error, Result, nearest, printable};
use crate::geometry::TriangleMesh;

/// Name and description of every built-in tool.
pub const TOOLS: &[(&str, &str)] = &[
    ("end-mill-6", include_str!("builtin/tools/end-mill-6.toml")),
    ("end-mill-3", include_str!("builtin/tools/end-mill-3.toml")),
    ("ball-mill-6", include_str!("builtin/tools/ball-mill-6.toml")),
    ("deburring-cone", include_str!("builtin/tools/deburring-cone.toml")),
    ("flush-cutter", include_str!("builtin/tools/flush-cutter.toml")),
    ("long-nose-pliers", include_str!("builtin/tools/long-nose-pliers.toml")),
    ("blast-nozzle", include_str!("builtin/tools/blast-nozzle.toml")),
    ("brush", include_str!("builtin/tools/brush.toml")),
    ("tap-m3", include_str!("builtin/tools/tap-m3.toml")),
    ("tap-m5", include_str!("builtin/tools/tap-m5.toml")),
    ("touch-probe", include_str!("builtin/tools/touch-probe.toml")),
];

/// A tool as it was chosen: its description, and the mesh that the description names or is.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolChoice {
    pub name: String,
    /// TOML; empty for a tool that is nothing but a mesh.
    pub text: String,
    pub mesh: Option<TriangleMesh>,
}

impl ToolChoice {
    /// A built-in tool.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with the nearest name.
    pub fn named(name: &str) -> Result<Self> {
        TOOLS
            .iter()
            .find(|(n, _)| *n == name)
            .map(|(n, text)| ToolChoice { name: n.to_string(), text: text.to_string(), mesh: None })
            .ok_or_else(|| Error::UnknownName {
                what: "tool",
                given: printable(name),
                nearest: nearest(name, TOOLS.iter().map(|(n, _)| *n)),
                known: TOOLS.iter().map(|(n, _)| n.to_string()).collect(),
            })
    }
}

/// The tools of a process.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tools {
    /// What supports are taken off with.
    pub removal: Vec<ToolChoice>,
    /// What surfaces are finished with.
    pub finishing: Vec<ToolChoice>,
    /// Whether the user named them: others never make a part fail.
    pub named: bool,
    /// Where finishing tools come from, and what they have to touch.
    pub finish: Finishing,
}

impl Tools {
    /// The tools a user names, for supports and for surfaces alike, in place of these.
    pub fn replaced(self, list: Vec<ToolChoice>) -> Self {
        Tools { removal: list.clone(), finishing: list, named: true, finish: self.finish }
    }
}
