//! A host that answers guards from a list and records the calls.

#![allow(dead_code, reason = "each test file uses a part of it")]

use std::sync::Arc;

use behavior::Status;
use behavior::machine::{
    Actions, BehaviorId, CallbackId, Definition, Event, Fault, GuardId, Machine, TriggerError,
    TriggerId, Vocabulary,
};
use behavior::status::ResetReason;

pub(crate) const GUARDS: &[&str] = &["x", "y"];
pub(crate) const CALLBACKS: &[&str] = &[
    "prepare_event",
    "before_change",
    "after_change",
    "finalize",
    "prep",
    "before",
    "after",
    "enter",
    "exit",
    "enter_child",
    "exit_child",
    "final",
    "posts",
    "fails",
];
pub(crate) const BEHAVIORS: &[&str] = &["fetch", "carry"];
pub(crate) const VOCABULARY: Vocabulary<'static> = Vocabulary {
    triggers: &[],
    guards: GUARDS,
    callbacks: CALLBACKS,
    behaviors: BEHAVIORS,
};

#[derive(Default)]
pub(crate) struct Host {
    pub(crate) holding: Vec<&'static str>,
    /// Makes a guard answer otherwise each time it is asked.
    pub(crate) fickle: bool,
    pub(crate) posts: Vec<TriggerId>,
    pub(crate) results: Vec<Status>,
    pub(crate) slow_to_halt: u32,
    pub(crate) log: Vec<String>,
}

impl Host {
    pub(crate) fn with(holding: &[&'static str]) -> Self {
        Self {
            holding: holding.to_vec(),
            ..Self::default()
        }
    }

    pub(crate) fn take_log(&mut self) -> String {
        std::mem::take(&mut self.log).join(" ")
    }
}

impl Actions for Host {
    fn guard(&mut self, guard: GuardId) -> bool {
        let name = GUARDS[guard.index()];
        self.log.push(format!("c_{name}"));
        let value = self.holding.contains(&name);
        if self.fickle {
            if value {
                self.holding.retain(|it| *it != name);
            } else {
                self.holding.push(name);
            }
        }
        value
    }

    fn call(&mut self, callback: CallbackId, event: &mut Event<'_>) -> Result<(), Fault> {
        let name = CALLBACKS[callback.index()];
        self.log.push(name.to_owned());
        match name {
            "fails" => {
                return Err(Fault {
                    reason: "on purpose",
                });
            }
            "posts" => {
                for trigger in &self.posts {
                    event.post(*trigger)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn run(&mut self, behavior: BehaviorId) -> Status {
        self.log
            .push(format!("run_{}", BEHAVIORS[behavior.index()]));
        if self.results.is_empty() {
            Status::Running
        } else {
            self.results.remove(0)
        }
    }

    fn halt(&mut self, behavior: BehaviorId, _: ResetReason) -> bool {
        self.log
            .push(format!("halt_{}", BEHAVIORS[behavior.index()]));
        self.slow_to_halt = self.slow_to_halt.saturating_sub(1);
        self.slow_to_halt == 0
    }
}

pub(crate) fn machine(definition: &Definition) -> Machine {
    Machine::new(Arc::new(definition.compile(&VOCABULARY).unwrap()))
}

pub(crate) fn fire(
    machine: &mut Machine,
    trigger: &str,
    host: &mut Host,
) -> Result<bool, TriggerError> {
    let id = machine.table().trigger(trigger).unwrap();
    machine.trigger(id, host).map(|fired| fired.taken)
}

/// Fires; answers `taken` and the state, as the rows of the tables are written.
pub(crate) fn go(machine: &mut Machine, trigger: &str, host: &mut Host) -> (bool, String) {
    let taken = fire(machine, trigger, host).unwrap();
    (taken, machine.state_name().to_owned())
}

pub(crate) fn states(machine: &Machine) -> Vec<&str> {
    machine
        .active()
        .map(|state| machine.table().state_name(state))
        .collect()
}
