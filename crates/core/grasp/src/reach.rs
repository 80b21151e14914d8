//! Whether an arm brings its tool to a pose.

use cell_model::ArmSpec;
use nalgebra::Isometry3;
use plan::{Found, Tool};
use rmp::{JointLimits, RmpFlow, TargetId};

/// A motion ends within this of its target (m, rad).
const NEAR: (f64, f64) = (0.004, 0.05);

/// The inverse kinematics of an arm of a cell.
pub struct Reach {
    flow: RmpFlow,
    frame: TargetId,
    limits: JointLimits,
    base: Isometry3<f64>,
    /// Starts of a search: the cell's pose of the arm, and the robot's own.
    starts: [Vec<f64>; 2],
}

impl Reach {
    /// Of an arm; `None` for one whose files its controller refuses.
    pub fn of(arm: &ArmSpec) -> Option<Self> {
        let robot = &arm.robot;
        let mut flow = robot.motion_policies(0).ok()?;
        Some(Self {
            frame: flow.add_target_frame(robot.tcp_frame_name()).ok()?,
            flow,
            limits: robot.limits(),
            base: arm.base,
            starts: [arm.home.clone(), robot.default_joint_positions.clone()],
        })
    }

    /// Whether joint positions within the limits bring the TCP to `tcp` (world frame). Obstacles
    /// are not considered. A refusal takes up to 60 ms.
    pub fn reaches(&mut self, tcp: &Isometry3<f64>) -> bool {
        let goal = self.base.inverse() * tcp;
        let starts = self.starts.each_ref().map(Vec::as_slice);
        let found = Tool::new(&mut self.flow, self.frame, &self.limits).search(&starts, &goal);
        found.is_some_and(|found| is_near(&found))
    }

    /// The joint positions (rad or m) nearest to `joint_positions` that bring the TCP to `tcp`
    /// (world frame); `None` where it cannot be reached.
    pub fn joints(&mut self, joint_positions: &[f64], tcp: &Isometry3<f64>) -> Option<Vec<f64>> {
        let goal = self.base.inverse() * tcp;
        let starts = [joint_positions, &self.starts[0], &self.starts[1]];
        let mut tool = Tool::new(&mut self.flow, self.frame, &self.limits);
        // From where the arm is first: the nearest of several postures.
        let found = tool.solve(joint_positions, &goal).filter(is_near);
        let found = found.or_else(|| tool.search(&starts, &goal).filter(is_near));
        found.map(|found| found.positions)
    }

    /// As [`Reach::reaches`], searched only from these joint positions and those of the start: a
    /// refusal takes a few milliseconds, and may be wrong.
    pub fn reaches_from(&mut self, joint_positions: &[f64], tcp: &Isometry3<f64>) -> bool {
        let goal = self.base.inverse() * tcp;
        let mut tool = Tool::new(&mut self.flow, self.frame, &self.limits);
        let starts = [joint_positions, &self.starts[0], &self.starts[1]];
        starts.iter().enumerate().any(|(index, start)| {
            // The arm is often where it began: the same start gives the same result.
            let is_new = !starts.iter().take(index).any(|before| before == start);
            is_new
                && tool
                    .solve(start, &goal)
                    .is_some_and(|found| is_near(&found))
        })
    }
}

fn is_near(found: &Found) -> bool {
    found.off_m < NEAR.0 && found.off_rad < NEAR.1
}
