//! Lengths, areas, volumes and angles as types, so that no bare number has to be trusted.
//!
//! Inside, lengths are millimetres and angles radians; text such as `0.4mm`, `400um` or `45deg` is read
//! at the edges only. There is no `From<f64>`: a unit is always said.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $make:ident, $read:ident, $suffix:literal) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(f64);

        impl $name {
            /// The quantity from its number in the unit of this constructor.
            pub const fn $make(value: f64) -> Self {
                Self(value)
            }
            /// The number in the unit of this accessor.
            pub const fn $read(self) -> f64 {
                self.0
            }
            /// The smaller of the two.
            pub fn min(self, other: Self) -> Self {
                Self(self.0.min(other.0))
            }
            /// The larger of the two.
            pub fn max(self, other: Self) -> Self {
                Self(self.0.max(other.0))
            }
        }
        impl Add for $name {
            type Output = Self;
            fn add(self, o: Self) -> Self { Self(self.0 + o.0) }
        }
        impl Sub for $name {
            type Output = Self;
            fn sub(self, o: Self) -> Self { Self(self.0 - o.0) }
        }
        impl Neg for $name {
            type Output = Self;
            fn neg(self) -> Self { Self(-self.0) }
        }
        impl Mul<f64> for $name {
            type Output = Self;
            fn mul(self, k: f64) -> Self { Self(self.0 * k) }
        }
        impl Div<f64> for $name {
            type Output = Self;
            fn div(self, k: f64) -> Self { Self(self.0 / k) }
        }
        impl Div for $name {
            type Output = f64;
            fn div(self, o: Self) -> f64 { self.0 / o.0 }
        }
    };
}

quantity!(
    /// A length in millimetres.
    Length, mm, as_mm, "mm"
);
quantity!(
    /// An area in square millimetres.
    Area, mm2, as_mm2, "mm²"
);
quantity!(
    /// A volume in cubic millimetres.
    Volume, mm3, as_mm3, "mm³"
);
quantity!(
    /// An angle in radians.
    Angle, radians, as_radians, "rad"
);

impl Mul for Length {
    type Output = Area;
    fn mul(self, o: Length) -> Area {
        Area(self.0 * o.0)
    }
}
impl Mul<Length> for Area {
    type Output = Volume;
    fn mul(self, o: Length) -> Volume {
        Volume(self.0 * o.0)
    }
}

impl Angle {
    /// An angle from degrees.
    pub fn degrees(value: f64) -> Self {
        Angle(value.to_radians())
    }
    /// The angle in degrees.
    pub fn as_degrees(self) -> f64 {
        self.0.to_degrees()
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} mm", short(self.0))
    }
}
impl fmt::Display for Area {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} mm²", short(self.0))
    }
}
impl fmt::Display for Volume {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} mm³", short(self.0))
    }
}
impl fmt::Display for Angle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}°", short(self.as_degrees()))
    }
}

/// A number for people: at most four decimals, no trailing zeros, never `-0`.
///
/// ```
/// assert_eq!(amcheck::units::short(0.3500), "0.35");
/// assert_eq!(amcheck::units::short(46591.9081), "46591.9");
/// assert_eq!(amcheck::units::short(-0.0), "0");
/// assert_eq!(amcheck::units::short(0.03125), "0.0313");
/// ```
pub fn short(value: f64) -> String {
    let decimals = decimals_shown(value);
    let text = format!("{:.decimals$}", nearest(value, decimals));
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}

/// Decimals that [`short`] shows of a number.
fn decimals_shown(value: f64) -> usize {
    match value.abs() {
        v if v >= 1000.0 => 1,
        v if v >= 100.0 => 2,
        v if v >= 10.0 => 3,
        _ => 4,
    }
}

/// A number at so many decimals; what lies in the middle goes away from zero, where formatting takes the even digit.
fn nearest(value: f64, decimals: usize) -> f64 {
    let scale = 10f64.powi(decimals as i32);
    let rounded = (value * scale).round() / scale;
    if rounded.is_finite() { rounded } else { value }
}

/// A length with as many digits as it takes to tell it from its neighbours, where [`short`] ones would read alike.
///
/// ```
/// use amcheck::units::{Length, exact};
/// assert_eq!(exact(Length::mm(0.1 + 0.2)), "0.30000000000000004 mm");
/// assert_eq!(exact(Length::mm(1e-9)), "1e-9 mm");
/// ```
pub fn exact(length: Length) -> String {
    format!("{:?} mm", length.as_mm())
}

/// The name of a unit of so many millimetres.
///
/// ```
/// assert_eq!(amcheck::units::unit_name(25.4), "in");
/// assert_eq!(amcheck::units::unit_name(2.5), "2.5 mm");
/// ```
pub fn unit_name(mm: f64) -> String {
    let known = [("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("in", 25.4), ("ft", 304.8), ("um", 0.001)];
    known.iter().find(|k| k.1 == mm).map_or_else(|| format!("{} mm", short(mm)), |k| k.0.into())
}

/// A number for people, to hundredths.
///
/// ```
/// assert_eq!(amcheck::units::hundredths(4.996), "5");
/// ```
pub fn hundredths(value: f64) -> String {
    short((value * 100.0).round() / 100.0)
}

/// Decimals that show a bracket to two digits of its width, 0 to 4.
pub fn decimals_of(width: f64) -> usize {
    if width > 1e-9 { (1.0 - width.log10().floor()).clamp(0.0, 4.0) as usize } else { 4 }
}

/// Decimals that tell a number above 0 from it, 0 to 4.
pub fn decimals_above_zero(x: f64) -> usize {
    if x > 0.0 { (-x.log10().floor()).clamp(0.0, 4.0) as usize } else { 0 }
}

/// A value at the digits that its bracket supports, as reports tell it: what is there for certain is not told as nothing.
///
/// ```
/// assert_eq!(amcheck::units::told(0.4501, 0.446, 0.4501), 0.4501);
/// assert_eq!(amcheck::units::told(0.4501, 0.41, 0.47), 0.45);
/// assert_eq!(amcheck::units::told(0.09, 0.08, 18.0), 0.09);
/// ```
pub fn told(value: f64, low: f64, high: f64) -> f64 {
    let width = high - low;
    if width <= 1e-6 {
        return value;
    }
    // Rounded once: to more decimals than are shown would be rounded again.
    let at = |decimals: usize| nearest(value, decimals.min(decimals_shown(value)));
    let told = at(decimals_of(width));
    if told < low { at(decimals_of(width).max(decimals_above_zero(low))) } else { told }
}

/// A number and the two that it lies between, for people: rounded outwards, at as many digits as tell a hundredth of the bracket, and four at least.
///
/// ```
/// assert_eq!(amcheck::units::enclosed(1.35871e-5, [1.3412e-5, 1.3688e-5]), ["0.000013587", "0.000013412", "0.000013688"]);
/// assert_eq!(amcheck::units::enclosed(38.5, [31.73, 38.95]), ["38.5", "31.73", "38.95"]);
/// ```
pub fn enclosed(value: f64, [low, high]: [f64; 2]) -> [String; 3] {
    let below = |x: f64| if x > 0.0 && x.is_finite() { (-x.log10().floor()) as i32 } else { 0 };
    let largest = value.abs().max(low.abs()).max(high.abs());
    let decimals = (below(high - low) + 2).max(below(largest) + 3).clamp(0, 15);
    let scale = 10f64.powi(decimals);
    let shown = |x: f64, round: fn(f64) -> f64| {
        // A number of so many digits is itself, whatever the product of it is.
        let (nearest, rounded) = ((x * scale).round(), round(x * scale));
        let whole = if (x * scale - nearest).abs() <= 4.0 * f64::EPSILON * nearest.abs() { nearest } else { rounded };
        let text = format!("{:.*}", decimals as usize, whole / scale);
        let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        if text == "-0" { "0".to_string() } else { text.to_string() }
    };
    [shown(value, f64::round), shown(low, f64::floor), shown(high, f64::ceil)]
}

/// By how many millimetres to change a length, in hundredths, rounded up so that the change is enough.
///
/// ```
/// assert_eq!(amcheck::units::enough(0.8 - 0.081153), "0.72");
/// ```
pub fn enough(by: f64) -> String {
    // A ten-thousandth of a hundredth is rounding.
    short((100.0 * by - 1e-4).ceil() / 100.0)
}

/// An area or a volume for people: two decimals below ten, whole above; what rounds to nothing is at least said to be little.
///
/// ```
/// assert_eq!([0.001, 4.537, 467.9].map(amcheck::units::coarse), ["< 0.01", "4.54", "468"]);
/// ```
pub fn coarse(value: f64) -> String {
    match value {
        0.0..0.005 => "< 0.01".into(),
        0.005..10.0 => short((value * 100.0).round() / 100.0),
        _ => short(value.round()),
    }
}

/// A volume in mm³ for people, at three digits: cubic centimetres from 1000 mm³ on.
///
/// ```
/// assert_eq!(amcheck::units::bulk(112.64), "113 mm³");
/// assert_eq!(amcheck::units::bulk(52953.2), "53 cm³");
/// ```
pub fn bulk(mm3: f64) -> String {
    let (value, unit) = if mm3 >= 1000.0 { (mm3 / 1000.0, "cm³") } else { (mm3, "mm³") };
    let decimals = if value > 0.0 { (2.0 - value.log10().floor()).clamp(0.0, 4.0) } else { 0.0 };
    let scale = 10f64.powf(decimals);
    format!("{} {unit}", short((value * scale).round() / scale))
}

/// A volume in words with the bounds around it: those once only that read alike.
///
/// ```
/// use amcheck::units::bulk_within;
/// assert_eq!(bulk_within(6120.0, [5900.0, 6310.0]), "6.12 cm³ (5.9 cm³ to 6.31 cm³)");
/// assert_eq!(bulk_within(6120.0, [6119.9, 6120.1]), "6.12 cm³");
/// ```
pub fn bulk_within(mm3: f64, bounds: [f64; 2]) -> String {
    match (bulk(mm3), bounds.map(bulk)) {
        (value, [low, high]) if low == high => value,
        (value, [low, high]) => format!("{value} ({low} to {high})"),
    }
}

/// A number rounded to the report's resolution of 1e-6, so that reports are equal byte for byte.
pub fn report_digits(value: f64) -> f64 {
    let rounded = (value * 1e6).round() / 1e6;
    if rounded == 0.0 { 0.0 } else { rounded }
}

impl Length {
    /// A positive or zero length from text with a unit: `0.4mm`, `400um`, `2in`, `1cm`, `0.1m`.
    ///
    /// A bare number is millimetres.
    ///
    /// # Errors
    /// [`Error::Usage`] for anything that is not a finite number with a known unit.
    ///
    /// ```
    /// use amcheck::units::Length;
    /// assert_eq!(Length::parse("400um").unwrap().as_mm(), 0.4);
    /// assert!(Length::parse("1,5mm").is_err());
    /// ```
    pub fn parse(text: &str) -> Result<Self> {
        let (number, unit) = split_unit(text)?;
        let scale = match unit {
            "" | "mm" => 1.0,
            "um" | "µm" | "micron" => 1e-3,
            "cm" => 10.0,
            "m" => 1000.0,
            "in" | "inch" => 25.4,
            _ => return Err(bad_quantity(text, "a length such as 0.4mm, 400um, 1in")),
        };
        // Division keeps 400um == 0.4 exactly, where multiplying by 1e-3 would not.
        Ok(Length(if scale == 1e-3 { number / 1000.0 } else { number * scale }))
    }
}

impl Angle {
    /// An angle from text: `45deg`, `45°`, `0.7rad`; a bare number is degrees.
    ///
    /// # Errors
    /// [`Error::Usage`] for anything that is not a finite number with a known unit.
    pub fn parse(text: &str) -> Result<Self> {
        let (number, unit) = split_unit(text)?;
        match unit {
            "" | "deg" | "°" => Ok(Angle::degrees(number)),
            "rad" => Ok(Angle(number)),
            _ => Err(bad_quantity(text, "an angle such as 45deg")),
        }
    }
}

/// Splits `0.4mm` into its finite number and its unit.
pub fn split_unit(text: &str) -> Result<(f64, &str)> {
    let text = text.trim();
    let at = text
        .char_indices()
        .find(|&(i, c)| {
            let numeric = c.is_ascii_digit() || matches!(c, '.' | '-' | '+');
            let in_exponent = matches!(c, 'e' | 'E') && exponent(&text[i..]);
            !numeric && !in_exponent
        })
        .map_or(text.len(), |(i, _)| i);
    let number: f64 =
        text[..at].parse().map_err(|_| bad_quantity(text, "a number with a unit, such as 0.4mm or 45deg"))?;
    if !number.is_finite() {
        return Err(bad_quantity(text, "a finite number"));
    }
    Ok((number, text[at..].trim()))
}

/// Whether the text starts an exponent (`e-3`) rather than a unit.
fn exponent(text: &str) -> bool {
    text[1..].trim_start_matches(['+', '-']).starts_with(|c: char| c.is_ascii_digit())
}

fn bad_quantity(text: &str, expected: &str) -> Error {
    Error::Usage {
        problem: format!("`{}` is not a quantity", crate::error::printable(text)),
        remedy: format!("write {expected}; the decimal sign is a point"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_read_with_their_unit() {
        for (text, mm) in [("0.4mm", 0.4), ("0.4", 0.4), ("400um", 0.4), ("1in", 25.4), ("1e-1 mm", 0.1), ("2cm", 20.0)]
        {
            assert_eq!(Length::parse(text).unwrap().as_mm(), mm, "{text}");
        }
        for text in ["", "mm", "1,5", "nan", "inf", "0x10", "4 parsecs", "1e400"] {
            assert!(Length::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_number_is_rounded_once_and_from_the_middle_away_from_zero() {
        for (value, text) in [(0.03125, "0.0313"), (-0.03125, "-0.0313"), (12.0625, "12.063"), (1234.25, "1234.3")] {
            assert_eq!(short(value), text);
            assert_eq!(short(told(value, value, value + 1e-6)), text);
            assert_eq!(short(told(value, value - 1e-5, value + 1e-5)), text);
        }
        assert_eq!([12.34549, f64::MAX].map(|v| short(told(v, v, v + 2e-6))), [12.34549, f64::MAX].map(short));
        assert_eq!((short(12.34549).as_str(), short(f64::INFINITY).as_str()), ("12.345", "inf"));
    }

    #[test]
    fn products_carry_their_dimension() {
        let edge = Length::mm(2.0);
        assert_eq!((edge * edge).as_mm2(), 4.0);
        assert_eq!((edge * edge * edge).as_mm3(), 8.0);
        assert!((Angle::parse("45deg").unwrap().as_radians() - std::f64::consts::FRAC_PI_4).abs() < 1e-15);
    }
}
