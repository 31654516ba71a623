//! What firmware keeps of a machine and takes back.

use super::machine::{Machine, Mode};
use super::unsupported;
use crate::error::Result;
use crate::geometry::vector::Vec3;

/// The modes of moves and of E.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Modes {
    moves: Mode,
    extrusion: Option<Mode>,
    marlin: Mode,
}

/// What `SAVE_GCODE_STATE` keeps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kept {
    at: Vec3,
    origin: Vec3,
    filament: f64,
    modes: Modes,
}

impl Machine {
    /// Keeps modes, origin, filament and place under a name.
    pub(super) fn save(&mut self, name: Vec<u8>) {
        let kept = Kept { at: self.at, origin: self.origin, filament: self.filament, modes: self.modes() };
        self.saved.retain(|(known, _)| *known != name);
        self.saved.push((name, kept));
    }

    fn modes(&self) -> Modes {
        Modes { moves: self.moves, extrusion: self.extrusion, marlin: self.marlin }
    }

    /// Takes back what was kept; the machine moves back to the place only where it is told to.
    pub(super) fn restore(&mut self, line: u64, name: &[u8], moves_back: bool) -> Result<()> {
        let Some((_, kept)) = self.saved.iter().find(|(known, _)| known == name) else {
            return Err(unsupported(line, "a state that was not saved before (RESTORE_GCODE_STATE)"));
        };
        let Kept { at, origin, filament, modes: Modes { moves, extrusion, marlin } } = *kept;
        (self.origin, self.filament) = (origin, filament);
        (self.moves, self.extrusion, self.marlin) = (moves, extrusion, marlin);
        if moves_back {
            self.at = at;
        }
        Ok(())
    }

    /// M120 keeps the modes in RepRapFirmware.
    pub(super) fn push_modes(&mut self) {
        self.pushed.push(self.modes());
    }

    /// M121 takes back the modes that M120 kept in RepRapFirmware, and turns end stops on and off in Marlin: only where both leave the same modes is it told what follows.
    pub(super) fn pop_modes(&mut self, line: u64) -> Result<()> {
        match self.pushed.pop() {
            Some(kept) if kept != self.modes() => {
                Err(unsupported(line, "M121, which takes modes back on some machines and not on others,"))
            }
            _ => Ok(()),
        }
    }
}
