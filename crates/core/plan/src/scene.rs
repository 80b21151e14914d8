//! The solids that an arm must not touch.

use std::sync::Arc;

use rmp::{Core, Hull, Obstacle, ObstacleError};

/// Solids at rest, base frame, prepared for the checks.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    pub(crate) solids: Vec<Prepared>,
}

/// A solid in single precision.
#[derive(Debug, Clone)]
pub(crate) struct Prepared {
    pub(crate) center: [f32; 3],
    /// World to local, row by row.
    pub(crate) rows: [[f32; 3]; 3],
    /// Distance of the surface from the core (m).
    pub(crate) radius: f32,
    pub(crate) form: Form,
}

/// The core.
#[derive(Debug, Clone)]
pub(crate) enum Form {
    /// Half extents (m).
    Box([f32; 3]),
    /// Radius and half height (m).
    Cylinder([f32; 2]),
    /// Radii at the bottom and at the top, and half height (m).
    Frustum([f32; 3]),
    /// Its planes.
    Hull(Arc<Hull>),
}

impl Scene {
    /// Room for `capacity` solids.
    pub fn with_capacity(capacity: usize) -> Self {
        Self {
            solids: Vec::with_capacity(capacity),
        }
    }

    /// The scene of some obstacles.
    ///
    /// # Errors
    /// [`ObstacleError`] if an obstacle has an invalid size or pose.
    pub fn new<'a>(
        obstacles: impl IntoIterator<Item = &'a Obstacle>,
    ) -> Result<Self, ObstacleError> {
        let mut scene = Self::default();
        for obstacle in obstacles {
            obstacle.validate()?;
            scene.solids.push(prepared(obstacle));
        }
        Ok(scene)
    }

    /// Replaces the solids. They have to be valid, as those of an [`rmp::ObstacleSet`] are.
    /// Allocates only beyond the capacity.
    pub fn set<'a>(&mut self, obstacles: impl IntoIterator<Item = &'a Obstacle>) {
        self.solids.clear();
        self.solids.extend(obstacles.into_iter().map(prepared));
    }
}

#[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}

#[expect(
    clippy::float_cmp,
    reason = "a cylinder is a frustum of two equal radii"
)]
fn prepared(obstacle: &Obstacle) -> Prepared {
    let rotation = obstacle.pose.rotation.to_rotation_matrix();
    let row = |axis: usize| {
        let column = rotation.matrix().column(axis);
        [single(column[0]), single(column[1]), single(column[2])]
    };
    let at = obstacle.pose.translation.vector;
    let form = match &obstacle.core {
        Core::Box(half) => Form::Box([single(half.x), single(half.y), single(half.z)]),
        // The distance from a cylinder takes fewer operations than that from a frustum.
        Core::Frustum {
            bottom,
            top,
            half_height,
        } if bottom == top => Form::Cylinder([single(*top), single(*half_height)]),
        Core::Frustum {
            bottom,
            top,
            half_height,
        } => Form::Frustum([single(*bottom), single(*top), single(*half_height)]),
        Core::Hull(hull) => Form::Hull(hull.clone()),
    };
    Prepared {
        center: [single(at.x), single(at.y), single(at.z)],
        rows: [row(0), row(1), row(2)],
        radius: single(obstacle.radius),
        form,
    }
}
