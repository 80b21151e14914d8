//! Rays against shapes, eight at a time.
//!
//! Only the outside of a shape is visible: a ray from inside does not hit it. Distances are in
//! units of the ray's direction, which need not have length 1.

use cell_model::Shape;
use nalgebra::Vector3;
use wide::f32x8;

/// Eight numbers.
pub(crate) type Lanes = f32x8;
/// How many.
pub(crate) const LANES: usize = 8;
/// The distance of a ray that hits nothing.
pub(crate) const FAR: f32 = 1.0e9;

/// A shape in its own frame (m).
#[derive(Clone, Debug)]
pub(crate) enum Solid {
    /// Half its edges.
    Box([f32; 3]),
    /// Radius.
    Ball(f32),
    /// Radius and half the height, along z.
    Cylinder(f32, f32),
    /// Radius and half the height of the cylindrical part, along z.
    Capsule(f32, f32),
    /// Half the edges of all of it; centre and half the edges of each panel.
    Bin([f32; 3], [([f32; 3], [f32; 3]); 5]),
}

/// Eight rays.
#[derive(Clone, Copy)]
pub(crate) struct Rays {
    pub(crate) origin: [Lanes; 3],
    pub(crate) direction: [Lanes; 3],
}

impl Solid {
    /// The shape, and half the edges of a box around it (m).
    pub(crate) fn of(shape: &Shape) -> (Self, Vector3<f64>) {
        let halved = |size: Vector3<f64>| -> [f32; 3] { (0.5 * size).map(single).into() };
        match *shape {
            Shape::Box { size_m } => (
                Self::Box(halved(size_m.into())),
                0.5 * Vector3::from(size_m),
            ),
            Shape::Sphere { radius_m } => (Self::Ball(single(radius_m)), Vector3::repeat(radius_m)),
            Shape::Cylinder { radius_m, height_m } => (
                Self::Cylinder(single(radius_m), single(0.5 * height_m)),
                Vector3::new(radius_m, radius_m, 0.5 * height_m),
            ),
            Shape::Capsule { radius_m, height_m } => (
                Self::Capsule(single(radius_m), single(0.5 * height_m)),
                Vector3::new(radius_m, radius_m, 0.5 * height_m + radius_m),
            ),
            Shape::Bin { size_m, .. } => {
                let panels = shape.panels().map(|panels| {
                    panels.map(|panel| (panel.centre.map(single).into(), halved(panel.size)))
                });
                let whole = halved(size_m.into());
                let solid = panels.map_or(Self::Box(whole), |panels| Self::Bin(whole, panels));
                (solid, 0.5 * Vector3::from(size_m))
            }
        }
    }

    /// Distance along each ray to the outside of the shape; [`FAR`] where it is not hit. The panels
    /// of a bin are shapes of their own: one that is nearer than `from` hides no other one.
    pub(crate) fn cast(&self, rays: &Rays, from: f32) -> Lanes {
        match self {
            Self::Box(half) => cuboid(*half, rays),
            Self::Ball(radius) => ball(*radius, 0.0, rays),
            Self::Cylinder(radius, half) => {
                nearer(side(*radius, *half, rays), cap(*radius, *half, rays))
            }
            Self::Capsule(radius, half) => {
                let ends = nearer(ball(*radius, *half, rays), ball(*radius, -half, rays));
                nearer(side(*radius, *half, rays), ends)
            }
            Self::Bin(whole, panels) => bin(*whole, panels, rays, from),
        }
    }

    /// Directions out of the shape at points of its surface, of length 1.
    pub(crate) fn normals(&self, points: &[Lanes; 3]) -> [Lanes; 3] {
        let [x, y, z] = *points;
        match self {
            Self::Box(half) => face([0.0; 3], *half, points).1,
            Self::Ball(radius) => points.map(|off| off / splat(*radius)),
            Self::Cylinder(radius, half) => {
                // How far outside of the side, and of the caps: the larger is the surface.
                let beyond = (x * x + y * y).sqrt() - splat(*radius);
                let is_cap = (z.abs() - splat(*half)).simd_gt(beyond);
                let nothing = splat(0.0);
                [
                    is_cap.select(nothing, x / splat(*radius)),
                    is_cap.select(nothing, y / splat(*radius)),
                    is_cap.select(sign(z), nothing),
                ]
            }
            Self::Capsule(radius, half) => {
                let (low, high) = (splat(-half), splat(*half));
                let middle = z.simd_lt(low).select(low, z.simd_gt(high).select(high, z));
                [x, y, z - middle].map(|off| off / splat(*radius))
            }
            Self::Bin(_, panels) => {
                // Rounded points are on no panel exactly: that with the least distance was hit.
                let [(centre, half), rest @ ..] = panels;
                let (mut least, mut normal) = face(*centre, *half, points);
                for (centre, half) in rest {
                    let (beyond, other) = face(*centre, *half, points);
                    let is_less = beyond.simd_lt(least);
                    least = is_less.select(beyond, least);
                    normal = [0, 1, 2].map(|axis| is_less.select(other[axis], normal[axis]));
                }
                normal
            }
        }
    }
}

/// How far points are outside of a box along the axis where that is most, and the normal of the
/// face there.
#[inline]
fn face(centre: [f32; 3], half: [f32; 3], points: &[Lanes; 3]) -> (Lanes, [Lanes; 3]) {
    let from = [0, 1, 2].map(|axis| points[axis] - splat(centre[axis]));
    let off = [0, 1, 2].map(|axis| from[axis].abs() - splat(half[axis]));
    let is_y = off[1].simd_gt(off[0]);
    let most = is_y.select(off[1], off[0]);
    let is_z = off[2].simd_gt(most);
    let nothing = splat(0.0);
    let normal = [
        is_z.select(nothing, is_y.select(nothing, sign(from[0]))),
        is_z.select(nothing, is_y.select(sign(from[1]), nothing)),
        is_z.select(sign(from[2]), nothing),
    ];
    (is_z.select(off[2], most), normal)
}

/// -1 below zero, else 1.
#[inline]
fn sign(value: Lanes) -> Lanes {
    value.simd_lt(splat(0.0)).select(splat(-1.0), splat(1.0))
}

fn splat(value: f32) -> Lanes {
    Lanes::splat(value)
}

/// The smaller of each lane; `other` where one is not a number.
#[inline]
fn nearer(one: Lanes, other: Lanes) -> Lanes {
    one.simd_lt(other).select(one, other)
}

#[inline]
fn cuboid(half: [f32; 3], rays: &Rays) -> Lanes {
    let (enter, leave) = slabs(half, rays);
    let hit = enter.simd_le(leave) & enter.simd_gt(splat(0.0));
    hit.select(enter, splat(FAR))
}

/// Distances at which the rays enter and leave the three pairs of faces of a box.
#[inline]
fn slabs(half: [f32; 3], rays: &Rays) -> (Lanes, Lanes) {
    let (mut enter, mut leave) = (splat(-FAR), splat(FAR));
    for axis in 0..3 {
        let (origin, half) = (rays.origin[axis], splat(half[axis]));
        // For a ray along the faces the inverse is infinite. Between them both distances are then
        // infinite with opposite signs; beside them they have the same sign, which is a miss.
        let inverse = splat(1.0) / rays.direction[axis];
        let (low, high) = ((-half - origin) * inverse, (half - origin) * inverse);
        let is_forward = low.simd_lt(high);
        let (first, last) = (is_forward.select(low, high), is_forward.select(high, low));
        enter = first.simd_gt(enter).select(first, enter);
        leave = last.simd_lt(leave).select(last, leave);
    }
    (enter, leave)
}

#[inline]
fn bin(whole: [f32; 3], panels: &[([f32; 3], [f32; 3]); 5], rays: &Rays, from: f32) -> Lanes {
    let (enter, leave) = slabs(whole, rays);
    let mut nearest = splat(FAR);
    // From inside of the box around it panels can be hit as well.
    if !(enter.simd_le(leave) & leave.simd_gt(splat(0.0))).any() {
        return nearest;
    }
    for (centre, half) in panels {
        let [x, y, z] = rays.origin;
        let origin = [
            x - splat(centre[0]),
            y - splat(centre[1]),
            z - splat(centre[2]),
        ];
        let at = cuboid(*half, &Rays { origin, ..*rays });
        let at = at.simd_gt(splat(from)).select(at, splat(FAR));
        nearest = nearer(at, nearest);
    }
    nearest
}

/// A ball at `z` on the axis.
#[inline]
fn ball(radius: f32, z: f32, rays: &Rays) -> Lanes {
    let [ox, oy, oz] = rays.origin;
    let [dx, dy, dz] = rays.direction;
    let oz = oz - splat(z);
    let length = dx * dx + dy * dy + dz * dz;
    let middle = -(ox * dx + oy * dy + oz * dz) / length;
    // From the point nearest to the centre: differences of large squares would lose the digits.
    let (x, y, z) = (ox + middle * dx, oy + middle * dy, oz + middle * dz);
    let square = (splat(radius * radius) - (x * x + y * y + z * z)) / length;
    first(middle, square)
}

/// The side of a cylinder, without its ends.
#[inline]
fn side(radius: f32, half: f32, rays: &Rays) -> Lanes {
    let [ox, oy, oz] = rays.origin;
    let [dx, dy, dz] = rays.direction;
    let length = dx * dx + dy * dy;
    // A ray along the axis gives 0 / 0 here. Comparisons with that are false, which is a miss.
    let middle = -(ox * dx + oy * dy) / length;
    let (x, y) = (ox + middle * dx, oy + middle * dy);
    let square = (splat(radius * radius) - (x * x + y * y)) / length;
    let at = first(middle, square);
    let z = oz + at * dz;
    let is_between = z.simd_le(splat(half)) & z.simd_ge(splat(-half));
    is_between.select(at, splat(FAR))
}

/// The first of the two hits around `middle`, whose squared distance from it is `square`.
#[inline]
fn first(middle: Lanes, square: Lanes) -> Lanes {
    let is_hit = square.simd_gt(splat(0.0));
    let at = middle - is_hit.select(square, splat(0.0)).sqrt();
    (is_hit & at.simd_gt(splat(0.0))).select(at, splat(FAR))
}

/// The end of a cylinder that faces the ray.
#[inline]
fn cap(radius: f32, half: f32, rays: &Rays) -> Lanes {
    let [ox, oy, oz] = rays.origin;
    let [dx, dy, dz] = rays.direction;
    let end = dz.simd_lt(splat(0.0)).select(splat(half), splat(-half));
    // Infinite for a ray along the end: the comparison below is then false, which is a miss.
    let at = (end - oz) / dz;
    let (x, y) = (ox + at * dx, oy + at * dy);
    let hit = (x * x + y * y).simd_le(splat(radius * radius)) & at.simd_gt(splat(0.0));
    hit.select(at, splat(FAR))
}

/// The nearest number of single precision.
#[allow(
    clippy::cast_possible_truncation,
    reason = "it rounds to the nearest number"
)]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}
