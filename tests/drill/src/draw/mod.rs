//! Draws plans.

use cell_model::cells::script::{ScriptAction, ScriptLine, Trigger};
use cell_model::random::Random;
use clap::ValueEnum;

use crate::plan::{Asked, Fault, Plan, Timed, noise};
use crate::scene::Scene;

mod behaviour;
mod faults;
mod people;
mod scene;

use faults::faults;
use people::{people, script};

/// What the plans of a batch are about. All levels run the same code; the scenes differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Level {
    /// Arms of one joint and a task that costs nothing: loops, slots, fences and supervision.
    Loops,
    /// Generated arms that RMPflow moves.
    Motion,
    /// The demos, and generated scenes of up to 160 objects.
    Whole,
    /// All of them.
    Mixed,
}

/// Scenes with their policies: arms of both kinds, two arms, equipment.
const SCENES: [(&str, &[&str]); 7] = [
    ("franka-stack", &["fsm", "ifelse", "bt"]),
    (
        "cube",
        &["ifelse", "fsm", "tree", "json", "table", "matrix"],
    ),
    ("franka-pyramid", &["json"]),
    ("ur10-palletize", &["table"]),
    ("ur10-fill-bin", &["matrix"]),
    ("ur10-bin-stack", &["matrix"]),
    ("reach", &["follow"]),
];

/// All processes have started by then (ms).
const STARTED_MS: u64 = 300;

/// Longest time until the launcher has read a line of the script (ms).
const LAUNCHER_READS_MS: u64 = 30;

/// Longer than the time within which a cell in lockstep has to recover (ms).
const LOCKSTEP_RECOVERS_MS: u64 = 26_000;

/// One plan of the level `loops` in so many is of minutes, where plans may be as long as this (ms).
const SILENT: u64 = 50;
const SILENT_FROM_MS: u64 = 4_000;
/// Longer than a counter of 16 bits counts (ms).
const SILENCE_MS: u64 = 66_000;
/// A cell recovers within this (ms).
const SILENCE_ENDS_MS: u64 = 8_000;

/// A stream of draws.
struct Draw(Random);

impl Draw {
    fn below(&mut self, below: u64) -> u64 {
        self.0.bits() % below.max(1)
    }

    fn percent(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }

    /// Between the two, small ones as often as large ones.
    fn log(&mut self, least: u64, most: u64) -> u64 {
        let (least, most) = (least as f64, most as f64);
        let part = self.below(1_000_001) as f64 * 1.0e-6;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between two positive whole numbers"
        )]
        let drawn = (least * (most / least).powf(part)) as u64;
        drawn
    }

    fn index(&mut self, below: usize) -> usize {
        usize::try_from(self.below(below as u64)).unwrap_or(0)
    }

    fn one<'a, T>(&mut self, of: &'a [T]) -> Option<&'a T> {
        let index = self.below(of.len() as u64);
        of.get(usize::try_from(index).ok()?)
    }
}

/// The plan of `seed`, with a time of at most `longest_ms`.
pub fn plan(seed: u64, level: Level, longest_ms: u64) -> Plan {
    let mut draw = Draw(Random::new(noise(seed, 3, 0)));
    let level = match (level, draw.below(10)) {
        (Level::Mixed, 0..=5) => Level::Loops,
        (Level::Mixed, 6 | 7) => Level::Motion,
        (Level::Mixed, _) => Level::Whole,
        (level, _) => level,
    };
    let scene = match level {
        Level::Loops => Some(scene::small(&mut draw)),
        Level::Motion => Some(scene::arms(&mut draw)),
        Level::Whole | Level::Mixed => draw.percent(50).then(|| scene::whole(&mut draw)),
    };
    let longest_ms = longest_ms / scene.as_ref().map_or(1, weight);
    let mut plan = plan_of(&mut draw, seed, scene);
    plan.lockstep = draw.percent(40);
    plan.fifo = draw.percent(70);
    plan.horizon_ms = draw.log(2_000.min(longest_ms), longest_ms);
    let arms = arms(&plan);
    if level == Level::Loops && longest_ms >= SILENT_FROM_MS && draw.below(SILENT) == 0 {
        return silent(&mut draw, plan, arms);
    }
    plan.faults = faults(&mut draw, &plan, arms);
    if draw.percent(40) {
        plan.people = people(&mut draw, plan.horizon_ms);
    }
    if draw.percent(30) {
        plan.script = script(&mut draw, &plan, arms);
    }
    // Whether lockstep has recovered is known late. With many objects that takes minutes.
    let is_light = plan.scene.as_ref().is_none_or(|scene| weight(scene) == 1);
    if plan.lockstep && is_light && draw.percent(3) {
        plan.horizon_ms += LOCKSTEP_RECOVERS_MS;
    }
    if !plan.faults.is_empty() && draw.percent(60) {
        let at_us = if !plan.script.is_empty() && draw.percent(50) {
            while_a_line_waits(&mut draw, &plan.script)
        } else {
            soon_after(&mut draw, &plan.faults)
        };
        let process = ipc_types::topic::Process::Physics.name();
        let effect = None;
        let kill = Fault::Kill { process, effect };
        let at_us = at_us.filter(|at_us| *at_us < plan.horizon_ms * 1000);
        plan.faults
            .extend(at_us.map(|at_us| Timed { at_us, fault: kill }));
        plan.faults.sort_by_key(|timed| timed.at_us);
    }
    plan
}

/// A plan of minutes: a process lacks a core, or people pause the cell, for longer than a counter
/// of 16 bits counts milliseconds. Physics, or what was silent, is killed afterwards.
fn silent(draw: &mut Draw, mut plan: Plan, arms: u8) -> Plan {
    let all = ipc_types::topic::Process::all(arms);
    let of = draw.one(&all).map_or_else(String::new, |of| of.name());
    let begins_us = 400_000 + draw.below(2_000_000);
    let for_ms = draw.log(SILENCE_MS, 2 * SILENCE_MS);
    let ends_us = begins_us + 1000 * for_ms;
    plan.lockstep = false;
    if draw.percent(70) {
        let fault = Fault::Starve {
            process: of.clone(),
            for_ms,
        };
        let at_us = begins_us;
        plan.faults.push(Timed { at_us, fault });
    } else {
        let ask = |at_us, action: &str| Asked {
            at_us,
            action: action.to_owned(),
            count: 0,
            draw: 0,
        };
        plan.people = vec![ask(begins_us, "pause"), ask(ends_us, "resume")];
    }
    let physics = ipc_types::topic::Process::Physics.name();
    let process = if draw.percent(50) { physics } else { of };
    plan.faults.push(Timed {
        at_us: ends_us + draw.below(1_000_000),
        fault: Fault::Kill {
            process,
            effect: None,
        },
    });
    plan.horizon_ms = ends_us / 1000 + SILENCE_ENDS_MS;
    plan
}

/// A time until the second state after a fault is saved (us).
fn soon_after(draw: &mut Draw, faults: &[Timed]) -> Option<u64> {
    let before = draw.one(faults)?;
    Some(before.at_us + 1000 * (before.fault.length_ms() + draw.log(10, 1_000)))
}

/// A time at which a line of the script waits for the launcher (us).
fn while_a_line_waits(draw: &mut Draw, script: &[String]) -> Option<u64> {
    let line: ScriptLine = serde_json::from_str(draw.one(script)?).ok()?;
    let Trigger::Time { at_s } = line.trigger else {
        return None;
    };
    let waits_ms = match line.action {
        ScriptAction::Pause { for_s } => crate::plan::ticks(for_s.unwrap_or_default()),
        _ => LAUNCHER_READS_MS,
    };
    let at_ms = STARTED_MS + crate::plan::ticks(at_s) + draw.below(waits_ms);
    Some(at_ms * 1000 + draw.below(1000))
}

/// How much shorter a run has to be for its cost.
fn weight(scene: &Scene) -> u64 {
    1 + scene.objects.len() as u64 / 30
}

/// A plan in which nothing happens.
fn plan_of(draw: &mut Draw, seed: u64, scene: Option<Scene>) -> Plan {
    let (demo, policies) = draw.one(&SCENES).copied().unwrap_or(SCENES[0]);
    let policy = draw.one(policies).copied().unwrap_or_default();
    let policy = scene.as_ref().map_or(policy, Scene::policy).to_owned();
    let demo = if scene.is_some() {
        crate::scene::NAME
    } else {
        demo
    };
    Plan {
        seed,
        demo: demo.to_owned(),
        scene,
        policy,
        lockstep: true,
        fifo: false,
        horizon_ms: 0,
        limit_s: None,
        faults: Vec::new(),
        script: Vec::new(),
        people: Vec::new(),
    }
}

/// A plan that a real cell can play: in lockstep, with lines of a script that take no process
/// back in time.
pub fn scripted(seed: u64) -> Plan {
    let mut draw = Draw(Random::new(noise(seed, 4, 0)));
    let mut plan = plan_of(&mut draw, seed, None);
    let limit_s = 4 + u32::try_from(draw.below(6)).unwrap_or(0);
    plan.horizon_ms = 1000 * u64::from(limit_s);
    plan.limit_s = Some(limit_s);
    let arms = arms(&plan);
    plan.script = script(&mut draw, &plan, arms);
    // Which state a killed physics resumes from depends on the disk.
    plan.script
        .retain(|line| !line.contains("physics") && !line.contains("fill"));
    // The run ends with its limit, however long the processes take.
    plan.horizon_ms = 600_000;
    plan
}

/// Number of arms.
fn arms(plan: &Plan) -> u8 {
    let of_demo = if plan.demo == "franka-pyramid" { 2 } else { 1 };
    plan.scene.as_ref().map_or(of_demo, |scene| scene.arms)
}
