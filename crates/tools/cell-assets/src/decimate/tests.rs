use std::collections::BTreeMap;

use super::*;
use crate::mesh::{as_index, cross, dot};

/// A grid of `n` by `n` squares, 1 m wide, in the plane spanned by `u` and `v`.
fn sheet(n: u32, origin: Vec3, u: Vec3, v: Vec3) -> ColourMesh {
    let mut mesh = ColourMesh::default();
    for row in 0..=n {
        for column in 0..=n {
            let (s, t) = (
                f64::from(column) / f64::from(n),
                f64::from(row) / f64::from(n),
            );
            mesh.positions
                .push(add(origin, add(scale(u, s), scale(v, t))));
        }
    }
    for row in 0..n {
        for column in 0..n {
            let a = row * (n + 1) + column;
            let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A closed cube of side 1 m.
fn cube(n: u32) -> ColourMesh {
    let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut mesh = ColourMesh::default();
    for side in [
        sheet(n, o, y, x),
        sheet(n, o, x, z),
        sheet(n, o, z, y),
        sheet(n, z, x, y),
        sheet(n, y, z, x),
        sheet(n, x, y, z),
    ] {
        let base = as_index(mesh.positions.len());
        mesh.positions.extend(side.positions);
        mesh.triangles
            .extend(side.triangles.iter().map(|t| t.map(|p| p + base)));
    }
    mesh.welded()
}

/// A closed sphere of radius 1 m, made of a cube.
fn sphere(n: u32) -> ColourMesh {
    let mut mesh = cube(n);
    for position in &mut mesh.positions {
        *position = crate::mesh::unit(sub(*position, [0.5; 3]));
    }
    mesh
}

fn volume(mesh: &ColourMesh) -> f64 {
    let six = mesh.triangles.iter().map(|t| {
        let [a, b, c] = mesh.corners(*t);
        dot(a, cross(b, c))
    });
    six.sum::<f64>() / 6.0
}

/// Edges that do not join exactly two triangles running opposite ways.
fn open_edges(mesh: &ColourMesh) -> usize {
    let mut edges: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for [a, b, c] in &mesh.triangles {
        for edge in [(*a, *b), (*b, *c), (*c, *a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    let paired = |(a, b): &(u32, u32)| edges.get(&(*b, *a)) == Some(&1);
    edges
        .iter()
        .filter(|(edge, count)| **count != 1 || !paired(edge))
        .count()
}

#[test]
fn a_cube_stays_closed_and_keeps_its_volume() {
    let fine = cube(12);
    assert_eq!(open_edges(&fine), 0);
    let coarse = decimate(&fine, 0.05, 4);
    assert!(coarse.triangles.len() <= 87, "{}", coarse.triangles.len());
    assert_eq!(open_edges(&coarse), 0);
    assert!((volume(&coarse) - 1.0).abs() < 1e-6, "{}", volume(&coarse));
}

#[test]
fn a_sphere_stays_round() {
    let fine = sphere(16);
    let coarse = decimate(&fine, 0.12, 4);
    assert!(coarse.triangles.len() <= 370, "{}", coarse.triangles.len());
    assert_eq!(open_edges(&coarse), 0);
    let ratio = volume(&coarse) / volume(&fine);
    assert!((0.97..1.03).contains(&ratio), "{ratio}");
    assert!(
        coarse
            .positions
            .iter()
            .all(|p| (length(*p) - 1.0).abs() < 0.05)
    );
}

#[test]
fn an_open_border_stays_in_place() {
    let coarse = decimate(
        &sheet(20, [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        0.02,
        2,
    );
    assert!(coarse.triangles.len() <= 16, "{}", coarse.triangles.len());
    for corner in [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
        assert!(
            coarse
                .positions
                .iter()
                .any(|p| length(sub(*p, corner)) < 1e-6),
            "{corner:?}"
        );
    }
    let area: f64 = coarse
        .triangles
        .iter()
        .map(|t| length(crate::mesh::area_normal(coarse.corners(*t))) / 2.0)
        .sum();
    assert!((area - 1.0).abs() < 1e-6, "{area}");
}

#[test]
fn the_same_mesh_gives_the_same_result() {
    assert_eq!(decimate(&sphere(10), 0.2, 4), decimate(&sphere(10), 0.2, 4));
}

#[test]
fn nothing_is_pushed_beyond_what_the_shape_allows() {
    let solid = decimate(&cube(3), 0.0, 0);
    assert!(solid.triangles.len() >= 4);
    assert_eq!(open_edges(&solid), 0);
    let empty = decimate(&ColourMesh::default(), 0.1, 4);
    assert!(empty.triangles.is_empty());
}

#[test]
fn degenerate_input_never_becomes_nan() {
    let mut mesh = sphere(8);
    // Needles, doubles and points on one line.
    for position in mesh.positions.iter_mut().step_by(3) {
        position[2] = 0.0;
    }
    mesh.triangles.extend([[0, 1, 2], [2, 1, 0], [5, 9, 40]]);
    let coarse = decimate(&mesh.welded(), 0.1, 4);
    assert!(
        coarse
            .positions
            .as_flattened()
            .iter()
            .all(|c| c.is_finite())
    );
    let shaded = crate::normals::shade(&coarse);
    assert!(
        shaded
            .normals
            .iter()
            .all(|n| (n.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-3)
    );
}
