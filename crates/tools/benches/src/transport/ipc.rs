//! `bench ipc`: round trips between two processes, over the cell's topics and over the
//! alternatives.

use std::fs::File;
use std::io::Read;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixListener;
use std::process::{Child, Command, Stdio};

use cell_bus::{Keeper, TopicMessage};
use cell_rt::{Grid, monotonic_ns};
use ipc_types::probe::{Probe, Probe1K, Probe4K, Probe16K, Probe64};

use super::links::names;
use super::peer::{Links, PAYLOADS, READY, WAYS, Wires, schedule};
use super::site::{BenchRun, Block, Control, RUN};
use super::{BenchError, bus, io};
use crate::report::{Report, Samples};
use crate::versions;

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    /// Rounds; every row is measured once per round, in another order.
    pub(crate) rounds: usize,
    /// Round trips back to back, per row and round.
    pub(crate) hot: usize,
    /// Round trips at 1 kHz, per row and round.
    pub(crate) paced: usize,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            rounds: 12,
            hot: 1000,
            paced: 100,
        }
    }
}

/// Round trips before the measured ones of a block.
// Caches and branch predictors are of the last block's link.
const WARM_UP: usize = 20;
const PERIOD_NS: u64 = 1_000_000;

/// Notes for reading the rows.
const NOTES: [&str; 3] = [
    "round trips between two processes on two cores; every byte of the payload written and read",
    "topic adds to bare a header, a fence and a check of every value, which is one more look at \
     the payload; topic-untouched leaves the payload alone: a time that does not grow with it \
     shows that nothing is copied",
    "raw copies the value out, word by word, as a reader that may be overtaken must",
];

/// Measures and prints.
pub(crate) fn run(json: bool) -> Result<(), BenchError> {
    let program = std::env::current_exe().map_err(io("find its own program"))?;
    let command = |place: &BenchRun| {
        let mut command = Command::new(&program);
        command
            .arg(super::peer::WORD)
            .arg(&place.dir)
            .arg(&place.site.prefix);
        command
    };
    measure(Plan::default(), command)?
        .write(&mut std::io::stdout().lock(), json)
        .map_err(io("print"))
}

fn measure(plan: Plan, command: impl Fn(&BenchRun) -> Command) -> Result<Report, BenchError> {
    let place = BenchRun::create()?;
    let _keeper = keep(&place)?;
    let listener = UnixListener::bind(place.socket()).map_err(io("make a socket"))?;
    let mut peer = Peer::spawn(&mut command(&place))?;
    let wires = peer.connect(&listener)?;
    let links = Links::open(&place, &wires, true)?;
    peer.wait_until_ready()?;
    let granted = schedule(true);
    let mut bench = Bench {
        counts: vec![0; links.all.len()],
        hot: samples(&links, plan.rounds * plan.hot),
        paced: samples(&links, plan.rounds * plan.paced),
        control: Control::open(&place)?,
        links,
        block: 0,
        fifo: granted.fifo,
    };
    for round in 0..plan.rounds {
        let links = bench.links.all.len();
        for step in 0..links {
            // Another order in every round, so that no row always follows the same one.
            let link = (step * 7 + round * 5) % links;
            bench.run_block(link, plan.hot, false)?;
            bench.run_block(link, plan.paced, true)?;
        }
    }
    // Back to the normal class: printing must not hold up the machine.
    cell_rt::priority::set_other().map_err(io("leave real-time scheduling"))?;
    let mut report = Report::new("ipc", granted.fifo, &granted.refused);
    report.notes.extend(NOTES.map(str::to_owned));
    report
        .notes
        .push(versions::note(versions::LOCK, &["iceoryx2"]));
    bench.fill(&mut report);
    Ok(report)
}

fn keep(place: &BenchRun) -> Result<Keeper, BenchError> {
    let mut keeper = Keeper::create(&place.site, RUN, 1).map_err(bus)?;
    add::<Probe64>(&mut keeper)?;
    add::<Probe1K>(&mut keeper)?;
    add::<Probe4K>(&mut keeper)?;
    add::<Probe16K>(&mut keeper)?;
    Ok(keeper)
}

fn add<T: Probe + TopicMessage>(keeper: &mut Keeper) -> Result<(), BenchError> {
    for kind in ["topic", "header"] {
        let (there, back) = names(kind, T::PAYLOAD, true);
        for name in [there, back] {
            keeper.add_topic::<T>(&name, 1, 16).map_err(bus)?;
        }
    }
    Ok(())
}

fn samples(links: &Links, count: usize) -> Vec<Samples> {
    links
        .all
        .iter()
        .map(|_| Samples::with_capacity(count))
        .collect()
}

struct Bench {
    links: Links,
    control: Control,
    counts: Vec<u64>,
    hot: Vec<Samples>,
    paced: Vec<Samples>,
    block: u64,
    fifo: bool,
}

impl Bench {
    fn run_block(&mut self, index: usize, count: usize, paced: bool) -> Result<(), BenchError> {
        self.block += 1;
        let block = Block {
            link: index as u64,
            count: (WARM_UP + count) as u64,
        };
        self.control.order(self.block, block)?;
        let link = &mut self.links.all[index];
        let number = &mut self.counts[index];
        let samples = if paced {
            &mut self.paced[index]
        } else {
            &mut self.hot[index]
        };
        let mut grid = Grid::new(PERIOD_NS, monotonic_ns(), self.fifo);
        for round_trip in 0..WARM_UP + count {
            // Warm-up trips are not paced: they only fill caches.
            let measured = round_trip >= WARM_UP;
            if paced && measured {
                grid.wait();
            } else if paced {
                grid.restart(monotonic_ns());
            }
            *number += 1;
            // From before the send to after the read of every
            // byte: the time a user of a link pays.
            let start_ns = monotonic_ns();
            link.send(*number)?;
            link.receive(*number)?;
            if measured {
                samples.record(monotonic_ns() - start_ns);
            }
        }
        Ok(())
    }

    fn fill(&mut self, report: &mut Report) {
        let name = |way: &str, payload: usize, pace: &str| format!("{way}/{payload}/{pace}");
        for (pace, all) in [("hot", &mut self.hot), ("paced", &mut self.paced)] {
            let rows = PAYLOADS
                .iter()
                .flat_map(|payload| WAYS.map(|way| name(way, *payload, pace)));
            report.rows.extend(
                all.drain(..)
                    .zip(rows)
                    .map(|(samples, name)| samples.into_row(name)),
            );
        }
        for pace in ["hot", "paced"] {
            for payload in PAYLOADS {
                for way in WAYS.iter().filter(|way| **way != "raw") {
                    // Our layer is compared with the transport below it,
                    // the transports with plain memory.
                    let base = if way.starts_with("topic") {
                        "bare"
                    } else {
                        "raw"
                    };
                    report.compare(&name(way, payload, pace), &name(base, payload, pace));
                }
            }
        }
    }
}

/// The second process; ends with the bench.
struct Peer {
    child: Child,
    output: Option<File>,
}

impl Peer {
    fn spawn(command: &mut Command) -> Result<Self, BenchError> {
        let child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(io("start its second process"))?;
        Ok(Self {
            child,
            output: None,
        })
    }

    fn connect(&mut self, listener: &UnixListener) -> Result<Wires, BenchError> {
        let (Some(input), Some(output)) = (self.child.stdin.take(), self.child.stdout.take())
        else {
            return Err(BenchError::Silent);
        };
        let from = OwnedFd::from(output);
        self.output = Some(File::from(
            from.try_clone().map_err(io("copy a descriptor"))?,
        ));
        // With a limit: a second process that fails at its start never connects.
        listener.set_nonblocking(true).map_err(io("listen"))?;
        let end_ns = monotonic_ns() + super::site::PATIENCE_NS;
        loop {
            match listener.accept() {
                Ok((socket, _)) => {
                    socket.set_nonblocking(false).map_err(io("listen"))?;
                    return Ok(Wires {
                        from,
                        to: OwnedFd::from(input),
                        socket,
                    });
                }
                Err(_) if monotonic_ns() < end_ns => {
                    cell_rt::sleep_until(monotonic_ns() + 1_000_000);
                }
                Err(_) => return Err(BenchError::Silent),
            }
        }
    }

    /// Reads the pipe up to the message that everything is open.
    fn wait_until_ready(&mut self) -> Result<(), BenchError> {
        let output = self.output.as_mut().ok_or(BenchError::Silent)?;
        let mut heard = Vec::new();
        while !heard.ends_with(READY) {
            let mut byte = [0];
            output
                .read_exact(&mut byte)
                .map_err(io("hear its second process"))?;
            heard.extend(byte);
        }
        Ok(())
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended already.
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "run by the other test as a process of its own"]
    fn helper_is_the_second_process() {
        let Ok(spec) = std::env::var("BENCH_PEER") else {
            return;
        };
        let (prefix, dir) = spec.split_once(' ').unwrap();
        super::super::peer::run(dir.as_ref(), prefix).unwrap();
    }

    #[test]
    fn every_way_carries_every_payload_and_nothing_is_left() {
        let plan = Plan {
            rounds: 2,
            hot: 20,
            paced: 3,
        };
        let dir = std::cell::RefCell::new(None);
        let report = measure(plan, |place| {
            dir.replace(Some(place.dir.clone()));
            let mut command = Command::new(std::env::current_exe().unwrap());
            command
                .args([
                    "--exact",
                    "transport::ipc::tests::helper_is_the_second_process",
                ])
                .args(["--ignored", "--nocapture"])
                .env(
                    "BENCH_PEER",
                    format!("{} {}", place.site.prefix, place.dir.display()),
                );
            command
        })
        .unwrap();
        assert_eq!(report.rows.len(), 2 * PAYLOADS.len() * WAYS.len());
        assert!(
            report
                .rows
                .iter()
                .all(|row| row.p50 > 0.0 && (row.n == 40 || row.n == 6))
        );
        let topic = report
            .rows
            .iter()
            .find(|row| row.name == "topic/1024/hot")
            .unwrap();
        assert_eq!(topic.against.as_deref(), Some("bare/1024/hot"));
        assert!(topic.ratio.unwrap() > 0.0);
        assert!(!dir.take().unwrap().exists());
    }
}
