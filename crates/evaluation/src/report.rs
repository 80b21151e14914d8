//! What rows say: how often a task ends done, why not, how long it takes; and whether another
//! way is better.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::Path;

use cell_model::cells::setting::Setting;
use cell_model::user_file::{self, UserFile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Number;

use crate::EvaluationError;
use crate::row::{Key, RowOutcome};
use crate::stats::{bootstrap, mcnemar, quantile, two_proportions, wilson};

/// What is less likely than this by chance is a difference.
const SIGNIFICANT: f64 = 0.05;

/// What a report needs of a row.
#[derive(Clone, Debug, Deserialize)]
struct Short {
    demo: String,
    policy: String,
    seed: u64,
    #[serde(default)]
    variant: u32,
    #[serde(default)]
    set: BTreeMap<String, Number>,
    #[serde(default)]
    drawn: BTreeMap<String, Number>,
    outcome: RowOutcome,
    reason: Option<String>,
    #[serde(default)]
    message: Option<String>,
    sim_time_s: f64,
    drops: u32,
    resyncs: u32,
    aborts: u32,
    limit_violations: u64,
    state_hash: String,
}

impl Short {
    fn key(&self) -> Key {
        Key {
            seed: self.seed,
            variant: self.variant,
        }
    }

    fn is_done(&self) -> bool {
        self.outcome == RowOutcome::Done
    }

    /// Why it did not end done.
    fn reason(&self) -> String {
        let outcome = match self.outcome {
            RowOutcome::Timeout => "timeout",
            RowOutcome::Error => "error",
            _ => "failed",
        };
        let reason = self.reason.as_ref();
        reason.map_or_else(|| outcome.to_owned(), |why| format!("{outcome}: {why}"))
    }
}

/// Rate of a success, with the interval that holds it with 95 % (Wilson); 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Rate {
    /// The rate.
    pub rate: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Quantiles of simulated time (s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Times {
    /// Half of the episodes take no longer.
    pub p50: f64,
    /// 90 %.
    pub p90: f64,
    /// 99 %.
    pub p99: f64,
    /// The longest.
    pub max: f64,
}

/// What the rows with one combination of the values of `--set` say.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Variant {
    /// The values, by the keys of the cell file.
    pub set: BTreeMap<String, Number>,
    /// Episodes.
    pub episodes: u64,
    /// Of these, those that ended done.
    pub done: u64,
    /// How often.
    pub success: Rate,
    /// Of those that ended done.
    pub times_s: Option<Times>,
}

/// An episode that did not end done.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Example {
    /// Its seed.
    pub seed: u64,
    /// Its combination of the values of `--set`, from 1; 0 without.
    pub variant: u32,
    /// The reason, or the newest fault, in a sentence; null in rows of older versions.
    pub message: Option<String>,
}

/// What the rows of one file say.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Report {
    /// The file.
    pub file: String,
    /// Name of the demo.
    pub demo: String,
    /// Name of the policy.
    pub policy: String,
    /// Episodes.
    pub episodes: u64,
    /// Of these, those that ended done.
    pub done: u64,
    /// How often.
    pub success: Rate,
    /// Why the others did not, with their number.
    pub reasons: BTreeMap<String, u64>,
    /// For each of these reasons its first episode.
    pub examples: BTreeMap<String, Example>,
    /// Of those that ended done.
    pub times_s: Option<Times>,
    /// Of each combination of the values of `--set`; empty without.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub variants: Vec<Variant>,
    /// Held objects that were lost, in all.
    pub drops: u64,
    /// Pick-ups begun again, in all.
    pub resyncs: u64,
    /// Transfers turned back, in all.
    pub aborts: u64,
    /// Commands and positions outside the limits of a joint, in all.
    pub limit_violations: u64,
}

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

/// A report, and a comparison where a second file was given.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Reports {
    /// One of each file.
    pub files: Vec<Report>,
    /// The second against the first.
    pub comparison: Option<Comparison>,
}

/// An episode that did not end done.
#[derive(Clone, Debug, PartialEq)]
pub struct Failed {
    /// Which.
    pub key: Key,
    /// What it had in place of numbers of the cell file.
    pub settings: Vec<Setting>,
    /// How it ended, and why if that is known.
    pub reason: String,
    /// The reason, or the newest fault, in a sentence.
    pub message: Option<String>,
    /// Simulated time (s).
    pub sim_time_s: f64,
    /// Hash of the last state; empty where the program could not finish it.
    pub state_hash: String,
}

/// What of each episode is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Episodes {
    /// Simulated times of those that ended done, in increasing order (s).
    pub times_s: Vec<f64>,
    /// The others, in the order of the file.
    pub failed: Vec<Failed>,
}

/// Reads the episodes of a file.
///
/// # Errors
/// As [`report`].
pub fn episodes(path: &Path) -> Result<Episodes, EvaluationError> {
    let rows = read(path)?;
    let failed = rows.iter().filter(|row| !row.is_done());
    let failed = failed.map(|row| Failed {
        key: row.key(),
        settings: settings(&row.set).chain(settings(&row.drawn)).collect(),
        reason: row.reason(),
        message: row.message.clone(),
        sim_time_s: row.sim_time_s,
        state_hash: row.state_hash.clone(),
    });
    Ok(Episodes {
        times_s: times(rows.iter()),
        failed: failed.collect(),
    })
}

/// Reads the rows of `first`, and compares those of `second` with them.
///
/// # Errors
/// A file that cannot be read, has no rows, or has a line that is no row.
pub fn report(first: &Path, second: Option<&Path>) -> Result<Reports, EvaluationError> {
    let rows = read(first)?;
    let mut files = vec![summary(first, &rows)];
    let Some(second) = second else {
        return Ok(Reports {
            files,
            comparison: None,
        });
    };
    let other = read(second)?;
    files.push(summary(second, &other));
    Ok(Reports {
        comparison: Some(compare(&rows, &other)),
        files,
    })
}

fn read(path: &Path) -> Result<Vec<Short>, EvaluationError> {
    let file = UserFile::open(path).map_err(EvaluationError::io(path))?;
    let (mut file, mut text) = (BufReader::new(file), String::new());
    let mut rows = Vec::new();
    while user_file::read_line(&mut file, &mut text).map_err(EvaluationError::io(path))? > 0 {
        let row = serde_json::from_str(&text).map_err(|error| EvaluationError::Line {
            path: path.to_owned(),
            line: rows.len() as u64 + 1,
            reason: error.to_string(),
        })?;
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(EvaluationError::Line {
            path: path.to_owned(),
            line: 1,
            reason: "the file is empty".to_owned(),
        });
    }
    Ok(rows)
}

fn settings(numbers: &BTreeMap<String, Number>) -> impl Iterator<Item = Setting> {
    numbers.iter().map(|(key, value)| Setting {
        key: key.clone(),
        value: value.clone(),
    })
}

fn count(n: usize) -> u64 {
    u64::try_from(n).unwrap_or(u64::MAX)
}

/// Episodes, those that ended done, and how often they did.
fn success<'a>(rows: impl Iterator<Item = &'a Short>) -> (u64, u64, Rate) {
    let (mut episodes, mut done) = (0, 0);
    for row in rows {
        episodes += 1;
        done += u64::from(row.is_done());
    }
    let (low, high) = wilson(done, episodes);
    let rate = done as f64 / episodes as f64;
    (episodes, done, Rate { rate, low, high })
}

fn summary(path: &Path, rows: &[Short]) -> Report {
    let (episodes, done, success) = success(rows.iter());
    let (mut reasons, mut examples) = (BTreeMap::new(), BTreeMap::new());
    for row in rows.iter().filter(|row| !row.is_done()) {
        *reasons.entry(row.reason()).or_insert(0) += 1;
        let example = examples.entry(row.reason());
        example.or_insert_with(|| Example {
            seed: row.seed,
            variant: row.variant,
            message: row.message.clone(),
        });
    }
    let sum = |of: fn(&Short) -> u64| rows.iter().map(of).sum();
    Report {
        file: path.display().to_string(),
        demo: rows.first().map_or(String::new(), |row| row.demo.clone()),
        policy: rows.first().map_or(String::new(), |row| row.policy.clone()),
        episodes,
        done,
        success,
        reasons,
        examples,
        times_s: quantiles(&times(rows.iter())),
        variants: variants(rows),
        drops: sum(|row| u64::from(row.drops)),
        resyncs: sum(|row| u64::from(row.resyncs)),
        aborts: sum(|row| u64::from(row.aborts)),
        limit_violations: sum(|row| row.limit_violations),
    }
}

fn variants(rows: &[Short]) -> Vec<Variant> {
    let mut by_variant: BTreeMap<u32, Vec<&Short>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.variant > 0) {
        by_variant.entry(row.variant).or_default().push(row);
    }
    let one = |rows: Vec<&Short>| {
        let (episodes, done, success) = success(rows.iter().copied());
        Variant {
            set: rows.first().map(|row| row.set.clone()).unwrap_or_default(),
            episodes,
            done,
            success,
            times_s: quantiles(&times(rows.into_iter())),
        }
    };
    by_variant.into_values().map(one).collect()
}

fn quantiles(times: &[f64]) -> Option<Times> {
    (!times.is_empty()).then(|| Times {
        p50: quantile(times, 0.5),
        p90: quantile(times, 0.9),
        p99: quantile(times, 0.99),
        max: quantile(times, 1.0),
    })
}

/// Of those that ended done, in increasing order (s).
fn times<'a>(rows: impl Iterator<Item = &'a Short>) -> Vec<f64> {
    let done = rows.filter(|row| row.is_done());
    let mut times: Vec<f64> = done.map(|row| row.sim_time_s).collect();
    times.sort_by(f64::total_cmp);
    times
}

fn compare(first: &[Short], second: &[Short]) -> Comparison {
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
