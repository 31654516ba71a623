//! Processes: limits with value, unit, basis and source.
