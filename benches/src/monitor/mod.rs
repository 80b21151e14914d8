//! `robocell bench monitor`: what the page costs, and whom.
//!
//! A private cell runs in real time with its page. One viewer looks at 60 Hz:
//! the processor time of the monitor's threads, of which the recorder's has a
//! budget of its own. Then the viewer sends a command every 20 ms, as a hand that
//! drags does: round trips, and the processor time again. Then 16 clients flood
//! the page in every second of ten pairs of blocks, and controllers say how late
//! their cycles began.

mod client;
mod threads;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::report::{Report, Row};
use cell_model::runs::spec::PageSecrets;
use cell_rt::clock::monotonic_ns;
use ipc_types::health::Scheduling;
use ipc_types::topic::Process;

use client::{Flood, Viewer};
use launch::failure::{Code, Failure};
use launch::run::{End, LiveCell, Plan};
use threads::Usage;

const SECOND_NS: u64 = 1_000_000_000;
/// The first seconds hold the start.
const WARM_UP_NS: u64 = 3 * SECOND_NS;
/// Health speaks of the last second; a block has to be longer.
const BLOCK_NS: u64 = 2 * SECOND_NS;
/// Pairs of blocks, without and with the flood.
const PAIRS: usize = 10;
/// Clients that flood.
const FLOODERS: usize = 16;

/// Measures for `seconds` with one viewer that looks, as long with one that asks,
/// then the blocks, and prints.
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
    if let End::GaveUp(message) = end {
        return Err(Failure {
            code: Code::GaveUp,
            message,
        });
    }
    bench.print(json)
}

/// A real-time run of a cell of its own, with a page.
fn plan() -> Result<Plan, Failure> {
    use clap::Parser;
    let cell = format!("bench-{}", std::process::id());
    let cli =
        launch::cli::Cli::try_parse_from(["robocell", "run", "franka-stack", "--cell", &cell])
            .map_err(Failure::usage)?;
    match &cli.command {
        launch::cli::Command::Run(args) => Plan::resolve(args),
        _ => Err(Failure::usage("the bench starts a run")),
    }
}

/// Controllers' lateness p99 (us) and missed cycles in blocks of one kind.
#[derive(Default)]
struct Blocks {
    lateness_us: Vec<f64>,
    missed: u64,
}

struct Bench {
    address: std::net::SocketAddr,
    token: String,
    measure_ns: u64,
    fifo: bool,
    began_ns: Option<u64>,
    viewer: Option<Viewer>,
    usage: Option<(Usage, u64)>,
    /// Percent of a core, of the monitor and its recorder: with a viewer that
    /// looks, and with one that asks.
    costs: Vec<[f64; 2]>,
    flood: Arc<AtomicBool>,
    flooders: Vec<Flood>,
    block: usize,
    block_began: (u64, u64),
    blocks: [Blocks; 2],
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
            block: 0,
            block_began: (0, 0),
            blocks: Default::default(),
            round_trips_ns: Vec::new(),
            frames: 0,
            refused: 0,
        })
    }

    /// One look; true when everything was measured.
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
                self.look(now, live, asks);
                return false;
            }
            if self.costs.len() == done {
                self.end_look(now, live);
            }
        }
        self.flood_in_turn(now, live)
    }

    fn look(&mut self, now: u64, live: &LiveCell, asks: bool) {
        if self.viewer.is_none() {
            self.viewer = Some(Viewer::start(self.address, self.token.clone(), asks));
        }
        // The first half second brings the story so far.
        if self.usage.is_none() && self.viewer.as_ref().is_some_and(|v| v.frames() > 30) {
            self.usage = monitor(live).map(|pid| (Usage::of(pid), now));
        }
    }

    fn end_look(&mut self, now: u64, live: &LiveCell) {
        let cost = self.usage.take().zip(monitor(live)).map(|(usage, pid)| {
            let (before, since) = usage;
            let seconds = (now - since) as f64 * 1.0e-9;
            Usage::of(pid).since(&before, seconds)
        });
        self.costs.push(cost.unwrap_or([f64::NAN; 2]));
        if let Some(viewer) = self.viewer.take() {
            let (trips, frames) = viewer.stop();
            self.round_trips_ns.extend(trips);
            self.frames += frames;
        }
    }

    fn flood_in_turn(&mut self, now: u64, live: &LiveCell) -> bool {
        let Some(health) = live.watch().health(Process::Controller(0)) else {
            return false;
        };
        self.fifo = health.scheduling == Scheduling::Fifo.code();
        if self.flooders.is_empty() {
            let start = |_| Flood::start(self.address, self.token.clone(), Arc::clone(&self.flood));
            self.flooders = (0..FLOODERS).map(start).collect();
            self.block_began = (now, health.missed_cycles);
        }
        if now - self.block_began.0 < BLOCK_NS {
            return false;
        }
        let blocks = &mut self.blocks[self.block % 2];
        blocks.lateness_us.push(health.lateness_p99_ns * 1.0e-3);
        blocks.missed += health.missed_cycles.saturating_sub(self.block_began.1);
        self.block += 1;
        self.block_began = (now, health.missed_cycles);
        self.flood.store(self.block % 2 == 1, Ordering::Relaxed);
        if self.block < 2 * PAIRS {
            return false;
        }
        self.refused = self.flooders.drain(..).map(Flood::stop).sum();
        true
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
            "the monitor is all its threads but the recorder's, whose budget is its own".to_owned(),
            format!(
                "missed cycles of the controller without and with {FLOODERS} flooding clients: {} and {}; \
                 {} times the monitor closed on one of them",
                self.blocks[0].missed, self.blocks[1].missed, self.refused
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
        for (name, blocks) in names.into_iter().zip(self.blocks) {
            report.rows.push(median_row(name, blocks.lateness_us));
        }
        report.compare(names[1], names[0]);
        report
            .write(&mut std::io::stdout().lock(), json)
            .map_err(Failure::configuration)
    }
}

fn monitor(live: &LiveCell) -> Option<u32> {
    let mut pids = live.pids().into_iter();
    pids.find(|(process, _)| *process == Process::Monitor)?.1
}

/// The blocks' figures: median, and the worst for all the others.
fn median_row(name: &str, mut figures: Vec<f64>) -> Row {
    figures.sort_by(f64::total_cmp);
    let median = figures.get(figures.len() / 2).copied().unwrap_or(0.0);
    let worst = figures.last().copied().unwrap_or(0.0);
    Row::new(
        name.to_owned(),
        figures.len(),
        [median, worst, worst, worst],
    )
}
