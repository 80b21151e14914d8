//! The clock of a replay: time is an argument.

use crate::page::command::PlayOrder;

pub(crate) use ipc_types::TICK_S;

/// A longer pause is a machine that slept (s).
// Without it the replay would leap by hours after the machine was suspended.
const MAX_GAP_S: f64 = 0.25;

/// Time and speed of a replay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Simulated time shown (s).
    pub time_s: f64,
    /// Whether it plays.
    pub plays: bool,
    /// Recorded seconds per second.
    pub speed: f64,
    from_s: f64,
    to_s: f64,
    last_s: Option<f64>,
}

impl Clock {
    /// A clock at the start of `(from, to)`, playing.
    pub fn new((from_s, to_s): (f64, f64)) -> Self {
        Self {
            time_s: from_s,
            plays: true,
            speed: 1.0,
            from_s,
            to_s: to_s.max(from_s),
            last_s: None,
        }
    }

    /// Advances to `now_s` of the monotonic clock; stops at the end.
    pub fn advance(&mut self, now_s: f64) -> f64 {
        let passed_s = self.last_s.map_or(0.0, |last_s| now_s - last_s);
        self.last_s = Some(now_s);
        if self.plays {
            let passed_s = passed_s.clamp(0.0, MAX_GAP_S);
            self.set(self.time_s + passed_s * self.speed);
            // Stopped, so that the page shows "play" and the next
            // press starts from the beginning.
            if self.time_s >= self.to_s {
                self.plays = false;
            }
        }
        self.time_s
    }

    /// Executes an order of a page.
    pub fn apply(&mut self, order: PlayOrder) {
        // Speed first, then time, then play: an order may have all of them.
        if let Some(speed) = order.speed {
            self.speed = speed;
        }
        if let Some(time_s) = order.time_s {
            self.set(time_s);
        }
        if let Some(ticks) = order.step {
            self.plays = false;
            self.set(self.time_s + ticks as f64 * TICK_S);
        }
        if let Some(plays) = order.play {
            // At the end, playing means playing again.
            if plays && self.time_s >= self.to_s {
                self.set(self.from_s);
            }
            self.plays = plays;
        }
    }

    fn set(&mut self, time_s: f64) {
        self.time_s = time_s.clamp(self.from_s, self.to_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_plays_at_its_speed_stops_at_the_end_and_begins_again() {
        let mut clock = Clock::new((10.0, 12.0));
        clock.advance(0.0);
        assert_eq!(clock.advance(0.2), 10.2);
        clock.apply(PlayOrder {
            speed: Some(2.0),
            ..PlayOrder::default()
        });
        assert_eq!(clock.advance(0.4), 10.6);
        assert_eq!(clock.advance(100.0), 11.1, "a machine that slept");
        for advance in 0..10 {
            clock.advance(100.0 + 0.2 * f64::from(advance));
        }
        assert_eq!((clock.time_s, clock.plays), (12.0, false));
        clock.apply(PlayOrder {
            play: Some(true),
            ..PlayOrder::default()
        });
        assert_eq!((clock.time_s, clock.plays), (10.0, true));
    }

    #[test]
    fn a_step_stands_still_and_a_time_outside_is_the_nearest_inside() {
        let mut clock = Clock::new((0.0, 5.0));
        clock.apply(PlayOrder {
            step: Some(500),
            ..PlayOrder::default()
        });
        assert_eq!((clock.advance(1.0), clock.plays), (0.5, false));
        clock.apply(PlayOrder {
            time_s: Some(99.0),
            ..PlayOrder::default()
        });
        assert_eq!(clock.time_s, 5.0);
    }
}
