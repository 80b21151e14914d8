//! The UR10 on its ways: far targets, postures, corridors, obstacles that come
//! and go. No limit is broken, and the tool arrives.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test fails by panicking"
)]

use crate::support;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use support::{Bench, down};

const DEFAULT: [f64; 6] = [-1.57, -1.57, -1.57, -1.57, 1.57, 0.0];
const PICK: [f64; 6] = [-1.2654, -2.9708, -2.2197, 0.6446, 1.5186, 0.3];
const FLIP: [f64; 6] = [-2.1273, -3.0046, -1.0576, -0.5194, -1.0809, 2.0418];

/// Ticks until the tool was within `near` metres of the goal, at most 8 s.
fn arrive(bench: &mut Bench, near: f64) -> usize {
    for tick in 0..8000 {
        bench.tick(true);
        if bench.error() < near {
            return tick;
        }
    }
    panic!(
        "{} m away after 8 s: {:?}",
        bench.error(),
        bench.command.joint_positions
    );
}

#[test]
fn far_targets_are_reached_and_not_overshot() {
    let mut bench = Bench::new();
    bench.posture(DEFAULT);
    for at in [
        [0.75, -0.3, 0.0],
        [-0.36, 0.9, -0.3],
        [0.84, -0.31, -0.4],
        [0.0, 0.81, 0.58],
    ] {
        bench.goal(at, down(0.3));
        let from = bench.tool().translation.vector;
        let ahead = (Vector3::from(at) - from).normalize();
        arrive(&mut bench, 0.005);
        for _ in 0..1000 {
            bench.tick(true);
            let beyond = (bench.tool().translation.vector - Vector3::from(at)).dot(&ahead);
            assert!(beyond < 5.0e-4, "{at:?} overshot by {beyond}");
            assert!(bench.error() < 0.0051, "{at:?}: {}", bench.error());
        }
        assert!(bench.speed() < 1.0e-3 && bench.error() < 1.0e-3);
    }
    assert_eq!(bench.violations, 0);
}

/// A palletizer's round: pick, flip, place and home with its postures and
/// corridors, its obstacles switched on and off on the way.
fn palletizer_round(bench: &mut Bench, toggle_ticks: usize) {
    let flip = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(
        0.52239, 0.62966, -0.50424, 0.27636,
    ));
    let flip_way = Vector3::new(0.5, -0.3, -0.75).normalize() * 0.4;
    let steps = [
        (
            PICK,
            [0.0, 0.9, -0.15],
            down(0.1),
            [0.0, 0.0, -0.1],
            0.005,
            0b01,
        ),
        (
            FLIP,
            [0.79166, 0.73903, -0.02897],
            flip,
            flip_way.into(),
            0.05,
            0b00,
        ),
        (
            DEFAULT,
            [1.05, -0.31, -0.35],
            down(0.0),
            [0.0, 0.0, -0.35],
            0.005,
            0b10,
        ),
    ];
    for (posture, at, orientation, way, std_dev, mask) in steps {
        if posture == FLIP {
            // Which way the wrist bends decides whether the station is in reach.
            bench.joints(FLIP);
            switch(bench, toggle_ticks, mask);
            settle(bench, FLIP);
        }
        bench.posture(posture);
        bench.goal(at, orientation);
        bench.corridor(way, std_dev);
        switch(bench, toggle_ticks, mask);
        arrive(bench, 0.01);
        // Home by the joints: the wrist turns back, too.
        bench.joints(DEFAULT);
        switch(bench, toggle_ticks, mask);
        settle(bench, DEFAULT);
    }
}

/// Runs until the joints are where they were sent, at most 10 s.
fn settle(bench: &mut Bench, joints: [f64; 6]) {
    let off = |bench: &Bench| {
        let errors = (0..6).map(|j| (bench.command.joint_positions[j] - joints[j]).abs());
        errors.fold(0.0, f64::max)
    };
    let arrived = (0..10_000).any(|_| {
        bench.tick(true);
        off(bench) < 0.05
    });
    assert!(arrived, "{} rad from {joints:?}", off(bench));
}

/// Obstacles come and go in the middle of the way; none in the end.
fn switch(bench: &mut Bench, toggle_ticks: usize, mask: u64) {
    for tick in 0..3 * toggle_ticks {
        let on = (tick / toggle_ticks).is_multiple_of(2);
        bench.decision.goals[0].obstacle_mask = if on { 0b11 } else { mask };
        bench.decision.goals[0].object_mask = if on { 0b111 } else { 0 };
        bench.tick(true);
    }
    bench.decision.goals[0].obstacle_mask = 0;
    bench.decision.goals[0].object_mask = 0;
}

#[test]
fn a_palletizers_round_breaks_no_limit_however_its_obstacles_are_switched() {
    for toggle_ticks in [37, 150, 400] {
        let mut bench = Bench::new();
        bench.put(0, [0.3, 0.8, -0.1]);
        bench.put(1, [0.84, -0.31, -0.5]);
        bench.put(2, [0.5, 0.4, 0.2]);
        palletizer_round(&mut bench, toggle_ticks);
        assert_eq!(bench.violations, 0, "{toggle_ticks}");
    }
}

#[test]
fn attaching_and_letting_go_amid_a_stack_breaks_no_limit() {
    let mut bench = Bench::new();
    bench.decision.goals[0].object_mask = 0b1110;
    for (object, x) in [(1, 0.55), (2, 0.9), (3, 0.75)] {
        bench.put(object, [x, -0.3, -0.45]);
    }
    let hanging = Isometry3::translation(0.0735, 0.0, 0.0);
    for round in 0..6 {
        let x = 0.6 + 0.1 * f64::from(round % 3);
        bench.goal([x, -0.3, -0.2], down(0.2));
        bench.run(900);
        bench.attach(0, &hanging);
        bench.run(700);
        bench.detach();
    }
    assert_eq!(bench.violations, 0);
}

#[test]
fn a_corridor_is_entered_from_its_far_end() {
    let mut bench = Bench::new();
    bench.goal([0.75, -0.3, -0.3], down(0.0));
    bench.corridor([0.0, 0.0, -0.3], 0.005);
    arrive(&mut bench, 0.005);
    assert_eq!(bench.violations, 0);
    // Over the last 0.15 m the tool moves straight down: repeat the approach and check it.
    bench.goal([0.3, 0.7, 0.2], down(0.0));
    bench.corridor([0.0; 3], 0.0);
    arrive(&mut bench, 0.01);
    bench.goal([0.75, -0.3, -0.3], down(0.0));
    bench.corridor([0.0, 0.0, -0.3], 0.005);
    for _ in 0..8000 {
        bench.tick(true);
        let off = bench.tool().translation.vector - Vector3::new(0.75, -0.3, -0.3);
        if off.z < 0.15 {
            assert!(off.xy().norm() < 0.03, "{off}");
        }
    }
    assert!(bench.error() < 0.005, "{}", bench.error());
}
