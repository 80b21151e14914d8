//! Numbers of a cell that the episodes of an evaluation replace: every combination of the
//! values of `--set`, and for each seed numbers drawn within the bounds of `--vary`.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use serde_json::Number;

use crate::cells::setting::{self, Kind, Setting};
use crate::error::{Location, ModelError};
use crate::random::Random;
use crate::runs::policy_server::Fault;

/// Largest number of combinations of an evaluation.
pub const MAX_VARIANTS: u32 = 10_000;

/// A key and its values, `KEY=V,V`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Values {
    /// See [`Setting::key`].
    pub key: String,
    /// The values, at least one.
    pub values: Vec<Number>,
}

impl FromStr for Values {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let allowed = || {
            format!(
                "{text:?} is not a setting; write KEY=NUMBER[,NUMBER..], as task.timeout_s=4,5,6"
            )
        };
        let (key, values) = text.split_once('=').ok_or_else(allowed)?;
        let values: Option<Vec<Number>> = values.split(',').map(setting::number).collect();
        Ok(Self {
            key: setting::key_of(key)?,
            values: values.ok_or_else(allowed)?,
        })
    }
}

impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values: Vec<String> = self.values.iter().map(Number::to_string).collect();
        write!(f, "{}={}", self.key, values.join(","))
    }
}

/// A key and the bounds of its values, `KEY=LOW..HIGH`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bounds {
    /// See [`Setting::key`].
    pub key: String,
    /// The smallest value.
    pub low: Number,
    /// The largest value.
    pub high: Number,
}

impl FromStr for Bounds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let allowed = || {
            format!(
                "{text:?} has no bounds; write KEY=LOW..HIGH with LOW below HIGH, as \
                 object.*.mass_kg=0.08..0.12"
            )
        };
        let (key, bounds) = text.split_once('=').ok_or_else(allowed)?;
        let (low, high) = bounds.split_once("..").ok_or_else(allowed)?;
        let bounds = setting::number(low).zip(setting::number(high));
        let (low, high) = bounds.ok_or_else(allowed)?;
        if low.as_f64() >= high.as_f64() {
            return Err(allowed());
        }
        Ok(Self {
            key: setting::key_of(key)?,
            low,
            high,
        })
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}..{}", self.key, self.low, self.high)
    }
}

impl Bounds {
    /// Both bounds if they are integers, for a number that is an integer in the cell file.
    pub(crate) fn integers(&self) -> Option<(i64, i64)> {
        Some((self.low.as_i64()?, self.high.as_i64()?))
    }

    /// The value at `part` (0 to 1, without 1) of the way from the smallest to the largest.
    fn at(&self, part: f64, kind: Kind) -> Option<Number> {
        let Some((low, high)) = self.integers().filter(|_| kind == Kind::Integer) else {
            let (low, high) = (self.low.as_f64()?, self.high.as_f64()?);
            return Number::from_f64(low + part * (high - low));
        };
        // The largest integer is as likely as the others, hence one more; rounding may exceed
        // it by one.
        let count = high.saturating_sub(low).saturating_add(1) as f64;
        #[expect(
            clippy::cast_possible_truncation,
            reason = "at most as far as both are apart"
        )]
        Some(Number::from((low + (part * count) as i64).min(high)))
    }
}

/// The numbers that the episodes of an evaluation replace.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sweep {
    /// Values whose combinations are all run with every seed.
    pub set: Vec<Values>,
    /// Bounds of the numbers drawn for every seed.
    pub vary: Vec<Bounds>,
    /// Latencies of a policy server (ms), which are all run with every seed, too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub latencies_ms: Vec<u32>,
    /// Faults of its observations: an episode without one, and one with each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<Fault>,
}

impl Sweep {
    /// Numbers of the combinations of `--set`: from 1, or only 0 without any.
    pub fn variants(&self) -> RangeInclusive<u32> {
        if self.set.is_empty() && self.latencies_ms.len() < 2 && self.faults.is_empty() {
            return 0..=0;
        }
        let counts = self.set.iter().map(|set| set.values.len());
        let counts = counts.chain([self.latencies_ms.len().max(1), self.faults.len() + 1]);
        // Saturating: the product of a few long lists exceeds any integer, and is refused
        // below.
        let all = counts.fold(1_usize, usize::saturating_mul);
        1..=u32::try_from(all).unwrap_or(u32::MAX)
    }

    /// A combination: faults change first, then latencies, then the values of the last key.
    fn variant(&self, variant: u32) -> (Vec<Setting>, Option<u32>, Option<Fault>) {
        let mut rest = variant.saturating_sub(1) as usize;
        let mut digit = |count: usize| {
            let digit = rest % count;
            rest /= count;
            digit
        };
        let fault = digit(self.faults.len() + 1).checked_sub(1);
        let latency = digit(self.latencies_ms.len().max(1));
        let mut settings: Vec<Setting> = Vec::new();
        for set in self.set.iter().rev() {
            let value = set.values.get(digit(set.values.len().max(1)));
            settings.extend(value.map(|value| Setting {
                key: set.key.clone(),
                value: value.clone(),
            }));
        }
        settings.reverse();
        let fault = fault.and_then(|fault| self.faults.get(fault).cloned());
        (settings, self.latencies_ms.get(latency).copied(), fault)
    }

    /// The episodes of a cell file with this text.
    ///
    /// # Errors
    /// Returns [`ModelError`] for a key that is not the path of a number, and for too many
    /// combinations.
    pub fn cases(self, file: &str, text: &str) -> Result<Cases, ModelError> {
        let count = *self.variants().end();
        if count > MAX_VARIANTS {
            let all: Vec<String> = self.set.iter().map(Values::to_string).collect();
            return Err(ModelError::value(
                Location::file(file),
                format!("--set {}", all.join(" --set ")),
                format!("{count} combinations"),
                format!("at most {MAX_VARIANTS} are allowed"),
            ));
        }
        for set in &self.set {
            setting::places(file, text, &set.key)?;
        }
        let mut draws = Vec::new();
        for bounds in &self.vary {
            let places = setting::places(file, text, &bounds.key)?;
            draws.extend(places.into_iter().map(|place| Draw {
                path: place.path,
                kind: place.kind,
                bounds: bounds.clone(),
            }));
        }
        Ok(Cases { sweep: self, draws })
    }
}

/// One episode of an evaluation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Case {
    /// Its seed.
    pub seed: u64,
    /// Its combination, one of [`Sweep::variants`].
    pub variant: u32,
    /// The values of that combination.
    pub set: Vec<Setting>,
    /// The numbers drawn for its seed.
    pub drawn: Vec<Setting>,
    /// The latency of the policy server (ms).
    pub latency_ms: Option<u32>,
    /// The fault of its observations.
    pub fault: Option<Fault>,
}

impl Case {
    /// All settings with which it replaces numbers of the cell file.
    pub fn settings(&self) -> Vec<Setting> {
        self.set.iter().chain(&self.drawn).cloned().collect()
    }
}

/// A number that is drawn for every seed.
#[derive(Clone, Debug)]
struct Draw {
    path: String,
    kind: Kind,
    bounds: Bounds,
}

/// The episodes of an evaluation.
#[derive(Clone, Debug, Default)]
pub struct Cases {
    sweep: Sweep,
    draws: Vec<Draw>,
}

impl Cases {
    /// The sweep that they are made from.
    pub fn sweep(&self) -> &Sweep {
        &self.sweep
    }

    /// An episode. A drawn number depends on seed, path and bounds alone, so it is the same
    /// whatever else is drawn or set.
    pub fn case(&self, seed: u64, variant: u32) -> Case {
        let draw = |draw: &Draw| {
            // Mixed first, so that neighbouring seeds have nothing in common.
            let seed = Random::new(seed).bits() ^ hash(&draw.path);
            let part = 0.5 + Random::new(seed).around_zero(0.5);
            Some(Setting {
                key: draw.path.clone(),
                value: draw.bounds.at(part, draw.kind)?,
            })
        };
        let (set, latency_ms, fault) = self.sweep.variant(variant);
        Case {
            seed,
            variant,
            set,
            latency_ms,
            fault,
            drawn: self.draws.iter().filter_map(draw).collect(),
        }
    }

    /// The smallest set of episodes of `seed` that has every value of `--set`, and both bounds
    /// of each drawn number.
    pub fn samples(&self, seed: u64) -> Vec<Case> {
        let first = self.case(seed, *self.sweep.variants().start());
        let mut samples = vec![first.clone()];
        for (place, set) in self.sweep.set.iter().enumerate() {
            for value in set.values.iter().skip(1) {
                let mut sample = first.clone();
                sample.set[place].value = value.clone();
                samples.push(sample);
            }
        }
        for (place, draw) in self.draws.iter().enumerate() {
            for bound in [&draw.bounds.low, &draw.bounds.high] {
                let mut sample = first.clone();
                sample.drawn[place].value = bound.clone();
                samples.push(sample);
            }
        }
        samples
    }
}

/// FNV-1a: the same in every build, unlike the hash of the standard library, so rows of two
/// builds have the same numbers.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[[object]]\nname = \"red\"\nmass = 1.0\n[[object]]\nname = \"blue\"\n\
        mass = 1\n[task]\nattempts = 3\n";

    fn sweep(set: &[&str], vary: &[&str]) -> Sweep {
        Sweep {
            set: set.iter().map(|text| text.parse().unwrap()).collect(),
            vary: vary.iter().map(|text| text.parse().unwrap()).collect(),
            ..Sweep::default()
        }
    }

    fn words(settings: &[Setting]) -> String {
        let words: Vec<String> = settings.iter().map(Setting::to_string).collect();
        words.join(" ")
    }

    #[test]
    fn every_combination_is_a_variant() {
        let both = sweep(&["a=1,2.5", "b=3,4,5"], &[]);
        let all: Vec<String> = both.variants().map(|v| words(&both.variant(v).0)).collect();
        assert_eq!(
            all,
            [
                "a=1 b=3",
                "a=1 b=4",
                "a=1 b=5",
                "a=2.5 b=3",
                "a=2.5 b=4",
                "a=2.5 b=5"
            ]
        );
        let cases = both.cases("c.toml", "").unwrap();
        let samples: Vec<String> = cases.samples(1).iter().map(|c| words(&c.set)).collect();
        assert_eq!(samples, ["a=1 b=3", "a=2.5 b=3", "a=1 b=4", "a=1 b=5"]);
        assert_eq!(Sweep::default().variants(), 0..=0);
        assert_eq!(Cases::default().case(7, 0).settings(), []);
        let many = vec!["a=1,2,3,4,5,6,7,8,9,10"; 5];
        let error = sweep(&many, &[])
            .cases("c.toml", "")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("100000 combinations; at most 10000"),
            "{error}"
        );
    }

    #[test]
    fn latencies_and_faults_are_variants_as_well() {
        let all = Sweep {
            latencies_ms: vec![0, 200],
            faults: vec!["drop@0..500".parse().unwrap()],
            ..sweep(&["a=1,2"], &[])
        };
        assert_eq!(all.variants(), 1..=8);
        let (set, latency_ms, fault) = all.variant(4);
        assert_eq!(words(&set), "a=1");
        assert_eq!(latency_ms, Some(200));
        assert_eq!(fault.unwrap().to_string(), "drop@0..500");
        let (set, latency_ms, fault) = all.variant(5);
        assert_eq!((words(&set).as_str(), latency_ms), ("a=2", Some(0)));
        assert_eq!(fault, None);
        // One latency is no choice.
        let one = Sweep {
            latencies_ms: vec![100],
            ..Sweep::default()
        };
        assert_eq!((one.variants(), one.variant(0).1), (0..=0, Some(100)));
    }

    #[test]
    fn numbers_are_drawn_within_their_bounds_and_depend_on_seed_and_path_alone() {
        let of = |vary: &[&str]| sweep(&[], vary).cases("c.toml", TEXT).unwrap();
        let few = of(&["object.*.mass=0.5..1.5"]);
        let more = of(&["task.attempts=1..4", "object.*.mass=0.5..1.5"]);
        let first = words(&few.case(1, 0).drawn);
        // Of another implementation of SplitMix64 and FNV-1a.
        assert_eq!(
            first,
            "object.red.mass=0.8431386287067437 object.blue.mass=1.0675667983811343"
        );
        let mut seen = std::collections::BTreeSet::new();
        for seed in 0..200 {
            let (few, all) = (few.case(seed, 0).drawn, more.case(seed, 0).drawn);
            assert_eq!(few[..], all[1..]);
            let value = |setting: &Setting| setting.value.as_f64().unwrap();
            assert!(few.iter().all(|one| (0.5..1.5).contains(&value(one))));
            assert_ne!(few[0].value, few[1].value);
            seen.insert(all[0].value.as_i64().unwrap());
        }
        assert_eq!(seen.into_iter().collect::<Vec<_>>(), [1, 2, 3, 4]);
    }

    #[test]
    fn what_has_no_bounds_or_values_is_refused() {
        for bad in [
            "a=1", "a=2..1", "a=1..1", "a=..", "a=1..inf", "a b=1..2", "=1..2",
        ] {
            assert!(bad.parse::<Bounds>().is_err(), "{bad}");
        }
        for bad in ["a", "a=", "a=1,,2", "a=1,x", "a=nan"] {
            assert!(bad.parse::<Values>().is_err(), "{bad}");
        }
    }
}
