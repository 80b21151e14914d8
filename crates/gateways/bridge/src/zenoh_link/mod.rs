//! zenoh as the [`Transport`], with the names of `rmw_zenoh`.
//!
//! Two sessions, as zenoh authenticates a link and messages of ROS 2 have no place for a token:
//! one for viewers, whose commands are refused, and one whose links need the token (ADR 0024).
//! Callbacks run on threads of zenoh, so they only put a bounded copy into a queue.

mod config;
mod token;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::CongestionControl;
use zenoh::query::{Query, Queryable};
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use crate::args::Args;
use crate::endpoints::{NamedCommand, Stream};
use crate::ros::attachment::Attachment;
use crate::ros::names::{Endpoint, Kind, Node};
use crate::ros::types::RosType;
use crate::transport::{Arrived, Reply, Transport, TransportError};

/// Commands that can wait; the bridge reads them every few milliseconds.
// Newer commands replace older ones anyway; dropped ones are counted and logged.
const WAITING: usize = 64;
/// Longest message of a command (bytes).
// No command is longer; a larger payload would be copied for nothing.
const MOST_BYTES: usize = 4096;
/// Name of the node, and its number in its session.
const NODE: &str = "robocell_bridge";
const NODE_ID: u32 = 0;

/// Sessions of zenoh: one for viewers, and one for clients with the token.
pub struct ZenohLink {
    sides: Vec<Side>,
    arrived: Receiver<Arrived>,
    inbox: Inbox,
    domain: u32,
    namespace: String,
}

/// One session and its endpoints.
struct Side {
    session: Session,
    may_command: bool,
    offer: Option<Offer>,
}

/// Endpoints of a session until it is dropped.
#[derive(Default)]
struct Offer {
    publishers: BTreeMap<Stream, StreamPublisher>,
    subscribers: Vec<Subscriber<()>>,
    queryables: Vec<Queryable<()>>,
    tokens: Vec<LivelinessToken>,
}

struct StreamPublisher {
    publisher: Publisher<'static>,
    gid: [u8; 16],
    sequence: i64,
}

/// Queue for commands, filled by callbacks of zenoh.
#[derive(Clone)]
struct Inbox {
    sender: SyncSender<Arrived>,
    dropped: Arc<AtomicU64>,
}

impl Inbox {
    fn put(&self, arrived: Arrived) {
        // Never waits: it is called on a thread of the network.
        if self.sender.try_send(arrived).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl ZenohLink {
    /// Opens the sessions requested by `args`.
    ///
    /// # Errors
    /// If the configuration, the token or an endpoint cannot be used.
    pub fn open(args: &Args) -> Result<Self, TransportError> {
        // Viewers first: a session without commands exists in any case.
        let mut sides = vec![Side::open(config::of_viewers(args)?, false)?];
        if let Some(path) = &args.control {
            let token = token::read(path)?;
            let dictionary = token::dictionary(path, &token)?;
            // The file with the password is needed while the
            // session opens, and deleted right after.
            sides.push(Side::open(config::of_commanders(args, &dictionary)?, true)?);
        }
        let (sender, arrived) = sync_channel(WAITING);
        Ok(Self {
            sides,
            arrived,
            inbox: Inbox {
                sender,
                dropped: Arc::default(),
            },
            domain: args.domain,
            namespace: args.namespace.clone(),
        })
    }

    fn node(&self, session: &Session) -> Node {
        Node {
            domain: self.domain,
            session: session.info().zid().wait().to_string(),
            id: NODE_ID,
            namespace: self.namespace.clone(),
            name: NODE.to_owned(),
        }
    }

    fn make_offer(
        &self,
        side: &Side,
        streams: &[Stream],
        commands: &[NamedCommand],
    ) -> Result<Offer, TransportError> {
        // Names are announced before their endpoints exist, so
        // that a client finds them at once.
        let mut names = Names::new(&side.session, self.node(&side.session))?;
        let mut offer = Offer::default();
        for stream in streams {
            let endpoint = names.add(Kind::Publisher, stream.topic(), stream.ros_type())?;
            let publisher = StreamPublisher::new(&side.session, &endpoint)?;
            offer.publishers.insert(*stream, publisher);
        }
        for (index, command) in commands.iter().enumerate() {
            let kind = if command.is_service() {
                Kind::Service
            } else {
                Kind::Subscription
            };
            let endpoint = names.add(kind, &command.name, command.ros_type())?;
            // Offered to viewers as well: they get a refusal with a reason instead of silence.
            let (inbox, may_command) = (self.inbox.clone(), side.may_command);
            let refused = |error| network(format!("offer {}", command.name), &error);
            if command.is_service() {
                // Complete: no other server of this name exists.
                let queryable = side.session.declare_queryable(endpoint.key).complete(true);
                let answer = move |query| inbox.put(of_query(index, may_command, query));
                let queryable = queryable.callback(answer).wait().map_err(refused)?;
                offer.queryables.push(queryable);
            } else {
                let subscriber = side.session.declare_subscriber(endpoint.key);
                let take = move |sample| inbox.put(of_sample(index, may_command, &sample));
                let subscriber = subscriber.callback(take).wait().map_err(refused)?;
                offer.subscribers.push(subscriber);
            }
        }
        offer.tokens = names.tokens;
        Ok(offer)
    }
}

/// An announced endpoint.
struct Announced {
    key: String,
    id: u32,
}

/// Names of one session, announced by liveliness tokens.
struct Names<'a> {
    session: &'a Session,
    node: Node,
    tokens: Vec<LivelinessToken>,
    next_id: u32,
}

impl<'a> Names<'a> {
    fn new(session: &'a Session, node: Node) -> Result<Self, TransportError> {
        let mut names = Self {
            session,
            // Numbers start after that of the node, which shares the space.
            next_id: NODE_ID + 1,
            tokens: Vec::new(),
            node,
        };
        names.announce("the node", names.node.token())?;
        Ok(names)
    }

    /// Announces an endpoint by its name within the namespace.
    fn add(
        &mut self,
        kind: Kind,
        name: &str,
        ros_type: RosType,
    ) -> Result<Announced, TransportError> {
        let endpoint = Endpoint {
            id: self.next_id,
            kind,
            topic: format!("{}{name}", self.node.namespace),
            ros_type,
        };
        self.next_id += 1;
        // ROS tools list only announced endpoints.
        self.announce(name, self.node.endpoint_token(&endpoint))?;
        Ok(Announced {
            key: self.node.topic_key(&endpoint),
            id: endpoint.id,
        })
    }

    fn announce(&mut self, what: &str, key: String) -> Result<(), TransportError> {
        let token = self.session.liveliness().declare_token(key).wait();
        let token = token.map_err(|error| network(format!("announce {what}"), &error))?;
        self.tokens.push(token);
        Ok(())
    }
}

impl StreamPublisher {
    fn new(session: &Session, endpoint: &Announced) -> Result<Self, TransportError> {
        let publisher = session
            .declare_publisher(endpoint.key.clone())
            // A client that does not read must not delay the others.
            .congestion_control(CongestionControl::Drop)
            // Sent at once: batching would add milliseconds to a state that is old then.
            .express(true)
            .wait()
            .map_err(|error| network(format!("publish {}", endpoint.key), &error))?;
        Ok(Self {
            publisher,
            gid: gid(session, endpoint.id),
            sequence: 0,
        })
    }
}

impl Side {
    fn open(config: zenoh::Config, may_command: bool) -> Result<Self, TransportError> {
        let what = if may_command {
            "open the endpoint for commands"
        } else {
            "open the endpoint for viewers"
        };
        let session = zenoh::open(config).wait();
        Ok(Self {
            session: session.map_err(|error| network(what, &error))?,
            may_command,
            offer: None,
        })
    }
}

impl Transport for ZenohLink {
    fn offer(
        &mut self,
        streams: &[Stream],
        commands: &[NamedCommand],
    ) -> Result<(), TransportError> {
        let mut offers = Vec::new();
        // All old offers end first: the new ones may have the same names.
        for side in &mut self.sides {
            side.offer = None;
        }
        // All are made before one is set: an error leaves no half of an offer.
        for side in &self.sides {
            offers.push(self.make_offer(side, streams, commands)?);
        }
        for (side, offer) in self.sides.iter_mut().zip(offers) {
            side.offer = Some(offer);
        }
        // Waiting commands refer to the former offer.
        while self.arrived.try_recv().is_ok() {}
        Ok(())
    }

    fn publish(&mut self, stream: Stream, payload: &[u8], source_ns: i64) {
        for side in &mut self.sides {
            let publishers = side.offer.as_mut().map(|offer| &mut offer.publishers);
            let Some(publisher) = publishers.and_then(|all| all.get_mut(&stream)) else {
                continue;
            };
            publisher.sequence += 1;
            let attachment = Attachment {
                sequence: publisher.sequence,
                source_ns,
                gid: publisher.gid,
            };
            let put = publisher.publisher.put(payload);
            // A session that is closed has no readers.
            put.attachment(attachment.to_bytes().as_slice()).wait().ok();
        }
    }

    fn next_command(&mut self) -> Option<Arrived> {
        self.arrived.try_recv().ok()
    }

    fn dropped(&self) -> u64 {
        self.inbox.dropped.load(Ordering::Relaxed)
    }
}

fn of_sample(index: usize, may_command: bool, sample: &Sample) -> Arrived {
    Arrived {
        index,
        payload: bounded(Some(sample.payload())),
        attachment: attachment(sample.attachment()),
        may_command,
        reply: None,
    }
}

fn of_query(index: usize, may_command: bool, query: Query) -> Arrived {
    let asked = attachment(query.attachment());
    let payload = bounded(query.payload());
    let reply: Reply = Box::new(move |payload: Vec<u8>| {
        let key = query.key_expr().clone();
        let mut reply = query.reply(key, payload);
        // The client finds its request by number and sender.
        if let Some(asked) = asked {
            let answer = Attachment {
                source_ns: crate::clock::wall_ns(),
                ..asked
            };
            reply = reply.attachment(answer.to_bytes().as_slice());
        }
        // A client that has left needs no answer.
        reply.wait().ok();
    });
    Arrived {
        index,
        payload,
        attachment: asked,
        may_command,
        reply: Some(reply),
    }
}

/// A payload that is too long is not a valid command, and is refused as empty.
fn bounded(bytes: Option<&zenoh::bytes::ZBytes>) -> Vec<u8> {
    let bytes = bytes.filter(|bytes| bytes.len() <= MOST_BYTES);
    bytes.map_or_else(Vec::new, |bytes| bytes.to_bytes().into_owned())
}

fn attachment(bytes: Option<&zenoh::bytes::ZBytes>) -> Option<Attachment> {
    Attachment::from_bytes(&bytes?.to_bytes())
}

/// Identifies a publisher: its session, and its number in it.
fn gid(session: &Session, id: u32) -> [u8; 16] {
    let mut gid = session.info().zid().wait().to_le_bytes();
    // Different for each endpoint of a session, equal for the whole session.
    for (byte, of_id) in gid.iter_mut().zip(id.to_le_bytes()) {
        *byte ^= of_id;
    }
    gid
}

fn network(what: impl Into<String>, reason: &zenoh::Error) -> TransportError {
    TransportError::Network {
        what: what.into(),
        reason: reason.to_string(),
    }
}
