//! Limit of connections: their number, and which connection is closed in favour of a new one.
//!
//! What can go wrong: connections that send nothing take all permits, by mistake (a browser opens
//! some in advance) or on purpose, and a person cannot open the page. The rule: a connection
//! that has not shown a token gives way, the longest silent one first; a connection that has is
//! never closed for another one.

use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::oneshot;
use tokio::time::Instant;

/// Largest number of connections.
// 16 pages with a few requests each, and room for strangers; each is an open file.
const MAX_CONNECTIONS: usize = 96;
/// Connections of one address without a token or cookie.
// A browser opens six per server; a tunnel or a proxy has one address for several people.
const MAX_STRANGERS_PER_ADDRESS: usize = 32;
/// Time without a request or an answer after which a connection is closed.
// Short, as a browser reconnects by itself.
const IDLE_TIMEOUT: Duration = Duration::from_secs(5);
/// Time within which a request is answered, after which its connection is closed.
// A search of grasps takes seconds, and beside other work several times that.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(60);
/// The connection has no idle timeout.
const NEVER: u64 = u64::MAX;

/// Time at which a connection is closed for silence, and whether it showed a token or cookie;
/// shared by the connection and the handlers of its requests.
#[derive(Clone, Debug)]
pub(super) struct Idle {
    opened: Instant,
    until_ms: Arc<AtomicU64>,
    trusted: Arc<AtomicBool>,
}

impl Idle {
    fn new() -> Self {
        let idle = Self {
            opened: Instant::now(),
            until_ms: Arc::new(AtomicU64::new(0)),
            trusted: Arc::new(AtomicBool::new(false)),
        };
        idle.restart();
        idle
    }

    /// Restarts the timeout, unless it was switched off.
    pub(super) fn restart(&self) {
        self.end_after(IDLE_TIMEOUT);
    }

    /// A request is being served: silence until its answer is not that of the other side.
    pub(super) fn serve(&self) {
        self.end_after(ANSWER_TIMEOUT);
    }

    fn end_after(&self, timeout: Duration) {
        let until = (self.opened.elapsed() + timeout).as_millis();
        let until = u64::try_from(until).unwrap_or(NEVER);
        // Switched off stays off: a late request of the same connection must not bring it back.
        let later = |now: u64| (now != NEVER).then_some(until);
        let _unless_switched_off = self
            .until_ms
            .fetch_update(Ordering::AcqRel, Ordering::Acquire, later)
            .is_ok();
    }

    /// Switches the timeout off: a websocket has its own.
    pub(super) fn switch_off(&self) {
        self.until_ms.store(NEVER, Ordering::Release);
    }

    /// A request showed a token or cookie of this run.
    pub(super) fn trust(&self) {
        self.trusted.store(true, Ordering::Release);
    }

    /// Time at which the connection is closed; `None`: never.
    pub(super) fn end(&self) -> Option<Instant> {
        match self.until_ms.load(Ordering::Acquire) {
            NEVER => None,
            until => Some(self.opened + Duration::from_millis(until)),
        }
    }

    fn is_stranger(&self) -> bool {
        !self.trusted.load(Ordering::Acquire)
    }
}

struct OpenConnection {
    number: u64,
    from: IpAddr,
    idle: Idle,
    close: oneshot::Sender<()>,
}

#[derive(Default)]
struct Table {
    open: Vec<OpenConnection>,
    next: u64,
}

impl Table {
    /// Closes the stranger that has been silent for the longest time, of `from` if given.
    /// `false` if there is none.
    fn close_stranger(&mut self, from: Option<IpAddr>) -> bool {
        let strangers = self.open.iter().enumerate().filter(|(_, open)| {
            open.idle.is_stranger() && from.is_none_or(|from| open.from == from)
        });
        let oldest = strangers
            .min_by_key(|(_, open)| open.idle.end())
            .map(|(index, _)| index);
        let Some(index) = oldest else {
            return false;
        };
        // The connection may have ended meanwhile; its permit is free in either case.
        let _unless_gone = self.open.swap_remove(index).close.send(());
        true
    }

    fn strangers(&self, from: IpAddr) -> usize {
        let of = |open: &&OpenConnection| open.from == from && open.idle.is_stranger();
        self.open.iter().filter(of).count()
    }
}

/// All permits of a server.
#[derive(Clone, Default)]
pub(super) struct ConnectionLimit(Arc<Mutex<Table>>);

impl ConnectionLimit {
    /// A permit for a connection from `from`. If all are taken, the connection without token or
    /// cookie that has been silent for the longest time loses its permit: silent strangers must
    /// not lock the page. `None` if all others showed one.
    pub(super) fn take(&self, from: IpAddr) -> Option<Permit> {
        let mut table = self.lock();
        // Per address first: one machine must not displace the strangers of all others.
        if table.strangers(from) >= MAX_STRANGERS_PER_ADDRESS {
            table.close_stranger(Some(from));
        } else if table.open.len() >= MAX_CONNECTIONS && !table.close_stranger(None) {
            return None;
        }
        let (close, closed) = oneshot::channel();
        let (number, idle) = (table.next, Idle::new());
        table.next += 1;
        table.open.push(OpenConnection {
            number,
            from,
            idle: idle.clone(),
            close,
        });
        Some(Permit {
            number,
            limit: self.clone(),
            idle,
            closed,
        })
    }

    fn lock(&self) -> MutexGuard<'_, Table> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The permit of one connection, freed when dropped.
pub(super) struct Permit {
    number: u64,
    limit: ConnectionLimit,
    /// The idle timeout of the connection.
    pub(super) idle: Idle,
    /// Ready when the permit went to another connection.
    pub(super) closed: oneshot::Receiver<()>,
}

impl Drop for Permit {
    fn drop(&mut self) {
        let mut table = self.limit.lock();
        table.open.retain(|open| open.number != self.number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::LOCALHOST);

    fn there(number: u8) -> IpAddr {
        IpAddr::from([10, 0, 0, number])
    }

    fn is_closed(permit: &mut Permit) -> bool {
        permit.closed.try_recv().is_ok()
    }

    #[test]
    fn one_address_has_a_part_of_the_slots_and_loses_its_most_silent_one() {
        let limit = ConnectionLimit::default();
        let mut other = limit.take(there(1)).unwrap();
        let mut here: Vec<Permit> = (0..MAX_STRANGERS_PER_ADDRESS)
            .map(|_| limit.take(HERE).unwrap())
            .collect();
        here[0].idle.until_ms.store(9_000, Ordering::Release);
        here[1].idle.until_ms.store(1, Ordering::Release);
        let _newest = limit.take(HERE).unwrap();
        assert!(is_closed(&mut here[1]));
        assert!(!is_closed(&mut here[0]) && !is_closed(&mut here[2]));
        assert!(!is_closed(&mut other), "of another address");
    }

    #[test]
    fn who_showed_a_token_keeps_the_slot_and_a_full_server_refuses() {
        let limit = ConnectionLimit::default();
        let mut trusted: Vec<Permit> = (0..MAX_CONNECTIONS - 1)
            .map(|_| {
                let permit = limit.take(HERE).unwrap();
                permit.idle.trust();
                permit
            })
            .collect();
        let mut stranger = limit.take(HERE).unwrap();
        let newest = limit.take(HERE).unwrap();
        assert!(is_closed(&mut stranger));
        assert!(!trusted.iter_mut().any(is_closed));
        newest.idle.trust();
        assert!(limit.take(HERE).is_none());
        drop(newest);
        assert!(limit.take(HERE).is_some(), "a slot is free again");
    }

    #[test]
    fn a_websocket_is_closed_after_all_others() {
        let limit = ConnectionLimit::default();
        let mut all: Vec<Permit> = (0..MAX_STRANGERS_PER_ADDRESS)
            .map(|_| limit.take(HERE).unwrap())
            .collect();
        all[0].idle.switch_off();
        all[0].idle.trust();
        let _more: Vec<_> = (0..200).map(|_| limit.take(HERE).unwrap()).collect();
        assert!(!is_closed(&mut all[0]));
        assert!(all[1..].iter_mut().all(is_closed));
    }
}
