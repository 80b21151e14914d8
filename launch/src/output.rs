//! What commands print with `--json`: one object on the last line, or one a line, and the
//! JSON Schema of each.

use cell_model::runs::incident::Incident;
use cell_model::runs::output::schema;
use cell_model::runs::summary::RunSummary;
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::Serialize;

use crate::failure::Failure;
use crate::{chaos, client, plot, record, say, task_program};

/// A command with `--json`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OutputName {
    /// `bench`.
    Bench,
    /// `eval bisect`.
    Bisect,
    /// `chaos`.
    Chaos,
    /// `bt check` and `fsm check`.
    Check,
    /// `doctor`.
    Doctor,
    /// `eval`: each line.
    Eval,
    /// `incident N`.
    Incident,
    /// `incident`.
    Incidents,
    /// `list`.
    List,
    /// `logs`: each line.
    Logs,
    /// `plot`.
    Plot,
    /// `record`.
    Record,
    /// `run`.
    Run,
    /// `status`.
    Status,
    /// `top`.
    Top,
    /// `replay --verify`.
    Verify,
}

impl OutputName {
    fn word(self) -> String {
        let value = self.to_possible_value();
        value.map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// Prints `value` as one object.
pub(crate) fn print(value: &impl Serialize) -> Result<(), Failure> {
    say::line(serde_json::to_string(value).map_err(Failure::configuration)?);
    Ok(())
}

/// `robocell schema output [NAME]`: the names without one.
pub(crate) fn print_schema(name: Option<OutputName>, task: Option<&str>) -> Result<(), Failure> {
    let Some(name) = name else {
        let names = OutputName::value_variants().iter();
        names.for_each(|name| say::line(name.word()));
        return Ok(());
    };
    match name {
        OutputName::Chaos => say_schema::<chaos::Report>(),
        OutputName::Doctor => say_schema::<client::DoctorReport>(),
        OutputName::Incident => say_schema::<Incident>(),
        OutputName::Incidents => say_schema::<client::IncidentList>(),
        OutputName::List => say_schema::<client::List>(),
        OutputName::Logs => say_schema::<client::LogLine>(),
        OutputName::Plot => say_schema::<plot::Plotted>(),
        OutputName::Record => say_schema::<record::Recorded>(),
        OutputName::Run => say_schema::<RunSummary>(),
        OutputName::Status => say_schema::<client::Status>(),
        OutputName::Top => say_schema::<client::Snapshot>(),
        // Printed by another program, which knows what it prints.
        OutputName::Bench => {
            task_program::run_other("robocell-bench", &["--schema".to_owned()])?;
        }
        OutputName::Bisect | OutputName::Check | OutputName::Eval | OutputName::Verify => {
            let program = task
                .map(|name| task_program::find(name, None))
                .transpose()?;
            let word = name.word();
            let question = format!("the schema of {word}");
            task_program::answer(program.as_deref(), &question, &["schema", &word])?;
        }
    }
    Ok(())
}

fn say_schema<T: JsonSchema>() {
    say::line(format_args!("{:#}", schema::<T>()));
}
