//! Services behind the routes, and limits of their use.

use std::collections::BTreeMap;
use std::sync::Arc;

use cell_run::incident::Incidents;
use tokio::sync::Semaphore;

use super::access::AccessControl;
use super::files::Files;
use crate::feed::broadcast::Broadcast;
use crate::operator::policy_file::PolicyFiles;
use crate::page::command::Names;
use crate::page::queue::CommandQueue;
use crate::timeline::scrub::OpenPast;

/// A search in the geometry of a live cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Search {
    /// The grasps of an object by an arm, by index.
    Grasps(usize, usize),
    /// The joint positions that bring the TCP of an arm to a pose: position (m) and w, x, y, z,
    /// world frame.
    Joints(usize, [f64; 7]),
}

/// The result of a search as JSON; or a sentence for people.
pub type SearchOf = Arc<dyn Fn(Search) -> Result<String, String> + Send + Sync>;

/// Failures that were kept.
pub enum KeptIncidents {
    /// Of a live cell, by the launcher.
    Live(Incidents),
    /// In a recording: JSON, by number.
    Recorded(BTreeMap<u32, Vec<u8>>),
}

impl KeptIncidents {
    /// Whether they are of a cell that runs.
    pub fn is_live(&self) -> bool {
        matches!(self, Self::Live(_))
    }

    /// The incident `number` as JSON.
    pub(super) fn bytes(&self, number: u32) -> Option<Vec<u8>> {
        match self {
            // From a disk, but less than a megabyte.
            Self::Live(incidents) => incidents.bytes(number).ok(),
            Self::Recorded(incidents) => incidents.get(&number).cloned(),
        }
    }
}

/// Services behind the routes.
pub struct Services {
    /// Decides about requests.
    pub access: AccessControl,
    /// The page.
    pub files: Files,
    /// Meshes by `/ROBOT/LINK.glb`.
    pub meshes: Files,
    /// Advice for people when there is no page.
    pub hint: String,
    /// Source of frames and messages.
    pub broadcast: Arc<Broadcast>,
    /// Executor of commands.
    pub queue: Arc<dyn CommandQueue>,
    /// Names commands can use.
    pub names: Names,
    /// The recording: of a live cell by its flight recorder, else the file.
    pub past: OpenPast,
    /// The policies of a live cell that are written in files.
    pub policies: Option<PolicyFiles>,
    /// Searches in a live cell.
    pub search: Option<SearchOf>,
    /// Failures that were kept.
    pub incidents: KeptIncidents,
}

/// The services with the limits of their use.
pub(super) struct AppState {
    pub(super) services: Services,
    /// Permits for websockets.
    pub(super) sockets: Arc<Semaphore>,
    /// Permits for pages that read the recording.
    pub(super) readers: Semaphore,
    /// The permit for a search.
    pub(super) searches: Arc<Semaphore>,
    /// The permit for a text that is being checked.
    pub(super) edits: Semaphore,
}
