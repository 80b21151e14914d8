//! Reader of `format: rmpflow` files: the tuning of the motion policies.
//!
//! Every section for which the `rmp` crate has a leaf is required. Sections of other policies
//! in published files (trajectory and affine attractors) and switches for printing are ignored;
//! any other key is refused.

use nalgebra::Vector3;
use rmp::{BodyCapsule, BodyCollisionController, RmpFlowParameters};
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::error::ModelError;

pub(crate) mod yaml;

/// Declares a section of numbers, converted to its struct in `rmp`.
macro_rules! section {
    ($section:ident => $target:ident { $($field:ident),* $(,)? } unused { $($unused:ident),* }) => {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct $section {
            $($field: f64,)*
            $(
                #[serde(default)]
                #[allow(dead_code, reason = "known, and of no effect here")]
                $unused: Option<IgnoredAny>,
            )*
        }

        impl From<$section> for rmp::$target {
            fn from(section: $section) -> Self {
                Self { $($field: section.$field),* }
            }
        }
    };
}

section!(CspaceTarget => CspaceTargetParameters {
    metric_scalar, position_gain, damping_gain, robust_position_term_thresh, inertia,
} unused {});
section!(JointLimit => JointLimitParameters {
    metric_scalar, metric_length_scale, metric_exploder_eps, metric_velocity_gate_length_scale,
    accel_damper_gain, accel_potential_gain, accel_potential_exploder_length_scale,
    accel_potential_exploder_eps,
} unused {});
section!(JointVelocityCap => JointVelocityCapParameters {
    max_velocity, velocity_damping_region, damping_gain, metric_weight,
} unused {});
section!(Target => TargetParameters {
    accel_p_gain, accel_d_gain, accel_norm_eps, metric_alpha_length_scale, min_metric_alpha,
    max_metric_scalar, min_metric_scalar, proximity_metric_boost_scalar,
    proximity_metric_boost_length_scale,
} unused { accept_user_weights, xi_estimator_gate_std_dev });
section!(AxisTarget => AxisTargetParameters {
    accel_p_gain, accel_d_gain, metric_scalar, proximity_metric_boost_scalar,
    proximity_metric_boost_length_scale,
} unused { accept_user_weights, xi_estimator_gate_std_dev });
section!(Collision => CollisionParameters {
    damping_gain, damping_std_dev, damping_robustness_eps, damping_velocity_gate_length_scale,
    repulsion_gain, repulsion_std_dev, metric_modulation_radius, metric_scalar,
    metric_exploder_std_dev, metric_exploder_eps,
} unused {});
section!(Damping => DampingParameters { accel_d_gain, metric_scalar, inertia } unused {});
section!(CanonicalResolve => CanonicalResolveParameters {
    max_acceleration_norm, projection_tolerance,
} unused { verbose });

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(clippy::struct_field_names, reason = "the keys of the file")]
struct Leaves {
    cspace_target_rmp: CspaceTarget,
    joint_limit_rmp: JointLimit,
    joint_velocity_cap_rmp: JointVelocityCap,
    target_rmp: Target,
    axis_target_rmp: AxisTarget,
    collision_rmp: Collision,
    damping_rmp: Damping,
    #[serde(default)]
    #[allow(dead_code, reason = "known, and of no effect here")]
    cspace_trajectory_rmp: Option<IgnoredAny>,
    #[serde(default)]
    #[allow(dead_code, reason = "known, and of no effect here")]
    cspace_affine_rmp: Option<IgnoredAny>,
    #[serde(default)]
    #[allow(dead_code, reason = "known, and of no effect here")]
    point_cloud_collision_rmp: Option<IgnoredAny>,
    #[serde(default)]
    #[allow(dead_code, reason = "known, and of no effect here")]
    point_cloud_obstacle_rmp: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Capsule {
    name: String,
    pt1: [f64; 3],
    pt2: [f64; 3],
    radius: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Controller {
    name: String,
    radius: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RmpFlowFile {
    #[serde(default)]
    format: Option<String>,
    #[serde(default)]
    #[allow(dead_code, reason = "known, and of no effect here")]
    api_version: Option<IgnoredAny>,
    #[serde(default)]
    #[allow(dead_code, reason = "known, and of no effect here")]
    verbose: Option<IgnoredAny>,
    joint_limit_buffers: Vec<f64>,
    rmp_params: Leaves,
    canonical_resolve: CanonicalResolve,
    /// Lula's files call them cylinders; its bodies are capsules, too.
    #[serde(default, alias = "body_cylinders")]
    body_capsules: Vec<Capsule>,
    #[serde(default)]
    body_collision_controllers: Vec<Controller>,
}

/// Reads a tuning. `file` is the name used in errors.
///
/// # Errors
/// Returns [`ModelError`] for bad YAML, another format, a missing or unknown key, and a number
/// that is not finite or out of range.
pub fn parse(file: &str, text: &str) -> Result<RmpFlowParameters, ModelError> {
    let read: RmpFlowFile = yaml::parse(file, text)?;
    if let Some(format) = read.format.as_deref().filter(|format| *format != "rmpflow") {
        return Err(yaml::refuse(
            file,
            text,
            "format",
            format,
            "only 'rmpflow' is allowed",
        ));
    }
    let parameters = convert(read);
    // `rmp` checks the ranges of its own numbers; here its error gets the line of the key.
    match parameters.validate() {
        Ok(()) => Ok(parameters),
        Err(error) => {
            let allowed = format!("{} is allowed", error.allowed);
            Err(yaml::refuse(file, text, &error.key, error.value, allowed))
        }
    }
}

fn convert(read: RmpFlowFile) -> RmpFlowParameters {
    let leaves = read.rmp_params;
    let capsule = |c: Capsule| BodyCapsule {
        name: c.name,
        pt1: Vector3::from(c.pt1),
        pt2: Vector3::from(c.pt2),
        radius: c.radius,
    };
    let controller = |c: Controller| BodyCollisionController {
        name: c.name,
        radius: c.radius,
    };
    RmpFlowParameters {
        joint_limit_buffers: read.joint_limit_buffers,
        cspace_target: leaves.cspace_target_rmp.into(),
        joint_limit: leaves.joint_limit_rmp.into(),
        joint_velocity_cap: leaves.joint_velocity_cap_rmp.into(),
        target: leaves.target_rmp.into(),
        axis_target: leaves.axis_target_rmp.into(),
        collision: leaves.collision_rmp.into(),
        damping: leaves.damping_rmp.into(),
        canonical_resolve: read.canonical_resolve.into(),
        body_capsules: read.body_capsules.into_iter().map(capsule).collect(),
        body_collision_controllers: read
            .body_collision_controllers
            .into_iter()
            .map(controller)
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PANDA: &str = include_str!("../../../../../../robots/panda/panda_rmpflow.yaml");

    #[test]
    fn our_own_tuning_is_read() {
        let parameters = parse("panda_rmpflow.yaml", PANDA).unwrap();
        assert_eq!(parameters.joint_limit_buffers.len(), 7);
        assert_eq!(parameters.damping.inertia, 3000.0);
        assert_eq!(parameters.body_collision_controllers.len(), 7);
        assert_eq!(parameters.body_capsules[0].pt1.z, 0.333);
    }

    #[test]
    fn a_mistyped_key_gets_line_and_suggestion() {
        let text = PANDA.replace("    inertia: 1.0", "    inertai: 1.0");
        let error = parse("a.yaml", &text).unwrap_err().to_string();
        assert!(error.starts_with("a.yaml:1"), "{error}");
        assert!(error.contains("did you mean 'inertia'"), "{error}");
    }

    #[test]
    fn a_number_out_of_range_gets_line_and_key_path() {
        for bad in ["0.0", "-1.0", ".nan", ".inf"] {
            let text = PANDA.replace("accel_norm_eps: 0.075", &format!("accel_norm_eps: {bad}"));
            let error = parse("a.yaml", &text).unwrap_err().to_string();
            let line = PANDA
                .lines()
                .position(|l| l.contains("accel_norm_eps"))
                .unwrap()
                + 1;
            assert!(error.starts_with(&format!("a.yaml:{line}: ")), "{error}");
            assert!(
                error.contains("rmp_params.target_rmp.accel_norm_eps"),
                "{error}"
            );
        }
    }

    #[test]
    fn another_format_and_broken_yaml_are_refused() {
        let text = PANDA.replace("format: rmpflow", "format: xrdf");
        assert!(
            parse("a.yaml", &text)
                .unwrap_err()
                .to_string()
                .contains("'rmpflow'")
        );
        assert!(parse("a.yaml", "format: [").is_err());
        assert!(parse("a.yaml", "").is_err());
    }
}
