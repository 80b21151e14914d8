//! Spheres for the surface of one link.

use cell_model::robots::cover::cover;
use nalgebra::Point3;

use crate::inside::Inside;
use crate::surface::Surface;

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
    samples.retain(|sample| inside.is_outer(sample));
    let candidates = candidates(&inside, &samples);
    let mut margin = rules.margin;
    loop {
        // What is between two samples is covered as well.
        let most = rules.most.max(1);
        let reach = (margin - 0.5 * spacing).max(0.5 * margin);
        let spheres = cover(&samples, &candidates, reach, most);
        let covers = |sample: &Point3<f64>| {
            let mut spheres = spheres.iter();
            spheres.any(|(center, radius)| (center - sample).norm() <= radius + 1e-9)
        };
        if samples.iter().all(covers) || margin > 10.0 {
            let grown = spheres.into_iter();
            let spheres = grown.map(|(center, radius)| (center, radius + 0.5 * spacing));
            return Fit {
                spheres: spheres.collect(),
                margin: reach + 0.5 * spacing,
            };
        }
        margin *= WIDER;
    }
}

/// Points inside of the surface with their depth (m), and points on it with none.
fn candidates(inside: &Inside, samples: &[Point3<f64>]) -> Vec<(Point3<f64>, f64)> {
    let depth = |point: &Point3<f64>| {
        let far = samples.iter().map(|sample| (sample - point).norm_squared());
        far.fold(f64::INFINITY, f64::min).sqrt()
    };
    let centres = inside.centres();
    let within = thinned(&centres, CANDIDATES).map(|point| (*point, depth(point)));
    let on = thinned(samples, CANDIDATES).map(|point| (*point, 0.0));
    within.chain(on).collect()
}

/// Evenly spread ones of `all`, at most `most`.
fn thinned<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    all.iter().step_by(all.len().div_ceil(most).max(1))
}
