//! What firmware keeps of a machine and takes back.

use super::machine::{Machine, Mode};
use super::unsupported;
use crate::error::Result;
use crate::geometry::vector::Vec3;

/// What `SAVE_GCODE_STATE` keeps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kept {
    at: Vec3,
    origin: Vec3,
    filament: f64,
    moves: Mode,
    extrusion: Option<Mode>,
    marlin: Mode,
}

impl Machine {
    /// Keeps modes, origin, filament and place under a name.
    pub(super) fn save(&mut self, name: Vec<u8>) {
        let Machine { at, origin, filament, moves, extrusion, marlin, .. } = *self;
        self.saved.retain(|(known, _)| *known != name);
        self.saved.push((name, Kept { at, origin, filament, moves, extrusion, marlin }));
    }

    /// Takes back what was kept; the machine moves back to the place only where it is told to.
    pub(super) fn restore(&mut self, line: u64, name: &[u8], moves_back: bool) -> Result<()> {
        let Some((_, kept)) = self.saved.iter().find(|(known, _)| known == name) else {
            return Err(unsupported(line, "a state that was not saved before (RESTORE_GCODE_STATE)"));
        };
        let Kept { at, origin, filament, moves, extrusion, marlin } = *kept;
        (self.origin, self.filament, self.moves, self.extrusion, self.marlin) =
            (origin, filament, moves, extrusion, marlin);
        if moves_back {
            self.at = at;
        }
        Ok(())
    }

    /// M121 takes back the modes that M120 kept in RepRapFirmware, and turns end stops on and off in Marlin: only where both leave the same modes is it told what follows.
    pub(super) fn pop(&mut self, line: u64) -> Result<()> {
        let now = [Some(self.moves), self.extrusion, Some(self.marlin)];
        match self.pushed.pop() {
            Some(kept) if kept != now => {
                Err(unsupported(line, "M121, which takes modes back on some machines and not on others,"))
            }
            _ => Ok(()),
        }
    }
}
