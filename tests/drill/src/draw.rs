//! Draws plans.

use cell_model::cells::script::{ScriptAction, ScriptLine, Trigger};
use cell_model::random::Random;
use clap::ValueEnum;

use crate::plan::{Asked, Fault, Plan, Timed, noise};
use crate::scene::Scene;

mod behaviour;
mod scene;

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

/// Times of a run at which limits are near (ms after something happened): ages of decisions
/// and commands, starts, hangs, kept states, two seconds without a command.
const EDGES_MS: [u64; 12] = [0, 17, 28, 49, 51, 99, 101, 499, 501, 999, 1001, 2001];

/// All processes have started by then (ms).
const STARTED_MS: u64 = 300;

/// Longest time until the launcher has read a line of the script (ms).
const LAUNCHER_READS_MS: u64 = 30;

/// Longer than the time within which a cell in lockstep has to recover (ms).
const LOCKSTEP_RECOVERS_MS: u64 = 26_000;

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
    plan.faults = faults(&mut draw, &plan, arms);
    if draw.percent(40) {
        plan.people = people(&mut draw, plan.horizon_ms);
    }
    if draw.percent(30) {
        plan.script = script(&mut draw, &plan, arms);
    }
    // Whether lockstep has recovered is known late.
    if plan.lockstep && draw.percent(3) {
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

fn faults(draw: &mut Draw, plan: &Plan, arms: u8) -> Vec<Timed> {
    // Without a fault any report is an error of a check.
    let count = match draw.below(10) {
        0 => return Vec::new(),
        1 => 1,
        _ => draw.log(2, 12),
    };
    // A random half of the kinds: kinds hide each other.
    let enabled: Vec<usize> = (0..Fault::KINDS.len())
        .filter(|_| draw.percent(50))
        .collect();
    let enabled = if enabled.is_empty() { vec![0] } else { enabled };
    if draw.percent(15) {
        return burst(draw, plan, arms);
    }
    let mut faults: Vec<Timed> = Vec::new();
    // Most of the starts are over by then.
    let mut last_us = 400_000;
    for _ in 0..count {
        let at_us = if draw.percent(40) {
            draw.below(plan.horizon_ms * 1000)
        } else {
            let edge = draw.one(&EDGES_MS).copied().unwrap_or(0);
            last_us + edge * 1000 + draw.below(2_000)
        };
        let Some(kind) = draw.one(&enabled).copied() else {
            continue;
        };
        if at_us < plan.horizon_ms * 1000 {
            let mut fault = fault(draw, kind, arms);
            last_us = at_us + fault.length_ms() * 1000;
            let before = faults.last().and_then(|before| before.fault.process());
            if let (Fault::Restart { process }, Some(before)) = (&mut fault, before)
                && draw.percent(50)
            {
                // While it hangs, is stopped, or starts.
                before.clone_into(process);
            }
            faults.push(Timed { at_us, fault });
        }
    }
    faults.sort_by_key(|timed| timed.at_us);
    faults
}

/// The same fault of the same process again and again; in lockstep mostly kills of the task, which
/// may not change anything, and of a controller, between any two of its messages.
fn burst(draw: &mut Draw, plan: &Plan, arms: u8) -> Vec<Timed> {
    let fault = if plan.lockstep && draw.percent(70) {
        let process = ["task", "task", "controller-0"][draw.index(3)].to_owned();
        Fault::Kill {
            process,
            effect: None,
        }
    } else {
        let kind = draw.index(Fault::KINDS.len());
        fault(draw, kind, arms)
    };
    let period_us = fault.length_ms() * 1000 + draw.log(20_000, 2_000_000);
    let mut at_us = 400_000;
    let mut faults = Vec::new();
    for _ in 0..draw.log(3, 40) {
        at_us += period_us + draw.below(period_us / 2);
        let mut fault = fault.clone();
        if let Fault::Kill { effect, .. } = &mut fault {
            *effect = draw.percent(70).then(|| draw.log(1, 300) - 1);
        }
        if at_us < plan.horizon_ms * 1000 {
            faults.push(Timed { at_us, fault });
        }
    }
    faults
}

/// Requests: what is paused is resumed some time later.
fn people(draw: &mut Draw, horizon_ms: u64) -> Vec<Asked> {
    let mut people = Vec::new();
    for _ in 0..draw.log(1, 6) {
        // Half of them while the arms are near their start.
        let most_ms = if draw.percent(50) {
            horizon_ms.min(1_500)
        } else {
            horizon_ms
        };
        let at_us = draw.below(most_ms * 1000);
        let after_us = at_us + 1000 * draw.log(5, 1_500);
        let ask = |at_us: u64, action: &str, count: u32| Asked {
            at_us,
            action: action.to_owned(),
            count,
            draw: 0,
        };
        let others = [
            "task_start",
            "drag",
            "target",
            "gripper",
            "drop_parts",
            "add_bin",
        ];
        match draw.below(8) {
            0 => people.push(ask(at_us, "reset", 0)),
            1 => people.push(ask(at_us, "task_reset", 0)),
            2 => {
                people.push(ask(at_us, "task_pause", 0));
                people.push(ask(after_us, "task_resume", 0));
            }
            3 => {
                people.push(ask(at_us, "step", 5));
                people.push(ask(after_us, "resume", 0));
            }
            4 | 5 => {
                people.push(ask(at_us, "pause", 0));
                people.push(ask(after_us, "resume", 0));
            }
            _ => {
                let action = others[draw.index(others.len())];
                let count = u32::try_from(draw.below(4)).unwrap_or(0);
                let draw = draw.below(u64::MAX);
                people.push(Asked {
                    draw,
                    ..ask(at_us, action, count)
                });
            }
        }
    }
    people.sort_by_key(|asked| asked.at_us);
    people
}

/// Lines about processes.
fn script(draw: &mut Draw, plan: &Plan, arms: u8) -> Vec<String> {
    let all = ipc_types::topic::Process::all(arms);
    let mut lines: Vec<(u64, String)> = Vec::new();
    for _ in 0..draw.log(1, 4) {
        let ms = draw.below(plan.horizon_ms);
        let of = draw.one(&all).map_or_else(String::new, |of| of.name());
        if draw.percent(25) {
            lines.push((ms, machine_line(draw)));
            continue;
        }
        if !draw.percent(70) {
            let for_s = draw.log(20, 1_500) as f64 * 1.0e-3;
            lines.push((
                ms,
                format!("\"stop\", \"process\": \"{of}\", \"for_s\": {for_s}"),
            ));
            continue;
        }
        let kill = format!("\"kill\", \"process\": \"{of}\"");
        // Its successor may be starting.
        if draw.percent(30) {
            lines.push((ms + draw.log(1, 60), kill.clone()));
        }
        lines.push((ms, kill));
    }
    lines.sort();
    let line = |(ms, what): (u64, String)| {
        let at_s = ms as f64 * 1.0e-3;
        format!("{{\"at_s\": {at_s}, \"do\": {what}}}")
    };
    lines.into_iter().map(line).collect()
}

/// A line about the machine, or about simulated time.
fn machine_line(draw: &mut Draw) -> String {
    let for_s = draw.log(20, 1_500) as f64 * 1.0e-3;
    match draw.below(4) {
        0 => format!("\"starve\", \"for_s\": {for_s}"),
        1 => format!("\"fill\", \"for_s\": {for_s}"),
        2 => "\"restart\", \"process\": \"task\"".to_owned(),
        _ => format!("\"pause\", \"for_s\": {for_s}"),
    }
}

fn fault(draw: &mut Draw, kind: usize, arms: u8) -> Fault {
    let all = ipc_types::topic::Process::all(arms);
    let of = draw
        .one(&all)
        .map_or_else(String::new, |process| process.name());
    match kind {
        1 => Fault::Stop {
            process: of,
            for_ms: draw.log(50, 2_500),
        },
        2 => Fault::Starve {
            process: of,
            for_ms: draw.log(20, 3_000),
        },
        3 => Fault::Full {
            for_ms: draw.log(200, 5_000),
        },
        4 => Fault::SlowDisk {
            for_ms: draw.log(200, 5_000),
            write_ms: draw.log(100, 3_000),
        },
        5 => Fault::FailedStart { process: of },
        6 => Fault::SlowStart {
            process: of,
            for_ms: draw.log(200, 1_900),
        },
        7 => Fault::Launcher {
            for_ms: draw.log(20, 500),
        },
        8 => Fault::Busy {
            process: of,
            for_ms: draw.log(20, 1_000),
            turn_us: draw.log(300, 60_000),
        },
        9 => Fault::Hang { process: of },
        10 => Fault::Restart { process: of },
        _ => Fault::Kill {
            process: of,
            effect: draw.percent(50).then(|| draw.log(1, 3_000) - 1),
        },
    }
}
