//! Time of one controller tick (all leaves, pose target, resolve) for the Panda
//! with 56 spheres over 0, 10, 20 and 50 random obstacles.
//!
//! `cargo run --release -p robocell-rmp --features measure --example flow_cost`
#![allow(clippy::print_stdout, reason = "prints a table")]

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use cell_model::data::Data;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rmp::{Obstacle, RmpFlow, RmpFlowSetup};

const STATES: usize = 512;
const ROUNDS: usize = 20;

struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("obstacles | median us | p99 us");
    for count in [0, 10, 20, 50] {
        let mut flow = panda(count)?;
        add_obstacles(&mut flow, count)?;
        let (median, p99) = measure(&mut flow)?;
        println!("{count:9} | {median:9.2} | {p99:6.2}");
    }
    Ok(())
}

fn panda(capacity: usize) -> Result<RmpFlow, Box<dyn Error>> {
    let data = Data::checkout();
    let read = |file: &str| data.read(&format!("robots/panda/{file}"));
    let urdf = cell_model::robots::urdf::parse("panda.urdf", &read("panda.urdf")?)?;
    let xrdf = cell_model::robots::xrdf::parse("panda.xrdf", &read("panda.xrdf")?)?;
    let tuning = read("panda_rmpflow.yaml")?;
    let parameters = cell_model::robots::rmpflow::parse("panda_rmpflow.yaml", &tuning)?;
    let mut flow = RmpFlow::new(&RmpFlowSetup {
        chain: &urdf.chain,
        joint_names: &xrdf.joint_names,
        default_positions: &xrdf.default_joint_positions,
        spheres: &xrdf.world_spheres,
        self_collision: rmp::SelfCollisionSetup::default(),
        parameters: &parameters,
        obstacle_capacity: capacity,
    })?;
    let id = flow.add_target_frame(xrdf.tool_frames.first().map_or("panda_hand", |f| f))?;
    flow.set_position_target(id, Some(Vector3::new(0.5, 0.1, 0.4)))?;
    let down = UnitQuaternion::from_euler_angles(3.1, 0.1, 0.0);
    flow.set_orientation_target(id, Some(down))?;
    Ok(flow)
}

/// Boxes and spheres anywhere in the workspace, one sphere in three.
fn add_obstacles(flow: &mut RmpFlow, count: usize) -> Result<(), Box<dyn Error>> {
    let mut random = Random(42);
    while flow.obstacles().len() < count {
        let at = Vector3::new(
            random.between(0.15, 0.85),
            random.between(-0.6, 0.6),
            random.between(0.0, 0.9),
        );
        let sides = Vector3::from_fn(|_, _| random.between(0.04, 0.16));
        let turn = UnitQuaternion::from_euler_angles(
            random.between(-1.5, 1.5),
            random.between(-1.5, 1.5),
            0.0,
        );
        if at.xy().norm() < 0.3 {
            continue;
        }
        let obstacle = if flow.obstacles().len() % 3 == 2 {
            Obstacle::sphere(at, 0.5 * sides.x)
        } else {
            Obstacle::cuboid(Isometry3::from_parts(at.into(), turn), sides)
        };
        flow.obstacles_mut().add(obstacle)?;
    }
    Ok(())
}

fn measure(flow: &mut RmpFlow) -> Result<(f64, f64), Box<dyn Error>> {
    let mut random = Random(7);
    let posture = flow.posture().to_vec();
    let mut jitter = |scale: f64| -> Vec<f64> {
        posture
            .iter()
            .map(|_| random.between(-scale, scale))
            .collect()
    };
    let states: Vec<(Vec<f64>, Vec<f64>)> = (0..STATES)
        .map(|_| {
            let moved = posture
                .iter()
                .zip(jitter(0.9))
                .map(|(q, d)| q + d)
                .collect();
            (moved, jitter(0.5))
        })
        .collect();
    let mut times = Vec::with_capacity(STATES * ROUNDS);
    for _ in 0..ROUNDS {
        for (q, qd) in &states {
            let start = Instant::now();
            flow.evaluate(q, qd)?;
            black_box(flow.resolve_exact());
            times.push(start.elapsed().as_secs_f64() * 1e6);
        }
    }
    times.sort_unstable_by(f64::total_cmp);
    Ok((times[times.len() / 2], times[times.len() * 99 / 100]))
}
