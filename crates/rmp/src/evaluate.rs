//! The sum of all leaves at one state.

use crate::RmpFlow;
use crate::RmpFlowParameters;
use crate::ball::Ball;
use crate::flow::{Clearance, TargetFrame};
use crate::kinematics::Kinematics;
use crate::leaves::collision::{Constants, Query};
use crate::leaves::{
    Floor, axis_target, cspace_target, damping, joint_limit, joint_velocity_cap, target,
};
use crate::obstacles::Block;
use crate::pullback::Pullback;
use crate::simd::Path;

impl RmpFlow {
    /// Fills `root` and `clearance` for positions and velocities of checked length.
    pub(crate) fn sum_leaves(&mut self, q: &[f64], qd: &[f64], floor: Floor) {
        self.constants.set_floor(floor);
        let p = &self.parameters;
        self.kinematics.update(q, qd);
        self.root.clear();
        self.pullback.clear();
        cspace_target::add(&mut self.root, &p.cspace_target, &self.posture, q, qd);
        joint_limit::add(&mut self.root, &p.joint_limit, &self.ranges, q, qd, floor);
        joint_velocity_cap::add(&mut self.root, &p.joint_velocity_cap, qd);
        for frame in &self.targets {
            add_target(p, &self.kinematics, &mut self.pullback, frame);
        }
        let mut push = Push {
            path: self.path,
            constants: &self.constants,
            kinematics: &self.kinematics,
            pullback: &mut self.pullback,
        };
        push.away(&self.body_balls, &self.body_blocks);
        let own = push.away(&self.balls, self.obstacles.blocks());
        let carried = push.away(&self.carried, self.obstacles.blocks());
        self.clearance = nearer(own, carried, self.balls.len());
        self.pullback.collect(&self.kinematics, &mut self.root);
    }
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
        let (pull, towards) = target::leaf(&p.target, position, &point);
        metric += pull;
        force += towards;
        squared = Some((position - point.position).norm_squared());
    }
    pullback.add_point(&frame.attachment, &point.position, &metric, &force);
    if let Some(wanted) = &frame.orientation {
        let weight = axis_target::weight(&p.axis_target, squared);
        let rotation = kinematics.rotation(&frame.attachment);
        let link = kinematics.link(&frame.attachment);
        for (axis, target) in rotation.column_iter().zip(wanted.column_iter()) {
            let (n, n0) = (axis.into_owned(), target.into_owned());
            let force = axis_target::force(&p.axis_target, weight, &n, &n0, link);
            pullback.add_direction(&frame.attachment, &n, weight, &force);
        }
    }
}

/// Collision leaves of spheres against blocks of obstacles.
struct Push<'a> {
    path: Path,
    constants: &'a Constants,
    kinematics: &'a Kinematics,
    pullback: &'a mut Pullback,
}

impl Push<'_> {
    /// Adds all pairs; returns the nearest approach.
    fn away(&mut self, balls: &[Ball], blocks: &[Block]) -> Option<Clearance> {
        if blocks.is_empty() {
            return None;
        }
        let mut nearest: Option<Clearance> = None;
        for (sphere, ball) in balls.iter().enumerate() {
            let query = Query {
                point: self.kinematics.point(&ball.attachment),
                radius: ball.radius,
            };
            let sum = self.path.run(self.constants, &query, blocks);
            self.pullback.add_point(
                &ball.attachment,
                &query.point.position,
                &sum.metric,
                &sum.force,
            );
            if nearest.is_none_or(|n| sum.clearance < n.distance) {
                nearest = Some(Clearance {
                    distance: sum.clearance,
                    sphere,
                });
            }
        }
        nearest
    }
}
