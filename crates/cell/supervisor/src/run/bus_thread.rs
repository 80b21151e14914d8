//! The launcher's ports on the bus, on a thread of their own.
//!
//! A process that is killed at the wrong moment can leave shared memory behind that
//! its readers wait for without limit. Signals, the control socket and the
//! children are served by a thread that never touches the bus, so that a cell can be
//! ended and cleaned up whatever is left there.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use cell_bus::{Bus, Keeper, OperatorClient, RunSite, Subscriber};
use cell_rt::clock::monotonic_ns;
use cell_rt::priority::{LAUNCHER_PRIORITY, set_fifo};
use ipc_types::operator::OperatorAction;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{Decision, Health, OperatorRequest, Wire, WorldState};

use super::watch::News;
use crate::failure::{Context, Failure};
use crate::say;

/// How often the bus is listened to.
const TURN: Duration = Duration::from_millis(5);
/// Time between two looks counts at most this much as silence, so that a launcher
/// that was not scheduled takes no process for hung.
const MAX_GAP_NS: u64 = 20_000_000;
/// How long physics may take to answer a request.
const OPERATOR_PATIENCE: Duration = Duration::from_millis(100);
/// How long the services may take to be created.
const OPEN_LIMIT: Duration = Duration::from_secs(20);
/// How long the services may take to be given back.
const CLOSE_LIMIT: Duration = Duration::from_secs(2);

/// The main thread's end.
pub(super) struct BusThread {
    news: Arc<Mutex<News>>,
    /// Gone when the thread has to end.
    requests: Option<SyncSender<(OperatorAction, u32)>>,
    asking: bool,
    heard_ns: u64,
    thread: Option<JoinHandle<()>>,
}

impl BusThread {
    /// Creates the services of run `run` and listens to `processes`.
    pub(super) fn start(site: RunSite, run: u64, processes: &[Process]) -> Result<Self, Failure> {
        let news = Arc::new(Mutex::new(News::default()));
        let (requests, to_do) = sync_channel(1);
        let (opened, is_open) = sync_channel(1);
        let (shared, processes) = (Arc::clone(&news), processes.to_vec());
        let work = move || match Ports::open(&site, run, &processes) {
            Ok(ports) => {
                // The main thread may have given up; `serve` then finds no sender and ends.
                opened.send(Ok(())).ok();
                ports.serve(&shared, &to_do);
            }
            Err(failure) => {
                opened.send(Err(failure)).ok();
            }
        };
        let thread = std::thread::Builder::new()
            .name("bus".to_owned())
            .spawn(work)
            .cannot("start a thread")?;
        let this = Self {
            news,
            requests: Some(requests),
            asking: false,
            heard_ns: monotonic_ns(),
            thread: Some(thread),
        };
        is_open
            .recv_timeout(OPEN_LIMIT)
            .cannot(format!("prepare shared memory within {OPEN_LIMIT:?}"))??;
        Ok(this)
    }

    /// What was heard since the last call.
    pub(super) fn take(&mut self, now_ns: u64) -> News {
        let news = std::mem::take(&mut *self.news.lock().unwrap_or_else(PoisonError::into_inner));
        self.asking &= news.answer.is_none();
        if news.listened_ns > 0 {
            self.heard_ns = now_ns;
        }
        news
    }

    /// For how long the thread has not listened (ns).
    pub(super) fn deaf_ns(&self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.heard_ns)
    }

    /// Sends a request to physics; the answer is in the news. One request at a time: one that
    /// is dropped now is repeated by the caller that needs it.
    pub(super) fn ask(&mut self, action: OperatorAction, count: u32) {
        if !self.asking
            && let Some(requests) = &self.requests
        {
            self.asking = requests.try_send((action, count)).is_ok();
        }
    }
}

impl Drop for BusThread {
    fn drop(&mut self) {
        self.requests = None;
        let Some(thread) = self.thread.take() else {
            return;
        };
        let begin = Instant::now();
        // `join` has no limit, and the thread may wait for damaged shared memory without one.
        while !thread.is_finished() {
            if begin.elapsed() > CLOSE_LIMIT {
                say::warn("the launcher's ports on the bus do not close; their files are removed");
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        thread.join().ok();
    }
}

/// The thread's end. Fields are dropped in this order: the services go last.
struct Ports {
    healths: Vec<(Process, Subscriber<Health>)>,
    state: Subscriber<WorldState>,
    decision: Subscriber<Decision>,
    operator: OperatorClient,
    _bus: Bus,
    _keeper: Keeper,
}

impl Ports {
    fn open(site: &RunSite, run: u64, processes: &[Process]) -> Result<Self, Failure> {
        let controllers = processes
            .iter()
            .filter(|process| matches!(process, Process::Controller(_)));
        let arms = u8::try_from(controllers.count()).unwrap_or(u8::MAX);
        let keeper = Keeper::create(site, run, arms).cannot("prepare shared memory")?;
        let bus = Bus::join(site, run, 1, "launch").cannot("join the cell's bus")?;
        let what = "read the cell's topics";
        let health = |process: &Process| {
            let subscriber = bus.subscriber(TopicId::Health(*process)).cannot(what)?;
            Ok((*process, subscriber))
        };
        let healths = processes.iter().map(health);
        Ok(Self {
            healths: healths.collect::<Result<_, Failure>>()?,
            state: bus.subscriber(TopicId::WorldState).cannot(what)?,
            decision: bus.subscriber(TopicId::Decision).cannot(what)?,
            operator: bus
                .operator_client()
                .cannot("reach the operator's service")?,
            _bus: bus,
            _keeper: keeper,
        })
    }

    /// Until the main thread drops its end.
    fn serve(mut self, news: &Mutex<News>, requests: &Receiver<(OperatorAction, u32)>) {
        // As for the thread it tells.
        set_fifo(LAUNCHER_PRIORITY).ok();
        let mut before_ns = monotonic_ns();
        loop {
            let answer = match requests.recv_timeout(TURN) {
                Ok((action, count)) => Some((action, self.request(action, count))),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return,
            };
            // This may wait without limit, so it comes before the lock is taken.
            let mut newer = self.listen();
            let now_ns = monotonic_ns();
            newer.listened_ns = now_ns.saturating_sub(before_ns).min(MAX_GAP_NS);
            newer.answer = answer;
            news.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .add(newer);
            before_ns = now_ns;
        }
    }

    fn listen(&mut self) -> News {
        // The state first: one that says the run ends was published after the
        // decision it ends with.
        let state = self.state.take().map(|state| Box::new(*state));
        let decision = self.decision.take().map(|decision| Box::new(*decision));
        let health = |(process, health): &mut (Process, Subscriber<Health>)| {
            Some((*process, Box::new(*health.take()?)))
        };
        News {
            state,
            decision,
            healths: self.healths.iter_mut().filter_map(health).collect(),
            ..News::default()
        }
    }

    fn request(&mut self, action: OperatorAction, count: u32) -> bool {
        let mut request = OperatorRequest::zeroed();
        request.action = action.code();
        request.count = count;
        // All zeros is not a rotation and would be refused.
        request.pose = ipc_types::Pose::IDENTITY;
        self.operator.request(request, OPERATOR_PATIENCE).is_ok()
    }
}
