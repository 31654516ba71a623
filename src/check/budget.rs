//! What finer looks may take, counted in samples, so that the same input gives the same answer on any machine.

/// The budget of one check for deciding what its first look left open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Budget {
    /// Finer looks taken.
    pub looks: u64,
    /// Samples that they took.
    pub spent: u64,
    /// Samples that are left.
    pub left: u64,
    /// The least samples that a look would have taken for which too few were left.
    pub lacking: Option<u64>,
    /// Looks that would have taken more memory than a window may.
    pub too_large: u64,
}

impl Budget {
    /// A whole one.
    pub fn of(samples: u64) -> Self {
        Budget { left: samples, ..Budget::default() }
    }

    /// What is advised where a budget of so many samples did not do, in millions: four times as much.
    ///
    /// ```
    /// use amcheck::check::Budget;
    /// assert_eq!([64_000_000, 1].map(Budget::more_than), [256, 1]);
    /// ```
    pub fn more_than(samples: u64) -> u64 {
        samples.saturating_mul(4).div_ceil(1_000_000)
    }

    /// Notes looks that were taken, whatever is left.
    ///
    /// ```
    /// use amcheck::check::Budget;
    /// let mut budget = Budget::of(1000);
    /// budget.note(1, 700);
    /// budget.note(2, 400);
    /// assert_eq!((budget.looks, budget.spent, budget.left), (3, 1100, 0));
    /// ```
    pub fn note(&mut self, looks: u64, samples: u64) {
        self.looks += looks;
        self.spent += samples;
        self.left = self.left.saturating_sub(samples);
    }

    /// Whether so many samples are left for a look; if not, that is noted.
    ///
    /// ```
    /// use amcheck::check::Budget;
    /// let mut budget = Budget::of(1000);
    /// assert!(budget.allows(1000) && !budget.allows(5000) && !budget.allows(3000));
    /// assert_eq!((budget.left, budget.lacking), (1000, Some(3000)));
    /// ```
    pub fn allows(&mut self, samples: u64) -> bool {
        if samples > self.left {
            self.lacking = Some(self.lacking.map_or(samples, |least| least.min(samples)));
        }
        samples <= self.left
    }
}
