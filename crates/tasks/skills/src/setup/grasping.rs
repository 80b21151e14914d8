//! The planner of grasps, with the shapes of the cell.

use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use cell_model::{ArmSpec, Cell};
use grasp::{Gripper, Reach, Scene, touches};
use ipc_types::Pose;
use nalgebra::{Isometry3, Vector3};
use robocell_task::Observation;

use crate::pose::isometry;

/// What the planner needs of the cell; clones share it. Not compared.
#[derive(Clone, Default)]
pub(crate) struct Grasping(Option<Arc<Shapes>>);

struct Shapes {
    /// At the start of a run.
    scene: Scene,
    arms: Vec<ArmShapes>,
}

struct ArmShapes {
    spec: ArmSpec,
    gripper: Option<Gripper>,
    /// Made when it is first needed: most jobs of a test never do.
    reach: OnceLock<Option<Mutex<Reach>>>,
}

impl Grasping {
    /// Of a cell.
    pub(crate) fn of(cell: &Cell) -> Self {
        let arm = |spec: &ArmSpec| ArmShapes {
            spec: spec.clone(),
            gripper: Gripper::of(&spec.robot),
            reach: OnceLock::new(),
        };
        Self(Some(Arc::new(Shapes {
            scene: Scene::of(cell),
            arms: cell.arms.iter().map(arm).collect(),
        })))
    }

    /// The tool of an arm; `None` for one without a gripper.
    pub(crate) fn gripper(&self, arm: usize) -> Option<&Gripper> {
        self.0.as_ref()?.arms.get(arm)?.gripper.as_ref()
    }

    /// The scene at the start of a run.
    pub(crate) fn scene_at_start(&self) -> Option<&Scene> {
        self.0.as_ref().map(|shapes| &shapes.scene)
    }

    /// The least and the largest coordinate of an object at `pose` along a unit `axis` (m).
    pub(crate) fn extent(
        &self,
        object: usize,
        pose: &Pose,
        axis: &Vector3<f64>,
    ) -> Option<(f64, f64)> {
        let body = self.scene_at_start()?.objects.get(object)?;
        Some(body.extent(&isometry(pose), axis))
    }

    /// The first of `others` that `object` would touch if it were set down at `goal` (world frame);
    /// one that is not in the cell is not in the way.
    pub(crate) fn blocker(
        &self,
        observation: &Observation<'_>,
        (object, goal): (usize, &Isometry3<f64>),
        mut others: impl Iterator<Item = usize>,
    ) -> Option<usize> {
        let bodies = &self.scene_at_start()?.objects;
        let body = bodies.get(object)?;
        others.find(|other| {
            let seen = observation.object(*other);
            let seen = seen.filter(|seen| seen.flags & ipc_types::world::OBJECT_ENABLED != 0);
            let both = seen.zip(bodies.get(*other));
            both.is_some_and(|(seen, its)| {
                *other != object && touches((body, goal), (its, &isometry(&seen.pose)))
            })
        })
    }

    /// The scene as `arm` sees it now: objects and other arms where they are.
    pub(crate) fn scene(&self, arm: usize, observation: &Observation<'_>) -> Option<Scene> {
        let shapes = self.0.as_ref()?;
        let mut scene = shapes.scene.clone();
        for (index, body) in scene.objects.iter_mut().enumerate() {
            let seen = observation.object(index);
            let seen = seen.filter(|seen| seen.flags & ipc_types::world::OBJECT_ENABLED != 0);
            body.pose = seen.map(|seen| isometry(&seen.pose));
        }
        let others = shapes.arms.iter().enumerate();
        for (other, shapes) in others.filter(|(other, _)| *other != arm) {
            if let Some(seen) = observation.arm(other) {
                let count = seen.joint_count as usize;
                let positions = seen.joint_positions.get(..count).unwrap_or_default();
                scene.add_arm(&shapes.spec, positions);
            }
        }
        Some(scene)
    }

    /// Whether `arm`, at these joint positions, reaches `tcp` (world frame); true for an arm whose
    /// files its controller refuses, since it does not run.
    pub(crate) fn reaches(&self, arm: usize, from: &[f64], tcp: &Isometry3<f64>) -> bool {
        let shapes = self.0.as_ref().and_then(|shapes| shapes.arms.get(arm));
        let reach = shapes.and_then(|shapes| {
            let make = || Reach::of(&shapes.spec).map(Mutex::new);
            shapes.reach.get_or_init(make).as_ref()
        });
        reach.is_none_or(|reach| {
            let mut reach = reach.lock().unwrap_or_else(PoisonError::into_inner);
            reach.reaches_from(from, tcp)
        })
    }
}

impl fmt::Debug for Grasping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Grasping")
    }
}

impl PartialEq for Grasping {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}
