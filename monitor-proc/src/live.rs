//! The page of a live cell: its parts, and the thread that serves it.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use cell_model::runs::incident::Incidents;
use cell_model::runs::spec::{PageSecrets, PageSpec, RunSpec, Speed};
use cell_record::Recording;
use cell_worker::Start;
use serde_json::Value;

use crate::desk::LiveDesk;
use crate::film::Projector;
use crate::hub::{Hello, Hub, RunInfo};
use crate::page::command::Names;
use crate::page::desk::Desk;
use crate::policy_file::PolicyFiles;
use crate::recorder::{Recorder, RecorderRequest};
use crate::scene::{self, SceneError};
use crate::scrub::{OpenPast, Past};
use crate::web::files::Files;
use crate::web::gate::Gate;
use crate::web::{self, Site};

/// Folder with `meshes/ROBOT/LINK.glb`.
const ENV_CACHE: &str = "ROBOCELL_CACHE_DIR";
/// Time for the closing message to every page.
const LAST_WORD: Duration = Duration::from_millis(150);

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

/// All parts of a site except its address.
pub struct Prepared {
    /// Source of frames and news.
    pub hub: Arc<Hub>,
    secrets: PageSecrets,
    host: Option<String>,
    one_time_links: Option<PathBuf>,
    site: Box<dyn FnOnce(Gate) -> Site + Send>,
}

/// Problems of the page, for the process's health.
#[derive(Clone, Debug, Default)]
pub struct Trouble(Arc<Mutex<Option<String>>>);

impl Trouble {
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

/// Reads everything the page of `start` needs.
///
/// # Errors
///
/// When a file cannot be read.
pub fn prepare(
    start: &Start,
    page: &PageSpec,
    scene: Value,
    desk: LiveDesk,
    recorder: &Arc<Recorder>,
) -> Result<Prepared, PageError> {
    let hello = Hello {
        live: true,
        run: run_info(&start.spec),
        demos: scene::demos(&start.cell.data),
        source: None,
    };
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
    let hub = Hub::new(hello, scene);
    let heard = hub.clone();
    let open = move || {
        // The newest second may be in memory only.
        recorder.ask(RecorderRequest::Flush)?;
        let film = Recording::open(&flight).map_err(|error| error.to_string())?;
        let heard = heard.clone();
        let before = Box::new(move |time_s| heard.story_before(time_s));
        let projector = Projector::new(film, fingers.clone(), objects.clone(), before);
        Ok(Box::new(projector) as Box<dyn Past>)
    };
    let incidents = Incidents::at(start.spec.incidents_dir.clone());
    let shown = (hub, names, Arc::new(open) as OpenPast);
    let policies = PolicyFiles::new(&start.spec);
    let kept = (Some(incidents), Some(policies));
    prepare_page(page, shown, Arc::new(desk), kept)
}

/// All of a site for `page`.
///
/// # Errors
///
/// When the secrets cannot be read.
pub fn prepare_page(
    page: &PageSpec,
    (hub, names, past): (Arc<Hub>, Names, OpenPast),
    desk: Arc<dyn Desk>,
    (incidents, policies): (Option<Incidents>, Option<PolicyFiles>),
) -> Result<Prepared, PageError> {
    let secrets = read_secrets(&page.secrets)?;
    // For a live cell `robocell status` prints a new link; for a recording nothing does.
    let one_time_links = incidents.is_some().then(|| page.secrets.clone());
    let files = Files::page(page.dist.as_deref(), &page.hint);
    let meshes = meshes();
    // Before serving, so that the log explains a missing mesh.
    let limits = [files.limit("the page"), meshes.limit("the robots' meshes")];
    for limit in limits.into_iter().flatten() {
        cell_worker::warn(format_args!("{limit}"));
    }
    let (hint, fed) = (page.hint.clone(), hub.clone());
    let site = move |gate| Site {
        gate,
        files,
        meshes,
        hint,
        hub: fed,
        desk,
        names,
        past: Some(past),
        policies,
        incidents,
    };
    Ok(Prepared {
        hub,
        secrets,
        host: page.host.clone(),
        one_time_links,
        site: Box::new(site),
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

/// Serves the page until its hub is closed. Errors are set in `trouble`: a monitor without a
/// page continues.
pub fn serve(prepared: Prepared, address: SocketAddr, trouble: &Trouble) {
    // One thread: pages must not take a second core from the loops.
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let served = runtime.and_then(|runtime| {
        runtime.block_on(async {
            let hub = prepared.hub.clone();
            // The server never ends by itself; the hub ends it.
            tokio::select! {
                served = listen(prepared, address) => served,
                () = ended(&hub) => Ok(()),
            }
        })
    });
    if let Err(error) = served {
        trouble.set(format!("no page at {address}: {error}"));
    }
}

async fn listen(prepared: Prepared, address: SocketAddr) -> std::io::Result<()> {
    let listening = web::bind(address).await?;
    let mut gate = Gate::new(listening.address(), prepared.secrets).with_host(prepared.host);
    if let Some(file) = prepared.one_time_links {
        gate = gate.with_one_time_links(file);
    }
    listening.serve((prepared.site)(gate)).await
}

async fn ended(hub: &Hub) {
    // Pages get their closing message before the runtime is dropped.
    hub.closed().await;
    tokio::time::sleep(LAST_WORD).await;
}
