//! The file of problems.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rmp::Obstacle;
use serde::Deserialize;

#[derive(Deserialize)]
pub(crate) struct Problems {
    pub(crate) joints: Vec<String>,
    /// By scene.
    pub(crate) problems: BTreeMap<String, Vec<Problem>>,
}

#[derive(Deserialize)]
pub(crate) struct Problem {
    pub(crate) start: Vec<f64>,
    pub(crate) goals: Vec<Vec<f64>>,
    #[serde(default, rename = "box")]
    boxes: Vec<Cuboid>,
    #[serde(default, rename = "cylinder")]
    cylinders: Vec<Cylinder>,
    #[serde(default, rename = "sphere")]
    spheres: Vec<Ball>,
}

#[derive(Deserialize)]
struct Cuboid {
    half_extents: [f64; 3],
    position: [f64; 3],
    orientation_quat_xyzw: [f64; 4],
}

#[derive(Deserialize)]
struct Cylinder {
    length: f64,
    radius: f64,
    position: [f64; 3],
    orientation_quat_xyzw: [f64; 4],
}

#[derive(Deserialize)]
struct Ball {
    radius: f64,
    position: [f64; 3],
}

pub(crate) fn read(file: &str) -> Result<Problems, Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(file).map_err(|error| format!("{file}: {error}"))?;
    Ok(serde_json::from_str(&text).map_err(|error| format!("{file}: {error}"))?)
}

impl Problem {
    pub(crate) fn obstacles(&self) -> Vec<Obstacle> {
        let boxes = self.boxes.iter().map(|one| {
            let sides = 2.0 * Vector3::from(one.half_extents);
            let pose = pose(one.position, one.orientation_quat_xyzw);
            Obstacle::cuboid(pose, sides)
        });
        let cylinders = self.cylinders.iter().map(|one| {
            let pose = pose(one.position, one.orientation_quat_xyzw);
            Obstacle::cylinder(pose, one.radius, one.length)
        });
        let spheres = self.spheres.iter().map(|one| {
            let center = Vector3::from(one.position);
            Obstacle::sphere(center, one.radius)
        });
        boxes.chain(cylinders).chain(spheres).collect()
    }
}

fn pose(position: [f64; 3], [x, y, z, w]: [f64; 4]) -> Isometry3<f64> {
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(position), turn)
}
