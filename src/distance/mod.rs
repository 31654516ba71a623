//! Distances on grids alone: the exact Euclidean transform, nearest features, the reverse transform, the ridge.
