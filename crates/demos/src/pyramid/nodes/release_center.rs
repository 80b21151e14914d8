//! `ReleaseCenter`: lets the other arm work in the centre.

use std::sync::Arc;

use behavior::Status;
use behavior::board::Fault;
use behavior::tree::{BindError, Binder, Leaf, NodeType};

use crate::pyramid::center::Center;
use crate::pyramid::cubes::{CubeState, Cubes};
use crate::pyramid::host::{Context, PyramidHost};
use crate::pyramid::setup::PyramidSetup;

/// See the module.
struct ReleaseCenter {
    cubes: Cubes,
    center: Center,
}

/// The node type.
pub(in crate::pyramid) fn node_type(setup: &Arc<PyramidSetup>) -> NodeType<PyramidHost> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "ReleaseCenter",
        "Gives the centre back, and says that the arm's cube is carried now.",
        move |binder| ReleaseCenter::new(&setup, binder),
    )
    .aliases(&["FrankaReleaseCenter"])
    .keywords(&["lock", "unlock", "carried"])
}

impl ReleaseCenter {
    fn new(setup: &PyramidSetup, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        Ok(Self {
            cubes: Cubes::bind(setup, binder)?,
            center: Center::bind(binder)?,
        })
    }
}

impl Leaf<PyramidHost> for ReleaseCenter {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let current = self.cubes.current(cx)?;
        if let Some(cube) = current.filter(|_| cx.world.cube_in_hand() == current) {
            self.cubes.set_state(cx, cube, CubeState::Carried)?;
        }
        self.center.release(cx)?;
        Ok(Status::Success)
    }
}
