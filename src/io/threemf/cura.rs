//! What Cura writes into an object: what its mesh is for.

use super::role::Role;

pub(super) const CURA: &str = "http://software.ultimaker.com/xml/cura/3mf/2015/10";

/// The settings of one object that bear on whether its mesh is material.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Cura {
    support: bool,
    blocker: bool,
    infill: bool,
    cutting: bool,
    no_walls: bool,
    no_infill: bool,
}

impl Cura {
    /// Takes in one setting, its key without the prefix.
    pub(super) fn set(&mut self, key: &str, value: &str) {
        let holds = value.trim().eq_ignore_ascii_case("true") || value.trim() == "1";
        let is_zero = value.trim().parse::<f64>() == Ok(0.0);
        match key {
            "support_mesh" => self.support = holds,
            "anti_overhang_mesh" => self.blocker = holds,
            "infill_mesh" => self.infill = holds,
            "cutting_mesh" => self.cutting = holds,
            "wall_thickness" | "wall_line_count" => self.no_walls |= is_zero,
            "infill_sparse_density" | "infill_line_distance" => self.no_infill |= is_zero,
            _ => {}
        }
    }

    /// What the mesh is for. A cutting mesh prints what it cuts out by its own settings, so it takes material away
    /// only if these leave neither walls nor infill.
    pub(super) fn role(self) -> Role {
        if self.support {
            Role::Support
        } else if self.blocker {
            Role::SupportBlocker
        } else if self.cutting && self.no_walls && self.no_infill {
            Role::Negative
        } else if self.cutting || self.infill {
            Role::Modifier
        } else {
            Role::Material
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn role(settings: &[(&str, &str)]) -> Role {
        let mut cura = Cura::default();
        settings.iter().for_each(|(key, value)| cura.set(key, value));
        cura.role()
    }

    #[test]
    fn a_mesh_is_for_what_its_settings_say() {
        assert_eq!(role(&[("infill_sparse_density", "0"), ("wall_line_count", "0")]), Role::Material);
        assert_eq!(role(&[("support_mesh", "True")]), Role::Support);
        assert_eq!(role(&[("support_mesh", "False"), ("anti_overhang_mesh", "true")]), Role::SupportBlocker);
        assert_eq!(role(&[("infill_mesh", "True"), ("infill_sparse_density", "0")]), Role::Modifier);
        assert_eq!(role(&[("cutting_mesh", "True"), ("wall_line_count", "3")]), Role::Modifier);
        let hole = [("wall_thickness", "0.0"), ("cutting_mesh", "True"), ("infill_sparse_density", "0")];
        assert_eq!(role(&hole), Role::Negative);
    }
}
