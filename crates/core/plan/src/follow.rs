//! Leads an arm along a path: in each cycle to the farthest point ahead that a free straight
//! line in joint space joins with the arm.

use std::sync::Arc;

use crate::check::{Checker, distance, rows};
use crate::lanes::Row;
use crate::scene::single;
use crate::{Body, Path, Scene, Settings};

/// Distance of the led point ahead of the arm (rad and m alike).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ahead {
    /// Largest distance. Policies pull harder, so the arm is faster, towards a farther point.
    pub most: f64,
    /// Least distance, also without a free line. Not zero, or an arm beside its path would
    /// stay there.
    pub least: f64,
    /// Largest increase from one cycle to the next.
    pub growth: f64,
    /// Distance of the line from the scene (m), if the arm keeps it itself: corners are not
    /// cut any nearer.
    pub padding: f64,
}

impl Default for Ahead {
    fn default() -> Self {
        Self {
            most: 0.6,
            least: 0.02,
            growth: 0.005,
            padding: 0.0,
        }
    }
}

/// An arm on a path among solids that may move.
#[derive(Debug)]
pub struct Guide {
    body: Arc<Body>,
    /// The present solids; the owner keeps them up to date.
    pub scene: Scene,
    follower: Follower,
    ahead: Ahead,
    /// Distance of the last point ahead of the arm.
    seen: f64,
    resolution: f64,
    rows: Vec<Row>,
}

impl Guide {
    /// For an arm at the start of `path`, found with `settings`.
    pub fn new(
        body: Arc<Body>,
        scene: Scene,
        path: &Path,
        settings: &Settings,
        ahead: Ahead,
    ) -> Self {
        Self {
            rows: rows(&body),
            body,
            scene,
            follower: Follower::new(path),
            seen: ahead.least,
            ahead,
            resolution: settings.resolution,
        }
    }

    /// Position of the arm on the path, and length of the path (rad and m alike).
    pub fn progress(&self) -> (f64, f64) {
        (self.follower.at(), self.follower.length())
    }

    /// The path: configurations that are joined by straight lines (rad or m).
    pub fn waypoints(&self) -> &[Vec<f64>] {
        &self.follower.waypoints
    }

    /// State from cycle to cycle: position of the arm on the path, and distance of the last
    /// point ahead. A guide with the same path, scene and positions that is set to this state
    /// continues as this one does, to the bit.
    pub fn memory(&self) -> (f64, f64) {
        (self.follower.at, self.seen)
    }

    /// Sets the state that [`Guide::memory`] gave; a position beyond the path is its end.
    pub fn set_memory(&mut self, (at, seen): (f64, f64)) {
        self.follower.at = at.max(0.0).min(self.follower.length());
        self.seen = seen.max(self.ahead.least).min(self.ahead.most);
    }

    /// Whether the point that the arm is led to is the end of the path.
    pub fn sees_the_end(&self) -> bool {
        self.follower.at + self.seen >= self.follower.length()
    }

    /// The configuration to which an arm at `positions` is led next. Allocates nothing.
    pub fn lead(&mut self, positions: &[f64]) -> &[f64] {
        self.follower.advance(positions, self.seen);
        // The lead grows slowly: a jump of the led point would be a jump of the acceleration.
        let farthest = (self.seen + self.ahead.growth).min(self.ahead.most);
        let rows = std::mem::take(&mut self.rows);
        let mut checker = Checker::with_rows(&self.body, &self.scene, self.resolution, rows);
        checker.padding = single(self.ahead.padding);
        let at = self.follower.at();
        let mut seen = farthest;
        // Halvings, few in each cycle: the lead grows again in the next ones.
        while seen > self.ahead.least
            && !checker.is_edge_free(positions, self.follower.point(at + seen))
        {
            seen = (0.5 * seen).max(self.ahead.least);
        }
        self.rows = checker.into_rows();
        self.seen = seen;
        self.follower.point(at + seen)
    }

    /// Whether the path is free for `length` ahead of the arm (rad and m alike). Allocates
    /// nothing.
    pub fn is_free_ahead(&mut self, length: f64) -> bool {
        let rows = std::mem::take(&mut self.rows);
        let mut checker = Checker::with_rows(&self.body, &self.scene, self.resolution, rows);
        let free = self.follower.is_free_ahead(&mut checker, length);
        self.rows = checker.into_rows();
        free
    }
}

/// Position of an arm on a path.
#[derive(Debug, Clone, Default)]
struct Follower {
    waypoints: Vec<Vec<f64>>,
    /// Length of the path up to each waypoint (rad and m alike).
    lengths: Vec<f64>,
    /// Length of the path behind the arm.
    at: f64,
    /// Buffer for a point of the path.
    point: Vec<f64>,
}

/// Number of points among which the nearest one is searched.
// One in 30 mrad of the farthest lead.
const STEPS: usize = 20;

impl Follower {
    /// Along `path`, from its start.
    fn new(path: &Path) -> Self {
        let mut lengths = vec![0.0];
        let mut total = 0.0;
        for pair in path.waypoints.windows(2) {
            total += distance(&pair[0], &pair[1]);
            lengths.push(total);
        }
        Self {
            point: path.waypoints.first().cloned().unwrap_or_default(),
            waypoints: path.waypoints.clone(),
            lengths,
            at: 0.0,
        }
    }

    /// Length of the path (rad and m alike).
    fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// Length of the path behind the arm.
    fn at(&self) -> f64 {
        self.at
    }

    /// Moves to the point nearest to `positions` within the next `window` of the path, never
    /// back. An arm that cuts a corner is near the path again no earlier than at the led
    /// point.
    fn advance(&mut self, positions: &[f64], window: f64) {
        let mut nearest = (f64::INFINITY, self.at);
        for step in 0..=STEPS {
            let along = self.at + window * step as f64 / STEPS as f64;
            let off = distance(self.point(along), positions);
            if off < nearest.0 {
                nearest = (off, along);
            }
        }
        self.at = nearest.1.min(self.length());
    }

    /// Whether the next `length` of the path is free.
    fn is_free_ahead(&mut self, checker: &mut Checker<'_>, length: f64) -> bool {
        let end = (self.at + length).min(self.length());
        let at = self.at;
        self.point(at);
        let mut after = self.lengths.partition_point(|length| *length <= at);
        while let Some(to) = self.waypoints.get(after) {
            let reaches = self.lengths[after] >= end;
            // The last edge is checked as a whole: its end is near.
            if !checker.is_edge_free(&self.point, to) {
                return false;
            }
            if reaches {
                break;
            }
            self.point.clone_from(to);
            after += 1;
        }
        true
    }

    /// The point at length `along` of the path; beyond its end, the end.
    fn point(&mut self, along: f64) -> &[f64] {
        let after = self.lengths.partition_point(|length| *length <= along);
        let (Some(from), to) = (
            self.waypoints.get(after.saturating_sub(1)),
            self.waypoints.get(after),
        ) else {
            return &self.point;
        };
        let begin = self.lengths[after.saturating_sub(1)];
        let part = match self.lengths.get(after) {
            Some(end) => (along - begin) / (end - begin).max(f64::MIN_POSITIVE),
            None => 0.0,
        };
        let to = to.unwrap_or(from);
        for ((slot, from), to) in self.point.iter_mut().zip(from).zip(to) {
            *slot = from + part * (to - from);
        }
        &self.point
    }
}
