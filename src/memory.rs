//! Memory known before it is taken: what judging a part needs, and what it may have.

use crate::error::{Error, Result};
use crate::grid::Fitting;
use crate::io::machine::Ceiling;
use crate::units::{Length, short};

/// What the process takes whatever the part: code, threads, fonts, pictures, the page.
const FIXED: u128 = 112 << 20;

/// What one triangle takes: corners, edges, trees, features, its share of the display copy and of the page.
const PER_TRIANGLE: u128 = 3_000;

/// What one sample takes: the sets and the density, the fields that checks share, and the scratch of making them.
const PER_SAMPLE: u128 = 40;

/// Bytes that judging so many triangles on so many samples takes at its peak; a test measures that no more is taken.
pub fn need_bytes(triangles: u64, samples: u128) -> u128 {
    FIXED + PER_TRIANGLE * u128::from(triangles) + samples.saturating_mul(PER_SAMPLE)
}

/// What judging may take.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Allowance {
    /// Bytes that the user allows.
    pub bytes: u128,
    /// What the machine allows; it refuses and never coarsens, so that an answer is the same on every machine.
    pub ceiling: Option<Ceiling>,
}

impl Allowance {
    /// The largest file that is read: its bytes, what is welded from them and the mesh stand side by side for a moment.
    pub fn file_bytes(&self) -> u64 {
        let least = self.ceiling.iter().map(|c| u128::from(c.bytes)).fold(self.bytes, u128::min);
        u64::try_from(least / 3).unwrap_or(u64::MAX)
    }

    /// How many samples the user's allowance leaves beside the triangles.
    pub fn samples(&self, triangles: u64) -> u128 {
        self.bytes.saturating_sub(need_bytes(triangles, 0)) / PER_SAMPLE
    }

    /// Refuses more triangles than there is memory for, before anything is made of them.
    ///
    /// # Errors
    /// [`Error::TooLarge`] with the need.
    pub fn admit_triangles(&self, triangles: u64) -> Result<()> {
        let remedy = "reduce the number of triangles in the export".to_string();
        self.admit(format!("judging {triangles} triangles"), need_bytes(triangles, 0), remedy)
    }

    /// The grid of a spacing, if there is memory for it and the triangles.
    ///
    /// # Errors
    /// [`Error::TooLarge`] with the need and the spacing that fits.
    pub fn admit_spacing(&self, extent_mm: [f64; 3], spacing: Length, triangles: u64) -> Result<Fitting> {
        let fitting = Fitting::of(extent_mm, spacing);
        let need = need_bytes(triangles, fitting.samples);
        let least = self.ceiling.iter().map(|c| u128::from(c.bytes)).fold(self.bytes, u128::min);
        let left = least.saturating_sub(need_bytes(triangles, 0)).max(1);
        let remedy = || {
            let fits = Fitting::with_samples(extent_mm, spacing, left / PER_SAMPLE).spacing.as_mm();
            format!("--voxel {}mm fits", short((fits * 1e3).ceil() / 1e3))
        };
        let what = format!("a grid of {} samples at {spacing} with {triangles} triangles", fitting.samples);
        self.admit(what, need, if need > least { remedy() } else { String::new() })?;
        Ok(Fitting { bytes: need, ..fitting })
    }

    fn admit(&self, what: String, need_bytes: u128, remedy: String) -> Result<()> {
        if need_bytes > self.bytes {
            let remedy = format!("{remedy}, or allow more with --memory");
            return Err(Error::TooLarge { what, need_bytes, allowed_bytes: self.bytes, remedy });
        }
        match &self.ceiling {
            Some(c) if need_bytes > u128::from(c.bytes) => Err(Error::TooLarge {
                what,
                need_bytes,
                allowed_bytes: u128::from(c.bytes),
                remedy: format!("{remedy}; {} allows no more: raise it, or use a larger machine", c.whose),
            }),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn allowance(bytes: u128, ceiling: Option<u64>) -> Allowance {
        Allowance { bytes, ceiling: ceiling.map(|bytes| Ceiling { bytes, whose: "`ulimit -v`".into() }) }
    }

    #[test]
    fn what_is_refused_says_what_fits() {
        let one_gib = allowance(1 << 30, None);
        let refused = one_gib.admit_spacing([100.0; 3], Length::mm(0.01), 1000).unwrap_err();
        let fits = refused.remedy().split_whitespace().nth(1).map(|w| Length::parse(w).unwrap()).unwrap();
        let fitting = one_gib.admit_spacing([100.0; 3], fits, 1000).unwrap();
        assert!(fitting.bytes <= 1 << 30 && fitting.bytes > 7 << 27, "{fitting:?}");
        assert_eq!(one_gib.admit_triangles(20_000_000).unwrap_err().exit_code(), 5);
        assert!(one_gib.admit_triangles(100_000).is_ok());
    }

    #[test]
    fn the_machine_refuses_in_a_sentence() {
        let tight = allowance(4 << 30, Some(200 << 20));
        let refused = tight.admit_spacing([50.0; 3], Length::mm(0.12), 1000).unwrap_err();
        assert!(refused.exit_code() == 5 && refused.remedy().contains("`ulimit -v` allows no more"), "{refused}");
        assert_eq!(tight.file_bytes(), (200 << 20) / 3);
        assert!(tight.admit_spacing([50.0; 3], Length::mm(0.5), 1000).is_ok());
    }
}
