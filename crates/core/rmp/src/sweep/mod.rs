//! All spheres against all obstacles: finds the pairs within reach, computes their leaves, and
//! lifts the sums to the links (ADR 0020).
#![allow(
    clippy::inline_always,
    reason = "lanes are compiled for the instruction set of the function they are inlined into"
)]

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use crate::groups::Group;
use crate::kinematics::{Kinematics, Link};
use crate::lanes::wide3::{self, Wide3, cross, dot};
use crate::lanes::{LANES, Lanes};
use crate::leaves::collision::{Constants, Spheres, Sum, within};
use crate::leaves::surface::surface;
use crate::obstacles::packed::Packed;
use crate::pullback::{Pullback, Spatial};

/// The nearest approach of a sphere to an obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    /// Signed distance of the surfaces (m).
    pub(crate) distance: f64,
    pub(crate) sphere: usize,
}

impl Nearest {
    const NONE: Self = Self {
        distance: f64::INFINITY,
        sphere: 0,
    };

    #[inline(always)]
    fn take<L: Lanes>(&mut self, distances: L, group: &Group) {
        for (distance, sphere) in distances.to_array().into_iter().zip(group.sphere) {
            if distance < self.distance {
                *self = Self { distance, sphere };
            }
        }
    }
}

/// Inputs and outputs of a sweep.
pub(crate) struct Sweep<'a> {
    pub(crate) constants: &'a Constants,
    pub(crate) kinematics: &'a Kinematics,
    pub(crate) groups: &'a [Group],
    pub(crate) obstacles: &'a Packed,
    /// Scratch: places of the obstacles near one group; capacity for all.
    pub(crate) near: &'a mut Vec<usize>,
    pub(crate) pullback: &'a mut Pullback,
}

impl Sweep<'_> {
    /// Adds the leaves of all pairs; returns the nearest approach. Inlined into each
    /// caller, so that it is compiled for the instruction set of that caller.
    #[inline(always)]
    pub(crate) fn run<L: Lanes>(&mut self) -> Nearest {
        let mut nearest = Nearest::NONE;
        // All groups of one link are summed lane by lane and added over lanes once.
        for groups in self.groups.chunk_by(|a, b| a.joint == b.joint) {
            let joint = groups.first().and_then(|group| group.joint);
            let link = self.kinematics.link_of(joint);
            let mut lifted = Lifted::new();
            for group in groups {
                self.find_near::<L>(link, group);
                // Nothing within reach: all weights are exactly zero, so leaving the group out
                // changes no bit.
                if self.near.is_empty() {
                    continue;
                }
                let spheres = motion(link, group);
                let mut sum = Sum::<L>::new();
                let mut next = 0;
                // In the order of the obstacles, in every implementation: sums keep their
                // bits.
                while next < self.near.len() {
                    let first = next;
                    next = self.end_of_obstacle(first);
                    let (distance, normal) = self.nearest_part(first..next, &spheres.position);
                    sum.add(self.constants, &spheres, distance, &normal);
                }
                nearest.take(sum.nearest, group);
                lifted.add(&spheres.position, &sum);
            }
            if let Some(joint) = joint {
                self.pullback.add(joint, &lifted.total());
            }
        }
        // The nearest of the pairs in reach is the nearest of all, if there is one in reach.
        if nearest.distance > self.constants.reach() {
            nearest = self.nearest_of_all::<L>();
        }
        nearest
    }

    /// Finds the obstacles that a sphere of `group` may be within reach of.
    #[inline(always)]
    fn find_near<L: Lanes>(&mut self, link: &Link, group: &Group) {
        let center = link.origin + link.rotation * group.center;
        let reach = group.bound + self.constants.reach();
        self.near.clear();
        for (index, block) in self.obstacles.blocks().iter().enumerate() {
            let mut bits = within::<L>(block, &center, reach);
            while bits != 0 {
                self.near
                    .push(LANES * index + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
    }

    /// End of the near parts of the obstacle whose first one is at `first`.
    #[inline(always)]
    fn end_of_obstacle(&self, first: usize) -> usize {
        let owner = self.obstacles.owner(self.near[first]);
        let mut end = first + 1;
        while end < self.near.len() && self.obstacles.owner(self.near[end]) == owner {
            end += 1;
        }
        end
    }

    /// The nearest of some near parts in each lane: its distance (m) and normal.
    #[inline(always)]
    fn nearest_part<L: Lanes>(&self, near: Range<usize>, position: &Wide3<L>) -> (L, Wide3<L>) {
        let (mut distance, mut normal) = self.surface(self.near[near.start], position);
        for index in near.start + 1..near.end {
            let (other, turned) = self.surface(self.near[index], position);
            let is_nearer = distance.gt(other);
            distance = is_nearer.select(other, distance);
            normal = [
                is_nearer.select(turned[0], normal[0]),
                is_nearer.select(turned[1], normal[1]),
                is_nearer.select(turned[2], normal[2]),
            ];
        }
        (distance, normal)
    }

    #[inline(always)]
    fn surface<L: Lanes>(&self, place: usize, position: &Wide3<L>) -> (L, Wide3<L>) {
        let block = &self.obstacles.blocks()[place / LANES];
        surface(self.obstacles.core(place), block, place % LANES, position)
    }

    /// The nearest approach without leaves, if no obstacle is within reach.
    #[inline(always)]
    fn nearest_of_all<L: Lanes>(&self) -> Nearest {
        let mut nearest = Nearest::NONE;
        for group in self.groups {
            let link = self.kinematics.link_of(group.joint);
            let spheres = motion::<L>(link, group);
            for place in 0..self.obstacles.len() {
                let (distance, _) = self.surface(place, &spheres.position);
                nearest.take(distance - spheres.radius, group);
            }
        }
        nearest
    }
}

/// See [`Kinematics::point`].
#[inline(always)]
fn motion<L: Lanes>(link: &Link, group: &Group) -> Spheres<L> {
    let offset = [
        L::load(&group.offset[0]),
        L::load(&group.offset[1]),
        L::load(&group.offset[2]),
    ];
    let r = &link.rotation;
    let arm = [
        dot(&wide3::splat(&Vector3::new(r.m11, r.m12, r.m13)), &offset),
        dot(&wide3::splat(&Vector3::new(r.m21, r.m22, r.m23)), &offset),
        dot(&wide3::splat(&Vector3::new(r.m31, r.m32, r.m33)), &offset),
    ];
    let angular = wide3::splat(&link.angular);
    let turning = cross(&angular, &arm);
    let swing = cross(&wide3::splat(&link.angular_bias), &arm);
    let inward = cross(&angular, &turning);
    let bias = wide3::add(&wide3::splat(&link.linear_bias), &swing);
    Spheres {
        position: wide3::add(&wide3::splat(&link.origin), &arm),
        velocity: wide3::add(&wide3::splat(&link.linear), &turning),
        bias: wide3::add(&bias, &inward),
        radius: L::load(&group.radius),
    }
}

/// The spatial forms of one link, one lane per sphere: see [`Spatial`].
struct Lifted<L> {
    angular: [L; 6],
    /// By column.
    cross: [Wide3<L>; 3],
    linear: [L; 6],
    torque: Wide3<L>,
    force: Wide3<L>,
}

impl<L: Lanes> Lifted<L> {
    #[inline(always)]
    fn new() -> Self {
        let zero = L::splat(0.0);
        Self {
            angular: [zero; 6],
            cross: [[zero; 3]; 3],
            linear: [zero; 6],
            torque: [zero; 3],
            force: [zero; 3],
        }
    }

    /// With `P` the cross matrix of the position: `-P M P`, `P M`, `M`, `p x f`, `f`.
    #[inline(always)]
    fn add(&mut self, p: &Wide3<L>, sum: &Sum<L>) {
        let [xx, xy, xz, yy, yz, zz] = sum.metric;
        // Columns of P M; the weight is symmetric, so its rows are its columns.
        let x = cross(p, &[xx, xy, xz]);
        let y = cross(p, &[xy, yy, yz]);
        let z = cross(p, &[xz, yz, zz]);
        let first = cross(p, &[x[0], y[0], z[0]]);
        let second = cross(p, &[x[1], y[1], z[1]]);
        let third = cross(p, &[x[2], y[2], z[2]]);
        let upper = [first[0], first[1], first[2], second[1], second[2], third[2]];
        add_to(&mut self.angular, &upper);
        add_to(&mut self.linear, &sum.metric);
        add_to(&mut self.cross[0], &x);
        add_to(&mut self.cross[1], &y);
        add_to(&mut self.cross[2], &z);
        add_to(&mut self.torque, &cross(p, &sum.force));
        add_to(&mut self.force, &sum.force);
    }

    #[inline(always)]
    fn total(&self) -> Spatial {
        Spatial {
            angular: symmetric(&self.angular),
            cross: Matrix3::from_columns(&[
                vector(&self.cross[0]),
                vector(&self.cross[1]),
                vector(&self.cross[2]),
            ]),
            linear: symmetric(&self.linear),
            torque: vector(&self.torque),
            force: vector(&self.force),
        }
    }
}

#[inline(always)]
fn add_to<L: Lanes, const N: usize>(sums: &mut [L; N], terms: &[L; N]) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum = *sum + *term;
    }
}

#[inline(always)]
fn symmetric<L: Lanes>(m: &[L; 6]) -> Matrix3<f64> {
    let [xx, xy, xz] = [m[0].total(), m[1].total(), m[2].total()];
    let [yy, yz, zz] = [m[3].total(), m[4].total(), m[5].total()];
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

#[inline(always)]
fn vector<L: Lanes>(v: &Wide3<L>) -> Vector3<f64> {
    Vector3::new(v[0].total(), v[1].total(), v[2].total())
}

#[cfg(test)]
mod tests;
