//! The three jobs of the UR10 under all disturbances, at random from seeds: bins taken away and
//! shoved, grips broken, suction that leaks, an arm that is stuck past every timeout, the task
//! killed and restored, missed decisions, pauses with the operator leading, opening and
//! closing, resets.
//!
//! Shown: nothing panics and every decision is one its receivers take; suction
//! is never switched off around a bin but where the job sets it down, at a reset
//! and at the operator's command; and undisturbed again, after another start if
//! it was given up, the job gets done. And of records: one that is cut, damaged
//! or of nonsense is refused or continued from, never with a panic.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use crate::ur10_world;

use cell_model::random::Random;
use ipc_types::GripperGoal;
use ipc_types::decision::Outcome;
use ur10_world::{PLACES, Placement, World};

/// Undisturbed, a job takes fewer decisions.
const PATIENCE: usize = 40_000;

struct Disturbed {
    world: World,
    random: Random,
    /// Number of further decisions for which the fault of arm or suction lasts.
    hindered: u64,
    /// Until then the operator leads.
    paused: u64,
    /// Suction may open: the operator or a reset commanded it.
    excused: bool,
}

impl Disturbed {
    fn new(place: &'static Placement, seed: u64) -> Self {
        Self {
            world: World::new(place, 2),
            random: Random::new(seed),
            hindered: 0,
            paused: 0,
            excused: false,
        }
    }

    fn below(&mut self, most: u64) -> u64 {
        self.random.bits() % most
    }

    fn length(&mut self) -> f64 {
        self.below(401) as f64 * 0.001 - 0.2
    }

    /// Something happens, on average every 80 decisions.
    fn disturb(&mut self) {
        let which = usize::try_from(self.below(2)).unwrap();
        let by = [self.length(), self.length(), self.length()];
        let world = &mut self.world;
        match self.random.bits() % 1000 {
            0 => world.break_grip(),
            1 => world.take_away(which),
            2 => world.shove(which, [by[0], by[1]]),
            3 => (self.hindered, world.leaky) = (300, true),
            4 => (self.hindered, world.stuck) = (4000, true),
            5 => self.paused = 150,
            6 => {
                world.state.panel.task_reset += 1;
                world.state.panel.task_start += 1;
                self.excused = true;
            }
            7 => world.state.header.tick += 700,
            8 if self.paused > 0 => world.lead(by),
            9 if self.paused > 0 => self.ask(GripperGoal::Open),
            10 if self.paused > 0 => self.ask(GripperGoal::Close),
            11 => world.state.panel.task_start += 1,
            _ => {}
        }
    }

    fn ask(&mut self, goal: GripperGoal) {
        self.excused |= goal == GripperGoal::Open;
        let panel = &mut self.world.state.panel;
        (panel.gripper, panel.gripper_seq) = (goal.code(), panel.gripper_seq + 1);
    }

    fn step(&mut self) {
        self.hindered = self.hindered.saturating_sub(1);
        if self.hindered == 0 {
            (self.world.leaky, self.world.stuck) = (false, false);
        }
        self.paused = self.paused.saturating_sub(1);
        self.world.state.panel.task_paused = u32::from(self.paused > 0);
        let tick = self.world.state.header.tick;
        if self.random.bits().is_multiple_of(5) {
            assert!(self.world.restart(None), "its own record");
            // Now and then decisions were missed meanwhile.
            if self.random.bits().is_multiple_of(50) {
                self.world.task.reconcile(&self.world.state);
            }
        }
        let held = self.world.holds();
        self.world.step();
        assert!(self.world.state.header.tick > tick);
        if held && self.world.gripper() == GripperGoal::Open {
            let phase = self.world.decision.phase.as_str();
            let sets_down = match self.world.place.policy {
                "table" => phase == "OpenSuctionGripper",
                _ if self.world.place.demo == "ur10-fill-bin" => self.tips_over(),
                _ => phase == "DETACH",
            };
            assert!(
                sets_down || self.excused,
                "lets go in {phase}: {}",
                self.story()
            );
        }
        self.excused &= self.world.holds() || self.paused > 0;
    }

    /// A bin that hangs upside down is dropped, according to the log.
    fn tips_over(&self) -> bool {
        let mut lines = self.world.lines.iter().rev().take(12);
        lines.any(|line| line.contains("upside down") || line.contains("[timeout]"))
    }

    /// A user fetches the bins that are out of the arm's reach.
    fn bring_back(&mut self) {
        if self.world.decision.reason.as_str() == "bin_out_of_reach" {
            (0..2).for_each(|bin| self.world.take_away(bin));
        }
    }

    fn story(&self) -> String {
        let from = self.world.lines.len().saturating_sub(30);
        self.world.lines[from..].join("\n")
    }

    #[track_caller]
    fn gets_done(&mut self) {
        (self.hindered, self.paused) = (0, 0);
        for _ in 0..PATIENCE {
            match self.world.outcome() {
                Outcome::Done => return,
                Outcome::Failed | Outcome::Idle => {
                    self.bring_back();
                    self.world.state.panel.task_start += 1;
                }
                _ => {}
            }
            self.step();
        }
        let phase = self.world.decision.phase.as_str().to_owned();
        let bins = self.world.bins();
        panic!("never done, in {phase}, {bins}: {}", self.story());
    }
}

fn disturb_all(place: &'static Placement, seeds: u64) {
    for seed in 0..seeds {
        let mut job = Disturbed::new(place, seed);
        for _ in 0..4 {
            for _ in 0..2_000 {
                job.disturb();
                job.step();
            }
            job.gets_done();
        }
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn palletizing_gets_done_whatever_happens() {
    disturb_all(&PLACES[0], 8);
}

#[test]
#[ignore = "slow: .ci/long"]
fn bin_stacking_gets_done_whatever_happens() {
    disturb_all(&PLACES[1], 8);
}

#[test]
fn filling_gets_done_whatever_happens() {
    disturb_all(&PLACES[2], 2);
}

#[test]
#[ignore = "slow: .ci/long"]
fn filling_gets_done_whatever_happens_in_a_long_series() {
    disturb_all(&PLACES[2], 8);
}

#[test]
fn a_task_restored_before_every_decision_decides_the_same() {
    for place in &PLACES {
        let (mut whole, mut restarted) = (World::new(place, 2), World::new(place, 2));
        for step in 0..4_000 {
            assert!(restarted.restart(None));
            whole.step();
            restarted.step();
            assert_eq!(whole.decision, restarted.decision, "{}, {step}", place.demo);
        }
        assert_eq!(whole.lines, restarted.lines);
        assert!(whole.lines.len() > 8, "{:?}", whole.lines);
    }
}

#[test]
fn an_arm_that_cannot_go_on_keeps_its_bin_and_goes_on_when_it_can() {
    for place in &PLACES[..2] {
        let mut job = Disturbed::new(place, 1);
        while !job.world.holds() {
            job.world.step();
        }
        (0..20).for_each(|_| job.world.step());
        job.world.stuck = true;
        for _ in 0..12_000 {
            job.world.step();
            assert!(job.world.holds(), "{}", job.story());
        }
        assert_eq!(job.world.outcome(), Outcome::Failed, "{}", place.demo);
        job.world.stuck = false;
        job.world.state.panel.task_start += 1;
        job.world.step();
        job.gets_done();
        assert_eq!(job.world.decision.drops, 0, "{}", job.story());
    }
}

/// Some of its bytes are changed, from eight bytes of ones to one bit.
fn damage(record: &mut [u8], random: &mut Random) {
    let at = usize::try_from(random.bits()).unwrap_or(0) % record.len();
    match random.bits() % 4 {
        0 => record[at] ^= 1 << (random.bits() % 8),
        1 => record[at] = 0,
        2 => record.iter_mut().skip(at).take(8).for_each(|b| *b = 0xff),
        _ => record.iter_mut().skip(at).take(8).for_each(|b| *b ^= 0x7f),
    }
}

#[test]
fn a_damaged_record_is_refused_or_gone_on_from() {
    for place in &PLACES {
        let mut world = World::new(place, 2);
        let mut random = Random::new(7);
        let (mut taken, mut refused) = (0, 0);
        for count in 0..1500 {
            world.step();
            if count % 5 > 0 {
                continue;
            }
            let whole = world.task.checkpoint();
            let cut = usize::try_from(random.bits()).unwrap_or(0) % whole.len();
            let mut other = World::new(place, 2);
            assert!(!other.restart(Some(&whole[..cut])), "cut at {cut}");
            let mut record = whole.clone();
            damage(&mut record, &mut random);
            *other.state = *world.state;
            if other.restart(Some(&record)) {
                taken += 1;
            } else {
                refused += 1;
            }
            (0..5).for_each(|_| other.step());
        }
        assert!(
            taken > 20 && refused > 20,
            "{taken} taken, {refused} refused"
        );
    }
}
