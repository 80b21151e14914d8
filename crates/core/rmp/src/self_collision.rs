//! Parts of a robot that keep away from each other.

use nalgebra::Vector3;

use crate::ball::{Ball, MAX_CARRIED};
use crate::kinematics::Kinematics;
use crate::leaves::self_collision::{Leaf, REACH_M, leaf};
use crate::{JointKind, PointMotion, Root};

/// The spheres of one frame.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    /// Joint of the tree that carries it; `None` is fixed in the base.
    pub(crate) joint: Option<usize>,
    pub(crate) balls: Vec<Ball>,
    /// A sphere around all of them, in the frame of the joint.
    pub(crate) center: Vector3<f64>,
    pub(crate) radius: f64,
    /// Centres of the spheres at the last evaluation, base frame (m).
    places: Vec<Vector3<f64>>,
}

impl Part {
    /// A part of spheres that one joint carries; at least one.
    pub(crate) fn new(balls: Vec<Ball>) -> Self {
        let mut part = Self {
            joint: balls.first().and_then(|ball| ball.attachment.joint),
            places: Vec::with_capacity(balls.len()),
            balls,
            center: Vector3::zeros(),
            radius: 0.0,
        };
        part.bound();
        part
    }

    /// Buffer for the spheres on the tool.
    fn carried() -> Self {
        Self {
            joint: None,
            balls: Vec::with_capacity(MAX_CARRIED),
            places: Vec::with_capacity(MAX_CARRIED),
            center: Vector3::zeros(),
            radius: 0.0,
        }
    }

    fn bound(&mut self) {
        let low = Vector3::repeat(f64::INFINITY);
        let corners = self.balls.iter().fold((low, -low), |(low, high), ball| {
            let (center, r) = (ball.attachment.offset, Vector3::repeat(ball.radius));
            (low.inf(&(center - r)), high.sup(&(center + r)))
        });
        self.center = 0.5 * (corners.0 + corners.1);
        let beyond = |ball: &Ball| (ball.attachment.offset - self.center).norm() + ball.radius;
        self.radius = self.balls.iter().map(beyond).fold(0.0, f64::max);
    }

    fn place(&mut self, kinematics: &Kinematics) {
        self.places.clear();
        let balls = self.balls.iter();
        self.places
            .extend(balls.map(|ball| kinematics.place(self.joint, &ball.attachment.offset)));
    }
}

/// The parts of a robot and the pairs of them that must not meet.
#[derive(Debug, Clone)]
pub(crate) struct SelfCollision {
    /// The last one has the spheres on the tool.
    parts: Vec<Part>,
    /// Pairs of the robot, then pairs with the tool's spheres.
    pairs: Vec<(usize, usize)>,
    /// Number of the pairs of the robot alone.
    own_pairs: usize,
    /// Centres of the bounds at the last evaluation, base frame (m).
    centers: Vec<Vector3<f64>>,
    /// Row of a Jacobian, by slot of a controlled joint.
    row: Vec<f64>,
    /// Slots of the row that are not zero.
    slots: Vec<usize>,
}

impl SelfCollision {
    pub(crate) fn new(mut parts: Vec<Part>, mut pairs: Vec<(usize, usize)>, joints: usize) -> Self {
        pairs.reserve(parts.len());
        parts.push(Part::carried());
        Self {
            centers: vec![Vector3::zeros(); parts.len()],
            row: vec![0.0; joints],
            slots: Vec::with_capacity(joints),
            own_pairs: pairs.len(),
            parts,
            pairs,
        }
    }

    /// Whether any parts of the robot keep away from each other.
    pub(crate) fn is_on(&self) -> bool {
        self.own_pairs > 0
    }

    /// Replaces the spheres on the tool by `balls`, at most [`MAX_CARRIED`]. They keep away
    /// from the parts from which a part on the joint of the tool keeps away.
    pub(crate) fn carry(&mut self, balls: &[Ball]) {
        self.pairs.truncate(self.own_pairs);
        let Some((carried, own)) = self.parts.split_last_mut() else {
            return;
        };
        carried.balls.clear();
        let Some(ball) = balls.first() else {
            return;
        };
        carried.balls.extend_from_slice(balls);
        carried.joint = ball.attachment.joint;
        carried.bound();
        let holds = |part: usize| own[part].joint == carried.joint;
        for part in 0..own.len() {
            let keeps_away =
                |&(a, b): &(usize, usize)| a == part && holds(b) || b == part && holds(a);
            if self.pairs[..self.own_pairs].iter().any(keeps_away) {
                self.pairs.push((part, own.len()));
            }
        }
    }

    /// Adds the leaves of all pairs of spheres within reach to `root`. Returns the least
    /// distance of two surfaces (m), infinite where none are within reach.
    pub(crate) fn add(&mut self, kinematics: &Kinematics, root: &mut Root) -> f64 {
        // All centres once per cycle: each part is in several pairs.
        for (center, part) in self.centers.iter_mut().zip(&mut self.parts) {
            *center = kinematics.place(part.joint, &part.center);
            part.place(kinematics);
        }
        let mut nearest = f64::INFINITY;
        // Bounds before spheres: most pairs of parts are beyond the reach.
        for index in 0..self.pairs.len() {
            let (a, b) = self.pairs[index];
            let reach = self.parts[a].radius + self.parts[b].radius + REACH_M;
            if (self.centers[a] - self.centers[b]).norm_squared() < reach * reach {
                nearest = nearest.min(self.add_pair(a, b, kinematics, root));
            }
        }
        nearest
    }

    fn add_pair(&mut self, a: usize, b: usize, kinematics: &Kinematics, root: &mut Root) -> f64 {
        let mut nearest = f64::INFINITY;
        let (one, other) = (&self.parts[a], &self.parts[b]);
        let mut row = Row {
            kinematics,
            values: &mut self.row,
            slots: &mut self.slots,
        };
        for (ball, center) in one.balls.iter().zip(&one.places) {
            // Most spheres of a part are far from the other part.
            let reach = ball.radius + other.radius + REACH_M;
            if (center - self.centers[b]).norm_squared() >= reach * reach {
                continue;
            }
            for (against, from) in other.balls.iter().zip(&other.places) {
                let (radii, apart) = (ball.radius + against.radius, (center - from).norm_squared());
                if apart >= (radii + REACH_M) * (radii + REACH_M) {
                    continue;
                }
                let distance = apart.sqrt();
                nearest = nearest.min(distance - radii);
                // The motion of a point is computed only for pairs in reach: most pairs are
                // not.
                let points = (
                    kinematics.point(&ball.attachment),
                    kinematics.point(&against.attachment),
                );
                if let Some(leaf) = leaf(&points.0, &points.1, distance, distance - radii) {
                    row.fill((one.joint, &points.0), (other.joint, &points.1), &leaf);
                    row.add(&leaf, root);
                }
            }
        }
        nearest
    }
}

/// The Jacobian of one distance: the effect of the joints between two parts on it.
struct Row<'a> {
    kinematics: &'a Kinematics,
    values: &'a mut [f64],
    slots: &'a mut Vec<usize>,
}

impl Row<'_> {
    /// Walks from both joints to their common one: beyond it the robot moves both points as
    /// one body, and their distance is constant.
    fn fill(
        &mut self,
        (mut a, at): (Option<usize>, &PointMotion),
        (mut b, from): (Option<usize>, &PointMotion),
        leaf: &Leaf,
    ) {
        self.slots.clear();
        while a != b {
            // Parents have smaller indices; the base is smaller than all.
            if a > b {
                a = self.step(a, &at.position, &leaf.normal);
            } else {
                b = self.step(b, &from.position, &-leaf.normal);
            }
        }
    }

    fn step(
        &mut self,
        joint: Option<usize>,
        point: &Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> Option<usize> {
        let index = joint?;
        let (joint, link) = (
            &self.kinematics.tree.joints[index],
            &self.kinematics.links[index],
        );
        let moves = match joint.kind {
            JointKind::Revolute => link.axis.cross(&(point - link.origin)),
            JointKind::Prismatic => link.axis,
        };
        let value = joint.ratio * normal.dot(&moves);
        // Joints that follow another one share its slot.
        if self.slots.contains(&joint.slot) {
            self.values[joint.slot] += value;
        } else {
            self.values[joint.slot] = value;
            self.slots.push(joint.slot);
        }
        joint.parent
    }

    fn add(&self, leaf: &Leaf, root: &mut Root) {
        for &i in self.slots.iter() {
            root.force[i] += self.values[i] * leaf.force;
            let weighted = leaf.weight * self.values[i];
            for &j in self.slots.iter() {
                root.metric[(i, j)] += weighted * self.values[j];
            }
        }
    }
}
