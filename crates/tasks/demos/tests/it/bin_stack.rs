//! The whole job of stacking 36 bins in a coarse world without dynamics: the cup
//! is where it is sent, and bins are where they are put.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::cast_possible_truncation,
    reason = "helpers of tests"
)]

use cell_model::{Cell, Data};
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{DECISION_TICKS, Decision, GripperGoal, Pose, Wire, WorldState};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use robocell_skills::{geometry, pose};
use robocell_task::Task;

const BINS: usize = 36;
const HEIGHT: f64 = 0.135;

struct World {
    cell: Cell,
    task: Task,
    state: Box<WorldState>,
    held: Option<(usize, Isometry3<f64>)>,
    add_bin: Option<u32>,
    supplied: usize,
    lines: Vec<String>,
    flips: usize,
}

fn task(cell: &Cell) -> Task {
    demos::policies().task(cell, "matrix").unwrap()
}

impl World {
    fn new(bins: u32) -> Self {
        Self::with_base(bins, [0.0; 3])
    }

    fn with_base(bins: u32, base_m: [f64; 3]) -> Self {
        let mut cell = Cell::load(&Data::checkout(), "ur10-bin-stack", 1, None).unwrap();
        cell.limit_bins(bins).unwrap();
        cell.arms[0].base.translation.vector = base_m.into();
        let mut state = Box::new(WorldState::zeroed());
        state.arm_count = 1;
        state.object_count = u32::try_from(cell.objects.len()).unwrap();
        state.panel.task_start = 1;
        state.panel.task_started = 1;
        state.arms[0].joint_count = 6;
        state.arms[0].tcp = Pose {
            position: [-0.0645, 0.7214, 0.495],
            orientation_wxyz: pose::wxyz(&geometry::rotation([0.6234, -0.3342, 0.3339, 0.6231])),
        };
        for object in &mut state.objects {
            object.pose = Pose::IDENTITY;
        }
        Self {
            task: task(&cell),
            cell,
            state,
            held: None,
            add_bin: None,
            supplied: 0,
            lines: Vec::new(),
            flips: 0,
        }
    }

    fn bin(&self, index: usize) -> Isometry3<f64> {
        pose::isometry(&self.state.objects[index].pose)
    }

    /// One decision, and ten ticks of its commands.
    fn step(&mut self) -> Decision {
        let mut decision = Decision::zeroed();
        let mut lines = Vec::new();
        self.task
            .decide(&self.state, &[None], &mut decision, &mut lines);
        self.lines.extend(
            lines
                .iter()
                .filter(|line| line.kind.is_for_people())
                .map(|line| line.text.as_str().to_owned()),
        );
        let goal = decision.goals[0];
        if goal.kind != GoalKind::Hold.code() {
            self.state.arms[0].tcp = goal.target;
        }
        let suction = match GripperGoal::from_code(goal.gripper).unwrap() {
            GripperGoal::Close => 1,
            GripperGoal::Open => 0,
            GripperGoal::Keep => self.state.arms[0].gripper.suction,
        };
        self.switch(suction);
        if let Some((bin, in_cup)) = self.held {
            let cup = pose::isometry(&self.state.arms[0].tcp);
            self.state.objects[bin].pose = pose::wire(&(cup * in_cup));
        }
        self.supply(decision.io.add_bin, decision.io.conveyor_running == 1);
        self.state.header.tick += DECISION_TICKS;
        decision
    }

    fn switch(&mut self, suction: u32) {
        let cup = pose::isometry(&self.state.arms[0].tcp);
        let gripper = &mut self.state.arms[0].gripper;
        let on = suction == 1 && gripper.suction == 0;
        gripper.suction = suction;
        if suction == 0 {
            self.held = None;
        }
        if on {
            let found = (0..BINS).find(|bin| self.touches(&cup, *bin));
            match found {
                Some(bin) => {
                    assert!(!self.covered(bin), "bin {bin} has another one on it");
                    self.held = Some((bin, cup.inverse() * self.bin(bin)));
                }
                None => self.state.arms[0].gripper.refusals += 1,
            }
        }
        let gripper = &mut self.state.arms[0].gripper;
        gripper.attached = u32::from(self.held.is_some());
        gripper.held_object = self
            .held
            .map_or(0, |(bin, _)| u32::try_from(bin + 1).unwrap());
    }

    /// The middle of the floor, inside or outside, is in front of the cup.
    fn touches(&self, cup: &Isometry3<f64>, bin: usize) -> bool {
        let pose = self.bin(bin);
        let enabled = self.state.objects[bin].flags & OBJECT_ENABLED != 0;
        let faces = [-0.5 * HEIGHT, -0.5 * HEIGHT + 0.005];
        let near = faces.iter().any(|z| {
            let face = pose * nalgebra::Point3::new(0.0, 0.0, *z);
            (face.coords - cup.translation.vector).norm() < 0.003
        });
        enabled && near
    }

    fn covered(&self, bin: usize) -> bool {
        let at = self.bin(bin).translation.vector;
        (0..BINS).any(|other| {
            let offset = self.bin(other).translation.vector - at;
            other != bin
                && self.state.objects[other].flags & OBJECT_ENABLED != 0
                && offset.xy().norm() < 0.1
                && offset.z > 0.05
        })
    }

    /// Bins come to the end of the belt at once; every other one upside down.
    fn supply(&mut self, asked: u32, running: bool) {
        let new = self.add_bin.replace(asked).is_some_and(|had| asked > had);
        let end = Vector3::new(0.01, 0.54, -0.45 + 0.5 * HEIGHT);
        let waits = |world: &Self| {
            (0..BINS).find(|bin| {
                let offset = world.bin(*bin).translation.vector - end;
                world.state.objects[*bin].flags & OBJECT_ENABLED != 0 && offset.norm() < 0.02
            })
        };
        if new && self.supplied < self.cell.bins && waits(self).is_none() {
            assert!(running || self.supplied == 0 || waits(self).is_none());
            let over = if self.supplied.is_multiple_of(2) {
                0.0
            } else {
                self.flips += 1;
                std::f64::consts::PI
            };
            let turn = UnitQuaternion::from_euler_angles(over, 0.0, 0.1);
            let pose = Isometry3::from_parts(Translation3::from(end), turn);
            self.state.objects[self.supplied].pose = pose::wire(&pose);
            self.state.objects[self.supplied].flags = OBJECT_ENABLED;
            self.supplied += 1;
        }
        self.state.equipment.sensors[0] =
            waits(self).map_or(0, |bin| u32::try_from(bin + 1).unwrap());
    }

    /// The task is killed, and a new one resumes from its checkpoint.
    fn restart(&mut self) {
        let record = self.task.checkpoint();
        self.task = task(&self.cell);
        self.task.restore(&record).unwrap();
        self.task.reconcile(&self.state);
    }

    /// Runs until the task is done; it is killed after the decisions that `restart` accepts.
    #[track_caller]
    fn finish(&mut self, restart: impl Fn(u32) -> bool) -> Decision {
        for count in 0..200_000 {
            let decision = self.step();
            let outcome = Outcome::from_code(decision.outcome).unwrap();
            assert_ne!(outcome, Outcome::Failed, "{:#?}", self.lines);
            if outcome == Outcome::Done {
                return decision;
            }
            if restart(count) {
                self.restart();
            }
        }
        panic!("not done: {:#?}", self.lines);
    }

    fn count(&self, part: &str) -> usize {
        self.lines.iter().filter(|l| l.contains(part)).count()
    }
}

/// Every bin upside down, in nine columns of four.
#[track_caller]
fn check_columns(world: &World) {
    let mut places: Vec<(i64, i64, i64)> = (0..BINS)
        .map(|bin| {
            let pose = world.bin(bin);
            assert!((pose.rotation * Vector3::z()).z < -0.9999, "bin {bin}");
            let at = pose.translation.vector;
            let index = |value: f64| {
                let rounded = value.round();
                assert!((value - rounded).abs() < 0.02, "bin {bin} at {at}");
                rounded as i64
            };
            (
                index((0.95 - at.x) / 0.215),
                index((at.y + 0.63) / 0.315),
                index((at.z + 0.45) / HEIGHT - 0.5),
            )
        })
        .collect();
    places.sort_unstable();
    let all = (0..3).flat_map(|i| (0..3).flat_map(move |j| (0..4).map(move |k| (i, j, k))));
    assert_eq!(places, all.collect::<Vec<_>>());
}

#[test]
fn all_36_end_upside_down_and_only_those_that_open_upward_are_flipped() {
    let mut world = World::new(36);
    let decision = world.finish(|_| false);
    assert_eq!(decision.placed_count, 36);
    check_columns(&world);
    assert_eq!(world.count("-> flip"), 18);
    assert_eq!(world.count("[placed]"), 36);
    let counted = (decision.drops, decision.recoveries, decision.resyncs);
    assert_eq!(counted, (0, 0, 0), "{:#?}", world.lines);
}

#[test]
fn a_task_that_is_killed_again_and_again_ends_the_same() {
    for interval in [7, 97] {
        let mut world = World::new(36);
        let decision = world.finish(|count| count % interval == interval - 1);
        assert_eq!(decision.placed_count, 36);
        check_columns(&world);
        assert_eq!(world.count("-> flip"), 18, "every {interval} decisions");
        assert_eq!(decision.drops, 0);
    }
}

#[test]
fn a_record_less_start_goes_on_with_what_is_in_the_hand_and_what_stands() {
    let mut world = World::new(4);
    while world.held.is_none() || world.count("[placed]") < 2 {
        world.step();
    }
    world.task = task(&world.cell);
    let decision = world.finish(|_| false);
    assert_eq!(decision.placed_count, 4);
    assert_eq!(world.count("is in the hand"), 1);
}

#[test]
fn a_bin_that_people_put_into_its_slot_counts() {
    let mut world = World::new(2);
    while world.supplied < 1 {
        world.step();
    }
    world.state.panel.task_paused = 1;
    world.step();
    let over = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 1.6);
    let slot = Translation3::new(0.955, -0.632, -0.45 + 0.5 * HEIGHT);
    world.state.objects[0].pose = pose::wire(&Isometry3::from_parts(slot, over));
    world.state.equipment.sensors[0] = 0;
    world.state.panel.task_paused = 0;
    let decision = world.finish(|_| false);
    assert_eq!(decision.placed_count, 2);
    assert_eq!(world.count("[decide] -> place"), 1, "{:#?}", world.lines);
    let above = world.bin(1).translation.vector;
    assert!((above.z - (-0.45 + 1.5 * HEIGHT)).abs() < 0.005, "{above}");
}

/// Puts a bin down (m), opening upward, with its long side along x.
fn put(world: &mut World, bin: usize, at_m: [f64; 3]) {
    let pose = Isometry3::from_parts(Translation3::from(at_m), UnitQuaternion::identity());
    world.state.objects[bin].pose = pose::wire(&pose);
    world.state.objects[bin].flags = OBJECT_ENABLED;
}

#[test]
fn a_bin_in_the_next_slot_that_opens_upward_takes_it_and_is_turned_over_afterwards() {
    let mut world = World::new(2);
    while world.count("-> PLACING") == 0 {
        world.step();
    }
    // On the way of the first bin to its slot a person sets the second one there.
    put(&mut world, 1, [0.95, -0.63, -0.45 + 0.5 * HEIGHT]);
    world.supplied = 2;
    let decision = world.finish(|_| false);
    assert_eq!((decision.placed_count, decision.drops), (2, 0));
    assert_eq!(world.count("[taken] column (0, 0) is taken by bin_02"), 1);
    // It lies across column (1, 0), too: the next one that is free is (0, 1).
    let first = world.bin(0).translation.vector;
    let off = (first.xy() - nalgebra::Vector2::new(0.95, -0.315)).norm();
    assert!(off < 0.01, "{first}");
    let second = world.bin(1);
    assert!((second.translation.vector.x - 0.95).abs() < 0.01);
    assert!((second.rotation * Vector3::z()).z < -0.999, "turned over");
}

#[test]
fn without_a_free_slot_a_bin_waits_in_the_hand_and_the_job_names_what_is_in_the_way() {
    let mut world = World::new(2);
    while world.count("-> PLACING") == 0 {
        world.step();
    }
    // A person holds bins over all columns.
    let columns = (0..3_u8).flat_map(|j| (0..3_u8).map(move |i| (i, j)));
    for (bin, (i, j)) in (10..).zip(columns) {
        let at = [
            0.95 - 0.215 * f64::from(i),
            -0.63 + 0.315 * f64::from(j),
            -0.1,
        ];
        put(&mut world, bin, at);
    }
    for _ in 0..100 {
        world.step();
    }
    assert_eq!(
        world.count("[wait] bin_01: column (0, 0) is taken by bin_11"),
        1
    );
    assert!(world.held.is_some());
    let decision = loop {
        let decision = world.step();
        if decision.outcome != Outcome::Running.code() {
            break decision;
        }
    };
    assert_eq!(decision.reason.as_str(), "place_taken");
    assert_ne!(decision.goals[0].gripper, GripperGoal::Open.code());
}

#[test]
fn a_bin_is_in_reach_by_its_distance_from_the_base_of_the_arm() {
    let picks = |base_m, at_m: [f64; 3]| {
        let mut world = World::with_base(1, base_m);
        while world.supplied < 1 {
            world.step();
        }
        world.state.panel.task_paused = 1;
        world.step();
        let pose = Isometry3::from_parts(Translation3::from(at_m), UnitQuaternion::identity());
        world.state.objects[0].pose = pose::wire(&pose);
        world.state.equipment.sensors[0] = 0;
        world.state.panel.task_paused = 0;
        (0..500).any(|_| {
            world.step();
            world.held.is_some()
        })
    };
    let (near, far) = ([0.9, 0.5, -0.3], [1.1, 0.7, -0.3]);
    assert!(picks([0.0; 3], near));
    assert!(!picks([0.0; 3], far));
    assert!(picks([0.3, 0.2, 0.0], far));
}

#[test]
fn the_belt_stops_for_a_bin_that_comes_in_a_pause() {
    let mut world = World::new(2);
    while world.supplied < 1 {
        world.step();
    }
    world.state.panel.task_paused = 1;
    assert_eq!(world.step().io.conveyor_running, 0);
    // Taken off by hand: room for the next one.
    world.state.objects[0].flags = 0;
    world.state.equipment.sensors[0] = 0;
    assert_eq!(world.step().io.conveyor_running, 1);
}

#[test]
fn a_grip_that_breaks_is_a_drop_and_the_bin_comes_again() {
    let mut world = World::new(1);
    while world.count("-> PLACING") + world.count("-> FLIPPING") == 0 {
        world.step();
    }
    // It falls, is cleared off the floor, and arrives on the belt again.
    world.held = None;
    world.state.objects[0].flags = 0;
    let gripper = &mut world.state.arms[0].gripper;
    (gripper.attached, gripper.held_object, gripper.breaks) = (0, 0, 1);
    gripper.break_limit = 1;
    gripper.break_cause = 2;
    world.supplied = 0;
    let decision = world.finish(|_| false);
    assert_eq!((decision.placed_count, decision.drops), (1, 1));
    assert_eq!(world.count("force limit, by impulse"), 1);
}
