//! Convolution and correlation by real 3-D Fourier transforms, with exact counts where a verdict rests on them.
