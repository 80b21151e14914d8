//! The thread of the planner. A cycle hands a request over and takes an answer, and never
//! waits for it in real time.
//!
//! The two sides exchange one box, which is always with one of them. An idle side parks and is
//! woken; the channels are only tried, which takes no lock. So a cycle frees no memory: the
//! box returns with the next request.

use std::io;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::{Builder, JoinHandle};

use crate::cycle::Cycle;
use crate::planning::{ANSWER_TICKS, PlanAnswer, PlanRequest, Planner};

/// A request and its answer.
struct Job {
    request: PlanRequest,
    /// From the planner the answer; to the planner one that can be dropped.
    answer: Option<PlanAnswer>,
    /// Whether the answer belongs to the request and was not delivered.
    is_answered: bool,
}

impl Job {
    /// An idle one, with room for the requests of `cycle`.
    fn none(cycle: &Cycle) -> Box<Self> {
        Box::new(Self {
            request: cycle.empty_plan_request(),
            answer: None,
            is_answered: false,
        })
    }

    fn be_answered(&mut self, planner: &mut Planner) {
        self.answer = Some(planner.answer(&self.request));
        self.is_answered = true;
    }
}

/// The planner of one arm.
pub struct PlanWorker {
    to_planner: Option<SyncSender<Box<Job>>>,
    from_planner: Receiver<Box<Job>>,
    thread: Option<JoinHandle<()>>,
    /// `None` while the planner has it.
    job: Option<Box<Job>>,
    /// In a model: answers without a thread.
    here: Option<Planner>,
}

impl PlanWorker {
    /// Starts the thread, with the priority of the caller, for a `cycle` of the planner's arm.
    ///
    /// # Errors
    /// The error of the operating system if the thread cannot be started.
    pub fn start(planner: Planner, cycle: &Cycle) -> io::Result<Self> {
        let (to_planner, requests) = sync_channel(1);
        let (answers, from_planner) = sync_channel(1);
        let thread = Builder::new()
            .name("planner".to_owned())
            .spawn(move || work(planner, &requests, &answers))?;
        Ok(Self {
            to_planner: Some(to_planner),
            from_planner,
            thread: Some(thread),
            job: Some(Job::none(cycle)),
            here: None,
        })
    }

    /// The planner of a modelled process: a request is answered when it is handed over.
    pub fn model(planner: Planner, cycle: &Cycle) -> Self {
        Self {
            to_planner: None,
            from_planner: sync_channel(1).1,
            thread: None,
            job: Some(Job::none(cycle)),
            here: Some(planner),
        }
    }

    /// Delivers the answer that is due at `tick` to `cycle`. False while it is due and missing:
    /// lockstep calls this again, real time in its next cycle. Allocates nothing.
    pub fn deliver(&mut self, cycle: &mut Cycle, tick: u64) -> bool {
        let Some(asked) = cycle.plan_asked() else {
            return true;
        };
        // Also an early answer is taken at this tick only: a fast machine gives the same run.
        if tick < asked.tick + ANSWER_TICKS {
            return true;
        }
        // A request that was made while the planner was busy is handed over here.
        self.hand_over(cycle);
        let done = |job: &&mut Box<Job>| job.is_answered && job.request.id == asked.id;
        let Some(job) = self.job.as_mut().filter(done) else {
            return false;
        };
        job.is_answered = false;
        cycle.answer_plan(&mut job.answer);
        true
    }

    /// Hands a new request of `cycle` to the planner. A request in work is finished first.
    /// Allocates nothing.
    pub fn hand_over(&mut self, cycle: &Cycle) {
        if let Ok(job) = self.from_planner.try_recv() {
            self.job = Some(job);
        }
        let asked = cycle.plan_asked().map(|asked| asked.id);
        let is_news = |job: &mut Box<Job>| asked.is_some_and(|id| id != job.request.id);
        let Some(mut job) = self.job.take_if(is_news) else {
            return;
        };
        cycle.copy_plan_request(&mut job.request);
        job.is_answered = false;
        if let Some(planner) = &mut self.here {
            job.be_answered(planner);
            self.job = Some(job);
            return;
        }
        // The channel has room: there is one job.
        let sent = self
            .to_planner
            .as_ref()
            .map(|planner| planner.try_send(job));
        if let (Some(Ok(())), Some(thread)) = (sent, &self.thread) {
            thread.thread().unpark();
        }
    }
}

/// Answers requests until the worker is dropped.
fn work(mut planner: Planner, requests: &Receiver<Box<Job>>, answers: &SyncSender<Box<Job>>) {
    loop {
        match requests.try_recv() {
            Ok(mut job) => {
                job.be_answered(&mut planner);
                // The channel has room: there is one job.
                let _sent = answers.try_send(job).is_ok();
            }
            Err(TryRecvError::Empty) => std::thread::park(),
            Err(TryRecvError::Disconnected) => return,
        }
    }
}

impl Drop for PlanWorker {
    /// Ends the thread.
    fn drop(&mut self) {
        // Closes the channel; the parked thread is woken to notice it.
        self.to_planner = None;
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ended = thread.join().is_ok();
        }
    }
}
