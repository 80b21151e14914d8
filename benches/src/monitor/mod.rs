//! `robocell bench monitor`: the cost of the page, and where it arises.
//!
//! A private cell runs in real time with its page. One viewer receives 60 frames a second: the
//! processor time of the monitor's threads; the recorder has a separate budget. Then the viewer
//! sends a command every 20 ms, like a person during a drag: round trips, and the processor
//! time again. Then 16 clients flood the page in every second of ten pairs of blocks, and
//! controllers report the lateness of their cycles. Last, in as many blocks, the monitor is
//! killed.

mod blocks;
mod client;
mod threads;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::report::{Report, Row};
use cell_model::runs::spec::PageSecrets;
use cell_rt::clock::monotonic_ns;
use cell_rt::process::{SIGKILL, kill};
use ipc_types::Health;
use ipc_types::health::Scheduling;
use ipc_types::topic::Process;

use blocks::Blocks;
use client::{Flood, Viewer};
use supervisor::failure::Failure;
use supervisor::run::plan::Plan;
use supervisor::run::{End, LiveCell};
use threads::Usage;

const SECOND_NS: u64 = 1_000_000_000;
/// The first seconds include the start.
const WARM_UP_NS: u64 = 3 * SECOND_NS;
/// Interval of the kills of the monitor: a shorter life would count as a crash loop.
const KILL_NS: u64 = SECOND_NS + SECOND_NS / 10;
/// Number of flooding clients.
const FLOODERS: usize = 16;

/// Measures for `seconds` with one viewer without commands, as long with one that sends
/// commands, then the blocks, and prints.
pub(crate) fn run(seconds: f64, json: bool) -> Result<(), Failure> {
    let live = LiveCell::start(plan()?)?;
    let Some(secrets) = live.secrets().cloned() else {
        return Err(Failure::configuration("the bench's cell has no page"));
    };
    let mut bench = Bench::new(&live, &secrets, seconds)?;
    let end = live.stay(|live| {
        if live.is_ready() && bench.turn(monotonic_ns(), live) {
            live.stop();
        }
    });
    if let End::GaveUp(failure) = end {
        return Err(failure);
    }
    bench.print(json)
}

/// A real-time run of a private cell, with a page.
fn plan() -> Result<Plan, Failure> {
    use clap::Parser;
    let cell = format!("bench-{}", std::process::id());
    let cli =
        launch::cli::Cli::try_parse_from(["robocell", "run", "franka-stack", "--cell", &cell])
            .map_err(Failure::usage)?;
    match &cli.command {
        launch::cli::Command::Run(args) => launch::run::resolve(args),
        _ => Err(Failure::usage("the bench starts a run")),
    }
}

struct Bench {
    address: std::net::SocketAddr,
    token: String,
    measure_ns: u64,
    fifo: bool,
    began_ns: Option<u64>,
    viewer: Option<Viewer>,
    usage: Option<(Usage, u64)>,
    /// Percent of a core, of the monitor and its recorder: with a viewer without and with
    /// commands.
    costs: Vec<[f64; 2]>,
    flood: Arc<AtomicBool>,
    flooders: Vec<Flood>,
    flooded: Blocks,
    is_flooded: bool,
    killed: Blocks,
    next_kill_ns: u64,
    kills: u64,
    round_trips_ns: Vec<u64>,
    frames: u64,
    refused: u64,
}

impl Bench {
    fn new(live: &LiveCell, secrets: &PageSecrets, seconds: f64) -> Result<Self, Failure> {
        let page = live.spec().page.as_ref();
        let address = page.map(|page| page.address);
        Ok(Self {
            address: address.ok_or_else(|| Failure::configuration("no page"))?,
            token: secrets.operator_token.clone(),
            measure_ns: u64::try_from(Duration::from_secs_f64(seconds).as_nanos())
                .unwrap_or(u64::MAX),
            fifo: false,
            began_ns: None,
            viewer: None,
            usage: None,
            costs: Vec::new(),
            flood: Arc::new(AtomicBool::new(false)),
            flooders: Vec::new(),
            flooded: Blocks::default(),
            is_flooded: false,
            killed: Blocks::default(),
            next_kill_ns: 0,
            kills: 0,
            round_trips_ns: Vec::new(),
            frames: 0,
            refused: 0,
        })
    }

    /// One step; true when everything was measured.
    fn turn(&mut self, now: u64, live: &LiveCell) -> bool {
        let began = *self.began_ns.get_or_insert(now);
        let since = now - began;
        if since < WARM_UP_NS {
            return false;
        }
        let mut end_ns = WARM_UP_NS;
        for (done, asks) in [false, true].into_iter().enumerate() {
            end_ns = end_ns.saturating_add(self.measure_ns);
            if since < end_ns {
                self.watch(now, live, asks);
                return false;
            }
            if self.costs.len() == done {
                self.end_watch(now, live);
            }
        }
        // Without health of the controller there is nothing to compare yet.
        let Some(health) = live.watch().health(Process::Controller(0)) else {
            return false;
        };
        self.fifo = health.scheduling == Scheduling::Fifo.code();
        if !self.is_flooded {
            self.is_flooded = self.flood_in_turn(now, health);
            return false;
        }
        match self.killed.turn(now, health) {
            Some(true) => {
                self.kill_monitor(now, live);
                false
            }
            Some(false) => false,
            None => true,
        }
    }

    fn kill_monitor(&mut self, now: u64, live: &LiveCell) {
        if now < self.next_kill_ns {
            return;
        }
        if let Some(pid) = monitor(live) {
            self.next_kill_ns = now + KILL_NS;
            self.kills += u64::from(kill(pid, SIGKILL).is_ok());
        }
    }

    fn watch(&mut self, now: u64, live: &LiveCell, asks: bool) {
        if self.viewer.is_none() {
            self.viewer = Some(Viewer::start(self.address, self.token.clone(), asks));
        }
        // The first half second includes the whole state.
        if self.usage.is_none() && self.viewer.as_ref().is_some_and(|v| v.frames() > 30) {
            self.usage = monitor(live).map(|pid| (Usage::of(pid), now));
        }
    }

    fn end_watch(&mut self, now: u64, live: &LiveCell) {
        let cost = self.usage.take().zip(monitor(live)).map(|(usage, pid)| {
            let (before, since) = usage;
            let seconds = (now - since) as f64 * 1.0e-9;
            Usage::of(pid).since(&before, seconds)
        });
        // Not a number: a missing figure must not look like a cost of 0.
        self.costs.push(cost.unwrap_or([f64::NAN; 2]));
        if let Some(viewer) = self.viewer.take() {
            let (trips, frames) = viewer.stop();
            self.round_trips_ns.extend(trips);
            self.frames += frames;
        }
    }

    /// True after the last block.
    fn flood_in_turn(&mut self, now: u64, health: &Health) -> bool {
        if self.flooders.is_empty() {
            let start = |_| Flood::start(self.address, self.token.clone(), Arc::clone(&self.flood));
            self.flooders = (0..FLOODERS).map(start).collect();
        }
        let block = self.flooded.turn(now, health);
        let floods = block == Some(true);
        self.flood.store(floods, Ordering::Relaxed);
        // All are stopped before the kills, which must not be measured with a flood.
        if block.is_none() {
            self.refused = self.flooders.drain(..).map(Flood::stop).sum();
        }
        block.is_none()
    }

    fn print(self, json: bool) -> Result<(), Failure> {
        let mut trips = self.round_trips_ns;
        trips.sort_unstable();
        let at = |permille: usize| {
            let rank = (trips.len() * permille).div_ceil(1000).max(1) - 1;
            trips.get(rank).map_or(0.0, |ns| *ns as f64 * 1.0e-3)
        };
        let notes = [
            format!(
                "command round trip p95 {:.3} ms; {} frames seen by the viewer",
                at(950) * 1.0e-3,
                self.frames
            ),
            // Both budgets are separate, so the report has to name them apart.
            "the monitor is all its threads but the recorder's, whose budget is its own".to_owned(),
            format!(
                "missed cycles of the controller without and with {FLOODERS} flooding clients: {} and {}; \
                 {} times the monitor closed on one of them",
                self.flooded.missed[0], self.flooded.missed[1], self.refused
            ),
            format!(
                "the same without and with {} kills of the monitor: {} and {}",
                self.kills, self.killed.missed[0], self.killed.missed[1]
            ),
        ];
        let mut report = Report::new("monitor", self.fifo, &notes);
        let trips_row = [at(500), at(990), at(999), at(1000)];
        report.rows.push(Row::new(
            "command round trip".to_owned(),
            trips.len(),
            trips_row,
        ));
        let phases = [" with one viewer", ", 50 commands a second too"];
        for (phase, costs) in phases.into_iter().zip(self.costs) {
            for (who, percent) in ["monitor", "recorder"].into_iter().zip(costs) {
                let row = Row::new(format!("{who}{phase}"), 1, [percent; 4]);
                report.rows.push(row.in_unit("% of a core"));
            }
        }
        let names = ["controller lateness p99", "the same, flooded"];
        self.flooded.report(&mut report, names);
        let names = ["controller lateness p99 again", "the same, monitor killed"];
        self.killed.report(&mut report, names);
        report
            .write(&mut std::io::stdout().lock(), json)
            .map_err(Failure::configuration)
    }
}

fn monitor(live: &LiveCell) -> Option<u32> {
    let mut pids = live.pids().into_iter();
    pids.find(|(process, _)| *process == Process::Monitor)?.1
}
