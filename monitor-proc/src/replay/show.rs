//! `monitor-proc replay`: a process that shows a recording.

use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc;
use std::thread;
use std::time::Instant;

use cell_record::{RecordError, Recording};
use cell_rt::{process, signal};
use cell_run::spec::PageSpec;
use serde_json::Value;

use super::args::{ReplayArgs, ReplayArgsError};
use super::page_record::PageRecord;
use super::player::Player;
use super::queue::ReplayCommandQueue;
use super::timeline;
use crate::feed::broadcast::Broadcast;
use crate::feed::hello::Hello;
use crate::feed::scene;
use crate::page::command::Names;
use crate::timeline::recorded::RecordedPast;
use crate::timeline::scrub::{OpenPast, PastReader};
use crate::web::KeptIncidents;
use crate::web::page_server::{self, PageError, PageProblem, PageServer};

/// Invalid configuration.
const EXIT_CONFIGURATION: u8 = 3;
/// Period of the frames: 60 a second.
const FRAME_NS: u64 = 16_666_667;
/// Reasons why a recording cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The arguments.
    #[error(transparent)]
    Args(#[from] ReplayArgsError),
    /// The recording.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The page.
    #[error(transparent)]
    Page(#[from] PageError),
    /// A signal or a thread.
    #[error("start-up: {0}")]
    System(#[from] std::io::Error),
    /// The port.
    #[error("{0}")]
    Port(String),
}

/// `main` of the replay: reads the arguments after `replay`.
pub fn main(arguments: impl Iterator<Item = String>) -> ExitCode {
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // `robocell replay` prints nothing else.
            writeln!(std::io::stderr(), "robocell: {error}").ok();
            ExitCode::from(EXIT_CONFIGURATION)
        }
    }
}

fn run(arguments: impl Iterator<Item = String>) -> Result<(), ReplayError> {
    // As for the processes of a cell: private files, a
    // handler before the parent's death signal.
    process::private_umask();
    signal::install_stop_handler()?;
    let parent = process::parent_pid();
    if !process::die_with_parent(process::SIGTERM, parent)? {
        return Ok(());
    }
    let args = ReplayArgs::parse(arguments)?;
    let mut recording = Recording::open(&args.file)?;
    let record = Arc::new(PageRecord::read(&mut recording)?);
    let (orders, ordered) = mpsc::channel();
    let server = prepare(&args, &recording, &record, ReplayCommandQueue(orders))?;
    let broadcast = server.broadcast.clone();
    let problem = PageProblem::default();
    let address = args.address;
    let mut player = player(recording, record.clone(), broadcast.clone());
    thread::scope(|scope| {
        // On its own thread: reading all of a long recording takes seconds.
        let (file, shown) = (&args.file, &broadcast);
        thread::Builder::new()
            .name("lanes".to_owned())
            .spawn_scoped(scope, move || show_timeline(file, &record, shown))?;
        let for_server = problem.clone();
        let serve = move || page_server::serve(server, address, &for_server);
        thread::Builder::new()
            .name("page".to_owned())
            .spawn_scoped(scope, serve)?;
        let start = Instant::now();
        while !signal::stop_requested() {
            for order in ordered.try_iter() {
                player.apply(order);
            }
            player.update(start.elapsed().as_secs_f64());
            // Without a page a replay has no purpose, unlike a monitor.
            if let Some(note) = problem.note() {
                return Err(ReplayError::Port(note));
            }
            cell_rt::sleep_until(cell_rt::monotonic_ns() + FRAME_NS);
        }
        broadcast.close("end");
        Ok(())
    })
}

fn prepare(
    args: &ReplayArgs,
    recording: &Recording,
    record: &PageRecord,
    queue: ReplayCommandQueue,
) -> Result<PageServer, ReplayError> {
    let name = args
        .file
        .file_name()
        .map(|name| name.to_string_lossy().into_owned());
    let hello = Hello {
        live: false,
        run: page_server::run_info(recording.run()),
        demos: Vec::new(),
        source: Some(name.unwrap_or_else(|| "recording".to_owned())),
    };
    let names = Names {
        objects: scene::object_names(recording.scene()),
        arms: u32::from(recording.run().arms),
    };
    let page = PageSpec {
        address: args.address,
        host: args.host.clone(),
        // Nothing can be loaded or restarted in a recording.
        dist: args.dist.clone(),
        hint: args.hint.clone(),
        secrets: args.secrets.clone(),
    };
    let broadcast = Broadcast::new(hello, with_meshes(recording.scene().clone()));
    let (file, fingers) = (args.file.clone(), scene::fingers_of(recording.scene()));
    let objects = names.objects.clone();
    // Each page that shows another time has its own reader.
    let open = move || {
        let recording = Recording::open(&file).map_err(|error| error.to_string())?;
        let no_trace = Box::new(|_| None);
        let past = RecordedPast::new(recording, fingers.clone(), objects.clone(), no_trace);
        Ok(Box::new(past) as Box<dyn PastReader>)
    };
    let shown = (broadcast, names, Arc::new(open) as OpenPast);
    Ok(page_server::prepare_page(
        &page,
        shown,
        Arc::new(queue),
        (
            KeptIncidents::Recorded(record.incidents.clone()),
            None,
            None,
        ),
    )?)
}

/// Reads the timeline, while the page shows the start.
fn show_timeline(file: &Path, record: &PageRecord, broadcast: &Broadcast) {
    // A recording that cannot be read is reported by the player.
    if let Ok(mut recording) = Recording::open(file) {
        let lanes = timeline::lanes(&mut recording, record, signal::stop_requested);
        let marks = timeline::marks(&mut recording, record);
        broadcast.replace_timeline(lanes, &marks);
    }
}

fn player(
    recording: Recording,
    record: Arc<PageRecord>,
    broadcast: Arc<Broadcast>,
) -> Player<Recording> {
    let fingers = scene::fingers_of(recording.scene());
    let objects = scene::object_names(recording.scene());
    let policy = recording.run().policy.clone();
    Player::new(recording, record, broadcast, fingers, objects, policy)
}

/// Meshes are those of this machine, not of the one that recorded.
fn with_meshes(mut scene: Value) -> Value {
    let meshes = page_server::meshes();
    for arm in scene["arms"].as_array_mut().into_iter().flatten() {
        let robot = arm["robot"].as_str().unwrap_or_default();
        arm["meshes"] = scene::links_with_mesh(robot, meshes.paths()).into();
    }
    scene
}
