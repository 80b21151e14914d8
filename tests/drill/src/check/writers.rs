//! Messages are used in their order, and only those about the present world.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use ipc_types::Header;
use ipc_types::header::Input;
use ipc_types::topic::{Process, TopicId};

use super::history::undo;
use super::{Check, Moment, Seen, Verdict, fail_if};
use crate::model::News;
use crate::plan::{Fault, Plan};

/// Ticks between two decisions.
const DECISION_TICKS: u64 = 10;
/// Most arms of a cell.
const MAX_ARMS: u8 = 2;
/// Messages of a topic that may still be used.
const MESSAGES: usize = 5_000;

pub(super) fn all(plan: &Plan) -> Vec<Box<dyn Check>> {
    let mut all: Vec<Box<dyn Check>> = vec![
        Box::new(Order::default()),
        Box::new(Once::default()),
        Box::new(World::default()),
        Box::new(Resets::default()),
        Box::new(Decided::default()),
        Box::new(Valid::default()),
        Box::new(Answers::default()),
    ];
    if plan.lockstep {
        all.push(Box::new(Causes::default()));
    }
    all
}

/// The headers that `moment` has, with a number of their topic.
fn header<'a>(moment: &Moment<'a>) -> Option<(u32, &'a Header)> {
    let arm = |arm: usize| u8::try_from(arm).unwrap_or(0);
    Some(match moment.seen {
        Seen::State(message) => (TopicId::WorldState.code(), &message.header),
        Seen::Decision(message) => (TopicId::Decision.code(), &message.header),
        Seen::Status(of, message) => (TopicId::ArmStatus(arm(of)).code(), &message.header),
        Seen::Command(of, message) => (TopicId::ArmCommand(arm(of)).code(), &message.header),
        _ => return None,
    })
}

/// A reader never goes back to a message of an older start, or an older one of the same.
#[derive(Default)]
struct Order {
    /// By reader, its start, and topic: generation and number of the last input.
    used: BTreeMap<(u32, u32, u32), (u32, u64)>,
}

impl Check for Order {
    fn number(&self) -> u32 {
        9
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Some((topic, header)) = header(moment) else {
            return Ok(());
        };
        for input in header.inputs() {
            let reader = (topic, header.generation, input.topic);
            let new = (input.generation, input.seq);
            let old = self.used.insert(reader, new).unwrap_or(new);
            fail_if(old > new, || {
                format!(
                    "topic {topic} used message {new:?} of topic {} after {old:?}",
                    input.topic
                )
            })?;
        }
        Ok(())
    }
}

/// A reader uses each message once, and none after a newer one.
#[derive(Default)]
struct Once {
    /// By topic: generation and number of the newest.
    newest: BTreeMap<u32, (u32, u64)>,
}

impl Check for Once {
    fn number(&self) -> u32 {
        9
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::Used(topic, header) = moment.seen else {
            return Ok(());
        };
        let new = (header.generation, header.seq);
        let old = self.newest.insert(topic.code(), new);
        fail_if(old >= Some(new), || {
            let name = topic.service();
            format!("a reader of {name} used message {new:?} after {old:?}")
        })
    }
}

/// Generation and number of a message, and the physics that it answers.
type Answer = ((u32, u64), u32);

/// Commands and decisions that physics uses answer this start of physics.
#[derive(Default)]
struct World {
    /// By topic: generation and number of messages, in their order, and the physics that each
    /// answers.
    answers: BTreeMap<u32, VecDeque<Answer>>,
    /// The newest message of each topic that a physics used: a successor resumes with it in
    /// force.
    in_force: BTreeMap<u32, (u32, u64)>,
}

impl Check for World {
    fn number(&self) -> u32 {
        11
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Some((topic, header)) = header(moment) else {
            return Ok(());
        };
        let state = TopicId::WorldState.code();
        let physics = header.inputs().iter().find(|input| input.topic == state);
        let physics = match (topic == state, physics) {
            (true, _) => header.generation,
            (false, Some(input)) => input.generation,
            (false, None) => return Ok(()),
        };
        for input in header.inputs().iter().filter(|input| input.topic != state) {
            let message = (input.generation, input.seq);
            let answered = self.answered(input.topic, message).unwrap_or(physics);
            let was_used = topic == state && self.in_force.get(&input.topic) >= Some(&message);
            if topic == state {
                self.in_force.insert(input.topic, message);
            }
            fail_if(answered != physics && !was_used, || {
                format!(
                    "topic {topic} about physics {physics} used message {message:?} of topic {}, \
                     which answers physics {answered}",
                    input.topic
                )
            })?;
        }
        let message = (header.generation, header.seq);
        let answers = self.answers.entry(topic).or_default();
        // A decision may be repeated with its number; the last counts.
        undo(answers, |(of, _)| *of >= message);
        answers.push_back((message, physics));
        if answers.len() > MESSAGES {
            answers.pop_front();
        }
        Ok(())
    }
}

impl World {
    /// The physics that a message answers, if it was seen.
    fn answered(&self, topic: u32, message: (u32, u64)) -> Option<u32> {
        let answers = self.answers.get(&topic)?;
        // Most messages that are used are among the newest.
        let mut newest = answers.iter().rev();
        let (of, physics) = newest.find(|(of, _)| *of <= message)?;
        (*of == message).then_some(*physics)
    }
}

/// After a reset of the scene no command about the scene before it is in force.
#[derive(Default)]
struct Resets {
    /// Number of the newest reset, the generation of physics that had it, and its tick.
    reset: (u32, u32, u64),
}

impl Check for Resets {
    fn number(&self) -> u32 {
        11
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::State(state) = moment.seen else {
            return Ok(());
        };
        let (number, generation) = (state.panel.scene_reset, state.header.generation);
        if (number, generation) != (self.reset.0, self.reset.1) {
            // A successor of physics may have resumed long after the reset.
            let is_reset = number != self.reset.0 && generation == self.reset.1;
            let tick = if is_reset { state.header.tick } else { 0 };
            self.reset = (number, generation, tick);
        }
        // The state in which the reset is published may be one tick later.
        let reset_tick = self.reset.2.saturating_sub(1);
        let arms = state.arms().iter().enumerate();
        for (arm, of) in arms.filter(|(_, of)| of.command_seq > 0) {
            fail_if(of.command_tick < reset_tick, || {
                let tick = of.command_tick;
                format!(
                    "arm {arm} follows a command about tick {tick}, before the reset at {reset_tick}"
                )
            })?;
        }
        Ok(())
    }
}

/// After a reset of the scene no decision about the scene before it is in force.
#[derive(Default)]
struct Decided {
    /// Number of the newest reset, and the generation of physics that had it.
    reset: Option<(u32, u32)>,
    /// The first tick of the scene, where this start of physics reset it.
    first_tick: u64,
}

impl Check for Decided {
    fn number(&self) -> u32 {
        11
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        if let Seen::State(state) = moment.seen {
            let now = (state.panel.scene_reset, state.header.generation);
            if let Some(before) = self.reset.replace(now).filter(|before| *before != now) {
                let is_reset = before.1 == now.1;
                self.first_tick = if is_reset { state.header.tick } else { 0 };
            }
        }
        let generation = self.reset.map_or(0, |(_, generation)| generation);
        let Some((topic, header)) = header(moment) else {
            return Ok(());
        };
        let decision = TopicId::Decision.code();
        let is_state = topic == TopicId::WorldState.code();
        let is_of_scene = (is_state || header.answers(generation))
            && topic != decision
            && header.tick >= self.first_tick;
        let used = header.inputs().iter().filter(|_| is_of_scene);
        for input in used.filter(|input| input.topic == decision) {
            // Physics uses a decision in the step that leads to the state.
            let at = header.tick.saturating_sub(u64::from(is_state));
            let about = at.saturating_sub(input.age_ticks);
            fail_if(about < self.first_tick, || {
                let (tick, first) = (header.tick, self.first_tick);
                format!(
                    "topic {topic} of tick {tick} used a decision about tick {about}, before the \
                     reset at {first}"
                )
            })?;
        }
        Ok(())
    }
}

/// No process refuses a message of another that was not damaged, or uses one that was.
#[derive(Default)]
struct Valid {
    /// Number of damaged messages.
    damaged: u64,
    /// Topics whose next message is damaged.
    next: BTreeSet<u32>,
    /// By topic: generation and number of the last message, and of the one that was damaged last.
    last: BTreeMap<u32, (u32, u64)>,
    of: BTreeMap<u32, (u32, u64)>,
}

impl Valid {
    fn message(&mut self, topic: u32, header: &Header) -> Verdict {
        let new = (header.generation, header.seq);
        if self.damaged == 0 {
            self.last.insert(topic, new);
            return Ok(());
        }
        let used =
            |input: &&Input| self.of.get(&input.topic) == Some(&(input.generation, input.seq));
        let used = header.inputs().iter().find(used);
        let last = self.last.insert(topic, new).unwrap_or_default();
        if self.next.remove(&topic) {
            // Two messages of one turn are seen as one.
            let is_same = last.0 == new.0;
            let first = if is_same {
                (last.0, last.1 + 1)
            } else {
                (new.0, 1)
            };
            self.of.insert(topic, first);
        }
        used.map_or(Ok(()), |input| {
            let (of, seq) = (input.topic, input.seq);
            Err(format!(
                "topic {topic} used message {seq} of topic {of}, which is damaged"
            ))
        })
    }
}

impl Check for Valid {
    fn number(&self) -> u32 {
        12
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        if let Seen::Fault(Fault::Damage { topic, .. }) = moment.seen {
            self.damaged += 1;
            let topic = crate::plan::topic(topic, MAX_ARMS);
            self.next.extend(topic.map(TopicId::code));
        }
        if let Some((topic, header)) = header(moment) {
            return self.message(topic, header);
        }
        let Seen::Health(process, health) = moment.seen else {
            return Ok(());
        };
        fail_if(health.rejected > self.damaged, || {
            format!("{} rejected {} messages", process.name(), health.rejected)
        })
    }
}

/// A controller answers a state once: a second command would move its setpoint twice.
#[derive(Default)]
struct Answers {
    /// By topic: the start of the controller, and generation and tick of the state that it
    /// answered last.
    last: BTreeMap<u32, (u32, u32, u64)>,
}

impl Check for Answers {
    fn number(&self) -> u32 {
        10
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let (Seen::Command(..), Some((topic, header))) = (moment.seen, header(moment)) else {
            return Ok(());
        };
        let state = TopicId::WorldState.code();
        let physics = header.inputs().iter().find(|input| input.topic == state);
        let physics = physics.map_or(0, |input| input.generation);
        let answer = (header.generation, physics, header.tick);
        let last = self.last.insert(topic, answer);
        fail_if(last == Some(answer), || {
            format!("the state of tick {} was answered twice", header.tick)
        })
    }
}

/// In lockstep each input is the one that its tick asks for. What a killed controller has not
/// sent is waited for, and then done without. A task whose newest checkpoint is damaged repeats the
/// decision of the one before.
#[derive(Default)]
struct Causes {
    died_ns: Option<u64>,
}

/// Longest time after such a start or death for which messages are missed (ns).
const MISSED_NS: u64 = 5_000_000_000;

impl Check for Causes {
    fn number(&self) -> u32 {
        10
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        if let Seen::News(News::Gone(Process::Controller(_), ..) | News::Meets(Process::Task, ..)) =
            moment.seen
        {
            self.died_ns = Some(moment.now_ns);
        }
        let is_missed = |died_ns: u64| moment.now_ns < died_ns + MISSED_NS;
        let Some((topic, header)) = header(moment).filter(|_| !self.died_ns.is_some_and(is_missed))
        else {
            return Ok(());
        };
        let tick = header.tick;
        let decision = TopicId::Decision.code();
        for input in header.inputs() {
            let Some(before) = tick.checked_sub(1) else {
                continue;
            };
            let is_status = TopicId::ArmStatus(0).code() == input.topic
                || TopicId::ArmStatus(1).code() == input.topic;
            fail_if(is_status && input.age_ticks != 1, || {
                let age = input.age_ticks;
                format!("the decision of tick {tick} used a status of {age} ticks, not 1")
            })?;
            let is_of_arm = matches!(moment.seen, Seen::Status(..) | Seen::Command(..));
            if is_of_arm && input.topic == decision {
                let wanted = tick - (before - before % DECISION_TICKS);
                fail_if(input.age_ticks != wanted, || {
                    format!(
                        "topic {topic} of tick {tick} used a decision of {} ticks, not {wanted}",
                        input.age_ticks
                    )
                })?;
            }
        }
        Ok(())
    }
}
