//! A gate for a change of a policy: whether its success is at least that of before.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;

use super::comparison::{Comparison, SIGNIFICANT, Verdict};
use crate::stats::mcnemar;

/// What a gate decided.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "result", rename_all = "snake_case")]
pub enum Gate {
    /// No loss of success is shown, and one of the given size would have been.
    Passed {
        /// The loss that would have been shown (share of the episodes).
        loss: f64,
    },
    /// The second ends done less often.
    Worse {
        /// Success of the first less that of the second.
        loss: f64,
        /// How likely equals differ as much.
        p: f64,
    },
    /// The loss could have stayed unseen.
    TooFew {
        /// Episodes that are in both files.
        pairs: u64,
        /// Least number of them with which the loss is seen.
        needed: u64,
        /// The loss (share of the episodes).
        loss: f64,
    },
}

/// Decides by the episodes that are in both files; `loss` is the least loss of success that has to be
/// seen (share of the episodes, above 0 and up to 1).
pub(super) fn gate(comparison: &Comparison, loss: f64) -> Gate {
    let (pairs, needed) = (comparison.pairs, pairs_needed(loss));
    // A loss that is shown is one, however few the episodes are.
    if pairs > 0 && comparison.verdict == Verdict::Worse {
        let loss = -comparison.difference;
        return Gate::Worse {
            loss,
            p: comparison.p,
        };
    }
    if pairs < needed {
        return Gate::TooFew {
            pairs,
            needed,
            loss,
        };
    }
    Gate::Passed { loss }
}

/// Least number of pairs of which a share of `loss` is enough for the test of `McNemar`, where no
/// pair differs the other way.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it is positive and the conversion saturates"
)]
fn pairs_needed(loss: f64) -> u64 {
    let mut flips = 1_u64;
    while mcnemar(flips, 0) >= SIGNIFICANT {
        flips += 1;
    }
    // 6 / 0.05 is a little more than 120.
    (flips as f64 / loss - 1.0e-9).ceil() as u64
}

impl fmt::Display for Gate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Passed { loss } => write!(
                f,
                "gate: passed; a loss of success by {:.1} % would have been seen",
                100.0 * loss
            ),
            Self::Worse { loss, p } => write!(
                f,
                "gate: worse; the second loses {:.1} % of the episodes (p = {p:.2e})",
                100.0 * loss
            ),
            Self::TooFew {
                pairs,
                needed,
                loss,
            } => write!(
                f,
                "gate: {pairs} episodes are in both files; {needed} are needed to see a loss of {:.1} %: run \
                 more seeds, or give a larger --loss",
                100.0 * loss
            ),
        }
    }
}
