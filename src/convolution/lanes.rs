//! Eight complex numbers side by side, and the arithmetic of registers on them.
//!
//! A sum is never fused with a product, so that every processor rounds alike.

use super::square;
use super::transform::Real;
use pulp::Simd;

/// Complex numbers in a strip: a cache line of `f32`, two of `f64`.
pub(super) const WIDTH: usize = 8;

/// Neighbouring complex numbers, real parts first: what one register takes needs no shuffling.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Strip<T> {
    pub(super) re: [T; WIDTH],
    pub(super) im: [T; WIDTH],
}

/// Numbers that registers are made of, and what can be done with a register of them.
pub trait Lanes: Sized + Copy {
    /// A register.
    type Register<S: Simd>: Copy;
    /// The register at a place of half a strip.
    fn read<S: Simd>(from: &[Self; WIDTH], at: usize) -> Self::Register<S>;
    /// Puts a register back to its place.
    fn write<S: Simd>(to: &mut [Self; WIDTH], at: usize, value: Self::Register<S>);
    /// The same number in every lane.
    fn all<S: Simd>(simd: S, value: Self) -> Self::Register<S>;
    /// `a + b`.
    fn plus<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// `a − b`.
    fn minus<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// `a·b`.
    fn times<S: Simd>(simd: S, a: Self::Register<S>, b: Self::Register<S>) -> Self::Register<S>;
    /// Rows become columns.
    fn transposed<S: Simd>(simd: S, square: [&[Self; WIDTH]; WIDTH]) -> [[Self; WIDTH]; WIDTH];
}

macro_rules! lanes {
    ($number:ident, $register:ident, $split:ident, $split_mut:ident, $all:ident, $add:ident, $sub:ident, $mul:ident, $transposed:path) => {
        impl Lanes for $number {
            type Register<S: Simd> = S::$register;
            #[inline(always)]
            fn read<S: Simd>(from: &[Self; WIDTH], at: usize) -> S::$register {
                S::$split(from).0[at]
            }
            #[inline(always)]
            fn write<S: Simd>(to: &mut [Self; WIDTH], at: usize, value: S::$register) {
                S::$split_mut(to).0[at] = value;
            }
            #[inline(always)]
            fn all<S: Simd>(simd: S, value: Self) -> S::$register {
                simd.$all(value)
            }
            #[inline(always)]
            fn plus<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$add(a, b)
            }
            #[inline(always)]
            fn minus<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$sub(a, b)
            }
            #[inline(always)]
            fn times<S: Simd>(simd: S, a: S::$register, b: S::$register) -> S::$register {
                simd.$mul(a, b)
            }
            #[inline(always)]
            fn transposed<S: Simd>(simd: S, square: [&[Self; WIDTH]; WIDTH]) -> [[Self; WIDTH]; WIDTH] {
                $transposed(simd, square)
            }
        }
    };
}

lanes!(f32, f32s, as_simd_f32s, as_mut_simd_f32s, splat_f32s, add_f32s, sub_f32s, mul_f32s, square::transposed_f32);
lanes!(f64, f64s, as_simd_f64s, as_mut_simd_f64s, splat_f64s, add_f64s, sub_f64s, mul_f64s, square::transposed_f64);

/// A complex number in every lane: a register of real parts and one of imaginary parts.
pub(super) struct Wide<T: Real, S: Simd> {
    pub re: T::Register<S>,
    pub im: T::Register<S>,
    pub simd: S,
}

impl<T: Real, S: Simd> Clone for Wide<T, S> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Real, S: Simd> Copy for Wide<T, S> {}

impl<T: Real, S: Simd> Wide<T, S> {
    /// Such numbers in a strip.
    pub const COUNT: usize = WIDTH * size_of::<T>() / size_of::<T::Register<S>>();

    #[inline(always)]
    pub fn read(simd: S, strip: &Strip<T>, at: usize) -> Self {
        Wide { re: T::read::<S>(&strip.re, at), im: T::read::<S>(&strip.im, at), simd }
    }

    #[inline(always)]
    pub fn write(self, strip: &mut Strip<T>, at: usize) {
        T::write::<S>(&mut strip.re, at, self.re);
        T::write::<S>(&mut strip.im, at, self.im);
    }

    #[inline(always)]
    pub fn plus(self, b: Self) -> Self {
        Wide { re: T::plus(self.simd, self.re, b.re), im: T::plus(self.simd, self.im, b.im), ..self }
    }

    #[inline(always)]
    pub fn minus(self, b: Self) -> Self {
        Wide { re: T::minus(self.simd, self.re, b.re), im: T::minus(self.simd, self.im, b.im), ..self }
    }

    /// `self + i·b`.
    #[inline(always)]
    pub fn plus_i(self, b: Self) -> Self {
        Wide { re: T::minus(self.simd, self.re, b.im), im: T::plus(self.simd, self.im, b.re), ..self }
    }

    /// `self − i·b`.
    #[inline(always)]
    pub fn minus_i(self, b: Self) -> Self {
        Wide { re: T::plus(self.simd, self.re, b.im), im: T::minus(self.simd, self.im, b.re), ..self }
    }

    #[inline(always)]
    pub fn conjugate(self) -> Self {
        Wide { im: T::minus(self.simd, T::all(self.simd, T::zero()), self.im), ..self }
    }

    /// `by·self`.
    #[inline(always)]
    pub fn scaled(self, by: T) -> Self {
        let by = T::all(self.simd, by);
        Wide { re: T::times(self.simd, self.re, by), im: T::times(self.simd, self.im, by), ..self }
    }

    /// `(c + i·s)·self`.
    #[inline(always)]
    pub fn turned(self, [c, s]: [T; 2]) -> Self {
        let simd = self.simd;
        let [c, s] = [c, s].map(|v| T::all(simd, v));
        Wide {
            re: T::minus(simd, T::times(simd, self.re, c), T::times(simd, self.im, s)),
            im: T::plus(simd, T::times(simd, self.re, s), T::times(simd, self.im, c)),
            simd,
        }
    }
}
