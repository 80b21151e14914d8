//! Arguments of commands about a robot's files.

use std::path::PathBuf;

use clap::Args;

use crate::cli_values::{margin, package, sphere_count};

/// A robot of the user in place of that of the demo.
#[derive(Clone, Debug, Default, Args)]
pub struct RobotArgs {
    /// Robot to use instead of that of the demo: a URDF, or a config.json of Isaac Sim
    #[arg(long, value_name = "URDF")]
    pub robot: Option<PathBuf>,
    /// Link of that robot that is the tool
    #[arg(long, value_name = "LINK", requires = "robot")]
    pub tip: Option<String>,
    /// Collision spheres and limits of that robot: an XRDF, or a robot description of Lula
    #[arg(long, value_name = "FILE", requires = "robot")]
    pub xrdf: Option<PathBuf>,
    /// Tuning of that robot, a file of `format: rmpflow`
    #[arg(long, value_name = "FILE", requires = "robot")]
    pub rmpflow: Option<PathBuf>,
}

/// `robocell spheres`.
#[derive(Clone, Debug, Args)]
pub struct SpheresArgs {
    /// The URDF, or a `config.json` of Isaac Sim that names it
    pub urdf: PathBuf,
    /// Link that is the tool; the arm ends there [default: as with `--robot`]
    #[arg(long, value_name = "LINK")]
    pub tip: Option<String>,
    /// How far a sphere may reach out of the geometry (m), where a link can be covered so
    #[arg(long, value_name = "M", default_value = "0.015", value_parser = margin)]
    pub margin: f64,
    /// The most spheres of a link
    #[arg(long, value_name = "N", default_value = "16", value_parser = sphere_count)]
    pub most: u32,
    /// Folder of a package whose meshes the URDF names; may be repeated
    /// [default: found beside the URDF and by `ROS_PACKAGE_PATH` and `AMENT_PREFIX_PATH`]
    #[arg(long, value_name = "NAME=DIR", value_parser = package)]
    pub package: Vec<String>,
}
