//! The page of a live cell: its parts, and the thread that serves it.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use cell_record::Recording;
use cell_run::incident::Incidents;
use cell_run::spec::{PageSecrets, PageSpec, RunSpec, Speed};
use cell_worker::Start;
use grasp::{GraspReport, Reach};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use serde_json::{Value, json};

use crate::feed::broadcast::Broadcast;
use crate::feed::hello::{Hello, RunInfo};
use crate::feed::scene::{self, SceneError};
use crate::operator::policy_file::PolicyFiles;
use crate::operator::queue::LiveCommandQueue;
use crate::page::command::Names;
use crate::page::queue::CommandQueue;
use crate::recorder::{Recorder, RecorderRequest};
use crate::timeline::recorded::RecordedPast;
use crate::timeline::scrub::{OpenPast, PastReader};
use crate::web::access::AccessControl;
use crate::web::files::Files;
use crate::web::{self, KeptIncidents, Search, SearchOf, Services};

/// Folder with `meshes/ROBOT/LINK.glb`.
const ENV_CACHE: &str = "ROBOCELL_CACHE_DIR";
/// Time for the closing message to every page.
const CLOSING_TIME: Duration = Duration::from_millis(150);

/// Reasons why a page cannot be served at all.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The secrets file.
    #[error("{path}: {reason}; the launcher writes this file, start the cell with `robocell run`")]
    Secrets {
        /// The file.
        path: PathBuf,
        /// Reason.
        reason: String,
    },
    /// A thread.
    #[error("no thread for the page: {0}")]
    Thread(#[from] std::io::Error),
}

/// All parts of a page server except its address.
pub struct PageServer {
    /// Source of frames and messages.
    pub broadcast: Arc<Broadcast>,
    secrets: PageSecrets,
    host: Option<String>,
    one_time_links: Option<PathBuf>,
    services: Box<dyn FnOnce(AccessControl) -> Services + Send>,
}

/// Problems of the page, for the process's health.
#[derive(Clone, Debug, Default)]
pub struct PageProblem(Arc<Mutex<Option<String>>>);

impl PageProblem {
    /// The problem, if there is one.
    pub fn note(&self) -> Option<String> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// Sets the problem, and writes it to the log of the process.
    pub fn set(&self, note: String) {
        cell_worker::warn(format_args!("{note}"));
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(note);
    }
}

/// The scene of `start`.
///
/// # Errors
///
/// When a file the cell was loaded from cannot be read again.
pub fn scene(start: &Start) -> Result<Value, SceneError> {
    scene::scene(&start.cell, &start.spec, &meshes().paths())
}

/// A broadcast of the live cell of `start`, whose page shows `scene`.
pub fn broadcast(start: &Start, scene: Value) -> Arc<Broadcast> {
    let hello = Hello {
        live: true,
        run: run_info(&start.spec),
        demos: scene::demos(&start.cell.data),
        source: None,
    };
    Broadcast::new(hello, scene)
}

/// Reads everything the page of `start` needs.
///
/// # Errors
///
/// When a file cannot be read.
pub fn prepare(
    start: &Start,
    page: &PageSpec,
    broadcast: Arc<Broadcast>,
    queue: LiveCommandQueue,
    recorder: &Arc<Recorder>,
) -> Result<PageServer, PageError> {
    let names = Names {
        objects: start.cell.objects.iter().map(|o| o.name.clone()).collect(),
        arms: u32::from(start.spec.arms),
    };
    let (flight, fingers) = (
        start.spec.record.flight_dir.clone(),
        scene::fingers(&start.cell),
    );
    let objects = names.objects.clone();
    let recorder = recorder.clone();
    let for_past = broadcast.clone();
    let open = move || {
        // The newest second may be in memory only.
        recorder.ask(RecorderRequest::Flush)?;
        let recording = Recording::open(&flight).map_err(|error| error.to_string())?;
        let for_past = for_past.clone();
        let before = Box::new(move |time_s| for_past.trace_before(time_s));
        let past = RecordedPast::new(recording, fingers.clone(), objects.clone(), before);
        Ok(Box::new(past) as Box<dyn PastReader>)
    };
    let incidents = Incidents::at(start.spec.incidents_dir.clone());
    let policies = PolicyFiles::new(&start.spec);
    let search = search_of(Arc::clone(&broadcast), &start.spec);
    let kept = (KeptIncidents::Live(incidents), Some(policies), Some(search));
    let shown = (broadcast, names, Arc::new(open) as OpenPast);
    prepare_page(page, shown, Arc::new(queue), kept)
}

/// The searches in a live cell, in the state that was kept last.
fn search_of(broadcast: Arc<Broadcast>, spec: &RunSpec) -> SearchOf {
    let spec = spec.clone();
    // One per arm that was asked for: a page that shows where a target leads asks ten times per
    // second.
    let arms: Mutex<HashMap<usize, Option<Reach>>> = Mutex::default();
    Arc::new(move |search| {
        let world = broadcast.world().ok_or("physics has published no state")?;
        // Read for each request, which is rare: a loaded cell stays in memory otherwise.
        let cell = || spec.load_cell().map_err(|error| error.to_string());
        match search {
            Search::Grasps(arm, object) => {
                let report = GraspReport::of(&cell()?, &world, object, arm)?;
                serde_json::to_string(&report).map_err(|error| error.to_string())
            }
            Search::Joints(arm, pose) => {
                let state = world.arms().get(arm).ok_or("this cell has no such arm")?;
                let mut arms = arms.lock().unwrap_or_else(PoisonError::into_inner);
                let reach = match arms.entry(arm) {
                    Entry::Occupied(known) => known.into_mut(),
                    Entry::Vacant(new) => new.insert(cell()?.arms.get(arm).and_then(Reach::of)),
                };
                let reach = reach.as_mut().ok_or("this arm has no controller")?;
                let count = (state.joint_count as usize).min(state.joint_positions.len());
                let found = reach.joints(&state.joint_positions[..count], &isometry(pose));
                Ok(json!({ "joints": found }).to_string())
            }
        }
    })
}

fn isometry([x, y, z, w, i, j, k]: [f64; 7]) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k)),
    )
}

/// All of a server for `page`.
///
/// # Errors
///
/// When the secrets cannot be read.
pub fn prepare_page(
    page: &PageSpec,
    (broadcast, names, past): (Arc<Broadcast>, Names, OpenPast),
    queue: Arc<dyn CommandQueue>,
    (incidents, policies, search): (KeptIncidents, Option<PolicyFiles>, Option<SearchOf>),
) -> Result<PageServer, PageError> {
    let secrets = read_secrets(&page.secrets)?;
    // For a live cell `robocell status` prints a new link; for a recording nothing does.
    let one_time_links = incidents.is_live().then(|| page.secrets.clone());
    let files = Files::page(page.dist.as_deref(), &page.hint);
    let meshes = meshes();
    // Before serving, so that the log explains a missing mesh.
    let limits = [files.limit("the page"), meshes.limit("the robots' meshes")];
    for limit in limits.into_iter().flatten() {
        cell_worker::warn(format_args!("{limit}"));
    }
    let (hint, source) = (page.hint.clone(), broadcast.clone());
    let services = move |access| Services {
        access,
        files,
        meshes,
        hint,
        broadcast: source,
        queue,
        names,
        past,
        policies,
        search,
        incidents,
    };
    Ok(PageServer {
        broadcast,
        secrets,
        host: page.host.clone(),
        one_time_links,
        services: Box::new(services),
    })
}

/// Meshes fetched by `robocell assets`.
pub fn meshes() -> Files {
    let folder = std::env::var_os(ENV_CACHE).map(PathBuf::from);
    folder.map_or_else(Files::default, |f| Files::folder(&f.join("meshes"), ""))
}

/// Reads the secrets of a run.
///
/// # Errors
///
/// When the file is missing or broken.
pub fn read_secrets(path: &Path) -> Result<PageSecrets, PageError> {
    let refuse = |reason: String| PageError::Secrets {
        path: path.to_owned(),
        reason,
    };
    PageSecrets::load(path).map_err(|error| refuse(error.to_string()))
}

/// The run as the page names it.
pub fn run_info(spec: &RunSpec) -> RunInfo {
    RunInfo {
        id: format!("{:016x}", spec.run),
        cell: spec.cell.clone(),
        command: spec.command.clone(),
        demo: spec.demo.clone(),
        policy: spec.policy.clone(),
        seed: spec.seed,
        speed: match spec.speed {
            Speed::RealTime => "1".to_owned(),
            Speed::Max => "max".to_owned(),
            Speed::Factor(factor) => factor.to_string(),
        },
    }
}

/// Serves the page until its broadcast is closed. Errors are set in `problem`: a monitor without a
/// page continues.
pub fn serve(server: PageServer, address: SocketAddr, problem: &PageProblem) {
    // One thread: pages must not take a second core from the loops.
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let served = runtime.and_then(|runtime| {
        runtime.block_on(async {
            let broadcast = server.broadcast.clone();
            // The server never ends by itself; the broadcast ends it.
            tokio::select! {
                served = listen(server, address) => served,
                () = ended(&broadcast) => Ok(()),
            }
        })
    });
    if let Err(error) = served {
        problem.set(format!("no page at {address}: {error}"));
    }
}

async fn listen(server: PageServer, address: SocketAddr) -> std::io::Result<()> {
    let listening = web::bind(address).await?;
    let mut access = AccessControl::new(listening.address(), server.secrets).with_host(server.host);
    if let Some(file) = server.one_time_links {
        access = access.with_one_time_links(file);
    }
    listening.serve((server.services)(access)).await
}

async fn ended(broadcast: &Broadcast) {
    // Pages get their closing message before the runtime is dropped.
    broadcast.closed().await;
    tokio::time::sleep(CLOSING_TIME).await;
}
