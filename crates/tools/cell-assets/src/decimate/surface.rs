//! A triangle mesh whose edges can be collapsed.

use std::collections::BTreeMap;

use super::quadric::Quadric;
use crate::mesh::{ColourMesh, Vec3, area_normal, as_index, cross, dot, length, sub, unit};

/// Weight of an open border against the surface itself.
const BORDER_WEIGHT: f64 = 10.0;
/// A collapse may not turn a triangle by more than this cosine.
const TURN_COSINE: f64 = 0.3;
/// A triangle thinner than this (twice its area over its longest side squared)
/// is a sliver: it has no reliable normal.
const SLIVER: f64 = 1e-3;

pub(super) struct Surface {
    positions: Vec<Vec3>,
    quadrics: Vec<Quadric>,
    border: Vec<bool>,
    /// Raised whenever a point moves or goes.
    ages: Vec<u32>,
    /// Triangles; those that went are none.
    triangles: Vec<Option<[u32; 3]>>,
    /// Triangles around each point; may list some that went.
    fans: Vec<Vec<u32>>,
    count: usize,
}

impl Surface {
    pub(super) fn new(mesh: &ColourMesh) -> Self {
        let points = mesh.positions.len();
        let mut surface = Self {
            positions: mesh.positions.clone(),
            quadrics: vec![Quadric::default(); points],
            border: vec![false; points],
            ages: vec![0; points],
            triangles: mesh.triangles.iter().copied().map(Some).collect(),
            fans: vec![Vec::new(); points],
            count: mesh.triangles.len(),
        };
        let mut edges: BTreeMap<(u32, u32), (usize, usize)> = BTreeMap::new();
        for (place, triangle) in mesh.triangles.iter().enumerate() {
            let corners = mesh.corners(*triangle);
            let normal = area_normal(corners);
            let plane = Quadric::plane(unit(normal), corners[0], length(normal) / 2.0);
            for (corner, next) in sides(*triangle) {
                surface.fans[corner as usize].push(as_index(place));
                surface.add_quadric(corner, &plane);
                let edge = edges.entry((corner.min(next), corner.max(next)));
                edge.or_insert((0, place)).0 += 1;
            }
        }
        for ((a, b), (count, place)) in edges {
            // Not only open edges: where three sheets meet, none may leave.
            if count != 2 {
                surface.hold_border(a, b, mesh.corners(mesh.triangles[place]));
            }
        }
        surface
    }

    fn add_quadric(&mut self, point: u32, quadric: &Quadric) {
        let own = &mut self.quadrics[point as usize];
        *own = own.plus(quadric);
    }

    /// A plane through the border, square to its triangle, holds it in place.
    fn hold_border(&mut self, a: u32, b: u32, corners: [Vec3; 3]) {
        let along = sub(self.position(b), self.position(a));
        let normal = unit(cross(along, area_normal(corners)));
        let weight = BORDER_WEIGHT * dot(along, along);
        let plane = Quadric::plane(normal, self.position(a), weight);
        for point in [a, b] {
            self.border[point as usize] = true;
            self.add_quadric(point, &plane);
        }
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.count
    }

    pub(super) fn position(&self, point: u32) -> Vec3 {
        self.positions[point as usize]
    }

    pub(super) fn quadric(&self, point: u32) -> &Quadric {
        &self.quadrics[point as usize]
    }

    pub(super) fn is_border(&self, point: u32) -> bool {
        self.border[point as usize]
    }

    pub(super) fn age(&self, point: u32) -> u32 {
        self.ages[point as usize]
    }

    /// Every edge once, smaller point first, in order.
    pub(super) fn edges(&self) -> Vec<(u32, u32)> {
        let mut edges: Vec<_> = self
            .triangles
            .iter()
            .flatten()
            .flat_map(|triangle| sides(*triangle))
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Triangles around a point.
    fn fan(&self, point: u32) -> impl Iterator<Item = [u32; 3]> + '_ {
        let places = self.fans[point as usize].iter();
        places.filter_map(|place| self.triangles[*place as usize])
    }

    /// Points that share an edge with `point`, in order.
    pub(super) fn neighbours(&self, point: u32) -> Vec<u32> {
        let mut all: Vec<u32> = self.fan(point).flatten().filter(|p| *p != point).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Whether merging `a` and `b` at `at` leaves a surface of the same kind
    /// with no triangle turned over.
    pub(super) fn allows(&self, a: u32, b: u32, at: Vec3) -> bool {
        let shared = self.fan(a).filter(|t| t.contains(&b)).count();
        if !matches!(shared, 1 | 2) {
            return false;
        }
        // Two borders joined across the surface would pinch it.
        if shared == 2 && self.is_border(a) && self.is_border(b) {
            return false;
        }
        let (around_a, around_b) = (self.neighbours(a), self.neighbours(b));
        let common = around_a.iter().filter(|p| around_b.contains(p)).count();
        // Without a and b themselves.
        let ring = around_a.len() + around_b.len() - common - 2;
        // The link condition: with more common neighbours than triangles the collapse would join
        // two sheets; without other neighbours it would flatten a tetrahedron or remove a triangle.
        if common != shared || ring <= shared {
            return false;
        }
        self.keeps_faces(a, b, at) && self.keeps_faces(b, a, at)
    }

    /// No triangle at `moved` that stays is turned over or made a sliver.
    fn keeps_faces(&self, moved: u32, other: u32, at: Vec3) -> bool {
        self.fan(moved)
            .filter(|t| !t.contains(&other))
            .all(|triangle| {
                let old = triangle.map(|p| self.position(p));
                let new = triangle.map(|p| if p == moved { at } else { self.position(p) });
                let (before, after) = (area_normal(old), area_normal(new));
                if is_sliver(before, old) {
                    // It may continue as one, but its direction says nothing.
                    return true;
                }
                !is_sliver(after, new) && dot(unit(before), unit(after)) > TURN_COSINE
            })
    }

    /// Merges `b` into `a`, which moves to `at`.
    pub(super) fn collapse(&mut self, a: u32, b: u32, at: Vec3) {
        let moved = std::mem::take(&mut self.fans[b as usize]);
        for place in moved {
            let Some(triangle) = &mut self.triangles[place as usize] else {
                continue;
            };
            if triangle.contains(&a) {
                self.triangles[place as usize] = None;
                self.count -= 1;
            } else {
                *triangle = triangle.map(|p| if p == b { a } else { p });
                self.fans[a as usize].push(place);
            }
        }
        let triangles = &self.triangles;
        self.fans[a as usize].retain(|place| triangles[*place as usize].is_some());
        let quadric = self.quadrics[b as usize];
        self.add_quadric(a, &quadric);
        self.positions[a as usize] = at;
        self.border[a as usize] |= self.border[b as usize];
        self.ages[a as usize] += 1;
        self.ages[b as usize] += 1;
    }

    /// The mesh that is left, without unused points.
    pub(super) fn into_mesh(self, colour: [f32; 3]) -> ColourMesh {
        let mut places = BTreeMap::new();
        let mut mesh = ColourMesh {
            colour,
            ..ColourMesh::default()
        };
        for triangle in self.triangles.iter().flatten() {
            mesh.triangles.push(triangle.map(|point| {
                *places.entry(point).or_insert_with(|| {
                    mesh.positions.push(self.positions[point as usize]);
                    as_index(mesh.positions.len() - 1)
                })
            }));
        }
        mesh
    }
}

fn sides([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

fn is_sliver(area_normal: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    let square = |v: Vec3| dot(v, v);
    let longest = square(sub(a, b))
        .max(square(sub(b, c)))
        .max(square(sub(c, a)));
    // Negated, so that NaN counts as a sliver.
    !(length(area_normal) > SLIVER * longest)
}
