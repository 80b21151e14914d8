//! Ranges of the tuning: divisors must be greater than zero, weights must not be negative.

use crate::{ParameterError, RmpFlowParameters};

/// Allowed range of one number.
#[derive(Debug, Clone, Copy)]
enum Allowed {
    Positive,
    NotNegative,
    Share,
}

use Allowed::{NotNegative, Positive, Share};

impl Allowed {
    fn text(self) -> &'static str {
        match self {
            Positive => "a finite number greater than 0",
            NotNegative => "a finite number of at least 0",
            Share => "a number from 0 to 1",
        }
    }

    fn holds(self, value: f64) -> bool {
        match self {
            Positive => value.is_finite() && value > 0.0,
            NotNegative => value.is_finite() && value >= 0.0,
            Share => (0.0..=1.0).contains(&value),
        }
    }
}

/// Keys that are common to targets and axes.
const BOOST: &str = "proximity_metric_boost_scalar";
const BOOST_LENGTH: &str = "proximity_metric_boost_length_scale";

/// Section, key, value, allowed range.
type Row = (&'static str, &'static str, f64, Allowed);

impl RmpFlowParameters {
    /// Checks that every number is finite and in range.
    ///
    /// # Errors
    /// [`ParameterError`] with the key path of the first that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let rows = self.posture_rows().into_iter();
        let rows = rows.chain(self.limit_rows()).chain(self.cap_rows());
        let rows = rows.chain(self.target_rows()).chain(self.axis_rows());
        let rows = rows.chain(self.damping_rows()).chain(self.collision_rows());
        for (section, key, value, allowed) in rows {
            check(|| format!("{section}.{key}"), value, allowed)?;
        }
        self.validate_body()
    }

    /// Checks the lists: by joint, by capsule and by sphere.
    fn validate_body(&self) -> Result<(), ParameterError> {
        for (i, &buffer) in self.joint_limit_buffers.iter().enumerate() {
            check(|| format!("joint_limit_buffers[{i}]"), buffer, NotNegative)?;
        }
        for (i, capsule) in self.body_capsules.iter().enumerate() {
            check(
                || format!("body_capsules[{i}].radius"),
                capsule.radius,
                Positive,
            )?;
            // Far beyond a robot: such a capsule would silently have no effect.
            for (key, point) in [("pt1", &capsule.pt1), ("pt2", &capsule.pt2)] {
                if let Some(&value) = point.iter().find(|x| x.is_nan() || x.abs() > 1e3) {
                    return Err(ParameterError {
                        key: format!("body_capsules[{i}].{key}"),
                        value,
                        allowed: "a number from -1000 to 1000",
                    });
                }
            }
        }
        for (i, controller) in self.body_collision_controllers.iter().enumerate() {
            let key = || format!("body_collision_controllers[{i}].radius");
            check(key, controller.radius, NotNegative)?;
        }
        Ok(())
    }

    fn posture_rows(&self) -> [Row; 5] {
        const POSTURE: &str = "rmp_params.cspace_target_rmp";
        let c = &self.cspace_target;
        [
            (POSTURE, "metric_scalar", c.metric_scalar, NotNegative),
            (POSTURE, "position_gain", c.position_gain, NotNegative),
            (POSTURE, "damping_gain", c.damping_gain, NotNegative),
            (
                POSTURE,
                "robust_position_term_thresh",
                c.robust_position_term_thresh,
                Positive,
            ),
            (POSTURE, "inertia", c.inertia, NotNegative),
        ]
    }

    fn limit_rows(&self) -> [Row; 8] {
        const LIMIT: &str = "rmp_params.joint_limit_rmp";
        let l = &self.joint_limit;
        [
            (LIMIT, "metric_scalar", l.metric_scalar, NotNegative),
            (
                LIMIT,
                "metric_length_scale",
                l.metric_length_scale,
                Positive,
            ),
            (
                LIMIT,
                "metric_exploder_eps",
                l.metric_exploder_eps,
                Positive,
            ),
            (
                LIMIT,
                "metric_velocity_gate_length_scale",
                l.metric_velocity_gate_length_scale,
                Positive,
            ),
            (LIMIT, "accel_damper_gain", l.accel_damper_gain, NotNegative),
            (
                LIMIT,
                "accel_potential_gain",
                l.accel_potential_gain,
                NotNegative,
            ),
            (
                LIMIT,
                "accel_potential_exploder_length_scale",
                l.accel_potential_exploder_length_scale,
                Positive,
            ),
            (
                LIMIT,
                "accel_potential_exploder_eps",
                l.accel_potential_exploder_eps,
                Positive,
            ),
        ]
    }

    fn cap_rows(&self) -> [Row; 4] {
        const CAP: &str = "rmp_params.joint_velocity_cap_rmp";
        let v = &self.joint_velocity_cap;
        [
            (CAP, "max_velocity", v.max_velocity, Positive),
            (
                CAP,
                "velocity_damping_region",
                v.velocity_damping_region,
                Positive,
            ),
            (CAP, "damping_gain", v.damping_gain, NotNegative),
            (CAP, "metric_weight", v.metric_weight, NotNegative),
        ]
    }

    fn target_rows(&self) -> [Row; 9] {
        const TARGET: &str = "rmp_params.target_rmp";
        let t = &self.target;
        [
            (TARGET, "accel_p_gain", t.accel_p_gain, NotNegative),
            (TARGET, "accel_d_gain", t.accel_d_gain, NotNegative),
            (TARGET, "accel_norm_eps", t.accel_norm_eps, Positive),
            (
                TARGET,
                "metric_alpha_length_scale",
                t.metric_alpha_length_scale,
                Positive,
            ),
            (TARGET, "min_metric_alpha", t.min_metric_alpha, Share),
            (
                TARGET,
                "max_metric_scalar",
                t.max_metric_scalar,
                NotNegative,
            ),
            (
                TARGET,
                "min_metric_scalar",
                t.min_metric_scalar,
                NotNegative,
            ),
            (TARGET, BOOST, t.proximity_metric_boost_scalar, NotNegative),
            (
                TARGET,
                BOOST_LENGTH,
                t.proximity_metric_boost_length_scale,
                Positive,
            ),
        ]
    }

    fn axis_rows(&self) -> [Row; 5] {
        const AXIS: &str = "rmp_params.axis_target_rmp";
        let a = &self.axis_target;
        [
            (AXIS, "accel_p_gain", a.accel_p_gain, NotNegative),
            (AXIS, "accel_d_gain", a.accel_d_gain, NotNegative),
            (AXIS, "metric_scalar", a.metric_scalar, NotNegative),
            (AXIS, BOOST, a.proximity_metric_boost_scalar, NotNegative),
            (
                AXIS,
                BOOST_LENGTH,
                a.proximity_metric_boost_length_scale,
                Positive,
            ),
        ]
    }

    fn damping_rows(&self) -> [Row; 4] {
        const DAMPING: &str = "rmp_params.damping_rmp";
        const RESOLVE: &str = "canonical_resolve";
        let (d, r) = (&self.damping, &self.canonical_resolve);
        [
            (DAMPING, "accel_d_gain", d.accel_d_gain, NotNegative),
            (DAMPING, "metric_scalar", d.metric_scalar, NotNegative),
            (DAMPING, "inertia", d.inertia, NotNegative),
            (
                RESOLVE,
                "max_acceleration_norm",
                r.max_acceleration_norm,
                Positive,
            ),
        ]
    }

    fn collision_rows(&self) -> [Row; 11] {
        const KEY: &str = "rmp_params.collision_rmp";
        let c = &self.collision;
        [
            (KEY, "damping_gain", c.damping_gain, NotNegative),
            (KEY, "damping_std_dev", c.damping_std_dev, Positive),
            (
                KEY,
                "damping_robustness_eps",
                c.damping_robustness_eps,
                Positive,
            ),
            (
                KEY,
                "damping_velocity_gate_length_scale",
                c.damping_velocity_gate_length_scale,
                Positive,
            ),
            (KEY, "repulsion_gain", c.repulsion_gain, NotNegative),
            (KEY, "repulsion_std_dev", c.repulsion_std_dev, Positive),
            (
                KEY,
                "metric_modulation_radius",
                c.metric_modulation_radius,
                Positive,
            ),
            (KEY, "metric_scalar", c.metric_scalar, NotNegative),
            (
                KEY,
                "metric_exploder_std_dev",
                c.metric_exploder_std_dev,
                Positive,
            ),
            (KEY, "metric_exploder_eps", c.metric_exploder_eps, Positive),
            (
                "canonical_resolve",
                "projection_tolerance",
                self.canonical_resolve.projection_tolerance,
                NotNegative,
            ),
        ]
    }
}

fn check(key: impl Fn() -> String, value: f64, allowed: Allowed) -> Result<(), ParameterError> {
    if allowed.holds(value) {
        Ok(())
    } else {
        Err(ParameterError {
            key: key(),
            value,
            allowed: allowed.text(),
        })
    }
}
