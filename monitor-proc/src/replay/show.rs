//! `monitor-proc replay`: a process that shows a recording.

use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc;
use std::thread;
use std::time::Instant;

use cell_model::runs::spec::PageSpec;
use cell_record::{RecordError, Recording};
use cell_rt::{process, signal};
use serde_json::Value;

use super::args::{ReplayArgs, ReplayArgsError};
use super::desk::ReplayDesk;
use super::player::Player;
use crate::film::Projector;
use crate::hub::{Hello, Hub};
use crate::lanes;
use crate::live::{self, PageError, Prepared, Trouble};
use crate::page::command::Names;
use crate::scene;
use crate::scrub::{OpenPast, Past};

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
    let film = Recording::open(&args.file)?;
    let (orders, ordered) = mpsc::channel();
    let prepared = prepare(&args, &film, ReplayDesk(orders))?;
    let hub = prepared.hub.clone();
    let trouble = Trouble::default();
    let address = args.address;
    let mut player = player(film, hub.clone());
    thread::scope(|scope| {
        // On its own thread: reading all of a long recording takes seconds.
        let (file, shown) = (&args.file, &hub);
        thread::Builder::new()
            .name("lanes".to_owned())
            .spawn_scoped(scope, move || show_lanes(file, shown))?;
        let told = trouble.clone();
        let serve = move || live::serve(prepared, address, &told);
        thread::Builder::new()
            .name("page".to_owned())
            .spawn_scoped(scope, serve)?;
        let began = Instant::now();
        while !signal::stop_requested() {
            for order in ordered.try_iter() {
                player.obey(order);
            }
            player.turn(began.elapsed().as_secs_f64());
            // Without a page a replay has no purpose, unlike a monitor.
            if let Some(note) = trouble.note() {
                return Err(ReplayError::Port(note));
            }
            cell_rt::sleep_until(cell_rt::monotonic_ns() + FRAME_NS);
        }
        hub.close("end");
        Ok(())
    })
}

fn prepare(args: &ReplayArgs, film: &Recording, desk: ReplayDesk) -> Result<Prepared, ReplayError> {
    let name = args
        .file
        .file_name()
        .map(|name| name.to_string_lossy().into_owned());
    let hello = Hello {
        live: false,
        run: live::run_info(film.run()),
        demos: Vec::new(),
        source: Some(name.unwrap_or_else(|| "recording".to_owned())),
    };
    let names = Names {
        objects: scene::object_names(film.scene()),
        arms: u32::from(film.run().arms),
    };
    let page = PageSpec {
        address: args.address,
        host: args.host.clone(),
        // Nothing can be loaded or restarted in a recording.
        dist: args.dist.clone(),
        hint: args.hint.clone(),
        secrets: args.secrets.clone(),
    };
    let hub = Hub::new(hello, with_meshes(film.scene().clone()));
    let (file, fingers) = (args.file.clone(), scene::fingers_of(film.scene()));
    let objects = names.objects.clone();
    // Each page that shows another time has its own reader.
    let open = move || {
        let film = Recording::open(&file).map_err(|error| error.to_string())?;
        let unheard = Box::new(|_| None);
        let projector = Projector::new(film, fingers.clone(), objects.clone(), unheard);
        Ok(Box::new(projector) as Box<dyn Past>)
    };
    let shown = (hub, names, Arc::new(open) as OpenPast);
    Ok(live::prepare_page(
        &page,
        shown,
        Arc::new(desk),
        (None, None),
    )?)
}

/// Reads the lanes of the timeline, while the page shows the start.
fn show_lanes(file: &Path, hub: &Hub) {
    // A recording that cannot be read is reported by the player.
    if let Ok(mut film) = Recording::open(file) {
        let arms = scene::arm_names(film.scene());
        let objects = scene::object_names(film.scene());
        hub.replace_lanes(lanes::of_film(
            &mut film,
            &arms,
            &objects,
            signal::stop_requested,
        ));
    }
}

fn player(film: Recording, hub: Arc<Hub>) -> Player<Recording> {
    let fingers = scene::fingers_of(film.scene());
    let objects = scene::object_names(film.scene());
    let policy = film.run().policy.clone();
    Player::new(film, hub, fingers, objects, policy)
}

/// Meshes are those of this machine, not of the one that recorded.
fn with_meshes(mut told: Value) -> Value {
    let meshes = live::meshes();
    for arm in told["arms"].as_array_mut().into_iter().flatten() {
        let robot = arm["robot"].as_str().unwrap_or_default();
        arm["meshes"] = scene::links_with_mesh(robot, meshes.paths()).into();
    }
    told
}
