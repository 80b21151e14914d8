//! The launcher's hold on every service of a run.
//!
//! What can go wrong: a process that is killed while it creates a service leaves a half-made
//! one, which no other process can open or remove (seen once in 80 to 300 kills in the first
//! milliseconds). And a service without users disappears, with its settings. The rule: the
//! launcher creates every service once, before any process starts, and holds all of them until
//! the run ends. Processes only open services.
//!
//! A change must not break: settings come from `qos` alone, as the creator's values win; the
//! node outlives its services; the keeper is dropped before the site is wiped.

use std::any::Any;
use std::fs::DirBuilder;
use std::os::unix::fs::DirBuilderExt;

use iceoryx2::prelude::{LogLevel, NodeBuilder, NodeName, SignalHandlingMode, ipc, set_log_level};
use ipc_types::topic::{OPERATOR_SERVICE, Process, TopicId, doorbell};
use ipc_types::{
    ArmCommand, ArmStatus, ClientInput, Contacts, Decision, Health, Keyframe, TraceLine,
    WorldPiece, WorldState,
};

use crate::error::BusError;
use crate::factory::{Factory, Limits, create_error};
use crate::message::TopicMessage;
use crate::qos;
use crate::shared::operator::create_service;
use crate::site::RunSite;

/// Creates every service of a run before any process starts, and holds them: a process of the
/// cell never creates one, so none can leave a half-made one behind, and a service outlives the
/// restart of all its users.
#[derive(Debug)]
pub struct Keeper {
    // Services before the node of the factory: they are given back in this order.
    services: Vec<Box<dyn Any>>,
    factory: Factory,
    run: u64,
}

impl Keeper {
    /// Creates the services of run `run` for a cell of `arms` arms at `site`. Fails when shared
    /// memory has no room for them, or when a service of this run exists already.
    pub fn create(site: &RunSite, run: u64, arms: u8) -> Result<Self, BusError> {
        set_log_level(LogLevel::Fatal);
        let config = site.config()?;
        // Before anything is created: on a full mount creation
        // succeeds and the first write is fatal.
        crate::cleanup::preflight(arms)?;
        // Only the owner may enter: directories of the transport inside are open to the group.
        DirBuilder::new()
            .recursive(true)
            .mode(0o700)
            .create(&site.root)
            .map_err(|source| BusError::Io {
                path: site.root.clone(),
                source,
            })?;
        let failed = |reason: String| BusError::Join {
            root: site.root.clone(),
            reason,
        };
        let name = NodeName::new("keeper").map_err(|error| failed(format!("{error:?}")))?;
        let node = NodeBuilder::new()
            .name(&name)
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|error| failed(format!("{error:?}")))?;
        let mut keeper = Self {
            services: Vec::new(),
            factory: Factory::new(node),
            run,
        };
        // All topics, also those that no process of this cell
        // opens: a tool may join at any time.
        for topic in qos::topics(arms) {
            keeper.create_topic(topic)?;
        }
        for process in Process::all(arms) {
            keeper.create_bell(&doorbell(process))?;
        }
        let operator = create_service(keeper.factory.builder(OPERATOR_SERVICE)?)
            .map_err(|reason| create_error(OPERATOR_SERVICE, reason))?;
        keeper.services.push(Box::new(operator));
        // Last, as segments exist only after their services.
        crate::cleanup::make_private(site)?;
        Ok(keeper)
    }

    /// Identity of the run.
    pub fn run(&self) -> u64 {
        self.run
    }

    /// Number of services held.
    pub fn len(&self) -> usize {
        self.services.len()
    }

    /// Whether it holds none; never, after [`Self::create`].
    pub fn is_empty(&self) -> bool {
        self.services.is_empty()
    }

    fn create_topic(&mut self, topic: TopicId) -> Result<(), BusError> {
        match topic {
            TopicId::WorldState => self.create_topic_of::<WorldState>(topic),
            TopicId::Contacts => self.create_topic_of::<Contacts>(topic),
            TopicId::WorldTap => self.create_topic_of::<WorldPiece>(topic),
            TopicId::Keyframe(_) => self.create_topic_of::<Keyframe>(topic),
            TopicId::ClientTap(_) => self.create_topic_of::<ClientInput>(topic),
            TopicId::ArmCommand(_) | TopicId::ArmCommandTap(_) => {
                self.create_topic_of::<ArmCommand>(topic)
            }
            TopicId::ArmStatus(_) | TopicId::ArmStatusTap(_) => {
                self.create_topic_of::<ArmStatus>(topic)
            }
            TopicId::Decision | TopicId::DecisionTap => self.create_topic_of::<Decision>(topic),
            TopicId::Trace => self.create_topic_of::<TraceLine>(topic),
            TopicId::Health(_) | TopicId::Recorder => self.create_topic_of::<Health>(topic),
        }
    }

    fn create_topic_of<T: TopicMessage>(&mut self, topic: TopicId) -> Result<(), BusError> {
        self.add::<T>(&topic.service(), Limits::of(topic))
    }

    /// Creates one more topic `name`, for a tool or a test with its own: `depth` messages that
    /// a reader can be behind, and at most `readers` readers. Its ports are opened with
    /// [`crate::Bus::publisher_of`] and [`crate::Bus::subscriber_of`].
    pub fn add_topic<T: TopicMessage>(
        &mut self,
        name: &str,
        depth: usize,
        readers: usize,
    ) -> Result<(), BusError> {
        let history = qos::HISTORY.min(depth);
        self.add::<T>(
            name,
            Limits {
                depth,
                readers,
                history,
            },
        )
    }

    fn add<T: TopicMessage>(&mut self, name: &str, limits: Limits) -> Result<(), BusError> {
        let service = T::create(&self.factory, name, limits)?;
        self.services.push(service);
        Ok(())
    }

    fn create_bell(&mut self, name: &str) -> Result<(), BusError> {
        // Every process and tool may ring; only the owner sleeps,
        // but its dead starts keep their slots.
        let service = self
            .factory
            .builder(name)?
            .event()
            .max_notifiers(qos::MAX_NODES)
            .max_listeners(qos::MAX_PUBLISHERS)
            .max_nodes(qos::MAX_NODES)
            .event_id_max_value(1)
            .create()
            .map_err(|error| create_error(name, error))?;
        self.services.push(Box::new(service));
        Ok(())
    }
}
