//! What a layer rests on: downward surface, islands, supports.
