//! Content of the server and its limits.

use std::sync::Arc;

use cell_model::runs::incident::Incidents;
use tokio::sync::Semaphore;

use super::files::Files;
use super::gate::Gate;
use crate::hub::Hub;
use crate::page::command::Names;
use crate::page::desk::Desk;
use crate::policy_file::PolicyFiles;
use crate::scrub::OpenPast;

/// Content of the server.
pub struct Site {
    /// Decides about requests.
    pub gate: Gate,
    /// The page.
    pub files: Files,
    /// Meshes by `/ROBOT/LINK.glb`.
    pub meshes: Files,
    /// Advice for people when there is no page.
    pub hint: String,
    /// Source of frames and news.
    pub hub: Arc<Hub>,
    /// Executor of commands.
    pub desk: Arc<dyn Desk>,
    /// Names commands can use.
    pub names: Names,
    /// The recording: of a live cell by its flight recorder, else the file.
    pub past: Option<OpenPast>,
    /// The policies of a live cell that are written in files.
    pub policies: Option<PolicyFiles>,
    /// Failures that were kept, when this is a live cell.
    pub incidents: Option<Incidents>,
}

/// A site with the places of its websockets.
pub(super) struct Served {
    pub(super) site: Site,
    pub(super) sockets: Arc<Semaphore>,
    /// Slots for pages that read the recording.
    pub(super) readers: Semaphore,
    /// The slot for a text that is being checked.
    pub(super) edits: Semaphore,
}
