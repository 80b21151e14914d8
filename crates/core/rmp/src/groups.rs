//! The spheres of a robot in groups of four, so that one vector instruction serves
//! four spheres of one link against one obstacle.

use nalgebra::Vector3;

use crate::ball::Ball;
use crate::lanes::LANES;

/// Radius of an unused lane (m): so small that its weight is exactly zero.
// A lane that is switched off costs a mask in each operation; a parked one costs nothing.
const PARKED: f64 = -1e7;

/// Up to four spheres that one joint carries, as a structure of arrays.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct Group {
    /// Centres in the frame of the joint (m), by axis.
    pub(crate) offset: [[f64; LANES]; 3],
    /// m.
    pub(crate) radius: [f64; LANES],
    /// Index of each sphere among those the groups were made of.
    pub(crate) sphere: [usize; LANES],
    /// Joint of the tree; `None` is fixed in the base.
    pub(crate) joint: Option<usize>,
    /// A sphere around all of them, in the frame of the joint (m).
    pub(crate) center: Vector3<f64>,
    pub(crate) bound: f64,
}

impl Group {
    fn new(sphere: usize, ball: &Ball) -> Self {
        let offset = ball.attachment.offset;
        let mut group = Self {
            offset: [[offset.x; LANES], [offset.y; LANES], [offset.z; LANES]],
            radius: [PARKED; LANES],
            sphere: [sphere; LANES],
            joint: ball.attachment.joint,
            center: offset,
            bound: ball.radius,
        };
        group.radius[0] = ball.radius;
        group
    }

    fn set(&mut self, lane: usize, sphere: usize, ball: &Ball) {
        for (row, value) in self.offset.iter_mut().zip(ball.attachment.offset.iter()) {
            row[lane] = *value;
        }
        self.radius[lane] = ball.radius;
        self.sphere[lane] = sphere;
    }

    /// Fits the sphere around the first `used` lanes.
    fn fit(&mut self, used: usize) {
        let at = |lane: usize| Vector3::from_fn(|axis, _| self.offset[axis][lane]);
        let far = Vector3::repeat(f64::INFINITY);
        let (low, high) = (0..used).fold((far, -far), |(low, high), lane| {
            let r = Vector3::repeat(self.radius[lane]);
            (low.inf(&(at(lane) - r)), high.sup(&(at(lane) + r)))
        });
        let center = 0.5 * (low + high);
        let beyond = |lane: usize| (at(lane) - center).norm() + self.radius[lane];
        self.bound = (0..used).map(beyond).fold(0.0, f64::max);
        self.center = center;
    }
}

/// Writes the groups of `balls` to `groups`, sorted by joint, with neighbours in one group.
/// Allocates only if `groups` has no capacity for one group per ball.
pub(crate) fn group(balls: &[Ball], groups: &mut Vec<Group>) {
    groups.clear();
    let joints = balls.iter().map(|ball| ball.attachment.joint);
    let (Some(first), Some(last)) = (joints.clone().min(), joints.max()) else {
        return;
    };
    let first = first.map_or(0, |joint| joint + 1);
    let last = last.map_or(0, |joint| joint + 1);
    // By joint, so that the sums of one link are lifted and added over lanes once (ADR 0020).
    for joint in (first..=last).map(|place| place.checked_sub(1)) {
        let mut lane = LANES;
        let carried = balls.iter().enumerate();
        for (sphere, ball) in carried.filter(|(_, ball)| ball.attachment.joint == joint) {
            match groups.last_mut() {
                Some(group) if lane < LANES => {
                    group.set(lane, sphere, ball);
                    lane += 1;
                    group.fit(lane);
                }
                _ => {
                    groups.push(Group::new(sphere, ball));
                    lane = 1;
                }
            }
        }
    }
}
