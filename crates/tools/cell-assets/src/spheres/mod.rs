//! `robocell spheres`: collision spheres for a robot whose URDF has meshes.
//!
//! Motion policies and the planner keep spheres of the robot away from obstacles and
//! from each other. This program fits them to the collision geometry of each link and
//! writes an XRDF, which `--xrdf` takes.

mod error;
mod fit;
mod inside;
mod links;
mod mesh;
mod place;
mod surface;
mod xrdf;

use std::path::Path;

use cell_model::{Robot, RobotFiles};
use rmp::CollisionSphere;

pub use error::SphereError;
pub use fit::{Fit, Rules};
pub use place::Packages;

/// The spheres of one link.
#[derive(Clone, Debug)]
pub struct FittedLink {
    /// Name of the link.
    pub name: String,
    /// Its spheres and how well they fit.
    pub fit: Fit,
    /// Whether it has no collision geometry and its visual was taken.
    pub is_visual: bool,
}

/// What was fitted to a robot.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Links with geometry, in the order of the URDF.
    pub links: Vec<FittedLink>,
    /// The XRDF.
    pub xrdf: String,
}

/// Fits spheres to the robot of `files`, which has no XRDF.
///
/// # Errors
/// [`SphereError`] where a file is missing or wrong.
pub fn fit_robot(
    files: &RobotFiles,
    packages: &Packages,
    rules: Rules,
) -> Result<Fitted, SphereError> {
    let robot = Robot::from_files(files)?;
    let mut links = Vec::new();
    for link in links::read(&files.urdf, packages)? {
        if robot.chain.frame_index(&link.name).is_some() {
            links.push(FittedLink {
                fit: fit::fit(&link.surface, rules),
                name: link.name,
                is_visual: link.is_visual,
            });
        }
    }
    let xrdf = xrdf::text(&robot, &links);
    Ok(Fitted { links, xrdf })
}

impl FittedLink {
    /// Its spheres, smaller by `less` (m).
    fn spheres(&self, less: f64) -> impl Iterator<Item = CollisionSphere> {
        let spheres = self.fit.spheres.iter();
        spheres.map(move |(center, radius)| CollisionSphere {
            frame: self.name.clone(),
            center: center.coords,
            radius: (radius - less).max(0.0),
        })
    }
}

/// Name of a file in messages.
fn name_of(path: &Path) -> String {
    path.display().to_string()
}
