//! Checks whether configurations are free, sixteen at a time.
#![allow(
    clippy::inline_always,
    reason = "lanes are compiled for the instruction set of the function they are inlined into"
)]

use pulp::{Arch, Simd, WithSimd};
use rmp::Hull;

use crate::body::{Ball, Body, BodyJoint, MAX_JOINTS, Part};
use crate::lanes::{LANES, Row, Wide, Wide3, add, dot, scale, sub};
use crate::scene::{Form, Prepared, Scene, single};

/// The body in a scene, with room for the configurations of a pass.
#[derive(Debug)]
pub(crate) struct Checker<'a> {
    body: &'a Body,
    scene: &'a Scene,
    /// Number of configurations checked for each rad (m) of an edge.
    resolution: f64,
    /// Distance of spheres from the scene (m).
    pub(crate) padding: f32,
    /// By joint.
    positions: Vec<Row>,
    /// Comparisons with solids in all passes.
    pub(crate) looked_at: u64,
    arch: Arch,
}

impl<'a> Checker<'a> {
    pub(crate) fn new(body: &'a Body, scene: &'a Scene, resolution: f64) -> Self {
        Self::with_rows(body, scene, resolution, rows(body))
    }

    /// With the buffer that [`rows`] made, to allocate nothing.
    pub(crate) fn with_rows(
        body: &'a Body,
        scene: &'a Scene,
        resolution: f64,
        positions: Vec<Row>,
    ) -> Self {
        Self {
            body,
            scene,
            resolution,
            padding: 0.0,
            positions,
            looked_at: 0,
            arch: Arch::new(),
        }
    }

    /// The buffer, for the next checker.
    pub(crate) fn into_rows(self) -> Vec<Row> {
        self.positions
    }

    /// Whether one configuration is free.
    pub(crate) fn is_free(&mut self, at: &[f64]) -> bool {
        for (row, position) in self.positions.iter_mut().zip(at) {
            *row = Row([single(*position); LANES]);
        }
        self.pass_is_free()
    }

    /// Whether the straight line between two configurations is free. The first one was checked
    /// before.
    pub(crate) fn is_edge_free(&mut self, from: &[f64], to: &[f64]) -> bool {
        let passes = (distance(from, to) * self.resolution / LANES as f64).ceil();
        let passes = passes.max(1.0);
        let mut pass = 1.0;
        while pass <= passes {
            // The lanes of each pass are spread over the whole edge: a wall at any place is
            // found by the first pass, not after half of the edge.
            for (slot, row) in self.positions.iter_mut().enumerate() {
                for (lane, position) in row.0.iter_mut().enumerate() {
                    let along = (lane as f64 + pass / passes) / LANES as f64;
                    *position = single(from[slot] + along * (to[slot] - from[slot]));
                }
            }
            if !self.pass_is_free() {
                return false;
            }
            pass += 1.0;
        }
        true
    }

    /// Whether all configurations of the pass are free.
    fn pass_is_free(&mut self) -> bool {
        // An empty scene counts as well: the limit has to end a search in which the arm blocks
        // itself.
        self.looked_at += self.scene.solids.len().max(1) as u64;
        self.arch.dispatch(Pass(self))
    }
}

/// Buffer for the configurations of a pass.
pub(crate) fn rows(body: &Body) -> Vec<Row> {
    vec![Row([0.0; LANES]); body.joint_count()]
}

/// The work of one pass, for any instruction set.
struct Pass<'a, 'b>(&'a Checker<'b>);

impl WithSimd for Pass<'_, '_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let checker = self.0;
        // No closure: an intrinsic inside one is called, not inlined (ADR 0019).
        for register in 0..LANES / S::F32_LANES {
            let pose = Posed::new(simd, checker, register);
            if !pose.is_free_of_scene(checker.scene, checker.padding) || !pose.is_free_of_itself() {
                return false;
            }
        }
        true
    }
}

/// Frame of a joint: columns of its rotation, then its origin (m).
#[derive(Clone, Copy)]
struct Frame<S: Simd> {
    columns: [Wide3<S>; 3],
    origin: Wide3<S>,
}

/// The body in the configurations of one register.
struct Posed<'a, S: Simd> {
    simd: S,
    body: &'a Body,
    frames: [Frame<S>; MAX_JOINTS],
}

impl<'a, S: Simd> Posed<'a, S> {
    #[inline(always)]
    fn new(simd: S, checker: &Checker<'a>, register: usize) -> Self {
        let zero = Wide::splat3(simd, &[0.0; 3]);
        let none = Frame {
            columns: [zero; 3],
            origin: zero,
        };
        let mut frames = [none; MAX_JOINTS];
        for (index, joint) in checker.body.joints.iter().enumerate() {
            let position = Wide::load(simd, &checker.positions[joint.slot], register);
            let position = Wide::splat(simd, joint.ratio) * position;
            let parent = joint.parent.map(|parent| frames[parent]);
            frames[index] = frame(simd, joint, parent.as_ref(), position);
        }
        Self {
            simd,
            body: checker.body,
            frames,
        }
    }

    #[inline(always)]
    fn point(&self, joint: Option<usize>, ball: &Ball) -> Wide3<S> {
        let local = Wide::splat3(self.simd, &ball.center);
        match joint {
            Some(joint) => placed(&self.frames[joint], &local),
            None => local,
        }
    }

    #[inline(always)]
    fn is_free_of_scene(&self, scene: &Scene, padding: f32) -> bool {
        for part in &self.body.parts {
            let bound = self.point(part.joint, &part.bound);
            for solid in &scene.solids {
                // The bound first: most parts are far from most solids.
                if touches(self.simd, solid, &bound, part.bound.radius + padding)
                    && self.touches_any(part, solid, padding)
                {
                    return false;
                }
            }
        }
        true
    }

    #[inline(always)]
    fn touches_any(&self, part: &Part, solid: &Prepared, padding: f32) -> bool {
        for ball in &part.balls {
            let at = self.point(part.joint, ball);
            if touches(self.simd, solid, &at, ball.radius + padding) {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn is_free_of_itself(&self) -> bool {
        let parts = &self.body.self_parts;
        for &(a, b) in &self.body.self_pairs {
            if self.meet(&parts[a], &parts[b]) {
                return false;
            }
        }
        true
    }

    #[inline(always)]
    fn meet(&self, one: &Part, other: &Part) -> bool {
        let center = self.point(other.joint, &other.bound);
        let bound = self.point(one.joint, &one.bound);
        let reach = other.bound.radius;
        // As above, part against part before sphere against sphere.
        if !self.are_within(&bound, &center, one.bound.radius + reach) {
            return false;
        }
        for ball in &one.balls {
            let at = self.point(one.joint, ball);
            if !self.are_within(&at, &center, ball.radius + reach) {
                continue;
            }
            for against in &other.balls {
                let from = self.point(other.joint, against);
                if self.are_within(&at, &from, ball.radius + against.radius) {
                    return true;
                }
            }
        }
        false
    }

    /// Whether in any lane two points are nearer than `reach` (m).
    #[inline(always)]
    fn are_within(&self, a: &Wide3<S>, b: &Wide3<S>, reach: f32) -> bool {
        let d = sub(a, b);
        dot(&d, &d).any_less(Wide::splat(self.simd, reach * reach))
    }
}

#[inline(always)]
fn frame<S: Simd>(
    simd: S,
    joint: &BodyJoint,
    parent: Option<&Frame<S>>,
    position: Wide<S>,
) -> Frame<S> {
    let own = [
        Wide::splat3(simd, &joint.columns[0]),
        Wide::splat3(simd, &joint.columns[1]),
        Wide::splat3(simd, &joint.columns[2]),
    ];
    let offset = Wide::splat3(simd, &joint.offset);
    // Written out for the three columns: a loop with a closure is not inlined (ADR 0019).
    let ([x, y, z], origin) = match parent {
        None => (own, offset),
        Some(parent) => (
            [
                turned(parent, &own[0]),
                turned(parent, &own[1]),
                turned(parent, &own[2]),
            ],
            placed(parent, &offset),
        ),
    };
    if joint.slides {
        return Frame {
            columns: [x, y, z],
            origin: add(&origin, &scale(position, &z)),
        };
    }
    let (sine, cosine) = position.sin_cos();
    let columns = [
        add(&scale(cosine, &x), &scale(sine, &y)),
        sub(&scale(cosine, &y), &scale(sine, &x)),
        z,
    ];
    Frame { columns, origin }
}

/// Euclidean distance in joint space (rad and m alike).
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

#[inline(always)]
fn turned<S: Simd>(frame: &Frame<S>, v: &Wide3<S>) -> Wide3<S> {
    let [x, y, z] = &frame.columns;
    add(&add(&scale(v[0], x), &scale(v[1], y)), &scale(v[2], z))
}

#[inline(always)]
fn placed<S: Simd>(frame: &Frame<S>, v: &Wide3<S>) -> Wide3<S> {
    add(&frame.origin, &turned(frame, v))
}

/// Whether in any lane a ball touches a solid.
#[inline(always)]
fn touches<S: Simd>(simd: S, solid: &Prepared, center: &Wide3<S>, radius: f32) -> bool {
    let zero = Wide::splat(simd, 0.0);
    let d = sub(center, &Wide::splat3(simd, &solid.center));
    let local = [
        dot(&Wide::splat3(simd, &solid.rows[0]), &d),
        dot(&Wide::splat3(simd, &solid.rows[1]), &d),
        dot(&Wide::splat3(simd, &solid.rows[2]), &d),
    ];
    let reach = solid.radius + radius;
    // Squares are compared: no square root is needed to know whether a ball touches.
    let square = match &solid.form {
        Form::Box(half) => {
            let half = Wide::splat3(simd, half);
            let out = [
                (local[0].abs() - half[0]).max(zero),
                (local[1].abs() - half[1]).max(zero),
                (local[2].abs() - half[2]).max(zero),
            ];
            dot(&out, &out)
        }
        Form::Cylinder([radius, half]) => {
            let off_axis = (local[0] * local[0] + local[1] * local[1]).sqrt();
            let aside = (off_axis - Wide::splat(simd, *radius)).max(zero);
            let along = (local[2].abs() - Wide::splat(simd, *half)).max(zero);
            aside * aside + along * along
        }
        Form::Frustum(size) => frustum(simd, size, &local),
        // Beyond edges this is less than the exact distance: a hull is checked as slightly
        // larger.
        Form::Hull(hull) => return is_within_planes(simd, hull, &local, reach),
    };
    square.any_less(Wide::splat(simd, reach * reach))
}

/// Square of the distance, zero inside: see [`rmp::Obstacle::distance`].
#[inline(always)]
fn frustum<S: Simd>(simd: S, size: &[f32; 3], local: &Wide3<S>) -> Wide<S> {
    let [bottom, top, half] = *size;
    let c = |value: f32| Wide::splat(simd, value);
    let zero = c(0.0);
    let off_axis = (local[0] * local[0] + local[1] * local[1]).sqrt();
    let z = local[2];
    let (across, along) = (top - bottom, 2.0 * half);
    let square = 1.0 / (across * across + along * along);
    let part = (c(top) - off_axis) * c(across) + (c(half) - z) * c(along);
    let part = (part * c(square)).max(zero).min(c(1.0));
    let aside = off_axis - c(top) + c(across) * part;
    let below = z - c(half) + c(along) * part;
    let beyond = z.abs() - c(half);
    // The nearer end is the one on the same side of the middle.
    let end = z.choose_less(zero, c(bottom), c(top));
    let out = (off_axis - end).max(zero);
    let to_end = out * out + beyond * beyond;
    let nearest = to_end.min(aside * aside + below * below);
    aside.max(beyond).choose_less(zero, zero, nearest)
}

/// Whether a point is nearer than `reach` (m) to the farthest plane of a hull.
#[inline(always)]
fn is_within_planes<S: Simd>(simd: S, hull: &Hull, local: &Wide3<S>, reach: f32) -> bool {
    let mut farthest = Wide::splat(simd, f32::NEG_INFINITY);
    for (normal, offset) in hull.planes() {
        let normal = [single(normal.x), single(normal.y), single(normal.z)];
        let distance = dot(&Wide::splat3(simd, &normal), local);
        farthest = farthest.max(distance - Wide::splat(simd, single(*offset)));
    }
    farthest.any_less(Wide::splat(simd, reach))
}
