//! Whether configurations are free: eight at a time.

use wide::f32x8;

use crate::body::{Ball, Body, Part};
use crate::scene::{Prepared, Scene, single};

/// Configurations in one pass.
pub const LANES: usize = 8;

/// A point of eight configurations, base frame (m).
type Point = [f32x8; 3];

/// Frame of a joint in eight configurations: columns of its rotation, then its origin.
#[derive(Debug, Clone, Copy)]
struct Frame {
    columns: [Point; 3],
    origin: Point,
}

/// The body in a scene, with room for the frames of a pass.
#[derive(Debug)]
pub(crate) struct Checker<'a> {
    body: &'a Body,
    scene: &'a Scene,
    /// Configurations of an edge for each rad (m) of its length.
    resolution: f64,
    /// How far spheres stay off the scene (m).
    pub(crate) padding: f32,
    frames: Vec<Frame>,
    positions: Vec<f32x8>,
    bounds: Vec<Point>,
}

impl<'a> Checker<'a> {
    pub(crate) fn new(body: &'a Body, scene: &'a Scene, resolution: f64) -> Self {
        Self {
            body,
            scene,
            resolution,
            padding: 0.0,
            frames: Vec::with_capacity(body.joints.len()),
            positions: vec![f32x8::ZERO; body.joint_count()],
            bounds: Vec::with_capacity(body.self_parts.len()),
        }
    }

    /// Whether one configuration is free.
    pub(crate) fn is_free(&mut self, at: &[f64]) -> bool {
        for (lanes, position) in self.positions.iter_mut().zip(at) {
            *lanes = f32x8::splat(single(*position));
        }
        self.pass_is_free()
    }

    /// Whether the straight line between two configurations is free. The first one is taken
    /// to be.
    pub(crate) fn is_edge_free(&mut self, from: &[f64], to: &[f64]) -> bool {
        let passes = (distance(from, to) * self.resolution / LANES as f64).ceil();
        let passes = passes.max(1.0);
        let mut pass = 1.0;
        while pass <= passes {
            // Lane by lane an eighth of the edge further: a wall anywhere ends the first pass.
            for (slot, lanes) in self.positions.iter_mut().enumerate() {
                let at = |lane: usize| {
                    let along = (lane as f64 + pass / passes) / LANES as f64;
                    single(from[slot] + along * (to[slot] - from[slot]))
                };
                *lanes = f32x8::from([0, 1, 2, 3, 4, 5, 6, 7].map(at));
            }
            if !self.pass_is_free() {
                return false;
            }
            pass += 1.0;
        }
        true
    }

    /// Whether all eight configurations are free.
    fn pass_is_free(&mut self) -> bool {
        self.place();
        let free_of_scene = self.body.parts.iter().all(|part| self.part_is_free(part));
        free_of_scene && self.is_free_of_itself()
    }

    fn place(&mut self) {
        self.frames.clear();
        for joint in &self.body.joints {
            let parent = joint.parent.map(|parent| self.frames[parent]);
            let constant = |value: f32| f32x8::splat(value);
            let columns = [0, 1, 2].map(|c| {
                let column = [0, 1, 2].map(|r| constant(joint.rotation[r][c]));
                parent.map_or(column, |parent| turned(&parent, &column))
            });
            let offset = joint.offset.map(constant);
            let mut origin = parent.map_or(offset, |parent| placed(&parent, &offset));
            let position = self.positions[joint.slot];
            let [x, y, z] = columns;
            let columns = if joint.slides {
                origin = [0, 1, 2].map(|i| origin[i] + z[i] * position);
                columns
            } else {
                let (sine, cosine) = position.sin_cos();
                [
                    [0, 1, 2].map(|i| x[i] * cosine + y[i] * sine),
                    [0, 1, 2].map(|i| y[i] * cosine - x[i] * sine),
                    z,
                ]
            };
            self.frames.push(Frame { columns, origin });
        }
    }

    fn point(&self, joint: Option<usize>, ball: &Ball) -> Point {
        let local = ball.center.map(f32x8::splat);
        joint.map_or(local, |joint| placed(&self.frames[joint], &local))
    }

    fn part_is_free(&self, part: &Part) -> bool {
        let (bound, padding) = (self.point(part.joint, &part.bound), self.padding);
        let solids = self.scene.solids.iter();
        let mut near = solids.filter(|solid| touches(solid, &bound, part.bound.radius + padding));
        near.all(|solid| {
            let mut balls = part.balls.iter();
            balls.all(|ball| !touches(solid, &self.point(part.joint, ball), ball.radius + padding))
        })
    }

    fn is_free_of_itself(&mut self) -> bool {
        let body = self.body;
        self.bounds.clear();
        for part in &body.self_parts {
            let at = self.point(part.joint, &part.bound);
            self.bounds.push(at);
        }
        body.self_pairs.iter().all(|&(a, b)| {
            let (one, other) = (&body.self_parts[a], &body.self_parts[b]);
            let reach = one.bound.radius + other.bound.radius;
            if !are_within(&self.bounds[a], &self.bounds[b], reach) {
                return true;
            }
            one.balls.iter().all(|ball| {
                let at = self.point(one.joint, ball);
                if !are_within(&at, &self.bounds[b], ball.radius + other.bound.radius) {
                    return true;
                }
                other.balls.iter().all(|against| {
                    let from = self.point(other.joint, against);
                    !are_within(&at, &from, ball.radius + against.radius)
                })
            })
        })
    }
}

/// Euclidean, in joint space (rad and m alike).
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

fn turned(frame: &Frame, v: &Point) -> Point {
    let [x, y, z] = &frame.columns;
    [0, 1, 2].map(|i| x[i] * v[0] + y[i] * v[1] + z[i] * v[2])
}

fn placed(frame: &Frame, v: &Point) -> Point {
    let turned = turned(frame, v);
    [0, 1, 2].map(|i| frame.origin[i] + turned[i])
}

/// Whether in any lane two points are nearer than `reach` (m).
fn are_within(a: &Point, b: &Point, reach: f32) -> bool {
    let d = [0, 1, 2].map(|i| a[i] - b[i]);
    let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    square.simd_lt(f32x8::splat(reach * reach)).any()
}

/// Whether in any lane a ball touches a solid.
fn touches(solid: &Prepared, center: &Point, radius: f32) -> bool {
    let d = [0, 1, 2].map(|i| center[i] - f32x8::splat(solid.center[i]));
    let local = solid.rows.map(|row| {
        let [x, y, z] = row.map(f32x8::splat);
        x * d[0] + y * d[1] + z * d[2]
    });
    let half = solid.half.map(f32x8::splat);
    let over = |value: f32x8| value.fast_max(f32x8::ZERO);
    let along = over(local[2].abs() - half[2]);
    let square = if solid.is_cylinder {
        let aside = (local[0] * local[0] + local[1] * local[1]).sqrt();
        let aside = over(aside - half[0]);
        aside * aside + along * along
    } else {
        let (x, y) = (
            over(local[0].abs() - half[0]),
            over(local[1].abs() - half[1]),
        );
        x * x + y * y + along * along
    };
    let reach = solid.radius + radius;
    square.simd_lt(f32x8::splat(reach * reach)).any()
}
