//! Pictures of a cell, drawn by the CPU: of each pixel the nearest of the shapes that
//! physics computes with, by ray casts within the shape's rectangle on the screen.

use std::num::NonZero;
use std::ops::Range;
use std::thread;

use cell_model::Cell;
use ipc_types::WorldState;
use ipc_types::world::OBJECT_ENABLED;
use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::Ray;
use parry3d_f64::shape::SharedShape;
use physics_proc::engine::shapes;

/// Most pixels of a picture in each direction.
const MAX_PIXELS: usize = 4096;
/// Vertical field of view (rad).
const FIELD_OF_VIEW: f64 = 0.7;
/// Nothing nearer to the eye is seen (m).
const NEAR_M: f64 = 0.02;
/// A shadow begins this far from a surface (m).
const OFF_SURFACE_M: f64 = 1.0e-3;
/// Nothing farther away throws a shadow (m).
const SHADOW_M: f64 = 3.0;
/// Towards the light; not of unit length.
const LIGHT: [f64; 3] = [0.35, -0.45, 1.0];
/// Colours, red, green, blue from 0 to 1.
const ROBOT: [f64; 3] = [0.86, 0.87, 0.89];
const SKY: [f64; 3] = [0.90, 0.92, 0.95];
/// Light on a surface in the shadow that faces up, and on one that faces down.
const AMBIENT: [f64; 2] = [0.52, 0.30];
/// Light on a surface that faces the light, besides.
const DIRECT: f64 = 0.55;

/// From where, and how large.
pub(crate) struct View {
    pub(crate) eye_m: [f64; 3],
    pub(crate) target_m: [f64; 3],
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// A shape in the world.
pub(crate) struct Solid {
    shape: SharedShape,
    from_world: Isometry3<f64>,
    to_world: Isometry3<f64>,
    centre: Vector3<f64>,
    radius: f64,
    colour: [f64; 3],
}

impl Solid {
    fn new(shape: &cell_model::Shape, pose: Isometry3<f64>, colour: [f64; 3]) -> Self {
        let (engine_shape, offset) = shapes::shared(shape);
        let to_world = pose * offset;
        Self {
            shape: engine_shape,
            from_world: to_world.inverse(),
            to_world,
            centre: pose.translation.vector,
            radius: shape.bounding_radius(),
            colour,
        }
    }

    /// Distance along a ray, and the normal there.
    fn hit(&self, origin: Vector3<f64>, direction: Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let from = self.from_world * nalgebra::Point3::from(origin);
        let along = self.from_world.rotation * direction;
        let ray = Ray::new(
            Vector::new(from.x, from.y, from.z),
            Vector::new(along.x, along.y, along.z),
        );
        let hit = self
            .shape
            .cast_local_ray_and_get_normal(&ray, f64::MAX, false)?;
        let normal = Vector3::new(hit.normal.x, hit.normal.y, hit.normal.z);
        Some((hit.time_of_impact, self.to_world.rotation * normal))
    }

    /// Whether a ray passes near enough for a hit, ahead of its origin.
    fn is_near(&self, origin: Vector3<f64>, direction: Vector3<f64>, length: f64) -> bool {
        let to = self.centre - origin;
        let along = to.dot(&direction);
        let off = to.norm_squared() - along * along;
        off < self.radius * self.radius && along > -self.radius && along < length + self.radius
    }
}

/// The shapes of a cell in a state.
pub(crate) fn solids(cell: &Cell, state: &WorldState) -> Vec<Solid> {
    let mut all: Vec<Solid> = cell
        .fixtures
        .iter()
        .filter(|fixture| fixture.solid)
        .map(|fixture| Solid::new(&fixture.shape, fixture.pose, fixture.colour))
        .collect();
    let objects = cell.objects.iter().zip(&state.objects);
    let present = objects.filter(|(_, seen)| seen.flags & OBJECT_ENABLED != 0);
    all.extend(
        present
            .map(|(object, seen)| Solid::new(&object.shape, isometry(&seen.pose), object.colour)),
    );
    for (arm, seen) in cell.arms.iter().zip(state.arms()) {
        let robot = &arm.robot;
        let mut positions = robot.with_arm_positions(&seen.joint_positions);
        let fingers = robot
            .gripper
            .iter()
            .flat_map(|gripper| gripper.finger_joints);
        for finger in fingers {
            if let Some(slot) = positions.get_mut(finger) {
                *slot = 0.5 * seen.gripper.width;
            }
        }
        for (link, pose) in robot.links.iter().zip(robot.link_poses(&positions)) {
            let shapes = link.shapes.iter();
            all.extend(
                shapes.map(|part| Solid::new(&part.shape, arm.base * pose * part.pose, ROBOT)),
            );
        }
    }
    all
}

fn isometry(pose: &ipc_types::Pose) -> Isometry3<f64> {
    let [w, x, y, z] = pose.orientation_wxyz;
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(pose.position.into(), rotation)
}

/// The eye and the axes of the screen.
struct Eye {
    at: Vector3<f64>,
    right: Vector3<f64>,
    down: Vector3<f64>,
    ahead: Vector3<f64>,
    /// Pixels at distance 1.
    focal: f64,
    middle: [f64; 2],
}

impl Eye {
    fn new(view: &View) -> Option<Self> {
        let at = Vector3::from(view.eye_m);
        let ahead = (Vector3::from(view.target_m) - at).try_normalize(1.0e-9)?;
        let right = ahead
            .cross(&Vector3::z())
            .try_normalize(1.0e-9)
            .unwrap_or_else(Vector3::x);
        let size = [view.width as f64, view.height as f64];
        Some(Self {
            at,
            right,
            down: ahead.cross(&right),
            ahead,
            focal: 0.5 * size[1] / (0.5 * FIELD_OF_VIEW).tan(),
            middle: size.map(|pixels| 0.5 * pixels),
        })
    }

    fn ray(&self, column: usize, row: usize) -> Vector3<f64> {
        let x = (column as f64 + 0.5 - self.middle[0]) / self.focal;
        let y = (row as f64 + 0.5 - self.middle[1]) / self.focal;
        (self.ahead + self.right * x + self.down * y).normalize()
    }

    /// Columns and rows in which a ball may be seen.
    fn rectangle(
        &self,
        solid: &Solid,
        width: usize,
        height: usize,
    ) -> (Range<usize>, Range<usize>) {
        let to = solid.centre - self.at;
        let (depth, radius) = (to.dot(&self.ahead), solid.radius);
        if depth + radius < NEAR_M {
            return (0..0, 0..0);
        }
        if depth - radius < NEAR_M {
            return (0..width, 0..height);
        }
        let range = |off: f64, middle: f64, pixels: usize| {
            let edge = |off: f64, depth: f64| middle + self.focal * off / depth;
            let (near, far) = (depth - radius, depth + radius);
            let low = edge(off - radius, near).min(edge(off - radius, far));
            let high = edge(off + radius, near).max(edge(off + radius, far));
            pixel(low.floor(), pixels)..pixel(high.ceil(), pixels)
        };
        (
            range(to.dot(&self.right), self.middle[0], width),
            range(to.dot(&self.down), self.middle[1], height),
        )
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates"
)]
fn pixel(at: f64, pixels: usize) -> usize {
    (at.max(0.0) as usize).min(pixels)
}

/// The pixels, row by row, red, green, blue.
///
/// # Errors
/// For a view that shows nothing.
pub(crate) fn draw(view: &View, solids: &[Solid]) -> Result<Vec<u8>, String> {
    let (width, height) = (view.width, view.height);
    if !(1..=MAX_PIXELS).contains(&width) || !(1..=MAX_PIXELS).contains(&height) {
        return Err(format!(
            "a picture of {width} x {height} pixels; 1 to {MAX_PIXELS} are allowed in each direction"
        ));
    }
    let eye = Eye::new(view)
        .filter(|eye| eye.ahead.iter().all(|x| x.is_finite()))
        .ok_or_else(|| {
            let (from, to) = (view.eye_m, view.target_m);
            format!("no direction of view: eye {from:?} m, target {to:?} m")
        })?;
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    let rows = height.div_ceil(threads).max(1);
    let mut pixels = vec![0; 3 * width * height];
    thread::scope(|scope| {
        for (index, part) in pixels.chunks_mut(3 * width * rows).enumerate() {
            let first = index * rows;
            let eye = &eye;
            scope.spawn(move || draw_rows(eye, solids, (width, height), first, part));
        }
    });
    Ok(pixels)
}

fn draw_rows(eye: &Eye, solids: &[Solid], size: (usize, usize), first: usize, part: &mut [u8]) {
    let width = size.0;
    let count = part.len() / (3 * width);
    let mut nearest: Vec<Option<Hit>> = vec![None; width * count];
    for (index, solid) in solids.iter().enumerate() {
        let (columns, rows) = eye.rectangle(solid, size.0, size.1);
        for row in rows.start.max(first)..rows.end.min(first + count) {
            for column in columns.clone() {
                let Some(slot) = nearest.get_mut((row - first) * width + column) else {
                    continue;
                };
                let Some((distance, normal)) = solid.hit(eye.at, eye.ray(column, row)) else {
                    continue;
                };
                if distance > NEAR_M && slot.is_none_or(|hit| distance < hit.distance) {
                    *slot = Some(Hit {
                        distance,
                        normal,
                        solid: index,
                    });
                }
            }
        }
    }
    for (at, (hit, pixel)) in nearest.iter().zip(part.chunks_exact_mut(3)).enumerate() {
        let direction = eye.ray(at % width, first + at / width);
        let colour = hit.map_or(SKY, |hit| shade(&hit, eye.at, direction, solids));
        for (byte, channel) in pixel.iter_mut().zip(colour) {
            *byte = level(channel);
        }
    }
}

#[derive(Clone, Copy)]
struct Hit {
    distance: f64,
    normal: Vector3<f64>,
    solid: usize,
}

fn shade(hit: &Hit, eye: Vector3<f64>, direction: Vector3<f64>, solids: &[Solid]) -> [f64; 3] {
    let Some(solid) = solids.get(hit.solid) else {
        return SKY;
    };
    let towards = if hit.normal.dot(&direction) > 0.0 {
        -hit.normal
    } else {
        hit.normal
    };
    let light = Vector3::from(LIGHT).normalize();
    let from = eye + direction * hit.distance + towards * OFF_SURFACE_M;
    let facing = towards.dot(&light).max(0.0);
    let is_lit = facing > 0.0
        && !solids.iter().any(|other| {
            other.is_near(from, light, SHADOW_M)
                && other.hit(from, light).is_some_and(|(at, _)| at < SHADOW_M)
        });
    let up = 0.5 + 0.5 * towards.z;
    let ambient = AMBIENT[1] + (AMBIENT[0] - AMBIENT[1]) * up;
    let strength = ambient + if is_lit { DIRECT * facing } else { 0.0 };
    solid.colour.map(|channel| channel * strength)
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it is from 0 to 255"
)]
fn level(channel: f64) -> u8 {
    (255.0 * channel.clamp(0.0, 1.0)).round() as u8
}
