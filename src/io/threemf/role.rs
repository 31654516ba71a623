//! What slicers take a volume for where it is not simply printed.

/// What a slicer does with a volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Role {
    Material,
    /// Other settings hold inside it; what it overlaps with stays material.
    Modifier,
    SupportBlocker,
    SupportEnforcer,
    /// Printed as support.
    Support,
    /// Taken out of what it overlaps with.
    Negative,
}

impl Role {
    /// By the words of Bambu Studio and OrcaSlicer or those of PrusaSlicer; any other is material, as it is to them.
    pub(super) fn named(word: &str) -> Role {
        match word {
            "modifier_part" | "ParameterModifier" => Role::Modifier,
            "support_blocker" | "SupportBlocker" => Role::SupportBlocker,
            "support_enforcer" | "SupportEnforcer" => Role::SupportEnforcer,
            "negative_part" | "NegativeVolume" => Role::Negative,
            _ => Role::Material,
        }
    }

    /// The words for one and for several such volumes.
    pub(super) fn words(self) -> [&'static str; 2] {
        match self {
            Role::Material => ["volume", "volumes"],
            Role::Modifier => ["modifier", "modifiers"],
            Role::SupportBlocker => ["support blocker", "support blockers"],
            Role::SupportEnforcer => ["support enforcer", "support enforcers"],
            Role::Support => ["support mesh", "support meshes"],
            Role::Negative => ["negative volume", "negative volumes"],
        }
    }
}
