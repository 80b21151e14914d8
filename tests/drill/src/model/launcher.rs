//! The launcher's side of the model: what the supervisor's loop needs of a machine.

use cell_bus::{Answered, Bus, BusError, OperatorClient, PendingReply, Subscriber};
use cell_model::cells::script::ScriptAction;
use ipc_types::operator::OperatorAction;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{Decision, Health, OperatorRequest, Pose, Wire, WorldState};
use supervisor::failure::Failure;
use supervisor::run::machine::{Machine, Threads};
use supervisor::run::{News as Heard, Watch};
use supervisor::supervision::Exit;

use super::running::Running;
use super::{Model, News, Shared, Signal};
use crate::plan::{Fault, MS, ticks};

/// As for the launcher's thread of the bus.
const OPERATOR_PATIENCE_NS: u64 = 100 * MS;
/// A turn of a process beside busy loops, where each has a small part of a core (ns).
const BUSY_TURN_NS: u64 = 4 * MS;

/// The machine of a simulated cell.
pub struct Launcher {
    model: Shared,
    healths: Vec<(Process, Subscriber<Health>)>,
    state: Subscriber<WorldState>,
    decision: Subscriber<Decision>,
    operator: OperatorClient,
    /// The request in flight, and since when.
    asked: Option<(OperatorAction, PendingReply, u64)>,
    heard_ns: u64,
}

impl Launcher {
    /// Of `model`.
    ///
    /// # Errors
    /// When the bus has no such topics.
    pub fn new(model: &Shared) -> Result<Self, BusError> {
        let bus: Bus = model.borrow().bus(1);
        let health = |process: Process| Ok((process, bus.subscriber(TopicId::Health(process))?));
        let processes = model.borrow().processes();
        Ok(Self {
            model: model.clone(),
            healths: processes
                .into_iter()
                .map(health)
                .collect::<Result<_, BusError>>()?,
            state: bus.subscriber(TopicId::WorldState)?,
            decision: bus.subscriber(TopicId::Decision)?,
            operator: bus.operator_client()?,
            asked: None,
            heard_ns: 0,
        })
    }

    fn answer(&mut self, now_ns: u64) -> Option<(OperatorAction, bool)> {
        let (action, pending, since_ns) = self.asked.take()?;
        match pending.take() {
            Answered::Reply(_) => Some((action, true)),
            Answered::Waiting if now_ns < since_ns + OPERATOR_PATIENCE_NS => {
                self.asked = Some((action, pending, since_ns));
                None
            }
            Answered::Waiting | Answered::Dropped => Some((action, false)),
        }
    }
}

impl Machine for Launcher {
    fn spawn(&mut self, process: Process, generation: u32) -> Result<(), String> {
        self.model.borrow_mut().spawn(process, generation);
        Ok(())
    }

    fn terminate(&mut self, process: Process) {
        let mut model = self.model.borrow_mut();
        model.news.push(News::Signalled(process, Signal::Terminate));
        let one = model.running.iter_mut().find(|one| one.process == process);
        if let Some(one) = one {
            // SIGCONT follows it.
            (one.is_stopping, one.frozen_until_ns) = (true, 0);
        }
    }

    fn kill(&mut self, process: Process) {
        let mut model = self.model.borrow_mut();
        model.news.push(News::Signalled(process, Signal::Kill));
        model.kill(process, None);
    }

    fn freeze(&mut self, process: Process) {
        let mut model = self.model.borrow_mut();
        model.stop(process, u64::MAX);
        model.news.push(News::Stopped(process, true));
    }

    fn thaw(&mut self, process: Process) {
        let mut model = self.model.borrow_mut();
        model.stop(process, 0);
        model.news.push(News::Stopped(process, false));
    }

    fn choose(&mut self, policy: &str) -> Result<(), String> {
        policy.clone_into(&mut self.model.borrow_mut().spec.policy);
        Ok(())
    }

    fn disturb(&mut self, now_ns: u64, action: &ScriptAction) -> Result<(), String> {
        let mut model = self.model.borrow_mut();
        match action {
            ScriptAction::Starve { for_s } => {
                let (for_ms, turn_us) = (ticks(*for_s), BUSY_TURN_NS / 1000);
                for of in model.processes() {
                    model.slow_down(of, BUSY_TURN_NS, now_ns + for_ms * MS);
                    let process = of.name();
                    model.news.push(News::Disturbed(Fault::Busy {
                        process,
                        for_ms,
                        turn_us,
                    }));
                }
            }
            ScriptAction::Fill { for_s } => {
                let for_ms = ticks(*for_s);
                model.fill(now_ns + for_ms * MS);
                model.news.push(News::Disturbed(Fault::Full { for_ms }));
            }
            // Its files are memory that no line overwrites.
            _ => {}
        }
        Ok(())
    }

    /// They end by themselves.
    fn end_disturbances(&mut self, _now_ns: u64) {}

    fn reap(&mut self) -> Vec<(Process, u32, Exit)> {
        std::mem::take(&mut self.model.borrow_mut().ended)
    }

    fn pid(&self, process: Process) -> Option<u32> {
        let model = self.model.borrow();
        let one = model.running.iter().find(|one| one.process == process);
        one.map(|one| one.pid)
    }

    fn threads(&self, pid: u32, _: bool) -> Option<Threads> {
        let model = self.model.borrow();
        let one = model.running.iter().find(|one| one.pid == pid)?;
        Some((one.share(model.now_ns()), vec![]))
    }

    fn lack_of_room(&self) -> Option<String> {
        let model = self.model.borrow();
        let is_full = model.now_ns() < model.full_until_ns;
        is_full.then(|| "/dev/shm has 0 KiB free".to_owned())
    }

    fn remove_half_made(&mut self, _: u64, _: bool, _: u64) {}

    fn news(&mut self, now_ns: u64) -> Heard {
        let health = |(process, health): &mut (Process, Subscriber<Health>)| {
            Some((*process, Box::new(*health.take()?)))
        };
        let before_ns = std::mem::replace(&mut self.heard_ns, now_ns);
        Heard {
            state: self.state.take().map(|state| Box::new(*state)),
            decision: self.decision.take().map(|decision| Box::new(*decision)),
            healths: self.healths.iter_mut().filter_map(health).collect(),
            // By the launcher's thread of the bus, which is scheduled when its main thread is not.
            listened_ns: now_ns - before_ns,
            answer: self.answer(now_ns),
        }
    }

    fn deaf_ns(&self, _: u64) -> u64 {
        0
    }

    fn ask(&mut self, action: OperatorAction, count: u32) {
        if self.asked.is_some() {
            return;
        }
        let mut request = OperatorRequest::zeroed();
        request.action = action.code();
        request.count = count;
        request.pose = Pose::IDENTITY;
        if let Ok(Some(pending)) = self.operator.send(request) {
            self.asked = Some((action, pending, self.heard_ns));
        }
    }

    fn new_bus(&mut self) -> Result<(), Failure> {
        // The ports of all processes are gone with them, as on another bus.
        Ok(())
    }

    fn note(&mut self, _: u64, _: &Watch) {}

    fn incident(&mut self, _: u64, _: Process, _: &str) -> String {
        "an incident is kept".to_owned()
    }

    fn last_words(&self, process: Process, count: usize) -> Vec<String> {
        let model = self.model.borrow();
        let of = model.logs.iter().filter(|(other, _)| *other == process);
        let lines: Vec<String> = of.map(|(_, line)| line.clone()).collect();
        lines[lines.len().saturating_sub(count)..].to_vec()
    }

    fn warn(&mut self, text: &str) {
        let news = News::Warned(text.to_owned());
        self.model.borrow_mut().news.push(news);
    }
}

impl Model {
    /// A process exists from now on; its loop begins after its start.
    fn spawn(&mut self, process: Process, generation: u32) {
        let slow = self.slow.iter().position(|(other, _)| *other == process);
        // Reading its files, opening its ports (docs/scale.md).
        let usual_ms = 12 + self.draw(48);
        let start_ms = slow.map_or(usual_ms, |slow| self.slow.remove(slow).1);
        self.next_pid += 1;
        let begins_ns = self.now_ns() + start_ms * MS;
        let one = Running::new(process, generation, self.next_pid, begins_ns);
        let place = Process::all(self.spec.arms);
        let place_of = |process| place.iter().position(|p| *p == process);
        self.running.push(Box::new(one));
        self.running.sort_by_key(|one| place_of(one.process));
        self.news.push(News::Spawned(process, generation));
    }
}
