//! The sum of all leaves at one state.

use crate::RmpFlow;
use crate::RmpFlowParameters;
use crate::flow::Clearance;
use crate::kinematics::Kinematics;
use crate::leaves::{
    Floor, axis_target, cspace_target, damping, joint_limit, joint_velocity_cap, target,
};
use crate::pullback::Pullback;
use crate::sweep::{Nearest, Sweep};
use crate::targets::TargetFrame;

impl RmpFlow {
    /// Fills `root` and `clearance` for positions and velocities of checked length.
    pub(crate) fn sum_leaves(&mut self, q: &[f64], qd: &[f64], floor: Floor) {
        self.constants.set_floor(floor);
        let p = &self.parameters;
        // Kinematics first: each leaf reads the links at this state.
        self.kinematics.update(q, qd);
        self.root.clear();
        self.pullback.clear();
        // Leaves on joints go to the root at once; leaves on points are gathered by link and
        // carried to the joints in one pass at the end.
        cspace_target::add(&mut self.root, &p.cspace_target, &self.posture, q, qd);
        joint_limit::add(&mut self.root, &p.joint_limit, &self.ranges, q, qd, floor);
        joint_velocity_cap::add(&mut self.root, &p.joint_velocity_cap, qd);
        for frame in self.targets.iter().flatten() {
            add_target(p, &self.kinematics, &mut self.pullback, frame);
        }
        // A tuning keeps a few frames away from capsules around the base, which are wider than
        // the robot. The robot's own spheres against each other replace them without that
        // margin.
        if floor == Floor::None || !self.self_collision.is_on() {
            self.push_away(Of::Body);
        }
        // Obstacles last: they are most of the cost, and write to the same sums as the
        // targets.
        let own = self.push_away(Of::Robot);
        let carried = self.push_away(Of::Tool);
        self.clearance = nearer(own, carried, self.balls.len());
        self.pullback.collect(&self.kinematics, &mut self.root);
    }

    /// Adds the collision leaves of some spheres; returns their nearest approach.
    fn push_away(&mut self, of: Of) -> Option<Clearance> {
        let (groups, obstacles) = match of {
            Of::Body => (&self.body_groups, &self.body),
            Of::Robot => (&self.groups, &self.obstacles),
            Of::Tool => (&self.carried_groups, &self.obstacles),
        };
        let obstacles = obstacles.packed();
        // No sweep without spheres or obstacles: the nearest approach would be infinite.
        if groups.is_empty() || obstacles.is_empty() {
            return None;
        }
        let mut sweep = Sweep {
            constants: &self.constants,
            kinematics: &self.kinematics,
            groups,
            obstacles,
            near: &mut self.near,
            pullback: &mut self.pullback,
        };
        let Nearest { distance, sphere } = self.path.run(&mut sweep);
        Some(Clearance { distance, sphere })
    }
}

/// Spheres that keep away from obstacles.
#[derive(Clone, Copy)]
enum Of {
    /// Frames that the tuning names, from the body of the robot.
    Body,
    /// The spheres of the robot, from obstacles.
    Robot,
    /// The spheres on the tool, from obstacles.
    Tool,
}

/// The nearer of two approaches; spheres of the second count from `first` on.
fn nearer(a: Option<Clearance>, b: Option<Clearance>, first: usize) -> Option<Clearance> {
    let b = b.map(|near| Clearance {
        sphere: first + near.sphere,
        ..near
    });
    match (a, b) {
        (Some(a), Some(b)) if b.distance < a.distance => Some(b),
        (a, b) => a.or(b),
    }
}

/// The leaves of one target frame.
fn add_target(
    p: &RmpFlowParameters,
    kinematics: &Kinematics,
    pullback: &mut Pullback,
    frame: &TargetFrame,
) {
    let point = kinematics.point(&frame.attachment);
    let (weight, mut force) = damping::leaf(&p.damping, &point);
    let mut metric = nalgebra::Matrix3::identity() * weight;
    let mut squared = None;
    if let Some(position) = &frame.position {
        let (pull, towards) = target::leaf(&frame.target, position, &point);
        metric += pull;
        force += towards;
        // The squared distance also scales the weight of the orientation, below.
        squared = Some((position - point.position).norm_squared());
    }
    pullback.add_point(&frame.attachment, &point.position, &metric, &force);
    if let Some(wanted) = &frame.orientation {
        let weight = axis_target::weight(&frame.axis_target, squared);
        let rotation = kinematics.rotation(&frame.attachment);
        let link = kinematics.link(&frame.attachment);
        for (axis, target) in rotation.column_iter().zip(wanted.column_iter()) {
            let (n, n0) = (axis.into_owned(), target.into_owned());
            let force = axis_target::force(&frame.axis_target, weight, &n, &n0, link);
            pullback.add_direction(&frame.attachment, &n, weight, &force);
        }
    }
}
