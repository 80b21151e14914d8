//! The loop between a cell and the network.
//!
//! Cell and network may come and go independently: the bridge waits for a cell, serves it until
//! its launcher ends or starts another run, and waits again. Nothing in the loop waits for a
//! client, and a state that is no longer updated is not published.

use std::time::Duration;

use cell_rt::{monotonic_ns, signal, sleep_until};
use thiserror::Error;

use crate::args::Args;
use crate::cell::{JoinError, Joined};
use crate::clock::{wall_ns, wall_of};
use crate::control::{self, Situation};
use crate::endpoints::{self, NamedCommand, Stream};
use crate::log;
use crate::outgoing::{self, Outgoing};
use crate::ros;
use crate::ros::messages::TriggerResponse;
use crate::transport::{Arrived, Transport, TransportError};
use crate::zenoh_link::ZenohLink;

/// Longest time between two reads of commands and events.
// A twentieth of a second would be felt when dragging; 5 ms costs little.
const LOOK_NS: u64 = 5_000_000;
/// Interval of the check whether the cell is running, or running again.
// The check reads a file.
const CELL_NS: u64 = 500_000_000;
/// A state older than this is not published: physics is not running.
const STALE_NS: u64 = 1_000_000_000;

/// Reasons why the bridge ends.
#[derive(Debug, Error)]
pub enum BridgeError {
    /// The network.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// Signals.
    #[error("cannot handle signals: {0}")]
    Signals(#[from] std::io::Error),
}

/// Bridges the cell named by `args` until a signal requests the end, over all of its runs.
///
/// # Errors
/// If the network cannot be used.
pub fn run(args: &Args) -> Result<(), BridgeError> {
    signal::install_stop_handler()?;
    let mut link = ZenohLink::open(args)?;
    for endpoint in args.view_endpoints() {
        log::line(format_args!("viewers connect to {endpoint}"));
    }
    if args.control.is_some() {
        let endpoint = &args.control_listen;
        log::line(format_args!(
            "clients with the token connect to {endpoint} as user `control`"
        ));
    }
    // Each reason is logged once, not twice a second.
    let mut said = String::new();
    while !signal::stop_requested() {
        match Joined::of(&args.cell) {
            Ok(cell) => {
                said.clear();
                bridge(cell, args, &mut link)?;
                // Clients must not call services of a cell that has ended.
                link.offer(&[], &[])?;
            }
            Err(error) => wait_for_cell(&error, &mut said),
        }
    }
    Ok(())
}

/// Logs once why there is no cell, and waits.
fn wait_for_cell(error: &JoinError, said: &mut String) {
    let text = error.to_string();
    if text != *said {
        log::line(format_args!("waiting: {text}"));
        *said = text;
    }
    sleep_until(monotonic_ns() + CELL_NS);
}

/// Bridges one run of a cell until it ends.
fn bridge(
    mut joined: Joined,
    args: &Args,
    link: &mut impl Transport,
) -> Result<(), TransportError> {
    // A copy: messages borrow the cell while the bus is read.
    let cell = joined.cell.clone();
    let commands = endpoints::commands(&cell);
    let outgoing = Outgoing::new(&cell);
    let mut schedule = Schedule::new(args, monotonic_ns());
    link.offer(&schedule.streams(), &commands)?;
    log::line(format_args!(
        "joined cell `{}`: {}",
        args.cell, joined.spec.demo
    ));
    let mut next_check_ns = monotonic_ns() + CELL_NS;
    let mut dropped = link.dropped();
    while !signal::stop_requested() {
        let now_ns = monotonic_ns();
        if now_ns >= next_check_ns {
            // Checked here and not by silence: a paused or
            // restarting physics is silent as well.
            if joined.is_over() {
                log::line(format_args!("cell `{}` has ended", args.cell));
                break;
            }
            if link.dropped() > dropped {
                log::line(format_args!(
                    "{} commands dropped: too many waited",
                    link.dropped() - dropped
                ));
                dropped = link.dropped();
            }
            next_check_ns = now_ns + CELL_NS;
        }
        // Events are published as they are read, so that none is skipped by a rate.
        joined.refresh(|line| {
            if let Some(Ok(event)) = outgoing::event(line).map(|event| ros::encode(&event)) {
                link.publish(Stream::Events, &event, wall_of(line.header.publish_ns));
            }
        });
        // States before commands: the answer to a command must
        // not overtake the state before it.
        publish_due(&joined, &outgoing, &mut schedule, link, now_ns);
        while let Some(arrived) = link.next_command() {
            if let Some(command) = commands.get(arrived.index) {
                answer(&mut joined, command, arrived, args.control.is_some());
            }
        }
        // At most until the next stream is due.
        sleep_until(schedule.next_ns().min(now_ns + LOOK_NS));
    }
    Ok(())
}

/// Publishes the streams that are due.
fn publish_due(
    joined: &Joined,
    outgoing: &Outgoing<'_>,
    schedule: &mut Schedule,
    link: &mut impl Transport,
    now_ns: u64,
) {
    let Some(world) = joined.world() else {
        return;
    };
    let is_stale = now_ns.saturating_sub(world.header.publish_ns) > STALE_NS;
    let source_ns = wall_of(world.header.publish_ns);
    for stream in schedule.due(now_ns) {
        // Due all the same, so that the schedule does not fall behind.
        if is_stale {
            continue;
        }
        match outgoing.message(stream, world, joined.decision()) {
            Ok(message) => link.publish(stream, &message, source_ns),
            Err(error) => log::line(format_args!("{}: {error}", stream.topic())),
        }
    }
}

/// Executes a command of a client, or refuses it; both are logged.
fn answer(joined: &mut Joined, command: &NamedCommand, arrived: Arrived, has_control: bool) {
    let name = &command.name;
    // Checked by the session of the message, not by its content.
    let done = if arrived.may_command {
        ask(joined, command, &arrived)
    } else if has_control {
        Err("commands are accepted at the endpoint for clients with the token".to_owned())
    } else {
        Err("the bridge was started without --control".to_owned())
    };
    match &done {
        Ok(time_s) => log::line(format_args!("{name}: accepted at {time_s:.3} s")),
        Err(reason) => log::line(format_args!("{name}: refused: {reason}")),
    }
    if let Some(reply) = arrived.reply {
        let response = TriggerResponse {
            // Also a refusal is answered: a client of a service waits for it.
            success: done.is_ok(),
            message: done.map_or_else(|reason| reason, |time_s| format!("at {time_s:.3} s")),
        };
        if let Ok(bytes) = ros::encode(&response) {
            reply(bytes);
        }
    }
}

fn ask(joined: &mut Joined, command: &NamedCommand, arrived: &Arrived) -> Result<f64, String> {
    // The age of a target is compared with this state.
    joined.refresh(|_| {});
    let world = joined.world().ok_or("physics has published no state yet")?;
    let now = Situation {
        world,
        policy: &joined.spec.policy,
        wall_ns: wall_ns(),
    };
    let request = control::request(command.command, &arrived.payload, arrived.attachment, &now)?;
    joined.ask(request)
}

/// Due times of the streams.
struct Schedule(Vec<Due>);

struct Due {
    stream: Stream,
    period_ns: u64,
    next_ns: u64,
}

impl Schedule {
    fn new(args: &Args, now_ns: u64) -> Self {
        // A rate of 0 switches a stream off.
        let with_rate = args.rates().into_iter().filter(|(_, rate)| *rate > 0.0);
        let due = |(stream, rate): (Stream, f64)| {
            let period = Duration::from_secs_f64(1.0 / rate);
            Due {
                stream,
                period_ns: u64::try_from(period.as_nanos()).unwrap_or(u64::MAX).max(1),
                next_ns: now_ns,
            }
        };
        Self(with_rate.map(due).collect())
    }

    /// All streams, with that of events.
    fn streams(&self) -> Vec<Stream> {
        let timed = self.0.iter().map(|due| due.stream);
        timed.chain([Stream::Events]).collect()
    }

    fn next_ns(&self) -> u64 {
        self.0
            .iter()
            .map(|due| due.next_ns)
            .min()
            .unwrap_or(u64::MAX)
    }

    /// The streams that are due; missed periods are skipped.
    fn due(&mut self, now_ns: u64) -> Vec<Stream> {
        let mut streams = Vec::new();
        for due in self.0.iter_mut().filter(|due| due.next_ns <= now_ns) {
            streams.push(due.stream);
            // Whole periods, so that the phase of the stream stays.
            let missed = (now_ns - due.next_ns) / due.period_ns;
            due.next_ns += (missed + 1) * due.period_ns;
        }
        streams
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser as _;

    #[test]
    fn a_stream_keeps_its_grid_and_leaves_out_what_it_missed() {
        let args = Args::parse_from([
            "bridge-proc",
            "--rate",
            "tf=0",
            "--rate",
            "joint_states=500",
        ]);
        let mut schedule = Schedule::new(&args, 0);
        assert!(!schedule.streams().contains(&Stream::Transforms));
        let mut times = Vec::new();
        for now_ns in [0, 2_000_000, 3_000_000, 4_100_000, 11_000_000, 12_000_000] {
            if schedule.due(now_ns).contains(&Stream::JointStates) {
                times.push(now_ns);
            }
        }
        assert_eq!(times, [0, 2_000_000, 4_100_000, 11_000_000, 12_000_000]);
        assert_eq!(schedule.next_ns(), 14_000_000);
    }
}
