//! The arguments of commands that lead an arm by hand.

use clap::{Args, ValueEnum};
use ipc_types::operator::CONTACT_LIMIT_N;

use crate::args::common::CellArgs;
use crate::args::values::{count, finite, newtons};

/// The arm that is led.
#[derive(Clone, Debug, Args)]
pub struct ArmArgs {
    /// Arm by its place in the cell file
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 0, value_parser = count)]
    pub arm: u32,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// How an arm is moved.
#[derive(Clone, Debug, Args)]
pub struct MoveArgs {
    /// Angles are in degrees
    #[arg(long)]
    pub deg: bool,
    /// Return at once; without it, when the arm is at rest
    #[arg(long)]
    pub no_wait: bool,
    /// Contact force at which the arm stops, in newtons
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = CONTACT_LIMIT_N, value_parser = newtons)]
    pub contact_limit: f64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub of: ArmArgs,
}

/// `robocell target`.
#[derive(Clone, Debug, Args)]
pub struct TargetArgs {
    /// Position in metres, then roll, pitch, yaw in radians (world frame);
    /// without an orientation the tool keeps its own
    #[arg(value_names = ["X", "Y", "Z", "R", "P", "YAW"], num_args = 3..=6, required = true,
          allow_negative_numbers = true, value_parser = finite)]
    pub values: Vec<f64>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub movement: MoveArgs,
}

/// `robocell joints`.
#[derive(Clone, Debug, Args)]
pub struct JointsArgs {
    /// Position of each joint of the arm, from the base on, in radians (metres for a
    /// prismatic joint)
    #[arg(value_name = "POSITION", required = true, num_args = 1..=16,
          allow_negative_numbers = true, value_parser = finite)]
    pub values: Vec<f64>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub movement: MoveArgs,
}

/// `robocell grasp`.
#[derive(Clone, Debug, Args)]
pub struct GraspArgs {
    /// Name of the object in the cell file
    pub object: String,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub of: ArmArgs,
}

/// Actions of the gripper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GripperVerb {
    /// Open fully, or let go.
    Open,
    /// Close, or switch suction on.
    Close,
}

/// `robocell gripper`.
#[derive(Clone, Debug, Args)]
pub struct GripperArgs {
    /// Action
    pub verb: GripperVerb,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub of: ArmArgs,
}
