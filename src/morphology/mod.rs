//! Dilation, erosion, opening, closing, offset, sweep: the words of the field, and nothing else.
