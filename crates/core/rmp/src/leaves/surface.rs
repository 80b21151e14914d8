//! Distance and outward normal of four points from one obstacle. All lanes have the same
//! shape, so a branch on the shape costs no mask (ADR 0020).
#![allow(
    clippy::inline_always,
    reason = "lanes are compiled for the instruction set of the function they are inlined into"
)]

use crate::hull::Hull;
use crate::lanes::Lanes;
use crate::lanes::wide3::{self, Wide3, dot};
use crate::obstacles::packed::Block;
use crate::shape::Core;

/// Signed distance (m) to the core grown by its radius, and the normal, base frame. The box
/// around `core` is in lane `lane` of `block`.
#[inline(always)]
pub(crate) fn surface<L: Lanes>(
    core: &Core,
    block: &Block,
    lane: usize,
    position: &Wide3<L>,
) -> (L, Wide3<L>) {
    let row = |row: usize| L::splat(block.0[row][lane]);
    let offset = wide3::sub(position, &[row(0), row(1), row(2)]);
    let axes = [
        [row(3), row(4), row(5)],
        [row(6), row(7), row(8)],
        [row(9), row(10), row(11)],
    ];
    // Distances are computed in the frame of the box, the normal is turned back at the end.
    let local = [
        dot(&axes[0], &offset),
        dot(&axes[1], &offset),
        dot(&axes[2], &offset),
    ];
    let (distance, normal) = match core {
        Core::Box(_) => cuboid(&[row(12), row(13), row(14)], &local),
        Core::Frustum {
            bottom,
            top,
            half_height,
        } => frustum([*bottom, *top, *half_height], &local),
        Core::Hull(hull) => faces(hull, &local),
    };
    let turned = wide3::add(
        &wide3::add(
            &wide3::scale(normal[0], &axes[0]),
            &wide3::scale(normal[1], &axes[1]),
        ),
        &wide3::scale(normal[2], &axes[2]),
    );
    (distance - row(15), turned)
}

#[inline(always)]
fn cuboid<L: Lanes>(half: &Wide3<L>, local: &Wide3<L>) -> (L, Wide3<L>) {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let beyond = [
        local[0].abs() - half[0],
        local[1].abs() - half[1],
        local[2].abs() - half[2],
    ];
    let out = [
        beyond[0].max(zero),
        beyond[1].max(zero),
        beyond[2].max(zero),
    ];
    let squared = dot(&out, &out);
    let inside = squared.le(zero);
    let outer = squared.sqrt();
    let deepest = beyond[0].max(beyond[1]).max(beyond[2]);
    // Inside the box `outer` is zero: dividing by one keeps the unused normal finite.
    let inverse = one / inside.select(one, outer);
    let mut normal = wide3::scale(inverse, &out);
    if inside.any() {
        // The face of least depth; the first of equals.
        let x = beyond[0].same(deepest).select(one, zero);
        let y = beyond[1].same(deepest).select(one, zero) * (one - x);
        let z = one - x - y;
        normal = [
            inside.select(x, normal[0]),
            inside.select(y, normal[1]),
            inside.select(z, normal[2]),
        ];
    }
    let signed = [
        normal[0].with_sign_of(local[0]),
        normal[1].with_sign_of(local[1]),
        normal[2].with_sign_of(local[2]),
    ];
    (inside.select(deepest, outer), signed)
}

/// In the plane through the axis and the point, as [`crate::Obstacle::distance`].
#[inline(always)]
fn frustum<L: Lanes>([bottom, top, half]: [f64; 3], local: &Wide3<L>) -> (L, Wide3<L>) {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let height = L::splat(half);
    let off_axis = (local[0] * local[0] + local[1] * local[1]).sqrt();
    let on_axis = off_axis.le(zero);
    let inverse = one / on_axis.select(one, off_axis);
    // On the axis all directions are equally near: x is taken.
    let outward = [on_axis.select(one, local[0] * inverse), local[1] * inverse];
    let z = local[2];
    let end = zero.gt(z).select(L::splat(bottom), L::splat(top));
    let to_end = [off_axis - off_axis.min(end), z.abs() - height];
    let (across, along) = (top - bottom, 2.0 * half);
    let square = 1.0 / (across * across + along * along);
    let part = (L::splat(top) - off_axis) * L::splat(across) + (height - z) * L::splat(along);
    let part = (part * L::splat(square)).max(zero).min(one);
    let to_side = [
        off_axis - L::splat(top) + L::splat(across) * part,
        z - height + L::splat(along) * part,
    ];
    let squares = [
        to_end[0] * to_end[0] + to_end[1] * to_end[1],
        to_side[0] * to_side[0] + to_side[1] * to_side[1],
    ];
    let by_side = squares[1].le(squares[0]);
    let distance = by_side.select(squares[1], squares[0]).sqrt();
    let touches = distance.le(zero);
    let inside = zero.gt(to_side[0].max(to_end[1]));
    let sign = inside.select(L::splat(-1.0), one);
    let scale = sign / touches.select(one, distance);
    let slope = square.sqrt();
    let radial = by_side.select(to_side[0], to_end[0]) * scale;
    let axial = by_side.select(to_side[1], to_end[1] * one.with_sign_of(z)) * scale;
    // On the surface itself the normal of the side is taken.
    let radial = touches.select(L::splat(along * slope), radial);
    let axial = touches.select(L::splat(-across * slope), axial);
    let normal = [radial * outward[0], radial * outward[1], axial];
    (sign * distance, normal)
}

/// The farthest of the planes.
#[inline(always)]
fn faces<L: Lanes>(hull: &Hull, local: &Wide3<L>) -> (L, Wide3<L>) {
    let zero = L::splat(0.0);
    let local = wide3::add(local, &wide3::splat(&hull.middle()));
    let (mut farthest, mut normal) = (L::splat(f64::NEG_INFINITY), [zero; 3]);
    for (face, offset) in hull.planes() {
        let face = wide3::splat(face);
        let distance = dot(&face, &local) - L::splat(*offset);
        let is_farther = distance.gt(farthest);
        farthest = distance.max(farthest);
        normal = [
            is_farther.select(face[0], normal[0]),
            is_farther.select(face[1], normal[1]),
            is_farther.select(face[2], normal[2]),
        ];
    }
    (farthest, normal)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

    use super::*;
    use crate::lanes::Scalar;
    use crate::{Obstacle, ObstacleSet};

    fn shapes() -> Vec<Obstacle> {
        let turn = UnitQuaternion::from_euler_angles(0.4, -0.7, 1.2);
        let pose = Isometry3::from_parts(Vector3::new(0.1, -0.2, 0.3).into(), turn);
        let corner = |i: u8| {
            let side = |bit: u8| if i >> bit & 1 == 1 { 0.3 } else { -0.1 };
            Vector3::new(side(0), side(1), 0.5 * side(2))
        };
        let corners: Vec<_> = (0..8).map(corner).collect();
        vec![
            Obstacle::cuboid(pose, Vector3::new(0.2, 0.3, 0.1)),
            Obstacle::cylinder(pose, 0.15, 0.4),
            Obstacle::cone(pose, 0.2, 0.3),
            Obstacle {
                radius: 0.03,
                ..Obstacle::frustum(pose, 0.1, 0.25, 0.2)
            },
            Obstacle::hull(pose, &corners).unwrap(),
        ]
    }

    fn at(obstacle: &Obstacle, point: Point3<f64>) -> (f64, Vector3<f64>) {
        let mut set = ObstacleSet::with_capacity(1);
        set.add(obstacle.clone()).unwrap();
        let packed = set.packed();
        let (distance, normal) = surface::<Scalar>(
            packed.core(0),
            &packed.blocks()[0],
            0,
            &wide3::splat(&point.coords),
        );
        let normal = normal.map(|lanes| lanes.to_array()[0]);
        (distance.to_array()[0], Vector3::from(normal))
    }

    #[test]
    fn the_kernel_has_the_distance_of_the_shape_and_its_gradient_as_normal() {
        const STEP: f64 = 1e-6;
        for obstacle in shapes() {
            let mut smooth = 0;
            for step in 0..4000_u32 {
                // Points of a coarse lattice, shifted off every symmetry.
                let along = |n: u32| 0.1 * f64::from(step / n % 16) - 0.713;
                let point = Point3::new(along(1), along(16), along(256));
                let (distance, normal) = at(&obstacle, point);
                let exact = obstacle.distance(&point);
                let what = format!("{:?} at {point}: {distance} {exact}", obstacle.core);
                assert!((distance - exact).abs() < 1e-12, "{what}");
                assert!((normal.norm() - 1.0).abs() < 1e-9, "{what} {normal}");
                let gradient = Vector3::from_fn(|axis, _| {
                    let by = Vector3::ith(axis, STEP);
                    let (above, below) = (point + by, point - by);
                    (obstacle.distance(&above) - obstacle.distance(&below)) / (2.0 * STEP)
                });
                // The gradient jumps where two faces are equally near.
                smooth += u32::from((gradient - normal).norm() < 1e-4);
            }
            assert!(smooth > 3950, "{:?}: {smooth}", obstacle.core);
        }
    }

    #[test]
    fn on_the_axis_and_on_the_surface_there_is_a_normal() {
        let cone = Obstacle::cone(Isometry3::identity(), 0.2, 0.4);
        for point in [
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 0.2],
            [0.0, 0.0, 0.7],
            [0.2, 0.0, -0.2],
            [0.1, 0.0, 0.0],
        ] {
            let (distance, normal) = at(&cone, point.into());
            assert!(
                distance.is_finite() && (normal.norm() - 1.0).abs() < 1e-9,
                "{point:?}"
            );
        }
    }
}
