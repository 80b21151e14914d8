//! Links that both processes of the bench open, and the main function of the second one.

use std::fs::File;
use std::io::Write as _;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::ExitCode;

use cell_bus::{Bus, TopicMessage};
use cell_rt::priority;
use iceoryx2::prelude::{Node, NodeBuilder, SignalHandlingMode, ipc};
use ipc_types::probe::{Probe, Probe1K, Probe4K, Probe16K, Probe64};

use super::links::{Bare, Channel, Raw, Stream, Topic};
use super::site::{BenchRun, Control, RUN};
use super::{BenchError, bus, io};

/// SCHED_FIFO priority of both processes.
// Below the loops of a cell that may run on the same machine.
pub(crate) const PRIORITY: i32 = 60;
/// The ways, in the order of [`links_of`].
pub(crate) const WAYS: [&str; 6] = ["raw", "bare", "topic", "topic-untouched", "pipe", "socket"];
/// Payloads in bytes, in the order of [`Links::open`].
pub(crate) const PAYLOADS: [usize; 4] = [
    Probe64::PAYLOAD,
    Probe1K::PAYLOAD,
    Probe4K::PAYLOAD,
    Probe16K::PAYLOAD,
];
/// Message of the second process when everything is open.
pub(crate) const READY: &[u8] = b"\nbench peer ready\n";

/// All links of one process, by payload and way.
pub(crate) struct Links {
    pub(crate) all: Vec<Box<dyn Channel>>,
    // The ports belong to these.
    _bus: Bus,
    _node: Node<ipc::Service>,
}

/// The descriptors one process has to the other.
pub(crate) struct Wires {
    pub(crate) from: OwnedFd,
    pub(crate) to: OwnedFd,
    pub(crate) socket: UnixStream,
}

impl Links {
    /// Opens everything; `first` is the process that sends first.
    pub(crate) fn open(place: &BenchRun, wires: &Wires, first: bool) -> Result<Self, BenchError> {
        let bus_ = Bus::join(&place.site, RUN, 1, "bench").map_err(bus)?;
        let node = NodeBuilder::new()
            .config(&place.site.config().map_err(bus)?)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(bus)?;
        let ends = Ends {
            place,
            wires,
            bus: &bus_,
            node: &node,
            first,
        };
        let mut all = Vec::new();
        all.extend(links_of::<Probe64>(&ends)?);
        all.extend(links_of::<Probe1K>(&ends)?);
        all.extend(links_of::<Probe4K>(&ends)?);
        all.extend(links_of::<Probe16K>(&ends)?);
        Ok(Self {
            all,
            _bus: bus_,
            _node: node,
        })
    }
}

struct Ends<'a> {
    place: &'a BenchRun,
    wires: &'a Wires,
    bus: &'a Bus,
    node: &'a Node<ipc::Service>,
    first: bool,
}

fn links_of<T: Probe + TopicMessage>(ends: &Ends) -> Result<[Box<dyn Channel>; 6], BenchError> {
    let copy = |end: &OwnedFd| {
        end.try_clone()
            .map(File::from)
            .map_err(io("copy a descriptor"))
    };
    let socket = || {
        ends.wires
            .socket
            .try_clone()
            .map_err(io("copy a descriptor"))
    };
    Ok([
        Box::new(Raw::open(ends.place, T::PAYLOAD, ends.first)?),
        Box::new(Bare::<T>::open(ends.node, ends.first)?),
        Box::new(Topic::<T>::open(ends.bus, ends.first, true)?),
        Box::new(Topic::<T>::open(ends.bus, ends.first, false)?),
        Box::new(Stream::new(
            copy(&ends.wires.from)?,
            copy(&ends.wires.to)?,
            T::PAYLOAD,
        )),
        Box::new(Stream::new(socket()?, socket()?, T::PAYLOAD)),
    ])
}

/// Requests real-time scheduling on core 0 (`first`) or 1. With one core pinning is useless,
/// and a spinning process would keep the other out.
pub(crate) fn schedule(first: bool) -> priority::Granted {
    let cores = priority::core_count();
    priority::request(PRIORITY, (cores > 1).then_some(usize::from(!first)))
}

/// First argument of the second process.
pub(crate) const WORD: &str = "peer";

/// Runs the second process if the arguments are `peer DIR PREFIX`.
pub(crate) fn main() -> Option<ExitCode> {
    let mut arguments = std::env::args().skip(1);
    let (word, dir, prefix) = (arguments.next()?, arguments.next()?, arguments.next()?);
    if word != WORD {
        return None;
    }
    Some(match run(dir.as_ref(), &prefix) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            writeln!(std::io::stderr(), "robocell-bench peer: {error}").ok();
            ExitCode::from(3)
        }
    })
}

/// The second process: answers every message until the first one has ended. Its standard input
/// and output are the pipes.
pub(crate) fn run(dir: &Path, prefix: &str) -> Result<(), BenchError> {
    let parent = cell_rt::process::parent_pid();
    // A spinning process without its partner would take a core for good.
    cell_rt::process::die_with_parent(cell_rt::process::SIGKILL, parent)
        .map_err(io("follow its parent"))?;
    let place = BenchRun::join(dir.to_owned(), prefix.to_owned());
    let control = Control::open(&place)?;
    let copied = |end: std::io::Result<OwnedFd>| end.map_err(io("copy a descriptor"));
    let wires = Wires {
        from: copied(std::io::stdin().as_fd().try_clone_to_owned())?,
        to: copied(std::io::stdout().as_fd().try_clone_to_owned())?,
        socket: UnixStream::connect(place.socket()).map_err(io("reach the socket"))?,
    };
    let mut links = Links::open(&place, &wires, false)?;
    // After all is open: opening at real-time priority would disturb the machine for no figure.
    schedule(false);
    let mut ready = copied(wires.to.try_clone()).map(File::from)?;
    std::io::Write::write_all(&mut ready, READY).map_err(io("report"))?;
    let alive = || cell_rt::process::parent_pid() == parent;
    let mut counts = vec![0; links.all.len()];
    for number in 1.. {
        // Ends with the first process, also where the kernel's signal was lost.
        let Some(block) = control.await_order(number, alive) else {
            break;
        };
        let index = usize::try_from(block.link).unwrap_or(usize::MAX);
        let (Some(link), Some(count)) = (links.all.get_mut(index), counts.get_mut(index)) else {
            break;
        };
        // The same number of messages on both sides, so no end of a block has to be sent.
        for _ in 0..block.count {
            *count += 1;
            link.receive(*count)?;
            link.send(*count)?;
        }
    }
    Ok(())
}
