//! What is served, and to how many.

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

/// What is served.
pub struct Site {
    /// Who may come in.
    pub gate: Gate,
    /// The page.
    pub files: Files,
    /// Meshes by `/ROBOT/LINK.glb`.
    pub meshes: Files,
    /// What to do when there is no page, for people.
    pub hint: String,
    /// What feeds the pages.
    pub hub: Arc<Hub>,
    /// Who carries out commands.
    pub desk: Arc<dyn Desk>,
    /// Names commands can use.
    pub names: Names,
    /// What was recorded: of a live cell by its flight recorder, else the file.
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
    /// Places of those who read what was recorded.
    pub(super) readers: Semaphore,
    /// The place of the one whose text is checked.
    pub(super) edits: Semaphore,
}
