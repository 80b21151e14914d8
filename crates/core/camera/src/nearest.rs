//! The nearest surface of each pixel.

use std::ops::Range;

use nalgebra::{Isometry3, Point3, Vector3};

use crate::NEAR_M;
use crate::cast::{FAR, LANES, Lanes, Rays, single};
use crate::scene::{Body, Scene};
use crate::view::View;

/// The nearest surface of each pixel; rows are filled up to whole groups of lanes.
pub(crate) struct Nearest {
    /// Groups in a row.
    pub(crate) groups: usize,
    pub(crate) depth: Vec<Lanes>,
    /// Index of the body.
    pub(crate) body: Vec<Lanes>,
}

/// Index of the body in a pixel of [`Nearest`].
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it is an index, and f32 has all whole numbers up to 16 million"
)]
pub(crate) fn index_of(depth: f32, body: f32) -> Option<usize> {
    (depth < FAR).then_some(body as usize)
}

/// `values` in `groups` of lanes; the last one is filled up with zeros.
pub(crate) fn groups_of(mut values: Vec<f32>, groups: usize) -> Vec<Lanes> {
    values.resize(groups * LANES, 0.0);
    values.chunks_exact(LANES).map(Lanes::from).collect()
}

/// The nearest surfaces that `view` sees.
pub(crate) fn nearest(scene: &Scene, view: &View) -> Nearest {
    let (width, height) = (view.width as usize, view.height as usize);
    let groups = width.div_ceil(LANES);
    let mut nearest = Nearest {
        groups,
        depth: vec![Lanes::splat(FAR); groups * height],
        body: vec![Lanes::splat(0.0); groups * height],
    };
    let [columns, rows] = view.slopes();
    let columns = groups_of(columns, groups);
    for (index, body) in scene.bodies.iter().enumerate() {
        let Some([across, down]) = rectangle(view, body) else {
            continue;
        };
        let across = across.start / LANES..across.end.div_ceil(LANES);
        nearest.take(index, body, view, (across, &columns), (down, &rows));
    }
    nearest
}

impl Nearest {
    /// Adds the visible part of one body in a rectangle of groups and rows.
    fn take(
        &mut self,
        index: usize,
        body: &Body,
        view: &View,
        (across, columns): (Range<usize>, &[Lanes]),
        (down, rows): (Range<usize>, &[f32]),
    ) {
        // The direction of a ray is linear in column and row, in the frame of the body as well,
        // and its distance is the depth.
        let [right, below, ahead] = view.axes_in(&body.pose).map(|axis| axis.map(single));
        let eye = body
            .pose
            .inverse_transform_point(&Point3::from(view.pose.translation.vector));
        let origin = [eye.x, eye.y, eye.z].map(|x| Lanes::splat(single(x)));
        let right: [Lanes; 3] = right.map(Lanes::splat).into();
        // In lanes like the depth, so that one mask selects both.
        let index = Lanes::splat(index as f32);
        for row in down {
            let start = ahead + below * rows[row];
            let start: [Lanes; 3] = start.map(Lanes::splat).into();
            let line = row * self.groups;
            for group in across.clone() {
                let slope = columns[group];
                let direction = [
                    start[0] + right[0] * slope,
                    start[1] + right[1] * slope,
                    start[2] + right[2] * slope,
                ];
                let at = body.solid.cast(&Rays { origin, direction }, NEAR_M);
                let (depth, seen) = (&mut self.depth[line + group], &mut self.body[line + group]);
                // Strictly less: of two surfaces at the same distance the one with the lower number
                // is seen.
                let is_nearer = at.simd_lt(*depth) & at.simd_gt(Lanes::splat(NEAR_M));
                *depth = is_nearer.select(at, *depth);
                *seen = is_nearer.select(index, *seen);
            }
        }
    }
}

/// Columns and rows that a body can be seen in; `None` where it is behind the eye.
fn rectangle(view: &View, body: &Body) -> Option<[Range<usize>; 2]> {
    let size = [view.width as usize, view.height as usize];
    let to_view: Isometry3<f64> = view.pose.inverse() * body.pose;
    let near = f64::from(NEAR_M);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut behind = 0;
    for corner in 0..8 {
        let sign = |bit: usize| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let corner = body
            .half
            .component_mul(&Vector3::new(sign(0), sign(1), sign(2)));
        let at = to_view * Point3::from(corner);
        if at.z < near {
            behind += 1;
            continue;
        }
        for (axis, off) in [at.x, at.y].into_iter().enumerate() {
            let pixel = 0.5 * size[axis] as f64 + view.focal() * off / at.z;
            low[axis] = low[axis].min(pixel);
            high[axis] = high[axis].max(pixel);
        }
    }
    match behind {
        // A pixel more on each side: rays are of single precision.
        0 => Some([0, 1].map(|axis| {
            let (low, high) = (low[axis].floor() - 1.0, high[axis].ceil() + 1.0);
            whole(low, size[axis])..whole(high, size[axis])
        })),
        8 => None,
        // A corner behind the eye has no place in the picture that could bound the body.
        _ => Some(size.map(|count| 0..count)),
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates"
)]
fn whole(at: f64, most: usize) -> usize {
    (at as usize).min(most)
}
