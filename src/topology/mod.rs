//! Components, Betti numbers and escape diameters of sets of samples.
