//! Affine transforms of nodes.

use roxmltree::Node;

use super::{Result, geometry};
use crate::mesh::{Vec3, cross, dot, scale, unit};

/// The upper three rows of an affine matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Transform([[f64; 4]; 3]);

impl Transform {
    pub(super) fn scaling(by: f64) -> Self {
        Self::axes([[by, 0.0, 0.0], [0.0, by, 0.0], [0.0, 0.0, by]])
    }

    /// From the images of the axes.
    fn axes([x, y, z]: [Vec3; 3]) -> Self {
        Self([0, 1, 2].map(|row| [x[row], y[row], z[row], 0.0]))
    }

    /// The transforms a node lists, the first one outermost.
    pub(super) fn of_node(node: Node<'_, '_>) -> Result<Self> {
        let mut all = Self::scaling(1.0);
        for element in node.children().filter(Node::is_element) {
            let name = element.tag_name().name();
            let one = match name {
                "matrix" | "translate" | "rotate" | "scale" => {
                    let values = geometry::numbers(element)?;
                    Self::of_values(name, &values).ok_or_else(|| {
                        let line = geometry::line(element);
                        format!("line {line}: {name} with {} numbers", values.len())
                    })?
                }
                "skew" | "lookat" => {
                    let line = geometry::line(element);
                    return Err(format!("line {line}: {name} is not supported"));
                }
                _ => continue,
            };
            all = all.then(&one);
        }
        Ok(all)
    }

    fn of_values(name: &str, values: &[f64]) -> Option<Self> {
        Some(match (name, values) {
            ("matrix", v) if v.len() == 16 => {
                Self([0, 4, 8].map(|row| [v[row], v[row + 1], v[row + 2], v[row + 3]]))
            }
            ("translate", [x, y, z]) => Self([
                [1.0, 0.0, 0.0, *x],
                [0.0, 1.0, 0.0, *y],
                [0.0, 0.0, 1.0, *z],
            ]),
            ("scale", [x, y, z]) => Self::axes([[*x, 0.0, 0.0], [0.0, *y, 0.0], [0.0, 0.0, *z]]),
            ("rotate", [x, y, z, degrees]) => Self::rotation([*x, *y, *z], degrees.to_radians()),
            _ => return None,
        })
    }

    /// Rodrigues' formula.
    fn rotation(axis: Vec3, angle: f64) -> Self {
        let axis = unit(axis);
        let (sin, cos) = angle.sin_cos();
        let turn = |v: Vec3| {
            let side = cross(axis, v);
            let along = scale(axis, dot(axis, v) * (1.0 - cos));
            [0, 1, 2].map(|i| v[i] * cos + side[i] * sin + along[i])
        };
        Self::axes([
            turn([1.0, 0.0, 0.0]),
            turn([0.0, 1.0, 0.0]),
            turn([0.0, 0.0, 1.0]),
        ])
    }

    /// `self` after `inner`.
    pub(super) fn then(&self, inner: &Self) -> Self {
        let (a, b) = (&self.0, &inner.0);
        Self(std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                let offset = if column == 3 { a[row][3] } else { 0.0 };
                (0..3).map(|k| a[row][k] * b[k][column]).sum::<f64>() + offset
            })
        }))
    }

    pub(super) fn point(&self, p: Vec3) -> Vec3 {
        self.0
            .map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3])
    }

    /// Makes a left hand of a right one.
    pub(super) fn mirrors(&self) -> bool {
        let [x, y, z] = self.0.map(|row| [row[0], row[1], row[2]]);
        dot(cross(x, y), z) < 0.0
    }
}
