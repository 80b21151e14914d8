//! Spheres for the surface of one link.

use cell_model::robots::cover::cover;
use nalgebra::Point3;

use crate::spheres::inside::Inside;
use crate::spheres::surface::Surface;

/// Points on the surface that are tried, about.
const SAMPLES: f64 = 3_000.0;
/// Least distance of such points (m).
const LEAST_SPACING_M: f64 = 0.003;
/// Centres that are tried.
const CANDIDATES: usize = 2_500;
/// Spheres reach out farther by this factor until they are few enough.
const WIDER: f64 = 1.15;

/// How closely spheres follow a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// How far they may reach out of it (m).
    pub margin: f64,
    /// The most spheres of a link; where it cannot be covered by so many, they reach
    /// out farther.
    pub most: usize,
}

/// The spheres of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Centre in the frame of the link and radius (m).
    pub spheres: Vec<(Point3<f64>, f64)>,
    /// How far they reach out of it at most (m).
    pub margin: f64,
}

/// Fits spheres to `surface`, which has triangles.
pub(crate) fn fit(surface: &Surface, rules: Rules) -> Fit {
    let spacing = (surface.area() / SAMPLES).sqrt().max(LEAST_SPACING_M);
    let inside = Inside::new(surface);
    let mut samples = surface.samples(spacing);
    // Inner walls cannot be touched. With them the spheres of the UR10's upper arm reached 61 mm
    // out of it, without them 46 mm (ADR 0022).
    samples.retain(|sample| inside.is_outer(sample));
    let candidates = candidates(&inside, &samples);
    let mut margin = rules.margin;
    loop {
        let most = rules.most.max(1);
        // Less than the margin: radii grow afterwards, to cover the surface between the samples. At
        // least half of it: with a coarse spacing nothing would be left.
        let reach = (margin - 0.5 * spacing).max(0.5 * margin);
        let spheres = cover(&samples, &candidates, reach, most);
        let covers = |sample: &Point3<f64>| {
            let mut spheres = spheres.iter();
            spheres.any(|(center, radius)| (center - sample).norm() <= radius + 1e-9)
        };
        if samples.iter().all(covers) || margin > 10.0 {
            let growth = growth(surface, &inside, &spheres, spacing);
            let grown = spheres.into_iter();
            let spheres = grown.map(|(center, radius)| (center, radius + growth));
            return Fit {
                spheres: spheres.collect(),
                margin: reach + growth,
            };
        }
        margin *= WIDER;
    }
}

/// By how much radii have to grow until all of the surface is covered (m): a point between two
/// samples may be outside of the spheres of both.
fn growth(surface: &Surface, inside: &Inside, spheres: &[(Point3<f64>, f64)], spacing: f64) -> f64 {
    let gap = |point: &Point3<f64>| {
        let gaps = spheres.iter();
        let gaps = gaps.map(|(center, radius)| (center - point).norm() - radius);
        gaps.fold(f64::INFINITY, f64::min)
    };
    let points = surface.grid(spacing);
    let outer = points.filter(|point| inside.is_outer(point));
    let gaps = outer.map(|point| gap(&point));
    // Without any sphere there is nothing that could grow.
    let widest = gaps.filter(|gap| gap.is_finite()).fold(0.0, f64::max);
    // No point is farther from one of the grid than this: the sides of its triangles are at
    // most half a spacing long.
    let between = 0.5 * spacing / 3.0_f64.sqrt();
    (widest + between).max(0.5 * spacing)
}

/// Points inside of the surface with their depth (m), and points on it with none.
fn candidates(inside: &Inside, samples: &[Point3<f64>]) -> Vec<(Point3<f64>, f64)> {
    let depth = |point: &Point3<f64>| {
        let far = samples.iter().map(|sample| (sample - point).norm_squared());
        far.fold(f64::INFINITY, f64::min).sqrt()
    };
    let centres = inside.centres();
    let within = thinned(&centres, CANDIDATES).map(|point| (*point, depth(point)));
    // A plate thinner than a cell has no inside, so points of its surface are its only centres.
    let on = thinned(samples, CANDIDATES).map(|point| (*point, 0.0));
    within.chain(on).collect()
}

/// Evenly spread ones of `all`, at most `most`.
fn thinned<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    all.iter().step_by(all.len().div_ceil(most).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box with its middle at the origin.
    fn cuboid([x, y, z]: [f64; 3]) -> Surface {
        let corner = |bits: usize| {
            let side = |bit: usize, size: f64| size * (((bits >> bit) & 1) as f64 - 0.5);
            Point3::new(side(0, x), side(1, y), side(2, z))
        };
        let quads = [
            [0, 1, 3, 2],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 3, 7, 5],
        ];
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        Surface {
            points: (0..8).map(corner).collect(),
            triangles: quads.into_iter().flat_map(halves).collect(),
        }
    }

    #[test]
    fn every_point_of_the_surface_is_in_a_sphere() {
        let surface = cuboid([0.3, 0.2, 0.1]);
        let rules = Rules {
            margin: 0.01,
            most: 64,
        };
        let fitted = fit(&surface, rules);
        let gap = |point: &Point3<f64>| {
            let spheres = fitted.spheres.iter();
            let gaps = spheres.map(|(center, radius)| (center - point).norm() - radius);
            gaps.fold(f64::INFINITY, f64::min)
        };
        let fine = surface.samples(0.0011);
        let widest = fine.iter().map(gap).fold(0.0, f64::max);
        assert!(widest <= 1e-9, "{widest} m uncovered");
    }
}
