//! `CheckStackComplete`: whether all cubes of the arm's stack stand.

use std::sync::Arc;

use behavior::Status;
use behavior::board::{Access, Fault, In, Out};
use behavior::tree::{BindError, Binder, Leaf, NodeType};

use crate::pyramid::cubes::Cubes;
use crate::pyramid::host::{Context, PyramidHost};
use crate::pyramid::keys;
use crate::pyramid::setup::PyramidSetup;
use crate::pyramid::targets::has;

/// See the module.
struct CheckStackComplete {
    required_count: In<i64>,
    cubes: Cubes,
    complete: Out<bool>,
}

/// The node type.
pub(in crate::pyramid) fn node_type(setup: &Arc<PyramidSetup>) -> NodeType<PyramidHost> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "CheckStackComplete",
        "Compares the arm's stack with what is seen, and succeeds when it has \
         the required number of cubes.",
        move |binder| CheckStackComplete::new(&setup, binder),
    )
    .aliases(&["FrankaCheckStackComplete"])
    .keywords(&["done", "finished", "count"])
    .input_or("required_count", 3_i64, "cubes of a complete stack")
    .within(1.0, 16.0)
}

impl CheckStackComplete {
    fn new(setup: &PyramidSetup, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        let complete = keys::stack_complete(keys::robot(binder)?.as_str());
        Ok(Self {
            required_count: binder.input("required_count")?,
            cubes: Cubes::bind(setup, binder)?,
            complete: keys::shared(binder, &complete, false, Access::Write)?,
        })
    }
}

impl Leaf<PyramidHost> for CheckStackComplete {
    type State = ();

    fn tick(&self, _state: &mut (), cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let stack = self.cubes.compare(cx)?;
        let complete = has(stack, cx.get(&self.required_count)?);
        cx.set(&self.complete, complete)?;
        Ok(if complete {
            Status::Success
        } else {
            Status::Failure
        })
    }
}
