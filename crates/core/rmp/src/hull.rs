//! Convex hulls, as the planes of their faces.

use nalgebra::Vector3;

use crate::ObstacleError;

/// Largest number of points of a hull: all triples of them are compared, once.
pub const MAX_HULL_POINTS: usize = 64;

/// The convex hull of some points.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    /// Unit normal, outward, and offset of each face: `n . p <= d` inside (m).
    planes: Vec<(Vector3<f64>, f64)>,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Hull {
    /// The hull of points (m) that are not in one plane.
    ///
    /// # Errors
    /// [`ObstacleError::Hull`] for fewer than four points, more than [`MAX_HULL_POINTS`], one
    /// that is not finite, or all in one plane.
    pub fn new(points: &[Vector3<f64>]) -> Result<Self, ObstacleError> {
        let refused = |why: &'static str| ObstacleError::Hull {
            points: points.len(),
            why,
        };
        if !(4..=MAX_HULL_POINTS).contains(&points.len()) {
            return Err(refused("4 to 64 points are allowed"));
        }
        let far = Vector3::repeat(f64::INFINITY);
        let (low, high) = points
            .iter()
            .fold((far, -far), |(low, high), p| (low.inf(p), high.sup(p)));
        let size = (high - low).norm();
        if !size.is_finite() || !points.iter().all(|p| p.iter().all(|x| x.is_finite())) {
            return Err(refused("every coordinate must be finite"));
        }
        // The slack is relative to the size, so that small and large hulls are treated alike.
        let planes = faces(points, 1e-9 * size);
        if planes.len() < 4 {
            return Err(refused("the points are all in one plane"));
        }
        Ok(Self { planes, low, high })
    }

    /// Normal and offset of each face.
    pub fn planes(&self) -> &[(Vector3<f64>, f64)] {
        &self.planes
    }

    /// Distance to the farthest plane (m).
    pub(crate) fn distance(&self, local: &Vector3<f64>) -> f64 {
        let planes = self.planes.iter();
        planes
            .map(|(normal, offset)| normal.dot(local) - offset)
            .fold(f64::NEG_INFINITY, f64::max)
    }

    pub(crate) fn half_extents(&self) -> Vector3<f64> {
        0.5 * (self.high - self.low)
    }

    pub(crate) fn middle(&self) -> Vector3<f64> {
        0.5 * (self.high + self.low)
    }
}

/// The planes through three of the points that have all others on one side, once each.
fn faces(points: &[Vector3<f64>], slack: f64) -> Vec<(Vector3<f64>, f64)> {
    let mut planes: Vec<(Vector3<f64>, f64)> = Vec::new();
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            for c in points.iter().skip(j + 1) {
                let normal = (b - a).cross(&(c - a));
                // Three points on a line span no plane.
                if normal.norm() <= slack * (b - a).norm().max(slack) {
                    continue;
                }
                let normal = normal.normalize();
                // Both directions: the order of the points does not tell the outward one.
                for normal in [normal, -normal] {
                    let offset = normal.dot(a);
                    let is_face = points.iter().all(|p| normal.dot(p) <= offset + slack);
                    let is_new = || {
                        planes
                            .iter()
                            .all(|(known, _)| known.dot(&normal) < 1.0 - 1e-12)
                    };
                    if is_face && is_new() {
                        planes.push((normal, offset));
                    }
                }
            }
        }
    }
    planes
}
