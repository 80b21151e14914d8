//! Requests to a planner.

use nalgebra::{Isometry3, Vector3};
use rmp::MAX_CARRIED;

use crate::checkpoint::{CheckpointError, Codec, damaged};
use crate::planning::{Moment, PlanGoal};

/// The kind of a request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ask {
    /// The reason why the arm is not at its goal.
    #[default]
    Reason,
    /// A path, if motion policies cannot move straight to the goal.
    Path,
    /// A path, even if the straight motion is free: motion policies did not make it.
    Detour,
}

/// A request: all that its answer depends on.
#[derive(Clone, Debug)]
pub struct PlanRequest {
    /// Number, from 1 up.
    pub id: u64,
    /// Tick at which it was made.
    pub tick: u64,
    /// The kind.
    pub ask: Ask,
    /// Positions of the arm (rad or m).
    pub start: Vec<f64>,
    /// Preferred joint positions (rad or m).
    pub posture: Vec<f64>,
    /// Pose of the tool, base frame (m).
    pub goal: Isometry3<f64>,
    /// The posture is the goal.
    pub by_joints: bool,
    /// The obstacles in force, by their number in the arm's surroundings, base frame.
    pub obstacles: Vec<(usize, Isometry3<f64>)>,
    /// Spheres of the held object: centre in the tool frame, radius (m).
    pub held: Vec<(Vector3<f64>, f64)>,
}

impl PlanRequest {
    /// An empty one with room for an arm of `joints` joints among `obstacles` obstacles.
    pub fn with_capacity(joints: usize, obstacles: usize) -> Self {
        Self {
            id: 0,
            tick: 0,
            ask: Ask::Reason,
            start: vec![0.0; joints],
            posture: vec![0.0; joints],
            goal: Isometry3::identity(),
            by_joints: false,
            obstacles: Vec::with_capacity(obstacles),
            held: Vec::with_capacity(MAX_CARRIED),
        }
    }

    /// Capacity of obstacles.
    pub(crate) fn obstacle_capacity(&self) -> usize {
        self.obstacles.capacity()
    }

    /// Becomes a copy of `other`. Allocates nothing within its capacity.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        (self.id, self.tick, self.ask, self.goal) = (other.id, other.tick, other.ask, other.goal);
        self.by_joints = other.by_joints;
        self.start.clone_from(&other.start);
        self.posture.clone_from(&other.posture);
        self.obstacles.clone_from(&other.obstacles);
        self.held.clone_from(&other.held);
    }

    /// Becomes the next request.
    pub(crate) fn fill(&mut self, ask: Ask, now: &Moment<'_>, goal: &PlanGoal) {
        self.id += 1;
        self.tick = now.tick;
        self.ask = ask;
        self.start.copy_from_slice(&now.state.positions);
        self.posture.copy_from_slice(now.posture);
        // For a goal with an approach the path ends where the approach starts.
        self.by_joints = goal.by_joints;
        self.goal = goal.pose;
        self.goal.translation.vector -= goal.approach;
        self.obstacles.clear();
        let placed = now
            .solids()
            .filter_map(|id| Some((id.0, now.obstacles.pose(id)?)));
        self.obstacles.extend(placed);
        self.held.clear();
        self.held.extend_from_slice(now.held);
    }

    /// Writes or reads all of a request that `is_in_flight`, or only its number.
    pub(crate) fn checkpoint(
        &mut self,
        codec: &mut Codec<'_>,
        is_in_flight: bool,
    ) -> Result<(), CheckpointError> {
        // The number is kept: requests of a restored cycle continue to count.
        codec.u64(&mut self.id)?;
        if !is_in_flight {
            return Ok(());
        }
        codec.u64(&mut self.tick)?;
        let mut ask = self.ask as u32;
        codec.u32(&mut ask)?;
        self.ask = match ask {
            0 => Ask::Reason,
            1 => Ask::Path,
            2 => Ask::Detour,
            found => return Err(damaged("request", u64::from(found))),
        };
        codec.f64s(&mut self.start)?;
        codec.f64s(&mut self.posture)?;
        codec.pose(&mut self.goal)?;
        codec.bool("goal by joints", &mut self.by_joints)?;
        // Lengths are checked against the buffers: a damaged checkpoint must not make a cycle
        // allocate.
        let most = self.obstacle_capacity();
        codec.list(
            "obstacles",
            &mut self.obstacles,
            most,
            |codec, (id, pose)| {
                codec.index("obstacle", id, most)?;
                codec.pose(pose)
            },
        )?;
        held(codec, &mut self.held)
    }
}

/// Writes or reads the spheres of a held object.
pub(crate) fn held(
    codec: &mut Codec<'_>,
    held: &mut Vec<(Vector3<f64>, f64)>,
) -> Result<(), CheckpointError> {
    codec.list("held spheres", held, MAX_CARRIED, |codec, (at, radius)| {
        codec.f64s(at.iter_mut())?;
        codec.f64(radius)
    })
}
