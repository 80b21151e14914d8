//! Normals made again: smooth over a curved face, sharp at an edge.

use std::collections::HashMap;

use crate::mesh::{ColourMesh, Vec3, add, area_normal, as_index, dot, unit};

/// Triangles whose normals differ by less than this are one smooth face:
/// cosine of 40 degrees.
const CREASE_COSINE: f64 = 0.766;

/// A mesh with one normal per point, ready to draw.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ShadedMesh {
    /// sRGB, each in 0 to 1.
    pub colour: [f32; 3],
    /// Points, metres; as many as `normals`.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Indices of points, three to a triangle.
    pub indices: Vec<u32>,
}

/// Computes normals; a point at a crease becomes one point for each side.
pub fn shade(mesh: &ColourMesh) -> ShadedMesh {
    let weighted: Vec<Vec3> = mesh
        .triangles
        .iter()
        .map(|t| area_normal(mesh.corners(*t)))
        .collect();
    let mut fans: Vec<Vec<usize>> = vec![Vec::new(); mesh.positions.len()];
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        for corner in triangle {
            fans[*corner as usize].push(face);
        }
    }
    let mut shaded = ShadedMesh {
        colour: mesh.colour,
        ..ShadedMesh::default()
    };
    let mut place = HashMap::new();
    for (point, fan) in fans.iter().enumerate() {
        for group in smooth_groups(fan, &weighted) {
            let sum = group
                .iter()
                .fold([0.0; 3], |sum, face| add(sum, weighted[*face]));
            // The sum has no direction where faces cancel each other; then the first one decides.
            let first = group.first().map_or([0.0; 3], |face| weighted[*face]);
            let place_of_group = shaded.positions.len();
            shaded.positions.push(narrow(mesh.positions[point]));
            shaded.normals.push(narrow(normal(sum, first)));
            for face in group {
                place.insert((point, face), as_index(place_of_group));
            }
        }
    }
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        for corner in triangle {
            shaded.indices.extend(place.get(&(*corner as usize, face)));
        }
    }
    shaded
}

/// A unit vector, whatever the triangles are like.
fn normal(sum: Vec3, first: Vec3) -> Vec3 {
    [sum, first]
        .into_iter()
        .map(unit)
        .find(|n| dot(*n, *n) > 0.5)
        .unwrap_or([0.0, 0.0, 1.0])
}

/// Faces around one point, split where neighbours bend more than the crease.
fn smooth_groups(fan: &[usize], weighted: &[Vec3]) -> Vec<Vec<usize>> {
    let units: Vec<Vec3> = fan.iter().map(|face| unit(weighted[*face])).collect();
    let mut open: Vec<usize> = (0..fan.len()).collect();
    let mut groups = Vec::new();
    while let Some(seed) = open.first().copied() {
        let mut group = vec![seed];
        open.remove(0);
        let mut next = 0;
        while next < group.len() {
            let here = units[group[next]];
            let (near, far) = open
                .iter()
                .partition::<Vec<usize>, _>(|other| dot(here, units[**other]) > CREASE_COSINE);
            group.extend(near);
            open = far;
            next += 1;
        }
        groups.push(group.into_iter().map(|place| fan[place]).collect());
    }
    groups
}

#[expect(clippy::cast_possible_truncation, reason = "drawing needs no more")]
fn narrow(value: Vec3) -> [f32; 3] {
    value.map(|c| c as f32)
}
