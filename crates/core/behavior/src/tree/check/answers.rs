//! The possible results of nodes.

use crate::status::Status;
use crate::tree::Host;
use crate::tree::spec::{Kind, Modifier, ParallelPolicy};

/// The results that a node may return.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Answers {
    pub running: bool,
    pub success: bool,
    pub failure: bool,
}

impl Answers {
    pub(super) const ALL: Self = Self::new(true, true, true);
    pub(super) const FINAL: Self = Self::new(false, true, true);
    pub(super) const SUCCESS: Self = Self::new(false, true, false);

    #[allow(
        clippy::fn_params_excessive_bools,
        reason = "in the order of the fields"
    )]
    const fn new(running: bool, success: bool, failure: bool) -> Self {
        Self {
            running,
            success,
            failure,
        }
    }

    fn has(self, status: Status) -> bool {
        match status {
            Status::Running => self.running,
            Status::Success => self.success,
            Status::Failure => self.failure,
        }
    }

    fn set(&mut self, status: Status, may: bool) {
        match status {
            Status::Running => self.running = may,
            Status::Success => self.success = may,
            Status::Failure => self.failure = may,
        }
    }

    fn inverted(self) -> Self {
        Self::new(self.running, self.failure, self.success)
    }

    fn running(self) -> Self {
        Self {
            running: true,
            ..self
        }
    }

    fn failing(self) -> Self {
        Self {
            failure: true,
            ..self
        }
    }
}

/// The possible results of a node without its modifiers, from those of its children.
/// Leaves are known to the caller.
pub(super) fn inner<H: Host>(kind: &Kind<H>, children: &[Answers]) -> Answers {
    let child = children.first().copied().unwrap_or(Answers::ALL);
    match kind {
        Kind::Sequence(_) => line(children, Status::Success),
        // It starts at most one child per tick, so it runs between two children that succeed.
        Kind::SequenceWithMemory => line(children, Status::Success).running(),
        Kind::Selector(_) => line(children, Status::Failure),
        Kind::Parallel(policy) => parallel(policy, children),
        Kind::Inverter => child.inverted(),
        Kind::Converter { from, to } => {
            let mut answers = child;
            answers.set(*from, false);
            if child.has(*from) {
                answers.set(*to, true);
            }
            answers
        }
        Kind::PassThrough | Kind::Count | Kind::OneShot(_) => child,
        Kind::Repeat { count }
        | Kind::Again {
            count,
            on_failure: false,
        } => Answers {
            // Without a count it ends with a failure only.
            success: child.success && count.is_some(),
            ..child.running()
        },
        Kind::Retry { count }
        | Kind::Again {
            count,
            on_failure: true,
        } => Answers {
            failure: child.failure && count.is_some(),
            // Each run ends a tick, so the decorator runs even if the child never does.
            ..child.running()
        },
        Kind::Condition(status) => Answers {
            success: child.has(*status),
            running: true,
            failure: false,
        },
        Kind::EternalGuard(_) => child.failing(),
        Kind::Timeout(_) => Answers {
            failure: child.failure || child.running,
            ..child
        },
        Kind::Wait(_) => Answers::new(true, true, false),
        Kind::Leaf(_) => Answers::ALL,
    }
}

/// Children one after the other as long as they return `goes_on`.
fn line(children: &[Answers], goes_on: Status) -> Answers {
    let ends = match goes_on {
        Status::Success => Status::Failure,
        _ => Status::Success,
    };
    let mut answers = Answers::new(false, false, false);
    for child in children {
        answers.running |= child.running;
        if child.has(ends) {
            answers.set(ends, true);
        }
        // A child that never returns `goes_on` hides all behind it.
        if !child.has(goes_on) {
            return answers;
        }
    }
    answers.set(goes_on, true);
    answers
}

fn parallel(policy: &ParallelPolicy, children: &[Answers]) -> Answers {
    // Only the selected children decide a success; any child may make it fail.
    let needed: Vec<&Answers> = match policy {
        ParallelPolicy::Selected { children: some, .. } => {
            some.iter().filter_map(|i| children.get(*i)).collect()
        }
        _ => children.iter().collect(),
    };
    let success = match policy {
        // Finished children are counted over several ticks, so one that may succeed is enough
        // here.
        ParallelPolicy::Count { .. } | ParallelPolicy::Finish { .. } => {
            needed.iter().any(|c| c.success)
        }
        ParallelPolicy::One => needed.iter().any(|c| c.success) || children.is_empty(),
        _ => needed.iter().all(|c| c.success),
    };
    Answers {
        running: children.iter().any(|c| c.running),
        success,
        failure: children.iter().any(|c| c.failure),
    }
}

/// The possible results outside of the modifiers, the first of which is the outermost.
pub(super) fn after<'m>(
    modifiers: impl DoubleEndedIterator<Item = &'m Modifier>,
    answers: Answers,
) -> Answers {
    modifiers
        // From the innermost outwards, as the engine runs them.
        .rev()
        .fold(answers, |inner, modifier| match modifier {
            Modifier::Repeat {
                count,
                break_on_failure,
            } => Answers {
                running: true,
                success: *count > 0 && (inner.success || !break_on_failure),
                failure: inner.failure && *break_on_failure,
            },
            Modifier::Retry { max, .. } => Answers {
                failure: inner.failure && *max > 0,
                ..inner.running()
            },
            Modifier::InvertStatus => inner.inverted(),
            Modifier::ForceStatus(status) => {
                let mut forced = Answers::new(inner.running, false, false);
                forced.set(*status, inner.success || inner.failure);
                forced
            }
            Modifier::Delay(_) => inner.running(),
            Modifier::Timeout(_) => Answers {
                failure: inner.failure || inner.running,
                ..inner
            },
            Modifier::CheckBlackboard { .. } => inner.failing(),
        })
}
