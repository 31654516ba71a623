//! The values of a PLY file, one after the other.

use super::header::{Encoding, Header, Kind, Scalar};
use crate::error::{Error, Place, Result};
use crate::io::words::Words;

/// A cursor over the values.
pub(super) enum Values<'a> {
    Text(Words<'a>),
    Binary { bytes: &'a [u8], at: usize, encoding: Encoding },
}

impl<'a> Values<'a> {
    /// The values after the header.
    pub(super) fn new(bytes: &'a [u8], header: &Header) -> Self {
        match header.encoding {
            Encoding::Text => {
                Values::Text(Words::from_line(bytes.get(header.body_at..).unwrap_or_default(), header.body_line))
            }
            encoding => Values::Binary { bytes, at: header.body_at, encoding },
        }
    }

    /// Where the cursor stands.
    pub(super) fn place(&self) -> Place {
        match self {
            Values::Text(words) => Place::Line(words.line()),
            Values::Binary { at, .. } => Place::Byte(*at as u64),
        }
    }

    /// Bytes that are left.
    pub(super) fn bytes_left(&self) -> u64 {
        match self {
            Values::Text(words) => words.bytes_left() as u64,
            Values::Binary { bytes, at, .. } => bytes.len().saturating_sub(*at) as u64,
        }
    }

    /// The next number.
    pub(super) fn number(&mut self, scalar: Scalar) -> Result<f64> {
        match self {
            Values::Text(words) => {
                let line = words.line();
                let word = words.next().ok_or_else(|| ends(Place::Line(line)))?;
                word.number().ok_or_else(|| {
                    let (problem, remedy) = word.number_problem();
                    damaged(Place::Line(word.line), problem, remedy)
                })
            }
            Values::Binary { bytes, at, encoding } => {
                let place = Place::Byte(*at as u64);
                let raw = bytes.get(*at..*at + scalar.size()).ok_or_else(|| ends(place))?;
                *at += scalar.size();
                Ok(decoded(raw, scalar, *encoding))
            }
        }
    }

    /// The length of a list, at most `most`.
    pub(super) fn length(&mut self, scalar: Scalar, most: u64) -> Result<u64> {
        let place = self.place();
        let length = self.number(scalar)?;
        if length >= 0.0 && length.fract() == 0.0 && length <= most as f64 {
            return Ok(length as u64);
        }
        let problem = format!("a list of {length} values; 0 to {most} are possible here");
        Err(damaged(place, problem, "export the file again"))
    }

    /// Goes over a property that is not needed.
    pub(super) fn skip(&mut self, kind: Kind) -> Result<()> {
        let (scalar, times) = match kind {
            Kind::One(scalar) => (scalar, 1),
            Kind::List { count, item } => {
                let most = self.bytes_left();
                (item, self.length(count, most)?)
            }
        };
        if let Values::Binary { bytes, at, .. } = self {
            let past = (times * scalar.size() as u64).saturating_add(*at as u64);
            if past > bytes.len() as u64 {
                return Err(ends(Place::Byte(bytes.len() as u64)));
            }
            *at = past as usize;
            return Ok(());
        }
        for _ in 0..times {
            self.word()?;
        }
        Ok(())
    }

    /// Goes over one word of a text, number or not.
    fn word(&mut self) -> Result<()> {
        let place = self.place();
        match self {
            Values::Text(words) => words.next().map(|_| ()).ok_or_else(|| ends(place)),
            Values::Binary { .. } => Ok(()),
        }
    }
}

/// A number from its bytes.
fn decoded(raw: &[u8], scalar: Scalar, encoding: Encoding) -> f64 {
    let mut little = [0u8; 8];
    for (i, to) in little.iter_mut().enumerate().take(raw.len()) {
        let from = if encoding == Encoding::Big { raw.len() - 1 - i } else { i };
        *to = raw.get(from).copied().unwrap_or(0);
    }
    let bits = u64::from_le_bytes(little);
    match scalar {
        Scalar::I8 => f64::from(bits as u8 as i8),
        Scalar::U8 => f64::from(bits as u8),
        Scalar::I16 => f64::from(bits as u16 as i16),
        Scalar::U16 => f64::from(bits as u16),
        Scalar::I32 => f64::from(bits as u32 as i32),
        Scalar::U32 => f64::from(bits as u32),
        Scalar::F32 => f64::from(f32::from_bits(bits as u32)),
        Scalar::F64 => f64::from_bits(bits),
    }
}

pub(super) fn damaged(place: Place, problem: String, remedy: &str) -> Error {
    Error::Damaged { format: "PLY", place, problem, remedy: remedy.into() }
}

fn ends(place: Place) -> Error {
    damaged(place, "the file ends before its last value".into(), "export or copy the file again")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_either_byte_order_are_equal() {
        for (scalar, little, value) in [
            (Scalar::I8, vec![0xff], -1.0),
            (Scalar::U8, vec![0xff], 255.0),
            (Scalar::I16, vec![0xfe, 0xff], -2.0),
            (Scalar::U32, vec![1, 0, 0, 0x80], 2147483649.0),
            (Scalar::F32, 0.1f32.to_le_bytes().to_vec(), f64::from(0.1f32)),
            (Scalar::F64, 0.1f64.to_le_bytes().to_vec(), 0.1),
        ] {
            let big: Vec<u8> = little.iter().rev().copied().collect();
            assert_eq!(decoded(&little, scalar, Encoding::Little), value);
            assert_eq!(decoded(&big, scalar, Encoding::Big), value);
        }
    }
}
