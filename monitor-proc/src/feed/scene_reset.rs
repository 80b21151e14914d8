//! Decisions from before a reset of the scene are not valid after it.

use ipc_types::{Decision, WorldState};

/// The newest reset of the scene.
#[derive(Default)]
pub(crate) struct SceneReset {
    count: Option<u32>,
    /// Tick at which it was seen; 0 for a reset before the first look.
    tick: u64,
}

impl SceneReset {
    /// Whether `decision` was made after the newest reset that `world` knows. A paused task
    /// makes no decision until it is resumed.
    pub(crate) fn is_after(&mut self, world: Option<&WorldState>, decision: &Decision) -> bool {
        if let Some(world) = world {
            let count = world.panel.scene_reset;
            let before = self.count.replace(count);
            // The first look only learns the count: resets before
            // it do not concern this decision.
            if before.is_some_and(|before| before != count) {
                self.tick = world.header.tick;
            }
        }
        self.tick == 0 || decision.header.tick > self.tick
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    #[test]
    fn a_decision_of_before_the_reset_is_none() {
        let (mut world, mut decision) = (WorldState::zeroed(), Decision::zeroed());
        (world.header.tick, decision.header.tick) = (5003, 5000);
        let mut reset = SceneReset::default();
        assert!(reset.is_after(Some(&world), &decision));
        world.panel.scene_reset = 1;
        assert!(!reset.is_after(Some(&world), &decision));
        assert!(!reset.is_after(None, &decision));
        decision.header.tick = 5010;
        assert!(reset.is_after(Some(&world), &decision));
    }
}
