//! Which share of the work is whose.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

/// One of `count` shares, numbered from 1: `2/4`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// 1 to `count`.
    pub number: u32,
    /// At least 1.
    pub count: u32,
}

impl Shard {
    /// The only one.
    pub const WHOLE: Self = Self {
        number: 1,
        count: 1,
    };

    /// Whether piece `index` of the work, counted from 0, is in this share: every `count`-th is, so that shares cost alike
    /// where neighbours do.
    pub fn has(self, index: usize) -> bool {
        index % self.count as usize == self.number as usize - 1
    }

    /// The share that has piece `index`.
    pub fn of(index: usize, count: u32) -> Self {
        Self {
            number: (index % count as usize) as u32 + 1,
            count,
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

impl FromStr for Shard {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (number, count) = text
            .split_once('/')
            .and_then(|(number, count)| Some((number.parse().ok()?, count.parse().ok()?)))
            .ok_or("a share and their number, as in 2/4")?;
        match (number, count) {
            (0, _) => Err("shares are counted from 1: 1/4 is the first of four"),
            (number, count) if number > count => Err("the share lies beyond their number"),
            (_, 65_536..) => Err("at most 65535 shares"),
            _ => Ok(Self { number, count }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_piece_is_in_one_share() {
        for count in [1, 3, 4] {
            for index in 0..20 {
                let owners: Vec<u32> = (1..=count)
                    .filter(|&number| Shard { number, count }.has(index))
                    .collect();
                assert_eq!(owners, [Shard::of(index, count).number]);
            }
        }
    }

    #[test]
    fn shares_are_read_as_they_are_shown() {
        assert_eq!("2/4".parse::<Shard>().unwrap().to_string(), "2/4");
        for wrong in ["", "2", "0/4", "5/4", "a/b", "-1/4", "1/0", "1/70000"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
