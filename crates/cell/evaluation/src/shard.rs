//! Which of the seeds of an evaluation a process runs.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// The most shards of an evaluation.
pub const MAX_SHARDS: u64 = 1_000_000;

/// Part `index` of `count`, from 1: every `count`-th seed, so that all parts take about as
/// long.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
// A row file of a person may have other numbers: 0 would divide by zero, and a huge count never end.
#[serde(try_from = "Numbers")]
pub struct Shard {
    /// 1 to `count`.
    pub index: u64,
    /// 1 to [`MAX_SHARDS`].
    pub count: u64,
}

/// The fields of a [`Shard`] as a file has them.
#[derive(Deserialize)]
struct Numbers {
    index: u64,
    count: u64,
}

impl TryFrom<Numbers> for Shard {
    type Error = String;

    fn try_from(Numbers { index, count }: Numbers) -> Result<Self, String> {
        let is_known = (1..=MAX_SHARDS).contains(&count) && (1..=count).contains(&index);
        let allowed =
            || format!("shard {index}/{count}: I/N has I from 1 to N, and N up to {MAX_SHARDS}");
        is_known
            .then_some(Self { index, count })
            .ok_or_else(allowed)
    }
}

impl Shard {
    /// All seeds.
    pub const ALL: Self = Self { index: 1, count: 1 };

    /// Its seeds of `seeds`, in order.
    pub fn seeds(self, seeds: &RangeInclusive<u64>) -> impl Iterator<Item = u64> + use<> {
        let (first, last) = (*seeds.start(), *seeds.end());
        // A sum that overflows is beyond the last seed: the shard has none.
        let first = first.checked_add(self.index - 1);
        let all = first.into_iter().flat_map(move |first| first..=last);
        all.step_by(usize::try_from(self.count).unwrap_or(usize::MAX))
    }

    /// Number of its seeds of `seeds`; at most [`u64::MAX`].
    pub fn len(self, seeds: &RangeInclusive<u64>) -> u64 {
        let first = seeds.start().checked_add(self.index - 1);
        let beyond = first.and_then(|first| seeds.end().checked_sub(first));
        beyond.map_or(0, |beyond| (beyond / self.count).saturating_add(1))
    }

    /// Whether `seed` of `seeds` is its own.
    pub fn has(self, seeds: &RangeInclusive<u64>, seed: u64) -> bool {
        seeds.contains(&seed) && (seed - seeds.start()) % self.count == self.index - 1
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let allowed =
            || format!("I/N is needed, such as 3/8, with I from 1 to N, and N up to {MAX_SHARDS}");
        let (index, count) = text.split_once('/').ok_or_else(allowed)?;
        let number = |part: &str| {
            part.parse::<u64>()
                .ok()
                .filter(|n| (1..=MAX_SHARDS).contains(n))
        };
        match (number(index), number(count)) {
            (Some(index), Some(count)) if index <= count => Ok(Self { index, count }),
            _ => Err(allowed()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_with_a_shard_that_cannot_be_is_refused() {
        for (index, count) in [
            (0, 1),
            (1, 0),
            (3, 2),
            (1, MAX_SHARDS + 1),
            (u64::MAX, u64::MAX),
        ] {
            let text = format!(r#"{{"index": {index}, "count": {count}}}"#);
            let why = serde_json::from_str::<Shard>(&text)
                .unwrap_err()
                .to_string();
            assert!(why.contains(&format!("shard {index}/{count}")), "{why}");
        }
        let one = serde_json::from_str::<Shard>(r#"{"index": 2, "count": 2}"#).unwrap();
        assert_eq!(one, Shard { index: 2, count: 2 });
    }

    #[test]
    fn shards_of_any_number_are_disjoint_and_complete() {
        for seeds in [0..=0, 5..=28, 1..=1_000, u64::MAX - 3..=u64::MAX] {
            for count in 1..=64 {
                let mut all = Vec::new();
                for index in 1..=count {
                    let shard = Shard { index, count };
                    let own: Vec<u64> = shard.seeds(&seeds).collect();
                    assert!(own.iter().all(|seed| shard.has(&seeds, *seed)));
                    assert_eq!(own.len() as u64, shard.len(&seeds));
                    all.extend(own);
                }
                all.sort_unstable();
                assert!(all.into_iter().eq(seeds.clone()), "{seeds:?} in {count}");
            }
        }
    }

    #[test]
    fn a_shard_is_read_as_people_write_it() {
        assert_eq!("3/8".parse(), Ok(Shard { index: 3, count: 8 }));
        for bad in [
            "",
            "3",
            "0/8",
            "9/8",
            "1/0",
            "-1/2",
            "1/2/3",
            "a/b",
            "1/1000001",
        ] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
    }
}
