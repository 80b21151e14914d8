//! The bodies of a cell.

use cell_model::{ArmSpec, Cell, Shape};
use nalgebra::{Isometry3, Vector3};

use crate::candidate::Exclusion;
use crate::solid::Solid;

/// A body of the cell at a pose.
#[derive(Clone)]
pub struct Body {
    /// Its name in the cell file.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Its pose; `None` while it is not in the cell.
    pub pose: Option<Isometry3<f64>>,
    /// The shape as convex parts.
    pub(crate) solid: Solid,
}

impl Body {
    /// A body with this shape.
    pub fn new(name: &str, shape: &Shape, pose: Option<Isometry3<f64>>) -> Self {
        Self {
            name: name.to_owned(),
            shape: shape.clone(),
            pose,
            solid: Solid::of(shape),
        }
    }

    /// The least and the largest coordinate of the body at `pose` along a unit `axis` (m).
    pub fn extent(&self, pose: &Isometry3<f64>, axis: &Vector3<f64>) -> (f64, f64) {
        self.solid.extent(pose, axis)
    }

    /// Whether a gripper's `solid` at `at` is nearer to it than `margin` (m).
    pub(crate) fn is_near(&self, solid: &Solid, at: &Isometry3<f64>, margin: f64) -> bool {
        self.pose
            .is_some_and(|pose| solid.is_near(at, &self.solid, &pose, margin))
    }
}

/// The surroundings of a grasp.
#[derive(Clone, Default)]
pub struct Scene {
    /// Fixtures that exist in physics.
    pub fixtures: Vec<Body>,
    /// The objects, by their place in the cell file.
    pub objects: Vec<Body>,
    /// Links of other arms.
    pub arms: Vec<Body>,
}

impl Scene {
    /// The scene of `cell` at the start of a run. Parked objects are not in it.
    pub fn of(cell: &Cell) -> Self {
        let fixtures = cell.fixtures.iter().filter(|fixture| fixture.solid);
        let fixtures = fixtures.map(|of| Body::new(&of.name, &of.shape, Some(of.pose)));
        let object = |of: &cell_model::ObjectSpec| {
            Body::new(&of.name, &of.shape, (!of.parked).then_some(of.pose))
        };
        Self {
            fixtures: fixtures.collect(),
            objects: cell.objects.iter().map(object).collect(),
            arms: Vec::new(),
        }
    }

    /// The object with this index, and the bodies nearer to its centre than `radius_m` (m), which
    /// are all that a gripper of that size can touch; `None` for an object that is not in the
    /// cell. The object is the first one.
    pub(crate) fn around(&self, object: usize, radius_m: f64) -> Option<Self> {
        let own = self.objects.get(object)?;
        let centre = own.pose?.translation.vector;
        let is_near = |body: &Body| {
            body.pose.is_some_and(|pose| {
                let apart = (pose.translation.vector - centre).norm();
                apart < radius_m + body.solid.radius()
            })
        };
        let near = |bodies: &[Body]| {
            bodies
                .iter()
                .filter(|body| is_near(body))
                .cloned()
                .collect()
        };
        let others = self.objects.iter().enumerate();
        let others = others.filter(|(index, body)| *index != object && is_near(body));
        Some(Self {
            fixtures: near(&self.fixtures),
            objects: std::iter::once(own)
                .chain(others.map(|(_, body)| body))
                .cloned()
                .collect(),
            arms: near(&self.arms),
        })
    }

    /// The first body other than `object` that `is_near` finds: fixtures, then objects, then
    /// arms, each with its margin (m).
    pub(crate) fn touched(
        &self,
        object: &Body,
        (fixtures, objects, arms): (f64, f64, f64),
        is_near: impl Fn(&Body, f64) -> bool,
    ) -> Option<Exclusion> {
        let find = |bodies: &[Body], margin: f64| {
            // By address: `object` is a body of this scene, and a copy of it would be its own
            // obstacle.
            let others = bodies.iter().filter(|body| !std::ptr::eq(*body, object));
            let mut near = others.filter(|body| is_near(body, margin));
            near.next().map(|body| body.name.clone())
        };
        find(&self.fixtures, fixtures)
            .map(Exclusion::Fixture)
            .or_else(|| find(&self.objects, objects).map(Exclusion::Object))
            .or_else(|| find(&self.arms, arms).map(Exclusion::Arm))
    }

    /// Adds the links of an arm of the cell as an obstacle, at these joint positions.
    pub fn add_arm(&mut self, arm: &ArmSpec, joint_positions: &[f64]) {
        let robot = &arm.robot;
        let poses = robot.link_poses(&robot.with_arm_positions(joint_positions));
        for (link, pose) in robot.links.iter().zip(poses) {
            let parts = link.shapes.iter();
            self.arms.extend(
                parts.map(|part| {
                    Body::new(&arm.name, &part.shape, Some(arm.base * pose * part.pose))
                }),
            );
        }
    }
}
