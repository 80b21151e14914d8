//! The comparison of the rows of two files.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::short_row::Short;
use super::success;
use crate::row::Key;
use crate::stats::{bootstrap, mcnemar, two_proportions};

/// A result less likely than this by chance counts as a difference (p value).
pub(super) const SIGNIFICANT: f64 = 0.05;

/// What a comparison found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The second ends done more often.
    Better,
    /// The second ends done less often.
    Worse,
    /// What differs may be chance.
    NoDifference,
}

/// A second file against the first.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Comparison {
    /// Episodes (seeds, with `--set` of each variant) that are in both files.
    pub pairs: u64,
    /// Of these, done in both.
    pub both: u64,
    /// Done in the first alone.
    pub first_only: u64,
    /// Done in the second alone.
    pub second_only: u64,
    /// Done in neither.
    pub neither: u64,
    /// Success of the second less that of the first.
    pub difference: f64,
    /// The interval that holds it with 95 % (bootstrap), where there are pairs.
    pub interval: Option<(f64, f64)>,
    /// How likely equals differ as much: `McNemar`'s exact test for pairs, without any the test
    /// of two proportions.
    pub p: f64,
    /// Mean of the time of the second less that of the first (s), where both ended done.
    pub time_difference_s: Option<f64>,
    /// The interval that holds it with 95 % (bootstrap).
    pub time_interval_s: Option<(f64, f64)>,
    /// What follows for the success, at 5 %.
    pub verdict: Verdict,
}

pub(super) fn compare(first: &[Short], second: &[Short]) -> Comparison {
    let by_key: BTreeMap<Key, &Short> = first.iter().map(|row| (row.key(), row)).collect();
    let pairs: Vec<(&Short, &Short)> = second
        .iter()
        .filter_map(|row| Some((*by_key.get(&row.key())?, row)))
        .collect();
    let of = |one: bool, other: bool| {
        let alike = pairs
            .iter()
            .filter(|(a, b)| (a.is_done(), b.is_done()) == (one, other));
        count(alike.count())
    };
    let (both, first_only) = (of(true, true), of(true, false));
    let (second_only, neither) = (of(false, true), of(false, false));
    let all = both + first_only + second_only + neither;
    let steps: Vec<f64> = pairs
        .iter()
        .map(|(a, b)| f64::from(u8::from(b.is_done())) - f64::from(u8::from(a.is_done())))
        .collect();
    let times: Vec<f64> = pairs
        .iter()
        .filter(|(a, b)| a.is_done() && b.is_done())
        .map(|(a, b)| b.sim_time_s - a.sim_time_s)
        .collect();
    let counts = |rows: &[Short]| {
        let (all, done, _) = success(rows.iter());
        (done, all)
    };
    // The same seed is the same scene: pairs need fewer episodes than samples to show a difference.
    let (difference, p) = if all > 0 {
        let difference = (second_only as f64 - first_only as f64) / all as f64;
        (difference, mcnemar(first_only, second_only))
    } else {
        let (one, other) = (counts(first), counts(second));
        let rate = |(done, all): (u64, u64)| done as f64 / all as f64;
        (rate(other) - rate(one), two_proportions(one, other))
    };
    Comparison {
        pairs: all,
        both,
        first_only,
        second_only,
        neither,
        difference,
        interval: bootstrap(&steps),
        p,
        time_difference_s: mean(&times),
        time_interval_s: bootstrap(&times),
        verdict: match p < SIGNIFICANT {
            true if difference > 0.0 => Verdict::Better,
            true => Verdict::Worse,
            false => Verdict::NoDifference,
        },
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn count(n: usize) -> u64 {
    u64::try_from(n).unwrap_or(u64::MAX)
}
