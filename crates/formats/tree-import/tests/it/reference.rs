//! The nodes of BehaviorTree.CPP 4 as their documentation describes them, for comparison.

use std::collections::BTreeMap;

/// What a node is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Leaf(String),
    Set(bool),
    Ask,
    Sequence,
    Fallback,
    ReactiveSequence,
    ReactiveFallback,
    SequenceWithMemory,
    Parallel { successes: usize, failures: usize },
    ParallelAll { failures: usize },
    IfThenElse,
    Inverter,
    ForceSuccess,
    ForceFailure,
    Repeat(usize),
    Retry(usize),
    KeepRunning,
    RunOnce { then_skip: bool },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    Running,
    Success,
    Failure,
    Skipped,
}

/// `_skipIf`, ..
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Around {
    SkipIf,
    SuccessIf,
    FailureIf,
    While,
}

#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub kind: Kind,
    /// With the value of the key `on` that it asks for.
    pub around: Option<(Around, bool)>,
    pub children: Vec<Node>,
    /// `None` is IDLE.
    status: Option<Answer>,
    at: usize,
    count: usize,
    ended: BTreeMap<usize, Answer>,
    last: Option<Answer>,
}

/// What the leaves share.
#[derive(Default)]
pub(crate) struct World {
    pub on: bool,
    pub scripts: BTreeMap<String, (String, usize)>,
    pub ticked: Vec<String>,
    pub halted: Vec<String>,
}

use Answer::{Failure, Running, Skipped, Success};

impl Node {
    pub(crate) fn new(kind: Kind, children: Vec<Self>) -> Self {
        Self {
            kind,
            around: None,
            children,
            status: None,
            at: 0,
            count: 0,
            ended: BTreeMap::new(),
            last: None,
        }
    }

    pub(crate) fn execute(&mut self, world: &mut World) -> Answer {
        let answer = match self.around {
            Some((Around::While, wanted)) if world.on != wanted => {
                if self.status == Some(Running) {
                    self.halt(world);
                    self.status = None;
                }
                Skipped
            }
            Some((around, wanted)) if self.status.is_none() && world.on == wanted => match around {
                Around::SkipIf => Skipped,
                Around::SuccessIf => Success,
                Around::FailureIf => Failure,
                Around::While => self.tick(world),
            },
            _ => self.tick(world),
        };
        if answer != Skipped {
            self.status = Some(answer);
        }
        answer
    }

    fn halt_child(&mut self, index: usize, world: &mut World) {
        let child = &mut self.children[index];
        if child.status == Some(Running) {
            child.halt(world);
        }
        child.status = None;
    }

    fn halt_from(&mut self, first: usize, world: &mut World) {
        (first..self.children.len()).for_each(|index| self.halt_child(index, world));
    }

    fn halt(&mut self, world: &mut World) {
        if let Kind::Leaf(name) = &self.kind {
            world.halted.push(name.clone());
        }
        if self.kind != Kind::SequenceWithMemory {
            self.at = 0;
        }
        self.count = 0;
        self.ended.clear();
        self.halt_from(0, world);
    }

    fn tick(&mut self, world: &mut World) -> Answer {
        match self.kind.clone() {
            Kind::Leaf(name) => {
                world.ticked.push(name.clone());
                let (script, given) = world.scripts.get_mut(&name).unwrap();
                let letter = script
                    .chars()
                    .nth(*given)
                    .or(script.chars().last())
                    .unwrap();
                *given += 1;
                match letter {
                    'R' => Running,
                    'F' => Failure,
                    _ => Success,
                }
            }
            Kind::Set(value) => {
                world.on = value;
                Success
            }
            Kind::Ask => {
                if world.on {
                    Success
                } else {
                    Failure
                }
            }
            Kind::Sequence => self.line(world, Success),
            Kind::Fallback => self.line(world, Failure),
            Kind::ReactiveSequence => self.reactive(world, Success),
            Kind::ReactiveFallback => self.reactive(world, Failure),
            Kind::SequenceWithMemory => self.with_memory(world),
            Kind::Parallel {
                successes,
                failures,
            } => self.parallel(world, Some(successes), failures),
            Kind::ParallelAll { failures } => self.parallel(world, None, failures),
            Kind::IfThenElse => self.if_then_else(world),
            Kind::Repeat(count) => self.again(world, count, Success),
            Kind::Retry(count) => self.again(world, count, Failure),
            Kind::RunOnce { then_skip } => self.once(world, then_skip),
            kind => self.decorated(world, &kind),
        }
    }

    /// Continues while children answer `goes_on`.
    fn line(&mut self, world: &mut World, goes_on: Answer) -> Answer {
        if self.status != Some(Running) {
            self.count = 0;
        }
        self.status = Some(Running);
        while self.at < self.children.len() {
            match self.children[self.at].execute(world) {
                Running => return Running,
                Skipped => {
                    self.count += 1;
                    self.at += 1;
                }
                answer if answer == goes_on => self.at += 1,
                answer => {
                    self.halt_from(0, world);
                    self.at = 0;
                    return answer;
                }
            }
        }
        let all_skipped = self.count == self.children.len();
        self.halt_from(0, world);
        self.at = 0;
        if all_skipped { Skipped } else { goes_on }
    }

    fn reactive(&mut self, world: &mut World, goes_on: Answer) -> Answer {
        self.status = Some(Running);
        let mut all_skipped = true;
        for index in 0..self.children.len() {
            let answer = self.children[index].execute(world);
            all_skipped &= answer == Skipped;
            match answer {
                Running => {
                    (0..self.children.len())
                        .filter(|other| *other != index)
                        .for_each(|other| self.halt_child(other, world));
                    return Running;
                }
                Skipped => self.halt_child(index, world),
                answer if answer == goes_on => {}
                answer => {
                    self.halt_from(0, world);
                    return answer;
                }
            }
        }
        self.halt_from(0, world);
        if all_skipped { Skipped } else { goes_on }
    }

    fn with_memory(&mut self, world: &mut World) -> Answer {
        self.status = Some(Running);
        while self.at < self.children.len() {
            let before = self.children[self.at].status;
            match self.children[self.at].execute(world) {
                Success => {
                    self.at += 1;
                    if before.is_none() && self.at < self.children.len() {
                        return Running;
                    }
                }
                Failure => {
                    self.halt_from(self.at, world);
                    return Failure;
                }
                answer => return answer,
            }
        }
        self.halt_from(0, world);
        self.at = 0;
        Success
    }

    /// Without `successes` it waits for all.
    fn parallel(&mut self, world: &mut World, successes: Option<usize>, failures: usize) -> Answer {
        self.status = Some(Running);
        let count = self.children.len();
        let of = |ended: &BTreeMap<usize, Answer>, answer| {
            ended.values().filter(|a| **a == answer).count()
        };
        let mut answer = None;
        for index in 0..count {
            if !self.ended.contains_key(&index) {
                let answer = self.children[index].execute(world);
                if answer != Running {
                    self.ended.insert(index, answer);
                }
            }
            let (good, bad) = (of(&self.ended, Success), of(&self.ended, Failure));
            if let Some(successes) = successes {
                if good >= successes {
                    answer = Some(Success);
                } else if count - bad < successes || bad == failures {
                    answer = Some(Failure);
                }
            }
            if answer.is_some() {
                break;
            }
        }
        if successes.is_none() && self.ended.len() == count {
            let failed = of(&self.ended, Failure) >= failures;
            answer = Some(if failed { Failure } else { Success });
        }
        let Some(answer) = answer else { return Running };
        self.ended.clear();
        self.halt_from(0, world);
        answer
    }

    fn if_then_else(&mut self, world: &mut World) -> Answer {
        self.status = Some(Running);
        if self.at == 0 {
            self.at = match self.children[0].execute(world) {
                Success => 1,
                Failure if self.children.len() == 3 => 2,
                Failure => {
                    self.halt_from(0, world);
                    return Failure;
                }
                answer => return answer,
            };
        }
        let answer = self.children[self.at].execute(world);
        if answer != Running {
            self.halt_from(0, world);
            self.at = 0;
        }
        answer
    }

    fn again(&mut self, world: &mut World, most: usize, repeats: Answer) -> Answer {
        self.status = Some(Running);
        loop {
            let before = self.children[0].status;
            match self.children[0].execute(world) {
                Running => return Running,
                answer if answer == repeats => {
                    self.count += 1;
                    self.halt_child(0, world);
                    if self.count >= most {
                        self.count = 0;
                        return repeats;
                    }
                    if before.is_none() {
                        return Running;
                    }
                }
                answer => {
                    self.count = 0;
                    self.halt_child(0, world);
                    return answer;
                }
            }
        }
    }

    fn once(&mut self, world: &mut World, then_skip: bool) -> Answer {
        if let Some(last) = self.last {
            return if then_skip { Skipped } else { last };
        }
        self.status = Some(Running);
        let answer = self.children[0].execute(world);
        if answer != Running {
            self.last = Some(answer);
            self.halt_child(0, world);
        }
        answer
    }

    fn decorated(&mut self, world: &mut World, kind: &Kind) -> Answer {
        self.status = Some(Running);
        let answer = self.children[0].execute(world);
        if matches!(answer, Success | Failure) {
            self.halt_child(0, world);
        }
        match (kind, answer) {
            (_, Running | Skipped) => answer,
            (Kind::Inverter, Success) | (Kind::ForceFailure, _) => Failure,
            (Kind::Inverter, Failure) | (Kind::ForceSuccess, _) => Success,
            (Kind::KeepRunning, Success) => Running,
            (_, answer) => answer,
        }
    }
}
