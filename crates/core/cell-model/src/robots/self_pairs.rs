//! Parts of a robot that may touch, for robots whose files do not list them: neighbours, pairs
//! that touch almost always or in the default posture, and pairs that are never near each
//! other. They are found by random poses, as in `MoveIt`'s setup assistant.

use nalgebra::Point3;
use rmp::{CollisionSphere, Joint};

use crate::random::Random;
use crate::robots::robot::Robot;

/// Number of poses that are tried.
const POSES: usize = 10_000;
/// Share of the poses in which a pair touches that cannot keep apart.
const ALMOST_ALWAYS: f64 = 0.95;
/// A pair that was never nearer than this does not touch (m); one that was nearer and moves
/// may.
const CLOSE_M: f64 = 0.005;
/// Two parts whose distance changes by less than this count as one body (m).
const CONSTANT_M: f64 = 0.001;

/// Observations of two frames.
#[derive(Clone, Copy)]
struct Distances {
    touching: usize,
    nearest: f64,
    farthest: f64,
    touches_at_default: bool,
}

impl Distances {
    const NOTHING: Self = Self {
        touching: 0,
        nearest: f64::INFINITY,
        farthest: f64::NEG_INFINITY,
        touches_at_default: false,
    };

    fn take(&mut self, apart: f64, is_default: bool) {
        self.nearest = self.nearest.min(apart);
        self.farthest = self.farthest.max(apart);
        if is_default {
            self.touches_at_default = apart < 0.0;
        } else {
            self.touching += usize::from(apart < 0.0);
        }
    }

    fn may_touch(&self) -> bool {
        self.touches_at_default
            || self.touching as f64 >= ALMOST_ALWAYS * POSES as f64
            || (self.touching == 0 && self.nearest > CLOSE_M)
            || self.farthest - self.nearest < CONSTANT_M
    }
}

impl Robot {
    /// Pairs of frames with `spheres` that may touch.
    pub fn pairs_that_may_touch(&self, spheres: &[CollisionSphere]) -> Vec<(String, String)> {
        let parts = self.parts(spheres);
        let count = parts.len();
        let mut distances = vec![Distances::NOTHING; count * count];
        // A fixed seed: every process of a run, and every run, finds the same pairs.
        let mut random = Random::new(3);
        for pose in 0..=POSES {
            // The default posture is the last pose: a pair that touches there would push the
            // arm at rest.
            let is_default = pose == POSES;
            let arm = if is_default {
                self.default_joint_positions.clone()
            } else {
                self.anywhere(&mut random)
            };
            let centers = self.centers(&parts, &arm);
            for a in 0..count {
                for b in a + 1..count {
                    let apart = distance(&centers[a], &centers[b]);
                    distances[a * count + b].take(apart, is_default);
                }
            }
        }
        let mut pairs = Vec::new();
        for a in 0..count {
            for b in a + 1..count {
                let are_neighbours = self.are_neighbours(parts[a].carrier, parts[b].carrier);
                if are_neighbours || distances[a * count + b].may_touch() {
                    pairs.push((parts[a].frame.to_owned(), parts[b].frame.to_owned()));
                }
            }
        }
        pairs
    }

    /// Whether a controlled joint moves `frame`; `false` if there is no such frame.
    pub fn is_moved(&self, frame: &str) -> bool {
        let index = self.chain.frame_index(frame);
        index.is_some_and(|index| self.carrier(self.chain.frames()[index].joint).is_some())
    }

    fn parts<'a>(&self, spheres: &'a [CollisionSphere]) -> Vec<Part<'a>> {
        let mut parts: Vec<Part<'a>> = Vec::new();
        for sphere in spheres {
            let known = parts.iter_mut().find(|part| part.frame == sphere.frame);
            if let Some(part) = known {
                part.spheres.push(sphere);
            } else if let Some(frame) = self.chain.frame_index(&sphere.frame) {
                parts.push(Part {
                    frame: &sphere.frame,
                    index: frame,
                    carrier: self.carrier(self.chain.frames()[frame].joint),
                    spheres: vec![sphere],
                });
            }
        }
        parts
    }

    /// The joint of the arm, or its follower, that moves everything fixed to `joint`.
    fn carrier(&self, mut joint: Option<usize>) -> Option<usize> {
        while let Some(index) = joint {
            let Joint { parent, mimic, .. } = self.chain.joints()[index];
            let driven_by = mimic.map_or(index, |mimic| mimic.joint);
            let moves = |joint: &usize| self.arm_joints.contains(joint);
            if moves(&index) || moves(&driven_by) {
                return Some(index);
            }
            joint = parent;
        }
        None
    }

    /// Whether one carries the other by a single joint of the arm, or both are one body.
    fn are_neighbours(&self, a: Option<usize>, b: Option<usize>) -> bool {
        let before = |joint: Option<usize>| {
            joint.map(|joint| self.carrier(self.chain.joints()[joint].parent))
        };
        a == b || before(a) == Some(b) || before(b) == Some(a)
    }

    /// A random configuration of the controlled joints within their limits.
    pub(super) fn anywhere(&self, random: &mut Random) -> Vec<f64> {
        let position = |spec: &crate::JointSpec| {
            let (low, high) = (spec.lower, spec.upper);
            0.5 * (low + high) + random.around_zero(0.5 * (high - low))
        };
        self.arm_specs().map(position).collect()
    }

    /// Centres (m) and radii of the spheres of each part, the joints of the arm at `arm`.
    fn centers(&self, parts: &[Part<'_>], arm: &[f64]) -> Vec<Vec<(Point3<f64>, f64)>> {
        let mut all = self.fixed_joint_positions.clone();
        self.place_arm(arm, &mut all);
        let links = self.link_poses(&all);
        let of = |part: &Part<'_>| {
            let frame = &self.chain.frames()[part.index];
            let pose = links[frame.joint.map_or(0, |joint| joint + 1)] * frame.pose;
            let spheres = part.spheres.iter();
            spheres
                .map(|sphere| (pose * Point3::from(sphere.center), sphere.radius))
                .collect()
        };
        parts.iter().map(of).collect()
    }
}

/// The spheres of one frame.
struct Part<'a> {
    frame: &'a str,
    index: usize,
    carrier: Option<usize>,
    spheres: Vec<&'a CollisionSphere>,
}

/// Smallest distance of two surfaces (m).
fn distance(one: &[(Point3<f64>, f64)], other: &[(Point3<f64>, f64)]) -> f64 {
    let pairs = one.iter().flat_map(|a| other.iter().map(move |b| (a, b)));
    pairs
        .map(|((a, r), (b, s))| (a - b).norm() - r - s)
        .fold(f64::INFINITY, f64::min)
}
