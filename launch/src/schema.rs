//! `robocell schema`.

use cell_run::incident::Incident;
use cell_run::output;
use cell_run::summary::RunSummary;
use cell_run::wire;
use clap::ValueEnum;
use schemars::JsonSchema;
use supervisor::failure::Failure;

use crate::args::kinds::OutputName;
use crate::args::{SchemaArgs, SchemaKind};
use crate::{chaos, client, plot, record, say, task_program};

/// Prints the JSON Schema of a kind of file.
pub(crate) fn schema(args: &SchemaArgs) -> Result<(), Failure> {
    if args.what == SchemaKind::Output {
        return of_output(args.name, args.program.task.as_deref());
    }
    if args.name.is_some() {
        let what = args.what.word();
        return Err(Failure::usage(format!("`schema {what}` takes no name")));
    }
    if args.what == SchemaKind::Wire {
        say::line(format_args!("{:#}", wire::schema()));
        return Ok(());
    }
    let task = args.program.task.as_deref();
    let program = task
        .map(|name| task_program::find(name, None))
        .transpose()?;
    let what = args.what.word();
    let question = format!("the schema of a {what}");
    task_program::answer(program.as_deref(), &question, &["schema", what])
}

/// `robocell schema output [NAME]`: the names without one.
fn of_output(name: Option<OutputName>, task: Option<&str>) -> Result<(), Failure> {
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
        OutputName::Check | OutputName::Eval | OutputName::Verify => {
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
    say::line(format_args!("{:#}", output::schema::<T>()));
}
