//! `RMPflow`: reactive motion from weighted accelerations.
//!
//! Each aim (reach a point, keep away from an obstacle, stay within joint limits) is a *leaf*:
//! an acceleration and a weight matrix in its task space. Leaves are pulled back to the
//! joints, summed, and resolved to one joint acceleration. The mathematics is that of Cheng et
//! al., "`RMPflow`" (2018, arXiv 1811.07049); the leaves are those of NVIDIA's published
//! tunings.
//!
//! The crate reads no files and keeps no time: positions, velocities and the step
//! are arguments.
#![deny(unsafe_code)]

mod ball;
mod carried;
mod chain;
mod error;
mod evaluate;
mod flow;
mod groups;
mod hull;
mod kinematics;
mod lanes;
mod leaves;
mod limits;
mod obstacles;
mod parameters;
mod pullback;
mod resolve;
mod self_collision;
mod setup;
mod shape;
mod simd;
mod state;
mod sweep;
mod targets;
mod tree;
mod validate;

pub use chain::{Chain, ChainError, Frame, Joint, JointKind, MAX_JOINTS, Mimic};
pub use error::{FlowError, ParameterError, SetupError};
pub use flow::{
    Clearance, CollisionSphere, MAX_CARRIED, RmpFlow, RmpFlowSetup, SelfCollisionSetup, StepReport,
    TargetId,
};
pub use hull::{Hull, MAX_HULL_POINTS};
pub use kinematics::PointMotion;
pub use limits::{JointLimits, LimitsError};
pub use obstacles::error::ObstacleError;
pub use obstacles::{ObstacleId, ObstacleSet};
pub use parameters::{
    AxisTargetParameters, BodyCapsule, BodyCollisionController, CanonicalResolveParameters,
    CollisionParameters, CspaceTargetParameters, DampingParameters, JointLimitParameters,
    JointVelocityCapParameters, RmpFlowParameters, TargetParameters,
};
pub use pullback::Root;
pub use resolve::cell::{ClipFlags, brake, follow};
pub use resolve::exact::Outcome;
pub use shape::{Core, Obstacle};
pub use state::MotionState;
pub use tree::{Carrier, Tree, TreeJoint};

/// The example of the README is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
