//! Spheres that cover solids.

use nalgebra::{Point3, Vector3};
use rmp::{CollisionSphere, Obstacle};

use crate::robots::robot::Robot;
use crate::shape::{Link, LinkShape, Shape};

/// Distance of samples and of candidates (m).
const SPACING_M: f64 = 0.01;
/// How far a sphere may reach out of a shape (m).
const MARGIN_M: f64 = 0.015;
/// Parts outside of the spheres by less than this count as covered (m).
const COVERED_M: f64 = 0.004;

/// Spheres (centre and radius, m) that cover `samples`: as few as a greedy choice finds, at
/// most `most`. A candidate is a point inside of a solid and its depth there; a sphere around
/// it reaches at most `margin` out of the solid. Samples that no candidate covers stay
/// uncovered.
pub fn cover(
    samples: &[Point3<f64>],
    candidates: &[(Point3<f64>, f64)],
    margin: f64,
    most: usize,
) -> Vec<(Point3<f64>, f64)> {
    let reaches = |(center, depth): &(Point3<f64>, f64), sample: &Point3<f64>| {
        (center - sample).norm() <= depth + margin
    };
    let mut left: Vec<&Point3<f64>> = samples.iter().collect();
    let mut spheres = Vec::new();
    while !left.is_empty() && spheres.len() < most {
        let covered = |candidate: &&(Point3<f64>, f64)| {
            left.iter()
                .filter(|sample| reaches(candidate, sample))
                .count()
        };
        // The first of equals, so that the same input has the same result.
        let best = candidates
            .iter()
            .map(|candidate| (covered(&candidate), candidate))
            .fold(
                None,
                |best: Option<(usize, &(Point3<f64>, f64))>, next| match best {
                    Some(best) if best.0 >= next.0 => Some(best),
                    _ => Some(next),
                },
            );
        let Some((_, best)) = best.filter(|(count, _)| *count > 0) else {
            break;
        };
        // As small as possible: the radius of the candidate may reach farther than any sample
        // needs.
        let far = left
            .iter()
            .filter(|sample| reaches(best, sample))
            .fold(0.0, |far: f64, sample| far.max((best.0 - **sample).norm()));
        spheres.push((best.0, far));
        left.retain(|sample| !reaches(best, sample));
    }
    spheres
}

impl Robot {
    /// Spheres for the parts of the collision shapes outside of [`Robot::spheres`], for all
    /// moving links except the first, which turns on the spot. With both the arm is covered to
    /// within 4 mm; the spheres reach at most 15 mm out of the shapes (ADR 0021).
    pub fn uncovered_spheres(&self) -> Vec<CollisionSphere> {
        let first = self.arm_joints.first().map_or(0, |joint| joint + 1);
        let links = self.links.iter().skip(first + 1);
        links.flat_map(|link| self.uncovered(link)).collect()
    }

    fn uncovered(&self, link: &Link) -> Vec<CollisionSphere> {
        let Some(frame) = self.chain.frame_index(&link.name) else {
            return Vec::new();
        };
        let carrier = self.chain.frames()[frame].joint;
        // In the frame of the joint, as the shapes are.
        let known: Vec<(Point3<f64>, f64)> = self
            .spheres
            .iter()
            .filter_map(|sphere| {
                let of = &self.chain.frames()[self.chain.frame_index(&sphere.frame)?];
                let center = of.pose * Point3::from(sphere.center);
                (of.joint == carrier).then_some((center, sphere.radius))
            })
            .collect();
        let solids: Vec<Obstacle> = link.shapes.iter().map(obstacle).collect();
        let is_open = |sample: &Point3<f64>| {
            let mut spheres = known.iter();
            let mut solids = solids.iter();
            !spheres.any(|(center, r)| (center - sample).norm() <= r + COVERED_M)
                && !solids.any(|solid| solid.distance(sample) < -COVERED_M)
        };
        let mut samples = Vec::new();
        let mut candidates = Vec::new();
        for (shape, solid) in link.shapes.iter().zip(&solids) {
            samples.extend(surface(shape).into_iter().filter(&is_open));
            candidates.extend(inside(solid));
        }
        let to_frame = self.chain.frames()[frame].pose.inverse();
        cover(&samples, &candidates, MARGIN_M, usize::MAX)
            .into_iter()
            .map(|(center, radius)| CollisionSphere {
                frame: link.name.clone(),
                center: (to_frame * center).coords,
                radius,
            })
            .collect()
    }
}

fn obstacle(shape: &LinkShape) -> Obstacle {
    shape.shape.obstacle(shape.pose)
}

/// Points inside of a solid, with their depths (m).
fn inside(solid: &Obstacle) -> Vec<(Point3<f64>, f64)> {
    let half = solid.half_extents().add_scalar(solid.radius);
    let mut found = Vec::new();
    for x in steps(half.x) {
        for y in steps(half.y) {
            for z in steps(half.z) {
                let point = solid.pose * Point3::new(x, y, z);
                let depth = -solid.distance(&point);
                if depth >= 0.0 {
                    found.push((point, depth));
                }
            }
        }
    }
    found
}

/// Steps from `-half` over 0 to `half`, at most [`SPACING_M`] apart.
fn steps(half: f64) -> impl Iterator<Item = f64> + Clone {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a link has a few hundred steps"
    )]
    let count = 2 * (half / SPACING_M).ceil().clamp(1.0, 500.0) as u32;
    (0..=count).map(move |step| half * (2.0 * f64::from(step) / f64::from(count) - 1.0))
}

/// Points on the surface of a shape, in the frame of its link.
fn surface(shape: &LinkShape) -> Vec<Point3<f64>> {
    let local = match shape.shape {
        Shape::Box { size_m } | Shape::Bin { size_m, .. } => faces(Vector3::from(size_m) * 0.5),
        Shape::Sphere { radius_m } => round(radius_m, 0.0),
        Shape::Capsule { radius_m, height_m } => {
            let mut points = round(radius_m, 0.5 * height_m);
            points.extend(side(radius_m, 0.5 * height_m));
            points
        }
        Shape::Cylinder { radius_m, height_m } => {
            let half = 0.5 * height_m;
            let mut points = side(radius_m, half);
            for radius in steps(0.5 * radius_m).map(|step| step + 0.5 * radius_m) {
                points.extend(ring(radius, half));
                points.extend(ring(radius, -half));
            }
            points
        }
    };
    local.into_iter().map(|point| shape.pose * point).collect()
}

/// Surface of a box.
fn faces(half: Vector3<f64>) -> Vec<Point3<f64>> {
    let mut points = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for a in steps(half[u]) {
            for b in steps(half[v]) {
                for end in [-half[axis], half[axis]] {
                    let mut point = Point3::origin();
                    (point[axis], point[u], point[v]) = (end, a, b);
                    points.push(point);
                }
            }
        }
    }
    points
}

/// Surface of a ball whose halves are `2 * half` apart along z.
fn round(radius: f64, half: f64) -> Vec<Point3<f64>> {
    let mut points = Vec::new();
    for height in steps(radius) {
        let around = (radius * radius - height * height).max(0.0).sqrt();
        points.extend(ring(around, height + half.copysign(height)));
    }
    points
}

/// Surface of a cylinder without its ends.
fn side(radius: f64, half: f64) -> Vec<Point3<f64>> {
    steps(half)
        .flat_map(|height| ring(radius, height))
        .collect()
}

fn ring(radius: f64, height: f64) -> Vec<Point3<f64>> {
    let around = steps(std::f64::consts::PI * radius).collect::<Vec<f64>>();
    // The ring of the pole of a ball has radius 0, and 0 / 0 is not a number.
    let angle = |along: f64| along / radius.max(f64::MIN_POSITIVE);
    let at = |along: f64| {
        let (sin, cos) = (libm::sin(angle(along)), libm::cos(angle(along)));
        Point3::new(radius * cos, radius * sin, height)
    };
    around.into_iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Data;

    #[test]
    fn a_ball_is_one_sphere_and_a_rod_a_row_of_them() {
        let ball = LinkShape {
            shape: Shape::Sphere { radius_m: 0.05 },
            pose: nalgebra::Isometry3::identity(),
        };
        let of = |shape: &LinkShape| {
            let solid = obstacle(shape);
            cover(&surface(shape), &inside(&solid), MARGIN_M, usize::MAX)
        };
        let spheres = of(&ball);
        assert_eq!(spheres.len(), 1, "{spheres:?}");
        assert!((spheres[0].1 - 0.05).abs() < 0.005);
        let rod = LinkShape {
            shape: Shape::Cylinder {
                radius_m: 0.03,
                height_m: 0.4,
            },
            pose: nalgebra::Isometry3::translation(0.1, 0.2, 0.3),
        };
        let spheres = of(&rod);
        assert!((5..60).contains(&spheres.len()), "{}", spheres.len());
        for sample in surface(&rod) {
            let apart = |(at, r): &(Point3<f64>, f64)| (at - sample).norm() - r;
            let least = spheres.iter().map(apart).fold(f64::INFINITY, f64::min);
            assert!(least < 1e-9, "{sample}: {least}");
        }
        let out = |(at, r): &(Point3<f64>, f64)| obstacle(&rod).distance(at) + r;
        assert!(spheres.iter().all(|sphere| out(sphere) <= MARGIN_M + 1e-9));
    }

    #[test]
    fn every_shape_of_our_robots_is_covered_with_few_more_spheres() {
        for name in ["panda", "ur10"] {
            let robot = Robot::load(&Data::checkout(), name).unwrap();
            let more = robot.uncovered_spheres();
            assert!((1..100).contains(&more.len()), "{name}: {}", more.len());
            let all: Vec<_> = robot.spheres.iter().chain(&more).collect();
            for link in &robot.links[2..] {
                let frame = robot.chain.frame_index(&link.name).unwrap();
                let joint = robot.chain.frames()[frame].joint;
                for sample in link.shapes.iter().flat_map(surface) {
                    let apart = |sphere: &&CollisionSphere| {
                        let of = robot.chain.frame_index(&sphere.frame).unwrap();
                        let of = &robot.chain.frames()[of];
                        let center = of.pose * Point3::from(sphere.center);
                        if of.joint == joint {
                            (center - sample).norm() - sphere.radius
                        } else {
                            f64::INFINITY
                        }
                    };
                    let least = all.iter().map(apart).fold(f64::INFINITY, f64::min);
                    assert!(least <= COVERED_M + 1e-9, "{name} {}: {least}", link.name);
                }
            }
        }
    }
}
