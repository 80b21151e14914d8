//! A matrix as written: in Rust with these types, or in a file.

use crate::machine::{Final, Name, names};

/// A matrix before it is compiled.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Definition {
    /// Name of the file in messages; the matrix's name if there is none.
    pub file: String,
    /// Name of the matrix.
    pub name: String,
    /// All events, the one with the highest precedence first.
    pub precedence: Vec<Name>,
    /// Event that is handled when none is pending.
    pub idle: Option<Name>,
    /// The states.
    pub states: Vec<StateDef>,
    /// Initial state; the first if missing.
    pub initial: Option<Name>,
    /// Cells that are filled in.
    pub cells: Vec<CellDef>,
}

/// A state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateDef {
    /// Its name.
    pub name: Name,
    /// Whether it is final.
    pub end: Final,
    /// The sub-behaviour that runs while it is active.
    pub during: Option<DuringDef>,
}

/// A sub-behaviour that runs while a state is active.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DuringDef {
    /// Its name.
    pub run: Name,
    /// Event that is pending once it succeeded.
    pub success: Option<Name>,
    /// Event that is pending once it failed.
    pub failure: Option<Name>,
}

impl StateDef {
    /// A plain state.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.into(),
            end: Final::No,
            during: None,
        }
    }
}

/// A cell that is filled in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellDef {
    /// State of the cell; none for all states without a cell for this event.
    pub state: Option<Name>,
    /// Event of the cell.
    pub event: Name,
    /// The handler that is called.
    pub handler: Name,
    /// States to which the handler may change; none if it only stays.
    pub goto: Vec<Name>,
}

impl CellDef {
    /// A cell whose handler stays. `*` is every state.
    pub fn new(state: &str, event: &str, handler: &str) -> Self {
        Self {
            state: (state != "*").then(|| state.into()),
            event: event.into(),
            handler: handler.into(),
            goto: Vec::new(),
        }
    }

    /// With states to which the handler may change.
    pub fn goto(mut self, states: &[&str]) -> Self {
        self.goto = names(states);
        self
    }
}

impl Definition {
    /// A matrix without cells. Events in their precedence; the first state is
    /// the initial one.
    pub fn new(name: &str, precedence: &[&str], states: &[&str]) -> Self {
        Self {
            file: name.to_owned(),
            name: name.to_owned(),
            precedence: names(precedence),
            states: states.iter().map(|name| StateDef::new(name)).collect(),
            ..Self::default()
        }
    }

    /// With an event for when none is pending.
    pub fn idle(mut self, event: &str) -> Self {
        self.idle = Some(event.into());
        self
    }

    /// With one more cell.
    pub fn cell(mut self, cell: CellDef) -> Self {
        self.cells.push(cell);
        self
    }

    /// Adds a sub-behaviour to a state; its result makes an event pending
    /// where one is named.
    pub fn during(
        mut self,
        state: &str,
        run: &str,
        success: Option<&str>,
        failure: Option<&str>,
    ) -> Self {
        for it in &mut self.states {
            if it.name.text == state {
                it.during = Some(DuringDef {
                    run: run.into(),
                    success: success.map(Name::from),
                    failure: failure.map(Name::from),
                });
            }
        }
        self
    }
}
