//! What rows say: how often a task ends done, why not, how long it takes; and whether another
//! way is better.

mod comparison;
mod gate;
mod short_row;

use std::collections::BTreeMap;
use std::path::Path;

use cell_model::cells::setting::Setting;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Number;

use crate::EvaluationError;
use crate::row::Key;
use crate::stats::{quantile, wilson};

use comparison::compare;
pub use comparison::{Comparison, Verdict};
pub use gate::Gate;
use gate::gate;
use short_row::{Short, read};

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
    /// Latency of the policy server (ms).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latency_ms: Option<u32>,
    /// Fault of its observations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// Episodes.
    pub episodes: u64,
    /// Of these, those that ended done.
    pub done: u64,
    /// How often.
    pub success: Rate,
    /// Of those that ended done.
    pub times_s: Option<Times>,
}

impl Reports {
    /// Decides whether the second file is worse; `loss` is the least loss of success that has to be
    /// seen (share of the episodes, above 0 and up to 1). Nothing without a second file.
    pub fn decide(&mut self, loss: f64) {
        self.gate = self
            .comparison
            .as_ref()
            .map(|comparison| gate(comparison, loss));
    }
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

/// A report, and a comparison where a second file was given.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Reports {
    /// One of each file.
    pub files: Vec<Report>,
    /// The second against the first.
    pub comparison: Option<Comparison>,
    /// Decision of the gate, where one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gate: Option<Gate>,
}

/// An episode that did not end done.
#[derive(Clone, Debug, PartialEq)]
pub struct Failed {
    /// Which.
    pub key: Key,
    /// Its values in place of numbers of the cell file.
    pub settings: Vec<Setting>,
    /// Options of `robocell run` for its policy server.
    pub server: Vec<String>,
    /// How it ended, and why if that is known: for people.
    pub reason: String,
    /// The stable name of the reason, if it has one.
    pub name: Option<String>,
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
        server: server_options(row),
        reason: row.reason(),
        name: row.reason.clone(),
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
            gate: None,
        });
    };
    let other = read(second)?;
    files.push(summary(second, &other));
    Ok(Reports {
        comparison: Some(compare(&rows, &other)),
        gate: None,
        files,
    })
}

fn settings(numbers: &BTreeMap<String, Number>) -> impl Iterator<Item = Setting> {
    numbers.iter().map(|(key, value)| Setting {
        key: key.clone(),
        value: value.clone(),
    })
}

fn server_options(row: &Short) -> Vec<String> {
    let latency = row
        .latency_ms
        .map(|ms| ["--latency-ms".to_owned(), ms.to_string()]);
    let fault = row.fault.clone().map(|fault| ["--fault".to_owned(), fault]);
    latency.into_iter().chain(fault).flatten().collect()
}

/// Episodes, those that ended done, and how often they did.
fn success<'a>(rows: impl Iterator<Item = &'a Short>) -> (u64, u64, Rate) {
    let (mut episodes, mut done) = (0, 0);
    for row in rows {
        episodes += 1;
        done += u64::from(row.is_done());
    }
    let (low, high) = wilson(done, episodes);
    // Never 0 episodes: `read` refuses a file without rows.
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
            latency_ms: rows.first().and_then(|row| row.latency_ms),
            fault: rows.first().and_then(|row| row.fault.clone()),
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
