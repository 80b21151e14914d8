//! Triangles of one colour.

use std::collections::{BTreeSet, HashMap};

/// Points nearer than this are one point, metres.
const WELD: f64 = 1e-6;

/// A point or direction, metres.
pub type Vec3 = [f64; 3];

/// Triangles of one colour.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ColourMesh {
    /// sRGB, each in 0 to 1.
    pub colour: [f32; 3],
    /// Points, metres.
    pub positions: Vec<Vec3>,
    /// Indices into `positions`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl ColourMesh {
    /// The same surface with points that coincide made one, and without
    /// triangles that have no area or come twice.
    pub fn welded(&self) -> Self {
        let mut places = HashMap::new();
        let mut positions = Vec::new();
        let mut place = Vec::with_capacity(self.positions.len());
        for position in &self.positions {
            #[expect(clippy::cast_possible_truncation, reason = "saturates, by intent")]
            let key = position.map(|c| (c / WELD).round() as i64);
            place.push(*places.entry(key).or_insert_with(|| {
                positions.push(*position);
                as_index(positions.len() - 1)
            }));
        }
        let mut seen = BTreeSet::new();
        let mut triangles = Vec::with_capacity(self.triangles.len());
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|corner| place[corner as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            // Rotated, not sorted: sorting would lose the side to which a triangle faces.
            let first = if a < b && a < c {
                [a, b, c]
            } else if b < c {
                [b, c, a]
            } else {
                [c, a, b]
            };
            if seen.insert(first) {
                triangles.push(first);
            }
        }
        Self {
            colour: self.colour,
            positions,
            triangles,
        }
    }

    /// Turns the mesh by half a turn about Z.
    pub fn half_turn(&mut self) {
        for position in &mut self.positions {
            *position = [-position[0], -position[1], position[2]];
        }
    }

    /// Corners of a triangle.
    pub fn corners(&self, triangle: [u32; 3]) -> [Vec3; 3] {
        triangle.map(|corner| self.positions[corner as usize])
    }
}

/// An index as stored. Files are limited to far below 2^32 points.
pub(crate) fn as_index(place: usize) -> u32 {
    u32::try_from(place).unwrap_or(u32::MAX)
}

pub(crate) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn scale(a: Vec3, by: f64) -> Vec3 {
    a.map(|c| c * by)
}

pub(crate) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(crate) fn length(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

/// Normal of a triangle with the length of twice its area.
pub(crate) fn area_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    cross(sub(b, a), sub(c, a))
}

/// Unit vector along `a`, or zero where it has no direction.
pub(crate) fn unit(a: Vec3) -> Vec3 {
    let length = length(a);
    if length > 0.0 {
        scale(a, 1.0 / length)
    } else {
        [0.0; 3]
    }
}
