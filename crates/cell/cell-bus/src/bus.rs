//! The membership of one process in a run.
//!
//! Two accidents are possible here. A process that dies while it joins leaves files that the
//! transport cannot clean up; so a process joins last, after everything else that may fail. And
//! two programs of different builds can agree on name and size of a message but not on its
//! fields; so the name of each type carries a hash of its fields, and opening compares it.
//!
//! There are two wirings: shared memory between processes, and the memory of a model that has
//! all of them in one thread. Stamps, fences and validation are the same code in both.

use ipc_types::topic::Process;

use crate::bell::{Doorbell, Sleeper};
use crate::error::BusError;
use crate::identity::Identity;
use crate::memory::MemorySite;
use crate::operator::{OperatorClient, OperatorServer};
use crate::shared::Shared;
use crate::site::RunSite;

/// The transport of a bus.
#[derive(Debug)]
pub(crate) enum Wiring {
    Shared(Box<Shared>),
    Memory(MemorySite),
}

/// One process's membership in a run. Do all work that may fail before joining:
/// a process that dies while it joins may leave files behind that only the
/// wipe after the run removes.
#[derive(Debug)]
pub struct Bus {
    wiring: Wiring,
    identity: Identity,
}

impl Bus {
    /// Joins run `run` at `site` as start number `generation` of the process called `name`.
    /// Signals stay with the caller. Fails when the site is invalid or the node cannot be
    /// created.
    pub fn join(site: &RunSite, run: u64, generation: u32, name: &str) -> Result<Self, BusError> {
        Ok(Self {
            wiring: Wiring::Shared(Box::new(Shared::join(site, name)?)),
            identity: Identity { run, generation },
        })
    }

    /// Joins run `run` as start number `generation` of a modelled process.
    pub fn in_memory(site: &MemorySite, run: u64, generation: u32) -> Self {
        Self {
            wiring: Wiring::Memory(site.clone()),
            identity: Identity { run, generation },
        }
    }

    /// Identity of the run.
    pub fn run(&self) -> u64 {
        self.identity.run
    }

    /// Start number of this process within the run, from 1 up.
    pub fn generation(&self) -> u32 {
        self.identity.generation
    }

    pub(crate) fn identity(&self) -> Identity {
        self.identity
    }

    pub(crate) fn wiring(&self) -> &Wiring {
        &self.wiring
    }

    /// The end of a process's doorbell that wakes it.
    pub fn doorbell(&self, process: Process) -> Result<Doorbell, BusError> {
        let name = ipc_types::topic::doorbell(process);
        Ok(Doorbell::new(match &self.wiring {
            Wiring::Shared(shared) => shared.ring(&name)?,
            Wiring::Memory(site) => site.ring(&name),
        }))
    }

    /// The end of a doorbell that sleeps; one per process.
    pub fn sleeper(&self, process: Process) -> Result<Sleeper, BusError> {
        let name = ipc_types::topic::doorbell(process);
        Ok(Sleeper::new(match &self.wiring {
            Wiring::Shared(shared) => shared.sleep(&name)?,
            Wiring::Memory(site) => site.sleep(&name),
        }))
    }

    /// The client of people and tools: sends a request and waits for the reply.
    pub fn operator_client(&self) -> Result<OperatorClient, BusError> {
        let port = match &self.wiring {
            Wiring::Shared(shared) => shared.ask()?,
            Wiring::Memory(site) => site.ask(),
        };
        Ok(OperatorClient::new(port, self.identity))
    }

    /// The server of operator requests, for physics only (ADR 0001).
    pub fn operator_server(&self) -> Result<OperatorServer, BusError> {
        let port = match &self.wiring {
            Wiring::Shared(shared) => shared.serve()?,
            Wiring::Memory(site) => site.serve(),
        };
        Ok(OperatorServer::new(port, self.identity))
    }
}
