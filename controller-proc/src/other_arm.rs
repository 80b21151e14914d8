//! The other arms of a cell as obstacles, at their measured joints.
//!
//! The collision spheres of a frame are covered by one rounded box each, capsule or box, the
//! smaller one: ten obstacles instead of fifty-six for a Panda (ADR 0010). That is cheaper,
//! and the published tuning is for obstacles with one weight each, not one for every sphere of
//! their model.

use cell_model::{Cell, Robot};
use ipc_types::ArmState;
use nalgebra::{Isometry3, Point3, Vector3};
use rmp::{Obstacle, ObstacleError, ObstacleId, ObstacleSet};

use crate::checkpoint::{CheckpointError, Codec};

/// Another arm in the frame of the own base.
#[derive(Debug)]
pub struct OtherArm {
    index: usize,
    name: String,
    robot: Robot,
    /// Its base in the frame of the own base.
    base: Isometry3<f64>,
    /// All joints of its chain (rad or m).
    positions: Vec<f64>,
    links: Vec<Isometry3<f64>>,
    parts: Vec<Part>,
    /// By part, once they were added.
    ids: Vec<ObstacleId>,
}

/// A cover of the spheres of one frame.
#[derive(Clone, Debug)]
struct Part {
    /// Index among the robot's links.
    link: usize,
    /// In the link's frame.
    cover: Obstacle,
}

/// A sphere in the frame of its link: centre and radius (m).
type Ball = (Vector3<f64>, f64);

impl OtherArm {
    /// Every arm of `cell` except `own`, in the frame of the base of `own`.
    pub fn all_but(cell: &Cell, own: usize) -> Vec<Self> {
        let Some(view) = cell.arms.get(own) else {
            return Vec::new();
        };
        let others = cell.arms.iter().enumerate();
        others
            .filter(|(index, _)| *index != own)
            .map(|(index, other)| Self {
                index,
                name: other.name.clone(),
                base: view.base.inverse() * other.base,
                positions: with_home(&other.robot, &other.home),
                links: Vec::with_capacity(other.robot.links.len()),
                parts: parts(&other.robot),
                ids: Vec::new(),
                robot: other.robot.clone(),
            })
            .collect()
    }

    /// Its name in the cell.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of its obstacles.
    pub fn part_count(&self) -> usize {
        self.parts.len()
    }

    /// Adds its parts to `set`, at home.
    ///
    /// # Errors
    /// [`ObstacleError`] if a sphere of the robot is not valid.
    pub fn add_to(&mut self, set: &mut ObstacleSet) -> Result<(), ObstacleError> {
        self.robot.link_poses_into(&self.positions, &mut self.links);
        for part in &self.parts {
            let pose = self.base * self.links[part.link] * part.cover.pose;
            self.ids.push(set.add(Obstacle {
                pose,
                ..part.cover.clone()
            })?);
        }
        Ok(())
    }

    /// Moves its parts to the joints of `arms`, all arms of the cell. A part keeps its pose if
    /// the arm is not among them. Allocates nothing.
    pub fn place(&mut self, arms: &[ArmState], set: &mut ObstacleSet) {
        let Some(arm) = arms.get(self.index) else {
            return;
        };
        self.robot
            .place_arm(&arm.joint_positions, &mut self.positions);
        self.move_parts(set);
    }

    /// Writes or reads its last joints; the parts in `set` are moved to them.
    pub(crate) fn checkpoint(
        &mut self,
        codec: &mut Codec<'_>,
        set: &mut ObstacleSet,
    ) -> Result<(), CheckpointError> {
        codec.same("joints of the other arm", self.positions.len() as u64)?;
        codec.f64s(&mut self.positions)?;
        if codec.reads() {
            self.move_parts(set);
        }
        Ok(())
    }

    fn move_parts(&mut self, set: &mut ObstacleSet) {
        self.robot.link_poses_into(&self.positions, &mut self.links);
        for (part, id) in self.parts.iter().zip(&self.ids) {
            let pose = self.base * self.links[part.link] * part.cover.pose;
            // A pose is refused only if it is not finite: the part then stays where it was.
            let _moved = set.set_pose(*id, pose).is_ok();
        }
    }
}

/// Fingers are at the positions that motion policies assume.
fn with_home(robot: &Robot, home: &[f64]) -> Vec<f64> {
    let mut positions = robot.fixed_joint_positions.clone();
    robot.place_arm(home, &mut positions);
    positions
}

/// One part for each frame that carries spheres, in the order of the frames.
fn parts(robot: &Robot) -> Vec<Part> {
    let part = |frame: &rmp::Frame| {
        let on_frame = robot.spheres.iter().filter(|s| s.frame == frame.name);
        let center = |s: &rmp::CollisionSphere| (frame.pose * Point3::from(s.center)).coords;
        let balls: Vec<Ball> = on_frame.map(|s| (center(s), s.radius)).collect();
        Some(Part {
            link: frame.joint.map_or(0, |joint| joint + 1),
            cover: cover(&balls)?,
        })
    };
    robot.chain.frames().iter().filter_map(part).collect()
}

/// The smaller of box and capsule around all `balls`; `None` around nothing.
fn cover(balls: &[Ball]) -> Option<Obstacle> {
    // The smaller one keeps more room free for the own arm.
    let (boxed, capsule) = (boxed(balls)?, capsule(balls)?);
    Some(if volume(&capsule) < volume(&boxed) {
        capsule
    } else {
        boxed
    })
}

/// The box of the centres, with the frame's axes, grown by the largest radius.
fn boxed(balls: &[Ball]) -> Option<Obstacle> {
    let (first, _) = balls.first()?;
    let low = balls
        .iter()
        .fold(*first, |low, (center, _)| low.inf(center));
    let high = balls
        .iter()
        .fold(*first, |high, (center, _)| high.sup(center));
    let middle = 0.5 * (low + high);
    Some(Obstacle::rounded_box(
        Isometry3::translation(middle.x, middle.y, middle.z),
        0.5 * (high - low),
        balls.iter().fold(0.0, |most, (_, radius)| radius.max(most)),
    ))
}

/// The capsule between the two farthest centres, wide enough for all spheres.
fn capsule(balls: &[Ball]) -> Option<Obstacle> {
    let (first, _) = balls.first()?;
    let (mut ends, mut furthest) = ((*first, *first), 0.0);
    for (index, (a, _)) in balls.iter().enumerate() {
        for (b, _) in balls.iter().skip(index + 1) {
            if (b - a).norm() > furthest {
                (ends, furthest) = ((*a, *b), (b - a).norm());
            }
        }
    }
    let width = |(center, radius): &Ball| radius + off_segment(&ends, center);
    let widest = balls.iter().map(width).fold(0.0, f64::max);
    Some(Obstacle::capsule(ends.0, ends.1, widest))
}

/// Distance of a point from a segment (m).
fn off_segment((a, b): &(Vector3<f64>, Vector3<f64>), point: &Vector3<f64>) -> f64 {
    let along = b - a;
    let share = (point - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
    (point - a - along * share.clamp(0.0, 1.0)).norm()
}

/// Volume of the box around a rounded box (m³): good enough to compare.
fn volume(obstacle: &Obstacle) -> f64 {
    let sides = obstacle.half_extents().add_scalar(obstacle.radius) * 2.0;
    sides.x * sides.y * sides.z
}

#[cfg(test)]
mod tests {
    use super::*;
    use cell_model::Data;
    use ipc_types::Wire;

    #[test]
    fn every_sphere_of_the_other_arm_lies_within_its_parts_wherever_it_is() {
        let cell = Cell::load(&Data::checkout(), "franka-pyramid", 1, None).unwrap();
        let mut other = OtherArm::all_but(&cell, 0).pop().unwrap();
        assert_eq!((other.name(), other.part_count()), ("right", 10));
        let mut set = ObstacleSet::with_capacity(10);
        other.add_to(&mut set).unwrap();
        let mut arms = [ArmState::zeroed(), ArmState::zeroed()];
        let joints = [0.4, -0.9, 0.3, -2.1, -0.5, 1.7, -1.1];
        arms[1].joint_positions[..7].copy_from_slice(&joints);
        other.place(&arms, &mut set);
        let arm = &cell.arms[1];
        let positions = with_home(&arm.robot, &joints);
        let to_own = cell.arms[0].base.inverse() * arm.base;
        for sphere in &arm.robot.spheres {
            let frame = arm.robot.chain.frame_index(&sphere.frame).unwrap();
            let pose = to_own * arm.robot.frame_pose(frame, &positions).unwrap();
            let center = pose * Point3::from(sphere.center);
            let nearest = (0..set.len())
                .map(|id| set.get(ObstacleId(id)).unwrap().distance(&center))
                .fold(f64::INFINITY, f64::min);
            assert!(
                nearest <= 1.0e-9 - sphere.radius,
                "{}: {nearest}",
                sphere.frame
            );
        }
    }

    #[test]
    fn an_arm_alone_sees_nobody() {
        let cell = Cell::load(&Data::checkout(), "franka-stack", 1, None).unwrap();
        assert!(OtherArm::all_but(&cell, 0).is_empty());
    }

    #[test]
    fn a_row_of_balls_becomes_a_capsule_and_a_sheet_a_box() {
        let row: Vec<Ball> = (0..4)
            .map(|i| (Vector3::new(0.03, 0.04, 0.0) * f64::from(i), 0.02))
            .collect();
        let capsule = cover(&row).unwrap();
        assert!((capsule.half_extents().z - 0.075).abs() < 1.0e-12);
        assert!((capsule.radius - 0.02).abs() < 1.0e-12);
        let sheet = [(0.0, 0.0), (0.2, 0.0), (0.0, 0.1), (0.2, 0.1)];
        let sheet = sheet.map(|(x, y)| (Vector3::new(x, y, 0.0), 0.02));
        let boxed = cover(&sheet).unwrap();
        assert_eq!(boxed.half_extents(), Vector3::new(0.1, 0.05, 0.0));
        assert_eq!(cover(&[]), None);
    }
}
