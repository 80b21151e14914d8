//! Loads a robot from its three files for the tests.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::path::{Path, PathBuf};

use cell_model::robots::xrdf::Xrdf;
use rmp::{
    Chain, JointLimits, MotionState, RmpFlow, RmpFlowParameters, RmpFlowSetup, SelfCollisionSetup,
    SetupError,
};

/// A robot as read from its files.
pub(crate) struct Files {
    pub(crate) chain: Chain,
    pub(crate) velocity: Vec<f64>,
    pub(crate) xrdf: Xrdf,
    pub(crate) parameters: RmpFlowParameters,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

/// Our own Panda.
pub(crate) fn panda() -> Files {
    load(&root().join("robots/panda"), "panda")
}

/// Our own UR10.
pub(crate) fn ur10() -> Files {
    load(&root().join("robots/ur10"), "ur10")
}

fn load(dir: &Path, name: &str) -> Files {
    let read = |file: String| std::fs::read_to_string(dir.join(&file)).expect(&file);
    let urdf = cell_model::robots::urdf::parse(name, &read(format!("{name}.urdf"))).expect("URDF");
    let xrdf = cell_model::robots::xrdf::parse(name, &read(format!("{name}.xrdf"))).expect("XRDF");
    let tuning = read(format!("{name}_rmpflow.yaml"));
    let velocity = xrdf
        .joint_names
        .iter()
        .map(|joint| urdf.limits[urdf.chain.joint_index(joint).expect(joint)].velocity)
        .collect();
    Files {
        chain: urdf.chain,
        velocity,
        xrdf,
        parameters: cell_model::robots::rmpflow::parse(name, &tuning).expect("tuning"),
    }
}

impl Files {
    pub(crate) fn flow(&self, obstacle_capacity: usize) -> RmpFlow {
        self.try_flow(obstacle_capacity, SelfCollisionSetup::default())
            .expect("controller")
    }

    pub(crate) fn try_flow(
        &self,
        obstacle_capacity: usize,
        self_collision: SelfCollisionSetup<'_>,
    ) -> Result<RmpFlow, SetupError> {
        RmpFlow::new(&RmpFlowSetup {
            chain: &self.chain,
            joint_names: &self.xrdf.joint_names,
            default_positions: &self.xrdf.default_joint_positions,
            spheres: &self.xrdf.world_spheres,
            self_collision,
            parameters: &self.parameters,
            obstacle_capacity,
        })
    }

    pub(crate) fn limits(&self) -> JointLimits {
        let of = |value: fn(&rmp::Joint) -> f64| {
            let joint = |name: &String| {
                value(&self.chain.joints()[self.chain.joint_index(name).expect(name)])
            };
            self.xrdf.joint_names.iter().map(joint).collect()
        };
        JointLimits {
            lower: of(|joint| joint.lower),
            upper: of(|joint| joint.upper),
            velocity: self.velocity.clone(),
            acceleration: self.xrdf.acceleration_limits.clone(),
            jerk: self.xrdf.jerk_limits.clone(),
        }
    }
}

/// One step of 1 ms from `before` to `after` keeps every limit, as physics counts them.
pub(crate) fn assert_within_limits(
    before: &MotionState,
    after: &MotionState,
    limits: &JointLimits,
) {
    let over = 1.0 + 1e-6;
    for i in 0..before.positions.len() {
        let acceleration = (after.velocities[i] - before.velocities[i]) / 1.0e-3;
        let jerk = (acceleration - before.accelerations[i]) / 1.0e-3;
        assert!(after.velocities[i].abs() <= limits.velocity[i] * over);
        assert!(acceleration.abs() <= limits.acceleration[i] * over);
        assert!(jerk.abs() <= limits.jerk[i] * over, "joint {i}: {jerk}");
        assert!(after.positions[i] >= limits.lower[i] - 1e-9);
        assert!(after.positions[i] <= limits.upper[i] + 1e-9);
    }
}

/// A reproducible stream of numbers in [0, 1).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}
