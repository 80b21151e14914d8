//! The registry of a task program: kinds of `[task]`, and the policies of each.

use std::sync::Arc;

use behavior::descriptor::Source;
use behavior::tree::{Host, Library};
use behavior::{Finding, suggest};
use cell_model::runs::policy_name::CLIENT_POLICY;
use cell_model::runs::policy_name::{policy_named, unknown_policy};
use cell_model::runs::policy_server::is_address;
use cell_model::{Cell, Data};
use serde_json::{Map, Value, json};

pub use crate::error::TaskError;

use crate::client::Client;
use crate::goals::Goals;
use crate::policy::{AnyPolicy, Policy, boxed};
use crate::ranges;
use crate::remote::{MakeRemote, Remote};
use crate::settings::{NoSettings, Settings, SetupError};
use crate::task::Task;
use crate::trees::{self, TreeError, TreeTools};

type MakeGoals<S> = Box<dyn Fn(&S, &Cell) -> Result<Goals, SetupError> + Send + Sync>;
type Make<S> = Box<dyn Fn(&S, &Cell) -> Result<Box<dyn AnyPolicy>, SetupError> + Send + Sync>;

/// A kind of `[task]` with settings `S`, and the policies that do it.
pub struct Kind<S> {
    name: String,
    policies: Vec<(String, Make<S>)>,
    trees: Option<TreeTools>,
    machines: Option<CheckMachine>,
    goals: Option<MakeGoals<S>>,
}

impl<S: Settings> Kind<S> {
    /// A kind without policies: `kind = "NAME"` in a cell file.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            policies: Vec::new(),
            trees: None,
            machines: None,
            goals: None,
        }
    }

    /// The slots by which the job is judged for a policy behind a socket.
    #[must_use]
    pub fn goals(
        mut self,
        make: impl Fn(&S, &Cell) -> Result<Goals, SetupError> + Send + Sync + 'static,
    ) -> Self {
        self.goals = Some(Box::new(make));
        self
    }

    /// Adds a policy under its name on the command line.
    #[must_use]
    pub fn policy(
        mut self,
        name: &str,
        make: impl Fn(&S, &Cell) -> Result<Box<dyn AnyPolicy>, SetupError> + Send + Sync + 'static,
    ) -> Self {
        self.policies.push((name.to_owned(), Box::new(make)));
        self
    }

    /// How a machine or matrix in a file of this kind is checked without its cell.
    #[must_use]
    pub fn machines(mut self, check: CheckMachine) -> Self {
        self.machines = Some(check);
        self
    }

    /// The node types a tree in a file of this kind may name, for `bt check` and
    /// `schema tree`. `library` gets the program's cells.
    #[must_use]
    pub fn trees<H: Host + 'static>(
        mut self,
        library: impl Fn(&Data) -> Result<Library<H>, TaskError> + Send + Sync + 'static,
    ) -> Self {
        self.trees = Some(TreeTools::new(library));
        self
    }
}

/// Probable mistakes, or errors, of a machine or matrix in a file; `None` for a file that
/// does not belong to this kind.
pub type CheckMachine = fn(&Source<'_>) -> Option<Result<Vec<Finding>, SetupError>>;

/// A kind, whatever its settings.
trait AnyKind: Send + Sync {
    fn name(&self) -> &str;
    fn policies(&self) -> Vec<&str>;
    fn task(&self, cell: &Cell, policy: &str) -> Result<Task, TaskError>;
    fn remote(&self, cell: &Cell, address: &str, make: &MakeRemote) -> Result<Task, TaskError>;
    fn schema(&self) -> Value;
    fn trees(&self) -> Option<&TreeTools>;
    fn machines(&self) -> Option<CheckMachine>;
}

impl<S: Settings> AnyKind for Kind<S> {
    fn name(&self) -> &str {
        &self.name
    }

    fn policies(&self) -> Vec<&str> {
        self.policies
            .iter()
            .map(|(name, _)| name.as_str())
            .collect()
    }

    fn task(&self, cell: &Cell, policy: &str) -> Result<Task, TaskError> {
        let settings = self.settings(cell)?;
        // Cell files and commands of earlier builds use other names of two policies; the
        // present name is the one in checkpoints and messages.
        let named = policy_named(policy, &self.policies());
        let mut known = self.policies.iter();
        let Some((name, make)) = known.find(|(name, _)| Some(name.as_str()) == named) else {
            let refusal = unknown_policy(policy, &self.policies(), &cell.name);
            return Err(TaskError::UnknownPolicy { refusal });
        };
        let made = replaced(cell, name, make(&settings, cell)?)?;
        Ok(Task::new(cell, name, settings.grip_force_n(cell), made))
    }

    fn remote(&self, cell: &Cell, address: &str, make: &MakeRemote) -> Result<Task, TaskError> {
        let settings = self.settings(cell)?;
        let Some(goals) = &self.goals else {
            let problem = format!(
                "a policy behind a socket needs a job that is judged by slots, and the kind '{}' has \
                 none; cube, stack and pyramid have, and a kind of your own gets them by Kind::goals",
                self.name
            );
            return Err(SetupError::new(cell, problem).into());
        };
        let force = settings.grip_force_n(cell);
        let made = make(Remote {
            cell,
            address,
            goals: goals(&settings, cell)?,
            grip_force: force,
        })?;
        Ok(Task::new(cell, address, force, made))
    }

    fn schema(&self) -> Value {
        schemars::schema_for!(S).to_value()
    }

    fn trees(&self) -> Option<&TreeTools> {
        self.trees.as_ref()
    }

    fn machines(&self) -> Option<CheckMachine> {
        self.machines
    }
}

impl<S: Settings> Kind<S> {
    /// The checked settings of `cell`.
    fn settings(&self, cell: &Cell) -> Result<S, TaskError> {
        let settings: S = cell.task.read()?;
        // Ranges first: `check` may compute with the numbers, and its message about a sum would
        // hide that one of them is out of range.
        ranges::check(&self.schema(), &cell.task.read()?, &cell.task.checker())?;
        settings.check(cell, &cell.task.checker())?;
        Ok(settings)
    }
}

/// The policy with the leaves of `--replace` replaced.
fn replaced(
    cell: &Cell,
    name: &str,
    mut policy: Box<dyn AnyPolicy>,
) -> Result<Box<dyn AnyPolicy>, SetupError> {
    if !cell.replace.is_empty() {
        let refused = |why| SetupError::in_file(format!("--replace: policy '{name}': {why}"));
        policy.replace(&cell.replace).map_err(refused)?;
    }
    Ok(policy)
}

type MakeAny = dyn Fn(&Cell) -> Result<Box<dyn AnyPolicy>, SetupError> + Send + Sync;

/// A policy for every kind of `[task]`, see [`Policies::policy_for_every_kind`].
#[derive(Clone)]
struct ForEveryKind {
    name: String,
    make: Arc<MakeAny>,
}

impl ForEveryKind {
    fn task(&self, cell: &Cell) -> Result<Task, TaskError> {
        let made = replaced(cell, &self.name, (self.make)(cell)?)?;
        let force = NoSettings {}.grip_force_n(cell);
        Ok(Task::new(cell, &self.name, force, made))
    }
}

/// All jobs a program can do. Cheap to clone.
#[derive(Clone, Default)]
pub struct Policies {
    kinds: Vec<Arc<dyn AnyKind>>,
    for_every_kind: Vec<ForEveryKind>,
    remote: Option<MakeRemote>,
}

impl Policies {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a kind; it replaces an earlier one of the same name.
    #[must_use]
    pub fn with<S: Settings>(mut self, kind: Kind<S>) -> Self {
        self.kinds.retain(|known| known.name() != kind.name);
        self.kinds.push(Arc::new(kind));
        self
    }

    /// Adds a policy in plain code that needs no settings: in a cell file
    /// `[task]` is `kind = "NAME"`, and `policies` is `["NAME"]`.
    #[must_use]
    pub fn policy<P: Policy + 'static>(
        self,
        name: &str,
        make: impl Fn(&Cell) -> P + Send + Sync + 'static,
    ) -> Self {
        let make = move |_: &NoSettings, cell: &Cell| Ok(boxed(make(cell)));
        self.with(Kind::<NoSettings>::new(name).policy(name, make))
    }

    /// Adds a policy that does the task of any cell, whatever its kind: for programs that
    /// read `[task]` themselves. It is found before the policies of the kinds.
    #[must_use]
    pub fn policy_for_every_kind(
        mut self,
        name: &str,
        make: impl Fn(&Cell) -> Result<Box<dyn AnyPolicy>, SetupError> + Send + Sync + 'static,
    ) -> Self {
        self.for_every_kind.push(ForEveryKind {
            name: name.to_owned(),
            make: Arc::new(make),
        });
        self
    }

    /// Lets a policy be named by the address of its server; `make` makes it, in place of an
    /// earlier `make`.
    #[must_use]
    pub fn with_remote(
        mut self,
        make: impl Fn(Remote<'_>) -> Result<Box<dyn AnyPolicy>, SetupError> + Send + Sync + 'static,
    ) -> Self {
        self.remote = Some(Arc::new(make));
        self
    }

    /// The policy of `cell` where the user names none: the one for every kind, else the
    /// default of the cell.
    pub fn default_policy<'a>(&'a self, cell: &'a Cell) -> &'a str {
        let first = self.for_every_kind.first();
        first.map_or(&cell.default_policy, |policy| &policy.name)
    }

    /// The names of all kinds.
    pub fn kinds(&self) -> Vec<&str> {
        self.kinds.iter().map(|kind| kind.name()).collect()
    }

    /// The task of `cell` with the policy of that name.
    ///
    /// # Errors
    /// [`TaskError`] for a kind or a policy this program does not have, with
    /// advice, and for a `[task]` table that does not fit the cell.
    pub fn task(&self, cell: &Cell, policy: &str) -> Result<Task, TaskError> {
        if cell.arms.is_empty() {
            return Err(TaskError::NoArm {
                demo: cell.name.clone(),
            });
        }
        if let Some(make) = self.remote.as_ref().filter(|_| is_address(policy)) {
            return self.kind(cell)?.remote(cell, policy, make);
        }
        if is_address(policy) {
            let problem = "this task program has no gateway for policy servers; pass \
                           robocell_gateways::all() to main_with";
            return Err(SetupError::new(cell, problem).into());
        }
        if policy == CLIENT_POLICY {
            let force = NoSettings {}.grip_force_n(cell);
            return Ok(Task::new(cell, CLIENT_POLICY, force, boxed(Client)));
        }
        // A program with policies for every kind reads `[task]` itself, so the table is not
        // checked against a kind, which this program need not know.
        if let Some(found) = self.for_every_kind.iter().find(|p| p.name == policy) {
            return found.task(cell);
        }
        if !self.for_every_kind.is_empty() {
            let names: Vec<&str> = self
                .for_every_kind
                .iter()
                .map(|p| p.name.as_str())
                .collect();
            let refusal = unknown_policy(policy, &names, &cell.name);
            return Err(TaskError::UnknownPolicy { refusal });
        }
        self.kind(cell)?.task(cell, policy)
    }

    /// The kind of the job of `cell`.
    fn kind(&self, cell: &Cell) -> Result<&dyn AnyKind, TaskError> {
        let wanted = cell.task.kind();
        let kind = self.kinds.iter().find(|kind| kind.name() == wanted);
        let unknown = || TaskError::UnknownKind {
            at: cell.task.checker().line_of("task.kind"),
            kind: wanted.to_owned(),
            advice: suggest::advice(wanted, &self.kinds()),
        };
        kind.map(AsRef::as_ref).ok_or_else(unknown)
    }

    /// Probable mistakes, or errors, of a machine or matrix in a file, as far as a kind knows
    /// its states and handlers; `None` where no kind does.
    pub fn check_machine(&self, source: &Source<'_>) -> Option<Result<Vec<Finding>, SetupError>> {
        let mut checks = self.kinds.iter().filter_map(|kind| kind.machines());
        checks.find_map(|check| check(source))
    }

    /// The tools of the kinds whose trees can be written in files.
    pub fn trees(&self) -> Vec<&TreeTools> {
        self.kinds.iter().filter_map(|kind| kind.trees()).collect()
    }

    /// The JSON Schema of a tree in a file, with the node types of all kinds;
    /// `None` where no kind has any.
    ///
    /// # Errors
    /// When the node types cannot be loaded.
    pub fn tree_schema(&self, data: &Data) -> Result<Option<Value>, TreeError> {
        let mut all: Option<Value> = None;
        for tools in self.trees() {
            // One schema for all kinds: an editor opens a file without knowing the cell it is
            // for.
            let schema = tools.schema(data)?;
            match &mut all {
                None => all = Some(schema),
                Some(all) => trees::merge_schema(all, &schema),
            }
        }
        Ok(all)
    }

    /// The JSON Schema of a cell file, with the `[task]` tables of all kinds.
    pub fn cell_schema(&self) -> Value {
        let mut schema = cell_model::cells::file::schema();
        let mut tables = Vec::new();
        let mut definitions = Map::new();
        for kind in &self.kinds {
            let mut table = kind.schema();
            if let Some(Value::Object(found)) =
                table.as_object_mut().and_then(|t| t.remove("$defs"))
            {
                definitions.extend(found);
            }
            add_head(&mut table, kind.name());
            tables.push(table);
        }
        // The generic schema of a cell accepts any `[task]`; here it becomes one of the kinds,
        // so an editor completes the keys of the kind that the file names.
        if let Some(known) = schema.get_mut("$defs").and_then(Value::as_object_mut) {
            known.extend(definitions);
            known.insert("TaskHead".to_owned(), json!({ "oneOf": tables }));
        }
        schema
    }
}

/// Adds the keys that every `[task]` has.
fn add_head(table: &mut Value, kind: &str) {
    if let Some(table) = table.as_object_mut() {
        table.remove("$schema");
        let keys = table.entry("properties").or_insert_with(|| json!({}));
        if let Some(keys) = keys.as_object_mut() {
            keys.insert("kind".to_owned(), json!({ "const": kind }));
            keys.insert("program".to_owned(), json!({ "type": "string" }));
        }
        let required = table.entry("required").or_insert_with(|| json!([]));
        if let Some(required) = required.as_array_mut() {
            required.push(json!("kind"));
        }
    }
}
