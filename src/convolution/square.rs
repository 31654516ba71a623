//! Squares of eight by eight numbers, rows made columns.
//!
//! Written out for AVX2, where the compiler moves one number at a time: a transform of 128³ in f32 then takes 1.4 ms
//! instead of 1.0.

use super::lanes::WIDTH;
use pulp::Simd;

#[inline(always)]
pub(super) fn transposed_f32<S: Simd>(simd: S, square: [&[f32; WIDTH]; WIDTH]) -> [[f32; WIDTH]; WIDTH] {
    #[cfg(target_arch = "x86_64")]
    if let Some(v3) = avx::token(simd) {
        return avx::transposed_f32(v3, square);
    }
    plain(simd, square)
}

#[inline(always)]
pub(super) fn transposed_f64<S: Simd>(simd: S, square: [&[f64; WIDTH]; WIDTH]) -> [[f64; WIDTH]; WIDTH] {
    #[cfg(target_arch = "x86_64")]
    if let Some(v3) = avx::token(simd) {
        return avx::transposed_f64(v3, square);
    }
    plain(simd, square)
}

#[inline(always)]
fn plain<S: Simd, T: Copy>(_simd: S, square: [&[T; WIDTH]; WIDTH]) -> [[T; WIDTH]; WIDTH] {
    std::array::from_fn(|i| std::array::from_fn(|j| square[j][i]))
}

#[cfg(target_arch = "x86_64")]
mod avx {
    use pulp::x86::V3;
    use pulp::{Simd, cast};
    use std::any::Any;
    use std::arch::x86_64::{__m256, __m256d};

    /// The leave to use AVX2, where `simd` is that; decided when compiled.
    #[inline(always)]
    pub fn token<S: Simd>(simd: S) -> Option<V3> {
        (&simd as &dyn Any).downcast_ref::<V3>().copied()
    }

    #[inline(always)]
    pub fn transposed_f32(v3: V3, [a, b, c, d, e, f, g, h]: [&[f32; 8]; 8]) -> [[f32; 8]; 8] {
        // Within each half of 128 bits first, then halves.
        let [i, j, k, l] = halves_f32(v3, [cast(*a), cast(*b), cast(*c), cast(*d)]);
        let [m, n, o, p] = halves_f32(v3, [cast(*e), cast(*f), cast(*g), cast(*h)]);
        [
            cast(v3.avx._mm256_permute2f128_pd::<0x20>(i, m)),
            cast(v3.avx._mm256_permute2f128_pd::<0x20>(j, n)),
            cast(v3.avx._mm256_permute2f128_pd::<0x20>(k, o)),
            cast(v3.avx._mm256_permute2f128_pd::<0x20>(l, p)),
            cast(v3.avx._mm256_permute2f128_pd::<0x31>(i, m)),
            cast(v3.avx._mm256_permute2f128_pd::<0x31>(j, n)),
            cast(v3.avx._mm256_permute2f128_pd::<0x31>(k, o)),
            cast(v3.avx._mm256_permute2f128_pd::<0x31>(l, p)),
        ]
    }

    #[inline(always)]
    fn halves_f32(v3: V3, [a, b, c, d]: [__m256; 4]) -> [__m256d; 4] {
        let low: [__m256d; 2] = [cast(v3.avx._mm256_unpacklo_ps(a, b)), cast(v3.avx._mm256_unpacklo_ps(c, d))];
        let high: [__m256d; 2] = [cast(v3.avx._mm256_unpackhi_ps(a, b)), cast(v3.avx._mm256_unpackhi_ps(c, d))];
        [
            v3.avx._mm256_unpacklo_pd(low[0], low[1]),
            v3.avx._mm256_unpackhi_pd(low[0], low[1]),
            v3.avx._mm256_unpacklo_pd(high[0], high[1]),
            v3.avx._mm256_unpackhi_pd(high[0], high[1]),
        ]
    }

    #[inline(always)]
    pub fn transposed_f64(v3: V3, [a, b, c, d, e, f, g, h]: [&[f64; 8]; 8]) -> [[f64; 8]; 8] {
        let [[a, i], [b, j], [c, k], [d, l]] = [cast(*a), cast(*b), cast(*c), cast(*d)];
        let [[e, m], [f, n], [g, o], [h, p]] = [cast(*e), cast(*f), cast(*g), cast(*h)];
        let (upper, upper_right) = (quarter_f64(v3, [a, b, c, d]), quarter_f64(v3, [i, j, k, l]));
        let (lower, lower_right) = (quarter_f64(v3, [e, f, g, h]), quarter_f64(v3, [m, n, o, p]));
        [
            cast([upper[0], lower[0]]),
            cast([upper[1], lower[1]]),
            cast([upper[2], lower[2]]),
            cast([upper[3], lower[3]]),
            cast([upper_right[0], lower_right[0]]),
            cast([upper_right[1], lower_right[1]]),
            cast([upper_right[2], lower_right[2]]),
            cast([upper_right[3], lower_right[3]]),
        ]
    }

    #[inline(always)]
    fn quarter_f64(v3: V3, [a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
        let (even, odd) = (v3.avx._mm256_unpacklo_pd(a, b), v3.avx._mm256_unpackhi_pd(a, b));
        let (even_below, odd_below) = (v3.avx._mm256_unpacklo_pd(c, d), v3.avx._mm256_unpackhi_pd(c, d));
        [
            v3.avx._mm256_permute2f128_pd::<0x20>(even, even_below),
            v3.avx._mm256_permute2f128_pd::<0x20>(odd, odd_below),
            v3.avx._mm256_permute2f128_pd::<0x31>(even, even_below),
            v3.avx._mm256_permute2f128_pd::<0x31>(odd, odd_below),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::{Arch, WithSimd};

    struct Squares([[f32; 8]; 8], [[f64; 8]; 8]);

    impl WithSimd for Squares {
        type Output = Self;
        fn with_simd<S: Simd>(self, simd: S) -> Self {
            Squares(transposed_f32(simd, self.0.each_ref()), transposed_f64(simd, self.1.each_ref()))
        }
    }

    #[test]
    fn rows_become_columns_whatever_the_machine_can() {
        let number = |i: usize, j: usize| (8 * i + j) as f32;
        let square: [[f32; 8]; 8] = std::array::from_fn(|i| std::array::from_fn(|j| number(i, j)));
        let squares = || Squares(square, square.map(|row| row.map(f64::from)));
        for found in [Arch::new().dispatch(squares()), squares().with_simd(pulp::Scalar::new())] {
            for (i, j) in (0..64).map(|at| (at / 8, at % 8)) {
                assert_eq!((found.0[i][j], found.1[i][j]), (number(j, i), number(j, i).into()));
            }
        }
    }
}
