//! What to do with a damaged file.

/// Whether a damaged file is refused, or its whole facets are kept and the loss is said.
///
/// Refusing is the default everywhere: a part with missing facets is another part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Salvage {
    /// Damage is an error.
    #[default]
    Refuse,
    /// Facets that are whole and finite are kept, the others dropped, counted and reported as a notice.
    KeepWhole,
}
