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
        for fault in &self.sweep.faults {
            let mut sample = first.clone();
            sample.fault = Some(fault.clone());
            samples.push(sample);
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
mod tests;
