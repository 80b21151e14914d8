//! The benches. Only ratios within one run are comparable: the rows of a bench are measured in
//! turns, on the same cores, in the same minutes.

mod camera;
mod cores;
mod e2e;
mod error;
mod fleet;
mod kept;
mod mujoco;
mod panda;
mod piles;
mod pinch;
mod procfs;
mod python;
mod reference;
mod report;
mod transport;
mod versions;

use std::io::Write as _;
use std::process::ExitCode;

use clap::{Parser, ValueEnum};

/// What a bench measures.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Kind {
    /// Round trips between two processes.
    Ipc,
    /// Lateness of a 1 kHz loop.
    Loop,
    /// A cell of four processes, hop by hop.
    E2e,
    /// The RMPflow cycle.
    Control,
    /// The step of physics, and the whole tick.
    Physics,
    /// Pictures of cameras.
    Camera,
    /// Many cells, and one that grows.
    Fleet,
}

#[derive(Parser)]
#[command(name = "robocell-bench")]
struct Arguments {
    /// What to measure.
    #[arg(required_unless_present = "schema")]
    kind: Option<Kind>,
    /// Length of a bench with a running cell, and of each part of `fleet` (s).
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// One JSON object as the last line.
    #[arg(long)]
    json: bool,
    /// Prints the JSON Schema of what `--json` prints.
    #[arg(long)]
    schema: bool,
}

/// The program of the benches.
pub fn main() -> ExitCode {
    // First: the second process of `bench ipc` is this program as well, with other arguments.
    if let Some(code) = transport::peer::main() {
        return code;
    }
    let arguments = Arguments::parse();
    let json = arguments.json;
    let Some(kind) = arguments.kind.filter(|_| !arguments.schema) else {
        let schema = cell_run::output::schema::<report::Report>();
        cell_rt::stdout::line(format_args!("{schema:#}"));
        return finished(cell_rt::stdout::finish().map_err(Into::into));
    };
    let done: Result<(), Box<dyn std::error::Error>> = match kind {
        Kind::Ipc => transport::ipc::run(json).map_err(Into::into),
        Kind::Loop => transport::loop_::run(json).map_err(Into::into),
        Kind::E2e => e2e::run(arguments.seconds, json).map_err(Into::into),
        Kind::Control => cores::run(cores::Core::Control, json).map_err(Into::into),
        Kind::Physics => cores::run(cores::Core::Physics, json).map_err(Into::into),
        Kind::Camera => camera::run(json).map_err(Into::into),
        Kind::Fleet => fleet::run(arguments.seconds, json).map_err(Into::into),
    };
    finished(done)
}

fn finished(done: Result<(), Box<dyn std::error::Error>>) -> ExitCode {
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            writeln!(std::io::stderr(), "robocell bench: {error}").ok();
            ExitCode::from(3)
        }
    }
}
