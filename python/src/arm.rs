//! One arm in one decision.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robocell_skills::{Way, World};

use crate::command::{Command, PoseCommand};
use crate::decision::Decision;
use crate::inner::{Shared, lock};
use crate::work::{Status, Work, gripper_of, pose_of};

/// One arm in one decision.
#[pyclass(frozen, module = "robocell._core")]
pub(crate) struct Arm {
    pub(crate) shared: Shared,
    pub(crate) index: usize,
}

impl Arm {
    pub(crate) fn new(shared: Shared, index: usize) -> Self {
        Self { shared, index }
    }

    fn check_joints(&self, decision: &Decision, positions: &[f64]) -> PyResult<()> {
        let count = decision.joint_count(self.index);
        if positions.len() == count && positions.iter().all(|x| x.is_finite()) {
            return Ok(());
        }
        Err(PyValueError::new_err(format!(
            "{count} finite joint positions are needed, not {positions:?}"
        )))
    }

    fn see<R>(&self, look: impl FnOnce(&mut World<'_>) -> R) -> R {
        lock(&self.shared).decision.world(self.index, look)
    }
}

#[pymethods]
impl Arm {
    /// Its name in the cell file.
    #[getter]
    fn name(&self) -> String {
        self.see(|world| world.arm_name().to_owned())
    }

    /// Its index in the cell file.
    #[getter]
    fn index(&self) -> usize {
        self.index
    }

    /// Name of the object in the gripper.
    #[getter]
    fn held(&self) -> Option<String> {
        self.see(|world| world.held().map(|o| world.setup.object_name(o).to_owned()))
    }

    /// Whether the gripper is open.
    #[getter]
    fn is_open(&self) -> bool {
        self.see(|world| world.is_open())
    }

    /// Whether the arm has no fault and its controller answers.
    #[getter]
    fn is_alive(&self) -> bool {
        self.see(|world| world.is_alive())
    }

    /// Whether the arm reaches a point with the tool straight down (m).
    fn reaches(&self, position_m: [f64; 3]) -> bool {
        self.see(|world| world.reaches(position_m.into()))
    }

    /// Orientation of the TCP with the tool straight down, turned by `yaw_rad`.
    fn down(&self, yaw_rad: f64) -> [f64; 4] {
        self.see(|world| world.tool().down(yaw_rad))
    }

    /// Whether an object is at rest.
    fn is_at_rest(&self, object: &str) -> PyResult<bool> {
        let mut inner = lock(&self.shared);
        let object = inner.decision.object(object)?;
        Ok(inner
            .decision
            .world(self.index, |world| world.is_at_rest(object)))
    }

    /// Whether an object covers another.
    fn is_covered(&self, object: &str) -> PyResult<bool> {
        let mut inner = lock(&self.shared);
        let object = inner.decision.object(object)?;
        Ok(inner
            .decision
            .world(self.index, |world| world.is_covered(object)))
    }

    /// The TCP with which this arm grips an object as it is now: position and turn.
    fn grip_pose(&self, object: &str, above_m: f64) -> PyResult<Option<([f64; 3], [f64; 4])>> {
        let mut inner = lock(&self.shared);
        let object = inner.decision.object(object)?;
        Ok(inner.decision.world(self.index, |world| {
            let at = world.placement(object)?;
            let pose = world.grip_pose(object, at, above_m);
            Some((pose.position, pose.orientation_wxyz))
        }))
    }

    /// Sends the TCP to a pose. A target near the one before moves the goal that is
    /// followed; another one is a new goal.
    #[pyo3(signature = (position_m, orientation_wxyz, gripper="keep", approach_m=[0.0; 3],
                        approach_std_dev_m=0.0, ignore=vec![], guides=vec![], posture=None))]
    #[allow(clippy::too_many_arguments, reason = "they are named in Python")]
    fn send(
        &self,
        position_m: [f64; 3],
        orientation_wxyz: [f64; 4],
        gripper: &str,
        approach_m: [f64; 3],
        approach_std_dev_m: f64,
        ignore: Vec<String>,
        guides: Vec<String>,
        posture: Option<Vec<f64>>,
    ) -> PyResult<()> {
        let target = pose_of(position_m, orientation_wxyz)?;
        let gripper = gripper_of(gripper)?.code();
        if !approach_m
            .iter()
            .chain([&approach_std_dev_m])
            .all(|x| x.is_finite())
        {
            return Err(PyValueError::new_err(
                "the approach has to be of finite numbers",
            ));
        }
        let mut inner = lock(&self.shared);
        if let Some(posture) = &posture {
            self.check_joints(&inner.decision, posture)?;
        }
        let (mut object_mask, mut way) = (u64::MAX, Way::default());
        for name in &guides {
            way.guides |= inner.decision.obstacle(name)?;
        }
        for name in &ignore {
            if let Ok(bit) = inner.decision.obstacle(name) {
                way.ignored |= bit;
                continue;
            }
            let object = inner.decision.object(name)?;
            // An object without a bit is not an obstacle, so there is nothing to ignore.
            if let Some(bit) = inner
                .decision
                .setup
                .objects
                .get(object)
                .and_then(|o| o.obstacle_bit)
            {
                object_mask &= !(1 << bit);
            }
        }
        let command = PoseCommand {
            position_m: target.position,
            orientation_wxyz: target.orientation_wxyz,
            gripper,
            approach_m,
            approach_std_dev_m,
            object_mask,
            obstacle_mask: way.obstacle_mask(&inner.decision.setup),
            posture,
        };
        inner.tell(self.index, Command::Pose(command))
    }

    /// Sends the controlled joints to positions (rad or m).
    fn send_joints(&self, positions: Vec<f64>, gripper: &str, avoids: bool) -> PyResult<()> {
        let gripper = gripper_of(gripper)?.code();
        let mut inner = lock(&self.shared);
        self.check_joints(&inner.decision, &positions)?;
        let command = Command::Joints {
            positions,
            gripper,
            avoids,
        };
        inner.tell(self.index, command)
    }

    /// Opens, closes or keeps the gripper; the arm stays where it was sent.
    fn grip(&self, gripper: &str) -> PyResult<()> {
        let gripper = gripper_of(gripper)?.code();
        lock(&self.shared).tell(self.index, Command::Grip(gripper))
    }

    /// Stops the arm where it is.
    fn hold(&self) -> PyResult<()> {
        lock(&self.shared).tell(self.index, Command::Hold)
    }

    /// Lets a skill lead the arm from the next decision on; outside of decisions only.
    fn begin(&self, mut skill: Work) -> PyResult<()> {
        skill.restart();
        let mut inner = lock(&self.shared);
        // Checked now: in a decision of a cell without a policy no caller would get the
        // exception.
        skill.check_names(&inner.decision)?;
        inner.tell(self.index, Command::Skill(Box::new(skill), None))
    }

    /// How the skill of [`Arm::begin`] ended.
    #[getter]
    fn skill_status(&self) -> Option<Status> {
        lock(&self.shared).skill_status(self.index)
    }

    fn __repr__(&self) -> String {
        format!("<arm '{}'>", self.name())
    }
}
