//! Light and shadow of each pixel.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use crate::cast::{FAR, LANES, Lanes, Rays, single};
use crate::light::Light;
use crate::nearest::{Nearest, groups_of, index_of};
use crate::scene::{Body, Scene};
use crate::view::View;

/// Distance from a surface to the origin of its shadow ray (m).
const OFF_SURFACE_M: f32 = 1.0e-3;
/// Nothing farther away throws a shadow (m).
const SHADOW_M: f32 = 3.0;
/// Rows of a block, which has [`LANES`] columns: few bodies shade one block.
const ROWS: usize = 8;

/// A body as light meets it, in single precision.
struct Shaded<'a> {
    body: &'a Body,
    /// From its frame into the world.
    turn: Matrix3<f32>,
    at: Vector3<f32>,
    radius: f32,
    /// Its centre in [`Axes`].
    centre: Vector3<f32>,
    /// Towards the light, in its frame.
    light: [Lanes; 3],
}

/// Rows: two directions across the light, and the one to it.
type Axes = Matrix3<f32>;

/// A picture being coloured.
struct Shading<'a> {
    bodies: Vec<Shaded<'a>>,
    nearest: &'a Nearest,
    light: &'a Light,
    axes: Axes,
    eye: Vector3<f32>,
    /// Axes of the view: right, down, ahead.
    view: [Vector3<f32>; 3],
    /// Slopes of columns, in groups.
    columns: Vec<Lanes>,
    /// Slopes of rows.
    rows: Vec<f32>,
}

/// The surfaces in one row of a block. Masks have lanes of ones or of zeros.
#[derive(Clone, Copy)]
struct Row {
    /// Origins of shadow rays.
    points: [Lanes; 3],
    /// Cosine to the light.
    facing: Lanes,
    /// Light from everywhere.
    ambient: Lanes,
    colour: [Lanes; 3],
    /// Mask: whether anything is seen.
    seen: Lanes,
    /// Mask: whether the light reaches it.
    lit: Lanes,
}

/// Bounds of the lit points of a block, along [`Axes`].
struct Bounds {
    low: [Lanes; 3],
    high: [Lanes; 3],
}

/// Red, green and blue of each pixel.
pub(crate) fn shade(scene: &Scene, view: &View, light: &Light, nearest: &Nearest) -> Vec<u8> {
    let shading = Shading::new(scene, view, light, nearest);
    let (width, height) = (view.width as usize, view.height as usize);
    let mut rgb = vec![0; 3 * width * height];
    for top in (0..height).step_by(ROWS) {
        for group in 0..nearest.groups {
            let rows = top..(top + ROWS).min(height);
            let lanes = LANES.min(width - group * LANES);
            for (row, seen) in rows.clone().zip(shading.block(rows, group)) {
                let first = row * width + group * LANES;
                let pixels = &mut rgb[3 * first..3 * (first + lanes)];
                let [red, green, blue] = shading.colours(&seen);
                for (lane, pixel) in pixels.chunks_exact_mut(3).enumerate() {
                    pixel.copy_from_slice(&[red[lane], green[lane], blue[lane]].map(level));
                }
            }
        }
    }
    rgb
}

impl<'a> Shading<'a> {
    fn new(scene: &'a Scene, view: &View, light: &'a Light, nearest: &'a Nearest) -> Self {
        let along = light.direction;
        // Any direction that is not along the light will do.
        let other = if along.z.abs() < 0.9 {
            Vector3::z()
        } else {
            Vector3::x()
        };
        let across = along.cross(&other).normalize();
        let axes = [across, along.cross(&across), along].map(|axis| axis.map(single));
        let axes = Matrix3::from_columns(&axes).transpose();
        let turn = view.pose.rotation;
        let [columns, rows] = view.slopes();
        Self {
            bodies: scene
                .bodies
                .iter()
                .map(|body| Shaded::new(body, &axes, light))
                .collect(),
            nearest,
            light,
            axes,
            eye: view.pose.translation.vector.map(single),
            view: [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| (turn * axis).map(single)),
            columns: groups_of(columns, nearest.groups),
            rows,
        }
    }

    /// The rows of a block of pixels, with its shadows.
    fn block(&self, rows: Range<usize>, group: usize) -> Vec<Row> {
        let mut bounds = Bounds {
            low: [Lanes::splat(f32::INFINITY); 3],
            high: [Lanes::splat(f32::NEG_INFINITY); 3],
        };
        let mut seen: Vec<Row> = rows.map(|row| self.row(row, group, &mut bounds)).collect();
        if !seen.iter().any(|row| row.lit.any()) {
            return seen;
        }
        let (low, high) = bounds.ends();
        for body in self
            .bodies
            .iter()
            .filter(|body| body.may_shade(&low, &high))
        {
            for row in seen.iter_mut().filter(|row| row.lit.any()) {
                row.lit = body.shades(&row.points).select(Lanes::splat(0.0), row.lit);
            }
        }
        seen
    }

    fn row(&self, row: usize, group: usize, bounds: &mut Bounds) -> Row {
        let nothing = Lanes::splat(0.0);
        let at = row * self.nearest.groups + group;
        let (depth, index) = (self.nearest.depth[at], self.nearest.body[at]);
        let seen = depth.simd_lt(Lanes::splat(FAR));
        let mut all = Row {
            points: [nothing; 3],
            facing: nothing,
            ambient: nothing,
            colour: [nothing; 3],
            seen,
            lit: nothing,
        };
        let mut left = seen.to_bitmask();
        if left == 0 {
            return all;
        }
        let points = self.points(depth, self.columns[group], self.rows[row]);
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            // All lanes of a body at a time, since neighbouring pixels mostly show the same body.
            let mine = index.simd_eq(Lanes::splat(index.as_array()[lane])) & seen;
            left &= !mine.to_bitmask();
            let Some(body) =
                index_of(0.0, index.as_array()[lane]).and_then(|index| self.bodies.get(index))
            else {
                continue;
            };
            let normal = body.normals(&points);
            let facing = dot(&row_of(&self.axes, 2), &normal);
            let (above, below) = (self.light.from_above, self.light.from_below);
            let up = Lanes::splat(0.5) + Lanes::splat(0.5) * normal[2];
            let ambient = Lanes::splat(below) + Lanes::splat(above - below) * up;
            all.ambient = mine.select(ambient, all.ambient);
            all.facing = mine.select(facing, all.facing);
            for axis in 0..3 {
                let point = points[axis] + normal[axis] * Lanes::splat(OFF_SURFACE_M);
                all.points[axis] = mine.select(point, all.points[axis]);
                all.colour[axis] =
                    mine.select(Lanes::splat(body.body.colour[axis]), all.colour[axis]);
            }
        }
        all.lit = all.facing.simd_gt(nothing) & seen;
        bounds.take(&self.axes, &all);
        all
    }

    /// Points in the world at a depth along the rays of eight columns.
    fn points(&self, depth: Lanes, column: Lanes, row: f32) -> [Lanes; 3] {
        let [right, down, ahead] = &self.view;
        let start = ahead + down * row;
        [0, 1, 2].map(|axis| {
            let direction = Lanes::splat(start[axis]) + Lanes::splat(right[axis]) * column;
            Lanes::splat(self.eye[axis]) + direction * depth
        })
    }

    /// Red, green and blue of eight pixels.
    fn colours(&self, row: &Row) -> [[f32; LANES]; 3] {
        let nothing = Lanes::splat(0.0);
        let direct = row
            .lit
            .select(Lanes::splat(self.light.direct) * row.facing, nothing);
        let strength = row.ambient + direct;
        [0, 1, 2].map(|channel| {
            let background = Lanes::splat(self.light.background[channel]);
            row.seen
                .select(row.colour[channel] * strength, background)
                .to_array()
        })
    }
}

impl Bounds {
    fn take(&mut self, axes: &Axes, row: &Row) {
        for axis in 0..3 {
            let place = dot(&row_of(axes, axis), &row.points);
            let (low, high) = (&mut self.low[axis], &mut self.high[axis]);
            *low = (place.simd_lt(*low) & row.lit).select(place, *low);
            *high = (place.simd_gt(*high) & row.lit).select(place, *high);
        }
    }

    /// Over all lanes.
    fn ends(&self) -> (Vector3<f32>, Vector3<f32>) {
        let fold = |lanes: &Lanes, better: fn(f32, f32) -> bool| {
            let lanes = lanes.to_array().into_iter();
            lanes.reduce(|one, other| if better(other, one) { other } else { one })
        };
        let low =
            [0, 1, 2].map(|axis| fold(&self.low[axis], |one, other| one < other).unwrap_or(0.0));
        let high =
            [0, 1, 2].map(|axis| fold(&self.high[axis], |one, other| one > other).unwrap_or(0.0));
        (low.into(), high.into())
    }
}

fn row_of(axes: &Axes, row: usize) -> [Lanes; 3] {
    [0, 1, 2].map(|column| Lanes::splat(axes[(row, column)]))
}

fn dot(one: &[Lanes; 3], other: &[Lanes; 3]) -> Lanes {
    one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
}

impl<'a> Shaded<'a> {
    fn new(body: &'a Body, axes: &Axes, light: &Light) -> Self {
        let at = body.pose.translation.vector.map(single);
        let towards = body.pose.rotation.inverse() * light.direction;
        Self {
            body,
            turn: body.pose.rotation.to_rotation_matrix().matrix().map(single),
            at,
            radius: single(body.half.norm()),
            centre: axes * at,
            light: towards.map(single).map(Lanes::splat).into(),
        }
    }

    /// Points of the world in its frame.
    fn local(&self, points: &[Lanes; 3]) -> [Lanes; 3] {
        let off = [0, 1, 2].map(|axis| points[axis] - Lanes::splat(self.at[axis]));
        [0, 1, 2].map(|axis| dot(&self.axis(axis), &off))
    }

    /// An axis of its frame in the world.
    fn axis(&self, axis: usize) -> [Lanes; 3] {
        [0, 1, 2].map(|row| Lanes::splat(self.turn[(row, axis)]))
    }

    /// Normals in the world at points of its surface.
    fn normals(&self, points: &[Lanes; 3]) -> [Lanes; 3] {
        let local = self.body.solid.normals(&self.local(points));
        [0, 1, 2].map(|row| dot(&row_of(&self.turn, row), &local))
    }

    /// Whether the ball around the body is between the light and any point from `low` to `high`.
    fn may_shade(&self, low: &Vector3<f32>, high: &Vector3<f32>) -> bool {
        let (before, beyond) = (
            self.centre.add_scalar(-self.radius),
            self.centre.add_scalar(self.radius),
        );
        (0..2).all(|axis| beyond[axis] >= low[axis] && before[axis] <= high[axis])
            && beyond.z >= low.z
    }

    /// Mask of the points that the body shades.
    fn shades(&self, points: &[Lanes; 3]) -> Lanes {
        let origin = self.local(points);
        let at = self.body.solid.cast(
            &Rays {
                origin,
                direction: self.light,
            },
            0.0,
        );
        at.simd_lt(Lanes::splat(SHADOW_M))
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it is from 0 to 255"
)]
fn level(channel: f32) -> u8 {
    (255.0 * channel.clamp(0.0, 1.0) + 0.5) as u8
}
