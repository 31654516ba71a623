//! A share of a batch, for one task of a job array.

use crate::error::{Error, Result, printable};
use sha2::{Digest, Sha256};

/// Share `index` of `count`, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    pub index: u32,
    pub count: u32,
}

impl Shard {
    /// A share written as `i/n`.
    ///
    /// # Errors
    /// [`Error::Usage`] unless 1 ≤ i ≤ n.
    ///
    /// ```
    /// use amcheck::batch::Shard;
    /// assert_eq!(Shard::parse("2/8")?, Shard { index: 2, count: 8 });
    /// # Ok::<(), amcheck::Error>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self> {
        let parsed = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
        match parsed {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Shard { index, count }),
            _ => Err(Error::Usage {
                problem: format!("`{}` is no share of a batch", printable(text)),
                remedy: "write --shard i/n with i from 1 to n, such as --shard 2/8".into(),
            }),
        }
    }

    /// What stands in the names of its tables: `-2-of-8`.
    pub fn tag(self) -> String {
        format!("-{}-of-{}", self.index, self.count)
    }

    /// The share whose tables have these words in their names.
    pub(super) fn tagged(tag: &str) -> Option<Self> {
        let (index, count) = tag.strip_prefix('-')?.split_once("-of-")?;
        Some(Shard { index: index.parse().ok()?, count: count.parse().ok()? })
    }

    /// Whether this share takes a part.
    ///
    /// The name alone decides, so that shares that see other parts come or go still take each part exactly once.
    pub fn takes(self, name: &str) -> bool {
        let digest = Sha256::digest(name.as_bytes());
        let number = digest.iter().take(8).fold(0u64, |n, &b| n << 8 | u64::from(b));
        number % u64::from(self.count.max(1)) == u64::from(self.index.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_is_in_exactly_one_share() {
        for n in 0..500 {
            let name = format!("part {n}.stl");
            assert_eq!((1..=7).filter(|&index| Shard { index, count: 7 }.takes(&name)).count(), 1);
        }
        for bad in ["", "0/4", "5/4", "1", "a/b", "1/0", "-1/4"] {
            assert_eq!(Shard::parse(bad).unwrap_err().exit_code(), 2, "{bad}");
        }
    }
}
