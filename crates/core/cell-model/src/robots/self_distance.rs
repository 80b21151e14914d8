//! Distances between the parts of a robot that may not touch.

use nalgebra::{Isometry3, Point3};

use crate::robots::robot::Robot;

/// The self-collision spheres of a robot, by frame.
#[derive(Clone, Debug)]
pub struct SelfDistance {
    parts: Vec<Part>,
    /// Pairs that may not touch.
    pairs: Vec<(usize, usize)>,
    /// Memory for the poses of the links and the centres of the spheres.
    links: Vec<Isometry3<f64>>,
    centers: Vec<Vec<Point3<f64>>>,
}

#[derive(Clone, Debug)]
struct Part {
    /// Index among the robot's links.
    link: usize,
    /// Centre in the link's frame and radius (m).
    spheres: Vec<(Point3<f64>, f64)>,
    /// A sphere around all of them.
    around: (Point3<f64>, f64),
}

impl SelfDistance {
    /// The distances of `robot`. Parts that one link carries may touch, and the pairs of its
    /// list.
    pub fn new(robot: &Robot) -> Self {
        let mut frames: Vec<&str> = Vec::new();
        for sphere in &robot.self_spheres {
            if !frames.contains(&sphere.frame.as_str()) {
                frames.push(&sphere.frame);
            }
        }
        let parts: Vec<(&str, Part)> = frames
            .iter()
            .filter_map(|frame| Some((*frame, part(robot, frame)?)))
            .collect();
        let may_touch = |(a, one): &(&str, Part), (b, other): &(&str, Part)| {
            let mut ignored = robot.self_ignore.iter();
            one.link == other.link || ignored.any(|(c, d)| (c == a && d == b) || (c == b && d == a))
        };
        let mut pairs = Vec::new();
        for a in 0..parts.len() {
            for b in a + 1..parts.len() {
                if !may_touch(&parts[a], &parts[b]) {
                    pairs.push((a, b));
                }
            }
        }
        let parts: Vec<Part> = parts.into_iter().map(|(_, part)| part).collect();
        Self {
            centers: parts
                .iter()
                .map(|part| part.spheres.clone())
                .map(places)
                .collect(),
            parts,
            pairs,
            links: Vec::with_capacity(robot.links.len()),
        }
    }

    /// The smallest distance of two surfaces (m), negative if they overlap, for `positions` of
    /// all joints of the chain of `robot` (rad or m). Pairs farther apart than `reach` (m) are
    /// not computed; infinite if all pairs are. Allocates nothing.
    pub fn nearest(&mut self, robot: &Robot, positions: &[f64], reach: f64) -> f64 {
        robot.link_poses_into(positions, &mut self.links);
        for (part, centers) in self.parts.iter().zip(&mut self.centers) {
            let pose = self.links.get(part.link).copied().unwrap_or_default();
            for ((center, _), at) in part.spheres.iter().zip(centers) {
                *at = pose * center;
            }
        }
        // The best distance so far bounds the next pairs, so most of them end at their
        // enclosing spheres.
        let mut nearest = reach;
        for &(a, b) in &self.pairs {
            nearest = nearest.min(self.apart(a, b, nearest));
        }
        if nearest < reach {
            nearest
        } else {
            f64::INFINITY
        }
    }

    /// Distance of two parts, if it is less than `least`.
    fn apart(&self, a: usize, b: usize, least: f64) -> f64 {
        let (one, other) = (&self.parts[a], &self.parts[b]);
        let place = |part: &Part| {
            let pose = self.links.get(part.link).copied().unwrap_or_default();
            pose * part.around.0
        };
        let bounds = (place(one) - place(other)).norm() - one.around.1 - other.around.1;
        if bounds >= least {
            return f64::INFINITY;
        }
        let mut nearest = f64::INFINITY;
        for (at, (_, radius)) in self.centers[a].iter().zip(&one.spheres) {
            for (from, (_, against)) in self.centers[b].iter().zip(&other.spheres) {
                nearest = nearest.min((at - from).norm() - radius - against);
            }
        }
        nearest
    }
}

fn places(spheres: Vec<(Point3<f64>, f64)>) -> Vec<Point3<f64>> {
    spheres.into_iter().map(|(center, _)| center).collect()
}

/// The spheres of a frame.
fn part(robot: &Robot, frame: &str) -> Option<Part> {
    let of = &robot.chain.frames()[robot.chain.frame_index(frame)?];
    let on_frame = robot.self_spheres.iter().filter(|s| s.frame == frame);
    let spheres: Vec<(Point3<f64>, f64)> = on_frame
        .map(|s| (of.pose * Point3::from(s.center), s.radius))
        .collect();
    let sum = spheres
        .iter()
        .fold(nalgebra::Vector3::zeros(), |sum, (at, _)| sum + at.coords);
    let middle = Point3::from(sum / spheres.len().max(1) as f64);
    let beyond = spheres
        .iter()
        .map(|(at, radius)| (at - middle).norm() + radius);
    Some(Part {
        link: of.joint.map_or(0, |joint| joint + 1),
        around: (middle, beyond.fold(0.0, f64::max)),
        spheres,
    })
}
