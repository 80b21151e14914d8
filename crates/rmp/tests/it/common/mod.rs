//! Loads a robot from its three files for the tests.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::path::{Path, PathBuf};

use cell_model::robots::xrdf::Xrdf;
use rmp::{Chain, JointLimits, RmpFlow, RmpFlowParameters, RmpFlowSetup};

/// A robot as read from its files.
pub(crate) struct Files {
    pub(crate) chain: Chain,
    pub(crate) velocity: Vec<f64>,
    pub(crate) xrdf: Xrdf,
    pub(crate) parameters: RmpFlowParameters,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
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
        RmpFlow::new(&RmpFlowSetup {
            chain: &self.chain,
            joint_names: &self.xrdf.joint_names,
            default_positions: &self.xrdf.default_joint_positions,
            spheres: &self.xrdf.world_spheres,
            parameters: &self.parameters,
            obstacle_capacity,
        })
        .expect("controller")
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
