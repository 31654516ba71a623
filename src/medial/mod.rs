//! Where grid and mesh meet: medial balls, feature pairs, witnesses and covers.
