//! The JSON Schema of the output of each command.

use cell_model::runs::incident::Incident;
use cell_model::runs::output::schema;
use cell_model::runs::summary::RunSummary;
use clap::ValueEnum;
use schemars::JsonSchema;
use supervisor::failure::Failure;

use crate::cli_kinds::OutputName;
use crate::{chaos, client, plot, record, say, task_program};

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
        OutputName::Grasp => say_schema::<grasp::GraspReport>(),
        OutputName::Incident => say_schema::<Incident>(),
        OutputName::Incidents => say_schema::<client::IncidentList>(),
        OutputName::List => say_schema::<client::List>(),
        OutputName::Logs => say_schema::<client::LogLine>(),
        OutputName::Plot => say_schema::<plot::Plotted>(),
        OutputName::Record => say_schema::<record::Recorded>(),
        OutputName::Run => say_schema::<RunSummary>(),
        OutputName::Status => say_schema::<client::Status>(),
        OutputName::Top => say_schema::<client::Snapshot>(),
        // Another program prints this output and knows its schema.
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
