//! Epochs: a restart of physics sets simulated time back to its snapshot, so a time alone does
//! not identify a moment. The epoch of a state is the generation of the physics process that
//! published it.

use std::collections::BTreeMap;

use serde::Serialize;

/// Simulated time that was recorded of one epoch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EpochSpan {
    /// Generation of physics; 0 in recordings that do not name it.
    pub epoch: u32,
    /// First simulated time (s).
    pub from_s: f64,
    /// Last simulated time (s).
    pub to_s: f64,
}

/// The same in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) epoch: u32,
    pub(crate) from_ns: u64,
    pub(crate) to_ns: u64,
}

impl From<Span> for EpochSpan {
    fn from(span: Span) -> Self {
        Self {
            epoch: span.epoch,
            from_s: span.from_ns as f64 / 1.0e9,
            to_s: span.to_ns as f64 / 1.0e9,
        }
    }
}

/// One span for each epoch, oldest first, of `pieces` in any order.
pub(crate) fn merged(pieces: impl IntoIterator<Item = Span>) -> Vec<Span> {
    let mut merged: Vec<Span> = Vec::new();
    for piece in pieces {
        // A list and not a map: a run has a handful of epochs.
        match merged.iter_mut().find(|span| span.epoch == piece.epoch) {
            Some(span) => {
                span.from_ns = span.from_ns.min(piece.from_ns);
                span.to_ns = span.to_ns.max(piece.to_ns);
            }
            None => merged.push(piece),
        }
    }
    merged.sort_by_key(|span| span.epoch);
    merged
}

/// The history of one epoch: its own time, and of the epochs before it the time up to the point
/// where the next one resumed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Line {
    /// Epochs, and the time their part ends before (ns).
    before_ns: BTreeMap<u32, u64>,
    /// First and last time (ns).
    pub(crate) span_ns: (u64, u64),
}

impl Line {
    /// The history of `epoch`, or of the newest of `epochs` where that is `None` or
    /// not among them.
    pub(crate) fn of(epochs: &[Span], epoch: Option<u32>) -> Self {
        let known = epochs.iter().rposition(|span| Some(span.epoch) == epoch);
        let last = known.unwrap_or(epochs.len().saturating_sub(1));
        let Some(own) = epochs.get(last) else {
            return Self::default();
        };
        let (mut before_ns, mut resumed_ns) =
            (BTreeMap::from([(own.epoch, u64::MAX)]), own.from_ns);
        // From the newest back: each epoch counts only up to the
        // time at which its successor resumed.
        for span in epochs.iter().take(last).rev() {
            // An epoch that starts later than it was overtaken has no part in this history.
            if span.from_ns < resumed_ns {
                before_ns.insert(span.epoch, resumed_ns);
                resumed_ns = span.from_ns;
            }
        }
        // Messages before the first state name no generation of
        // physics: they are of the first one.
        if let [unnamed, first, ..] = epochs
            && unnamed.epoch == 0
            && let Some(before) = before_ns.get(&first.epoch).copied()
        {
            before_ns.insert(unnamed.epoch, before);
        }
        Self {
            before_ns,
            span_ns: (resumed_ns, own.to_ns),
        }
    }

    /// Whether a message of `time_ns` in `epoch` is part of this history.
    pub(crate) fn has(&self, epoch: u32, time_ns: u64) -> bool {
        self.before_ns
            .get(&epoch)
            .is_some_and(|before| time_ns < *before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(epoch: u32, from_ns: u64, to_ns: u64) -> Span {
        Span {
            epoch,
            from_ns,
            to_ns,
        }
    }

    #[test]
    fn a_resumed_epoch_takes_over_where_it_resumed() {
        let epochs = merged([span(2, 25, 40), span(1, 0, 10), span(1, 10, 30)]);
        assert_eq!(epochs, [span(1, 0, 30), span(2, 25, 40)]);
        let line = Line::of(&epochs, None);
        assert_eq!(line.span_ns, (0, 40));
        assert!(line.has(1, 24) && !line.has(1, 25) && line.has(2, 25) && line.has(2, 40));
        // What was overtaken is reached by its epoch.
        let line = Line::of(&epochs, Some(1));
        assert_eq!(line.span_ns, (0, 30));
        assert!(line.has(1, 29) && !line.has(2, 25));
    }

    #[test]
    fn what_was_recorded_before_the_first_state_is_of_the_first_epoch() {
        let epochs = [span(0, 0, 0), span(1, 0, 60), span(2, 0, 7)];
        assert!(Line::of(&epochs[..2], None).has(0, 0));
        assert!(Line::of(&epochs, Some(1)).has(0, 0));
        assert!(!Line::of(&epochs, None).has(0, 0), "of another history");
        assert!(Line::of(&epochs[..1], None).has(0, 0));
    }

    #[test]
    fn an_epoch_that_begins_at_zero_has_no_earlier_history() {
        let epochs = [span(1, 0, 60), span(2, 0, 7)];
        let line = Line::of(&epochs, None);
        assert_eq!(line.span_ns, (0, 7));
        assert!(!line.has(1, 3) && line.has(2, 3));
        assert_eq!(Line::of(&epochs, Some(9)), line);
        assert_eq!(Line::of(&[], None), Line::default());
    }
}
