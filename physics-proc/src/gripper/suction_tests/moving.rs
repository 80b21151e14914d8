//! The read-out while the arm moves.

use nalgebra::Vector3;

use super::hold::Hold;

/// Ticks of the mean that is read out.
const MEAN: usize = 17;

/// Brings the shoulder to `speed` (rad/s) within half a second and continues with
/// it. By tick: the velocity of the block (m/s, world) and the read-out (N).
fn swing(hold: &mut Hold, speed: f64, ticks: usize) -> Vec<(Vector3<f64>, f64)> {
    let ramp = |t: f64| {
        let s = (t / 0.5).min(1.0);
        let rate = speed * s * s * (3.0 - 2.0 * s);
        let push = speed * 6.0 * s * (1.0 - s) / 0.5;
        (rate, push)
    };
    let seen = (0..ticks).map(|tick| {
        let (rate, push) = ramp(tick as f64 * 1.0e-3);
        (hold.rates[1], hold.pushes[1]) = (rate, push);
        hold.joints[1] += rate * 1.0e-3;
        hold.tick();
        let velocity = hold.state().objects[0].twist.linear;
        (Vector3::from(velocity), hold.gripper().suction_force)
    });
    seen.collect()
}

/// Force the cup has to give for the mean acceleration of the last ticks (N).
fn needed(mass: f64, seen: &[(Vector3<f64>, f64)], at: usize) -> f64 {
    let change = seen[at].0 - seen[at - MEAN].0;
    let acceleration = change / (MEAN as f64 * 1.0e-3);
    (mass * (acceleration + Vector3::new(0.0, 0.0, 9.81))).norm()
}

#[test]
fn while_the_arm_moves_it_reads_weight_and_acceleration() {
    for (mass, speed) in [(0.6, 0.35), (0.6, -0.35), (3.0, 0.2), (3.0, 0.5)] {
        let mut hold = Hold::new(mass, [0.0, 0.0], 0.004, 0.0);
        hold.run(500);
        let seen = swing(&mut hold, speed, 1_000);
        let up = seen[900].0.z;
        assert!(up.abs() > 0.1, "it goes up at {up} m/s");
        let ticks = (MEAN..1_000).step_by(7);
        let shares = ticks.map(|at| seen[at].1 / needed(mass, &seen, at));
        let (low, high) = shares.fold((f64::INFINITY, 0.0_f64), |(low, high), share| {
            (low.min(share), high.max(share))
        });
        println!("{mass} kg at {speed} rad/s, {up:.2} m/s up: {low:.4} to {high:.4}");
        assert!(
            low > 0.99 && high < 1.01,
            "{mass} kg at {speed} rad/s: from {low} to {high} of it"
        );
    }
}
