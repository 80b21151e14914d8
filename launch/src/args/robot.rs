//! Arguments of commands about a robot's files.

use std::net::IpAddr;
use std::path::PathBuf;
use std::str::FromStr;

use cell_model::CLIENT_CONTROLLER;
use clap::Args;

use crate::args::values::{margin, package, sphere_count};

/// A robot of the user in place of that of the demo.
#[derive(Clone, Debug, Default, Args)]
pub struct RobotArgs {
    /// Robot to use instead of that of the demo: one of `robots/`, a URDF, or a config.json of
    /// Isaac Sim
    #[arg(long, value_name = "NAME|URDF")]
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

/// Programs in place of the controllers of arms.
#[derive(Clone, Debug, Default, Args)]
pub struct ControllerArgs {
    /// Controller of an arm in place of that of the cell file: a program, or `fci` for the network
    /// interface of a Franka, at an address of its own with `fci@ADDRESS`; may be repeated
    #[arg(long, value_name = "[ARM=]P", value_parser = str::parse::<ControllerOf>)]
    pub controller: Vec<ControllerOf>,
    /// Let other machines command arms over the Franka control interface, which has no password
    #[arg(long, requires = "controller")]
    pub fci_from_network: bool,
    /// Count an answer of a client of `fci` that takes longer than 1 ms as lost also where simulated
    /// time waits for it, as the robot does
    #[arg(long)]
    pub strict: bool,
}

/// A controller for an arm.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ControllerOf {
    /// Name of the arm; `None` where the cell has one only.
    pub arm: Option<String>,
    /// The program, or `fci`.
    pub program: String,
    /// Where `fci` listens.
    pub address: Option<IpAddr>,
}

impl FromStr for ControllerOf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (arm, program) = match text.split_once('=') {
            Some((arm, program)) => (Some(arm.to_owned()), program),
            None => (None, text),
        };
        let (program, address) = match program.split_once('@') {
            // Only `fci` takes an address: the path of a program may contain an `@`.
            Some((CLIENT_CONTROLLER, address)) => {
                let wrong = |_| format!("'{address}' is not an IP address, as 127.0.0.2 is one");
                (CLIENT_CONTROLLER, Some(address.parse().map_err(wrong)?))
            }
            _ => (program, None),
        };
        if program.is_empty() || arm.as_deref() == Some("") {
            return Err("a program, or ARM=PROGRAM; `fci` is the Franka control interface".into());
        }
        Ok(Self {
            arm,
            program: program.to_owned(),
            address,
        })
    }
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
