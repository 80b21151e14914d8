//! Triangles of a link, and points on them.

use nalgebra::{Isometry3, Point3, Vector3};

/// Triangles, metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Surface {
    pub(crate) points: Vec<Point3<f64>>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Adds `other` at `pose`, stretched by `scale` along its own axes.
    pub(crate) fn add(&mut self, other: &Self, pose: &Isometry3<f64>, scale: &Vector3<f64>) {
        let base = u32::try_from(self.points.len()).unwrap_or(u32::MAX);
        let points = other.points.iter();
        self.points
            .extend(points.map(|p| pose * Point3::from(p.coords.component_mul(scale))));
        let triangles = other.triangles.iter();
        self.triangles
            .extend(triangles.map(|corners| corners.map(|corner| base.saturating_add(corner))));
    }

    /// Adds `other` as it is.
    pub(crate) fn append(&mut self, other: &Self) {
        self.add(other, &Isometry3::identity(), &Vector3::repeat(1.0));
    }

    /// Lengths of the box along the axes that encloses it (m).
    pub(crate) fn extent(&self) -> Vector3<f64> {
        let Some(first) = self.points.first() else {
            return Vector3::zeros();
        };
        let points = self.points.iter();
        let (low, high) = points.fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
        high - low
    }

    fn corners(&self) -> impl Iterator<Item = [Point3<f64>; 3]> {
        let all = self.triangles.iter();
        all.map(|corners| corners.map(|corner| self.points[corner as usize]))
    }

    /// Area (m²).
    pub(crate) fn area(&self) -> f64 {
        self.corners()
            .map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm())
            .sum()
    }

    /// Points on the triangles, so that none of the surface is farther from one than twice
    /// `spacing` (m); one for each cell of that size.
    pub(crate) fn samples(&self, spacing: f64) -> Vec<Point3<f64>> {
        let mut seen = std::collections::BTreeSet::new();
        let is_new = |point: &Point3<f64>| {
            #[expect(clippy::cast_possible_truncation, reason = "saturates, by intent")]
            let cell = [point.x, point.y, point.z].map(|x| (x / spacing).floor() as i64);
            seen.insert(cell)
        };
        self.grid(spacing).filter(is_new).collect()
    }

    /// Corners of triangles whose sides are at most half of `spacing` long (m), and which make
    /// up the surface.
    pub(crate) fn grid(&self, spacing: f64) -> impl Iterator<Item = Point3<f64>> {
        self.corners().flat_map(move |[a, b, c]| {
            let longest = (b - a).norm().max((c - a).norm()).max((c - b).norm());
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates, and is small for finite meshes"
            )]
            let steps = ((2.0 * longest / spacing).ceil() as u32).clamp(1, 2_000);
            let part = move |count: u32| f64::from(count) / f64::from(steps);
            (0..=steps).flat_map(move |i| {
                let across = move |j| a + (b - a) * part(i) + (c - a) * part(j);
                (0..=steps - i).map(across)
            })
        })
    }
}
