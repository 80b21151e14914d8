//! Warnings of many episodes: a warning that several of them have is shown once.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

/// Number of different warnings shown; a script that is refused at a time that depends on
/// the seed would fill the terminal.
const MOST: usize = 20;

/// The warnings that were shown.
#[derive(Default)]
pub(crate) struct Warned(Mutex<BTreeSet<String>>);

impl Warned {
    /// Shows those of `warnings` that are new.
    pub(crate) fn show(&self, warnings: &[String]) {
        self.new_ones(warnings).iter().for_each(cell_worker::warn);
    }

    fn new_ones(&self, warnings: &[String]) -> Vec<String> {
        let mut shown = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut new_ones = Vec::new();
        for warning in warnings {
            // One more than the limit is accepted: it becomes the line that reports further
            // ones.
            if shown.len() > MOST || !shown.insert(warning.clone()) {
                continue;
            }
            new_ones.push(if shown.len() > MOST {
                "more warnings of episodes are not shown; `--seeds N` shows those of one".to_owned()
            } else {
                warning.clone()
            });
        }
        new_ones
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_of_many_episodes_is_shown_once_and_too_many_are_named() {
        let (warned, mut shown) = (Warned::default(), Vec::new());
        for seed in 0..100 {
            let warnings = ["the same".to_owned(), format!("at {seed} s")];
            shown.extend(warned.new_ones(&warnings));
        }
        assert_eq!(shown.iter().filter(|text| *text == "the same").count(), 1);
        assert_eq!(shown.len(), MOST + 1);
        assert!(shown[MOST].contains("are not shown"), "{shown:?}");
    }
}
