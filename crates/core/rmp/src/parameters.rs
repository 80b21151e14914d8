//! The numbers of an `RMPflow` tuning, named as in `format: rmpflow` files.

use nalgebra::Vector3;

/// All numbers of a `format: rmpflow` file about the leaves and the resolve.
#[derive(Debug, Clone, PartialEq)]
pub struct RmpFlowParameters {
    /// Distance of each controlled joint from its position limits, rad or m.
    pub joint_limit_buffers: Vec<f64>,
    /// Pull towards the default posture.
    pub cspace_target: CspaceTargetParameters,
    /// Push away from joint position limits.
    pub joint_limit: JointLimitParameters,
    /// Brake near a common joint speed.
    pub joint_velocity_cap: JointVelocityCapParameters,
    /// Pull of a frame's origin towards a position.
    pub target: TargetParameters,
    /// Pull of a frame's axes towards an orientation.
    pub axis_target: AxisTargetParameters,
    /// Push of a sphere away from an obstacle.
    pub collision: CollisionParameters,
    /// Drag and inertia of every target frame.
    pub damping: DampingParameters,
    /// How the summed leaves become an acceleration.
    pub canonical_resolve: CanonicalResolveParameters,
    /// Capsules fixed in the base frame, in place of the robot's own body.
    pub body_capsules: Vec<BodyCapsule>,
    /// Frames that keep away from those capsules.
    pub body_collision_controllers: Vec<BodyCollisionController>,
}

/// `cspace_target_rmp`: the posture attractor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CspaceTargetParameters {
    /// Weight of the attractor.
    pub metric_scalar: f64,
    /// Gain on the position error, 1/s^2.
    pub position_gain: f64,
    /// Gain on the joint velocity, 1/s.
    pub damping_gain: f64,
    /// Norm at which the position error is capped, rad.
    pub robust_position_term_thresh: f64,
    /// Weight of a leaf that requests zero acceleration.
    pub inertia: f64,
}

/// `joint_limit_rmp`: both limits of every controlled joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimitParameters {
    /// Weight.
    pub metric_scalar: f64,
    /// Normalised distance over which the weight falls.
    pub metric_length_scale: f64,
    /// Keeps the weight finite at the limit.
    pub metric_exploder_eps: f64,
    /// Normalised speed over which the weight fades when moving away, 1/s.
    pub metric_velocity_gate_length_scale: f64,
    /// Damping gain, 1/s.
    pub accel_damper_gain: f64,
    /// Repulsion gain, 1/s^2.
    pub accel_potential_gain: f64,
    /// Normalised distance over which the repulsion falls.
    pub accel_potential_exploder_length_scale: f64,
    /// Keeps the repulsion finite at the limit.
    pub accel_potential_exploder_eps: f64,
}

/// `joint_velocity_cap_rmp`: one speed for all controlled joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointVelocityCapParameters {
    /// The speed cap, rad/s.
    pub max_velocity: f64,
    /// Width of the region below the cap in which the leaf brakes, rad/s.
    pub velocity_damping_region: f64,
    /// Damping gain, 1/s.
    pub damping_gain: f64,
    /// Weight.
    pub metric_weight: f64,
}

/// `target_rmp`: a position target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetParameters {
    /// Proportional gain, m/s^2.
    pub accel_p_gain: f64,
    /// Damping gain, 1/s.
    pub accel_d_gain: f64,
    /// Softens the unit direction near the target, m.
    pub accel_norm_eps: f64,
    /// Distance within which the weight turns isotropic, m.
    pub metric_alpha_length_scale: f64,
    /// Least isotropic share of the weight, 0 to 1.
    pub min_metric_alpha: f64,
    /// Weight near the target.
    pub max_metric_scalar: f64,
    /// Weight along the direction to a far target.
    pub min_metric_scalar: f64,
    /// Factor on the weight at the target.
    pub proximity_metric_boost_scalar: f64,
    /// Distance within which that factor acts, m.
    pub proximity_metric_boost_length_scale: f64,
}

/// `axis_target_rmp`: one axis of an orientation target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisTargetParameters {
    /// Proportional gain, 1/s^2.
    pub accel_p_gain: f64,
    /// Damping gain, 1/s.
    pub accel_d_gain: f64,
    /// Weight.
    pub metric_scalar: f64,
    /// Factor on the weight at the position target.
    pub proximity_metric_boost_scalar: f64,
    /// Distance to the position target within which that factor acts, m.
    pub proximity_metric_boost_length_scale: f64,
}

/// `collision_rmp`: a sphere against an obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CollisionParameters {
    /// Damping gain, 1/s.
    pub damping_gain: f64,
    /// Distance over which the damping falls, m.
    pub damping_std_dev: f64,
    /// Keeps the damping finite in contact.
    pub damping_robustness_eps: f64,
    /// Speed over which leaf and damping fade when moving away, m/s.
    pub damping_velocity_gate_length_scale: f64,
    /// Repulsion gain, m/s^2.
    pub repulsion_gain: f64,
    /// Distance over which the repulsion falls, m.
    pub repulsion_std_dev: f64,
    /// Distance beyond which the weight is zero, m.
    pub metric_modulation_radius: f64,
    /// Weight.
    pub metric_scalar: f64,
    /// Distance over which the weight falls, m.
    pub metric_exploder_std_dev: f64,
    /// Keeps the weight finite in contact.
    pub metric_exploder_eps: f64,
}

/// `damping_rmp`: drag and inertia of a target frame's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DampingParameters {
    /// Drag gain, 1/m.
    pub accel_d_gain: f64,
    /// Weight per speed, s/m.
    pub metric_scalar: f64,
    /// Weight of a leaf that requests zero acceleration.
    pub inertia: f64,
}

/// `canonical_resolve`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CanonicalResolveParameters {
    /// Trust region on the norm of the joint acceleration, rad/s^2.
    pub max_acceleration_norm: f64,
    /// Published tolerance of the reference solver; ours is tighter.
    pub projection_tolerance: f64,
}

/// A capsule fixed in the base frame.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyCapsule {
    /// Name, for messages only.
    pub name: String,
    /// One end of the core segment in the base frame, m.
    pub pt1: Vector3<f64>,
    /// The other end in the base frame, m.
    pub pt2: Vector3<f64>,
    /// Radius, m.
    pub radius: f64,
}

/// A frame whose origin, as a sphere, keeps away from every [`BodyCapsule`].
#[derive(Debug, Clone, PartialEq)]
pub struct BodyCollisionController {
    /// Name of the frame.
    pub name: String,
    /// Radius of the sphere, m.
    pub radius: f64,
}
