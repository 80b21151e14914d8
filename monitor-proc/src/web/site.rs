//! What is served, and to how many.

use std::sync::Arc;

use cell_model::runs::incident::Incidents;
use tokio::sync::Semaphore;

use super::files::Files;
use super::gate::Gate;
use crate::hub::Hub;
use crate::page::command::Names;
use crate::page::desk::Desk;
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
    /// What was kept of its past, when this is a live cell.
    pub kept: Option<Kept>,
}

/// What is kept while a cell runs.
pub struct Kept {
    /// The recording to look back into.
    pub past: OpenPast,
    /// Failures.
    pub incidents: Incidents,
}

/// A site with the places of its websockets.
pub(super) struct Served {
    pub(super) site: Site,
    pub(super) sockets: Arc<Semaphore>,
}
