//! A machine as written: in Rust with these types, or in a file.

use super::problem::Location;

/// A name and its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// The name.
    pub text: String,
    /// Its place in the file; the default when written in Rust.
    pub place: Location,
}

impl From<&str> for Name {
    fn from(text: &str) -> Self {
        Self {
            text: text.to_owned(),
            place: Location::default(),
        }
    }
}

/// Many names.
pub fn names(texts: &[&str]) -> Vec<Name> {
    texts.iter().map(|text| Name::from(*text)).collect()
}

/// A machine before it is compiled.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Definition {
    /// Name of the file in messages; the machine's name if there is none.
    pub file: String,
    /// Name of the machine.
    pub name: String,
    /// States; children are inside of their parent.
    pub states: Vec<StateDef>,
    /// Initial state: a full name such as `work.fetch`.
    pub initial: Option<Name>,
    /// Triggers that rows may name; if empty, any.
    pub triggers: Vec<Name>,
    /// Rows, in their order of precedence for one trigger and source.
    pub rows: Vec<RowDef>,
    /// Chains of states that follow one trigger.
    pub ordered: Vec<OrderedDef>,
    /// Run at the start of the handling of a trigger.
    pub prepare_event: Vec<Name>,
    /// Run when the guards of a row hold, before its own `before`.
    pub before_state_change: Vec<Name>,
    /// Run after a row's own `after`.
    pub after_state_change: Vec<Name>,
    /// Run at the end of every trigger, also of a refused or failed one.
    pub finalize_event: Vec<Name>,
    /// Run when the machine has become final, after the enter callbacks.
    pub on_final: Vec<Name>,
    /// Whether each state gets a trigger `to_STATE` from everywhere.
    pub auto_transitions: bool,
    /// Whether a trigger without a row in the active states is ignored instead of an error.
    pub ignore_invalid_triggers: bool,
}

/// Whether a state is final, and with which result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Final {
    /// Not final.
    #[default]
    No,
    /// The job is done.
    Success,
    /// The job has failed.
    Failure,
}

/// A sub-behaviour that runs while a state is active.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DuringDef {
    /// Its name.
    pub run: Name,
    /// Trigger fired when it succeeds.
    pub success: Option<Name>,
    /// Trigger fired when it fails.
    pub failure: Option<Name>,
}

/// A state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateDef {
    /// Name, unique among its siblings, without `.`, `*` and `=`.
    pub name: Name,
    /// Callbacks run on entering.
    pub enter: Vec<Name>,
    /// Callbacks run on leaving.
    pub exit: Vec<Name>,
    /// Child that is entered with it.
    pub initial: Option<Name>,
    /// States inside of it.
    pub children: Vec<StateDef>,
    /// Whether all children are active together.
    pub parallel: bool,
    /// Whether it is final.
    pub end: Final,
    /// The sub-behaviour that runs while it is active.
    pub during: Option<DuringDef>,
}

impl StateDef {
    /// A plain state.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.into(),
            enter: Vec::new(),
            exit: Vec::new(),
            initial: None,
            children: Vec::new(),
            parallel: false,
            end: Final::No,
            during: None,
        }
    }

    /// With enter callbacks.
    pub fn enter(mut self, callbacks: &[&str]) -> Self {
        self.enter = names(callbacks);
        self
    }

    /// With exit callbacks.
    pub fn exit(mut self, callbacks: &[&str]) -> Self {
        self.exit = names(callbacks);
        self
    }

    /// With children; `initial` is entered first.
    pub fn children(mut self, initial: &str, children: Vec<StateDef>) -> Self {
        self.initial = Some(initial.into());
        self.children = children;
        self
    }

    /// With children that are all active at the same time.
    pub fn regions(mut self, children: Vec<StateDef>) -> Self {
        self.parallel = true;
        self.children = children;
        self
    }

    /// As a final state of this kind.
    pub fn end(mut self, end: Final) -> Self {
        self.end = end;
        self
    }

    /// With a sub-behaviour; its result fires a trigger where one is named.
    pub fn during(mut self, run: &str, success: Option<&str>, failure: Option<&str>) -> Self {
        self.during = Some(DuringDef {
            run: run.into(),
            success: success.map(Name::from),
            failure: failure.map(Name::from),
        });
        self
    }
}

/// The source states of a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SourceDef {
    /// Every state of the outermost level, and with it the states inside.
    Any(Location),
    /// These, by full name.
    These(Vec<Name>),
}

/// The destination of a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DestDef {
    /// Into a state, by full name.
    To(Name),
    /// The source itself, which is left and entered again.
    Same,
    /// None: no state is left or entered, only callbacks run.
    Internal,
}

/// A row: on a trigger, from a source, if guards hold, to a destination.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowDef {
    /// Location of the row.
    pub place: Location,
    /// Its trigger.
    pub trigger: Name,
    /// Its source states.
    pub source: SourceDef,
    /// Its destination.
    pub dest: DestDef,
    /// Guards that must hold, evaluated in this order.
    pub conditions: Vec<Name>,
    /// Guards that must not hold, evaluated after those.
    pub unless: Vec<Name>,
    /// Callbacks before the guards are evaluated.
    pub prepare: Vec<Name>,
    /// Callbacks before the state is left.
    pub before: Vec<Name>,
    /// Callbacks after the state was entered.
    pub after: Vec<Name>,
}

impl RowDef {
    /// A row. `source`: a name, several separated by spaces, or `*`. `dest`: a
    /// name, `=` for the source itself, or empty for an internal row.
    pub fn new(trigger: &str, source: &str, dest: &str) -> Self {
        Self {
            place: Location::default(),
            trigger: trigger.into(),
            source: match source {
                "*" => SourceDef::Any(Location::default()),
                _ => SourceDef::These(source.split_whitespace().map(Name::from).collect()),
            },
            dest: match dest {
                "=" => DestDef::Same,
                "" => DestDef::Internal,
                _ => DestDef::To(dest.into()),
            },
            conditions: Vec::new(),
            unless: Vec::new(),
            prepare: Vec::new(),
            before: Vec::new(),
            after: Vec::new(),
        }
    }

    /// With guards that must hold.
    pub fn when(mut self, guards: &[&str]) -> Self {
        self.conditions = names(guards);
        self
    }

    /// With guards that must not hold.
    pub fn unless(mut self, guards: &[&str]) -> Self {
        self.unless = names(guards);
        self
    }

    /// With callbacks before the guards.
    pub fn prepare(mut self, callbacks: &[&str]) -> Self {
        self.prepare = names(callbacks);
        self
    }

    /// With callbacks before the change.
    pub fn before(mut self, callbacks: &[&str]) -> Self {
        self.before = names(callbacks);
        self
    }

    /// With callbacks after the change.
    pub fn after(mut self, callbacks: &[&str]) -> Self {
        self.after = names(callbacks);
        self
    }
}

/// States that follow one another on one trigger.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OrderedDef {
    /// Location of the chain.
    pub place: Location,
    /// The trigger.
    pub trigger: Name,
    /// States in their order; empty means all of the outermost level. The
    /// chain is rotated so that the initial state is first, if it contains it.
    pub states: Vec<Name>,
    /// Whether the first follows the last.
    pub cyclic: bool,
    /// Guards that must hold for each step.
    pub conditions: Vec<Name>,
    /// Guards that must not hold.
    pub unless: Vec<Name>,
}

impl Definition {
    /// An empty machine.
    pub fn new(name: &str) -> Self {
        Self {
            file: name.to_owned(),
            name: name.to_owned(),
            ..Self::default()
        }
    }

    /// With plain states; the first is the initial one.
    pub fn states(mut self, states: &[&str]) -> Self {
        for name in states {
            self = self.state(StateDef::new(name));
        }
        self
    }

    /// With one more state; the first is the initial one unless
    /// [`Definition::initial`] names another one.
    pub fn state(mut self, state: StateDef) -> Self {
        self.initial.get_or_insert_with(|| state.name.clone());
        self.states.push(state);
        self
    }

    /// With this initial state.
    pub fn initial(mut self, state: &str) -> Self {
        self.initial = Some(state.into());
        self
    }

    /// With one more row.
    pub fn row(mut self, row: RowDef) -> Self {
        self.rows.push(row);
        self
    }

    /// With a chain of states that follow `trigger`; no states means all.
    pub fn ordered(mut self, trigger: &str, states: &[&str], cyclic: bool) -> Self {
        self.ordered.push(OrderedDef {
            place: Location::default(),
            trigger: trigger.into(),
            states: names(states),
            cyclic,
            conditions: Vec::new(),
            unless: Vec::new(),
        });
        self
    }
}
