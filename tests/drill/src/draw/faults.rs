//! Draws faults.

use ipc_types::topic::Process;

use super::Draw;
use crate::plan::{Fault, Plan, Timed};

/// Times of a run at which limits are near (ms after something happened): ages of decisions
/// and commands, starts, hangs, kept states, two seconds without a command.
const EDGES_MS: [u64; 12] = [0, 17, 28, 49, 51, 99, 101, 499, 501, 999, 1001, 2001];

pub(super) fn faults(draw: &mut Draw, plan: &Plan, arms: u8) -> Vec<Timed> {
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
            let mut fault = fault(draw, kind, plan, arms);
            last_us = at_us + fault.length_ms() * 1000;
            let before = faults.last().and_then(|before| before.fault.process());
            if let (Fault::Restart { process }, Some(before)) = (&mut fault, before)
                && draw.percent(50)
            {
                // While it hangs, is stopped, or starts.
                before.clone_into(process);
            }
            let start = start_on(draw, at_us, &fault);
            faults.push(Timed { at_us, fault });
            faults.extend(start.filter(|start| start.at_us < plan.horizon_ms * 1000));
        }
    }
    faults.sort_by_key(|timed| timed.at_us);
    faults
}

/// A kill of the process that reads the file which `fault` damages at `at_us`: files are read at a
/// start, and a damaged record is soon replaced by a newer one.
fn start_on(draw: &mut Draw, at_us: u64, fault: &Fault) -> Option<Timed> {
    let Fault::DamageFile { file, .. } = fault else {
        return None;
    };
    if draw.percent(20) {
        return None;
    }
    // Its start takes 12 ms or more, so the damage may also fall into it.
    let at_us = if draw.percent(50) {
        at_us + draw.below(2_000)
    } else {
        at_us.saturating_sub(draw.below(10_000))
    };
    let process = file.split('.').next().unwrap_or_default().to_owned();
    let effect = None;
    let fault = Fault::Kill { process, effect };
    Some(Timed { at_us, fault })
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
        fault(draw, kind, plan, arms)
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

fn fault(draw: &mut Draw, kind: usize, plan: &Plan, arms: u8) -> Fault {
    let all = Process::all(arms);
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
        11 => Fault::DamageFile {
            file: Fault::FILES[draw.index(Fault::FILES.len())].to_owned(),
            draw: draw.below(u64::MAX),
        },
        12 => Fault::CutWrite {
            steps: draw.below(6),
        },
        13..=15 => disturbance(draw, kind, plan, arms),
        16 => Fault::Preempt {
            // Physics has the most effects in a turn, and the others wait for it.
            process: if draw.percent(50) {
                Process::Physics.name()
            } else {
                of
            },
            for_ms: draw.log(20, 1_000),
            gap_us: draw.log(20, 900),
        },
        _ => Fault::Kill {
            process: of,
            effect: draw.percent(50).then(|| draw.log(1, 3_000) - 1),
        },
    }
}

/// What happens to messages. In lockstep none may be lost or late: every process waits for every
/// message, on memory that keeps it. One that comes again after a newer one may displace a third.
fn disturbance(draw: &mut Draw, kind: usize, plan: &Plan, arms: u8) -> Fault {
    let topics = crate::plan::topics(arms);
    let topic = draw.one(&topics).map(|(name, _)| name.clone());
    let topic = topic.unwrap_or_default();
    let after = u32::try_from(draw.below(4)).unwrap_or(0);
    match kind {
        13 if !plan.lockstep => Fault::Damage {
            topic,
            draw: draw.below(u64::MAX),
        },
        15 if !plan.lockstep => Fault::Late {
            topic,
            after: after.max(1),
        },
        _ => Fault::Repeat {
            topic,
            after: if plan.lockstep { 0 } else { after },
            count: u32::try_from(draw.log(1, 500)).unwrap_or(1),
        },
    }
}
