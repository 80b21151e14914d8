//! Number of times the task reached each breakpoint.

use ipc_types::{BreakName, Decision, WorldState};

/// Counts, by breakpoint.
#[derive(Default)]
pub(crate) struct BreakpointCounts {
    counts: Vec<(String, u64)>,
    tick: u64,
}

impl BreakpointCounts {
    /// Updates the breakpoints in force and counts the one reached last.
    pub(crate) fn update(&mut self, world: &WorldState, decision: Option<&Decision>) {
        // Names are carried over by name: a breakpoint set again starts from 0.
        let names = world.panel.breaks().iter().map(BreakName::as_str);
        let before = std::mem::take(&mut self.counts);
        let known = |name: &str| before.iter().find(|(known, _)| known == name);
        let count = |name: &str| known(name).map_or(0, |(_, count)| *count);
        self.counts = names.map(|name| (name.to_owned(), count(name))).collect();
        let tick = decision.map_or(self.tick, |decision| decision.break_tick);
        // The tick changes once per stop, so a stop is counted once however often it is read.
        if std::mem::replace(&mut self.tick, tick) != tick && tick != 0 {
            let reached = decision.map_or("", |decision| decision.break_name.as_str());
            let mut counts = self.counts.iter_mut();
            if let Some((_, count)) = counts.find(|(name, _)| name == reached) {
                *count += 1;
            }
        }
    }

    /// Count of each, in the order they were set.
    pub(crate) fn counts(&self) -> &[(String, u64)] {
        &self.counts
    }
}

#[cfg(test)]
mod tests {
    use ipc_types::{Text, Wire as _};

    use super::*;

    #[test]
    fn a_breakpoint_is_counted_once_each_time_it_is_reached() {
        let (mut world, mut decision) = (WorldState::zeroed(), Decision::zeroed());
        world.panel.break_count = 1;
        world.panel.breaks[0] = Text::new("LIFT");
        let mut breaks = BreakpointCounts::default();
        breaks.update(&world, Some(&decision));
        assert_eq!(breaks.counts(), [("LIFT".to_owned(), 0)]);
        for tick in [120, 120, 450] {
            decision.break_tick = tick;
            decision.break_name = Text::new("LIFT");
            breaks.update(&world, Some(&decision));
        }
        assert_eq!(breaks.counts(), [("LIFT".to_owned(), 2)]);
        world.panel.break_count = 0;
        breaks.update(&world, Some(&decision));
        assert!(breaks.counts().is_empty());
    }
}
