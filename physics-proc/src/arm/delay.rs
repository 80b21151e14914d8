//! Drives that follow their targets later, for `drive_delay_s` of `[disturbance]`.

use std::collections::VecDeque;

use ipc_types::TICK_NS;

use crate::arm::multibody::DriveTarget;

/// Targets of the joints of an arm that its drives do not follow yet, the oldest first.
pub(crate) type Delayed = VecDeque<Vec<DriveTarget>>;

/// Delay of the drives of an arm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Delay {
    ticks: usize,
}

impl Delay {
    /// By the nearest whole number of ticks; 0 to 1 s.
    pub(crate) fn new(seconds: f64) -> Self {
        let ticks = (seconds * 1.0e9 / TICK_NS as f64).round().clamp(0.0, 1.0e3);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number up to 1000"
        )]
        Self {
            ticks: ticks as usize,
        }
    }

    /// Takes the targets of this tick and replaces them by those that are due. The first ones
    /// are followed until later ones are due. The effort that carries the arm is not delayed:
    /// drives know their own posture.
    pub(crate) fn pass(self, delayed: &mut Delayed, targets: &mut [DriveTarget]) {
        if self.ticks == 0 {
            return;
        }
        delayed.push_back(targets.to_vec());
        // The queue keeps a constant length from here on.
        let due = if delayed.len() > self.ticks {
            delayed.pop_front()
        } else {
            delayed.front().cloned()
        };
        for (target, due) in targets.iter_mut().zip(due.unwrap_or_default()) {
            *target = DriveTarget {
                gravity: target.gravity,
                ..due
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_followed_so_many_ticks_later() {
        let at = |position: f64| {
            vec![DriveTarget {
                position,
                gravity: position,
                ..DriveTarget::default()
            }]
        };
        let follow = |seconds: f64| {
            let (delay, mut delayed) = (Delay::new(seconds), Delayed::default());
            let mut followed = |tick: i32| {
                let mut targets = at(f64::from(tick));
                delay.pass(&mut delayed, &mut targets);
                targets[0]
            };
            (0..6).map(&mut followed).collect::<Vec<DriveTarget>>()
        };
        let positions = |seconds| {
            let all = follow(seconds);
            all.iter().map(|t| t.position).collect::<Vec<f64>>()
        };
        assert_eq!(positions(0.0), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(positions(0.0021), [0.0, 0.0, 0.0, 1.0, 2.0, 3.0]);
        assert!(
            follow(0.002)
                .iter()
                .zip(0..6)
                .all(|(target, tick)| { (target.gravity - f64::from(tick)).abs() < f64::EPSILON })
        );
    }
}
