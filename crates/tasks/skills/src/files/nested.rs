//! A machine in a file as a leaf of a tree, or as a step.

use std::sync::Arc;

use behavior::board::{Fault, In};
use behavior::machine::Happening;
use behavior::tree::leaf::{AnyLeaf, Halt};
use behavior::tree::{BindError, Cx, Library, NodeType};
use behavior::{ResetReason, Status, Str};
use cell_model::{Cell, Data};

use super::machine::MachineJob;
use super::parts::Loader;
use crate::nodes;
use crate::setup::Setup;
use crate::skill::Station;

/// The node types of trees and steps in files: the skills, and machines in files of their own.
/// `open` are the files that are being read.
fn library(setup: &Arc<Setup>, data: &Data, open: &[String]) -> Library<Station> {
    nodes::library(setup).with(node_type(setup, Some(data), open))
}

/// The node types for `file`, beside the cell file.
pub(super) fn of_file(cell: &Cell, setup: &Arc<Setup>, file: &str) -> Library<Station> {
    library(setup, &cell.data, &[file.to_owned()])
}

/// The node types for a file that is checked without its cell.
pub(super) fn unknown() -> Library<Station> {
    let setup = Arc::new(Setup::unknown());
    nodes::library(&setup).with(node_type(&setup, None, &[]))
}

/// `RunMachine`, in the last of the files `open`. Without `data` its file is not read: for a
/// tree that is checked without its cell, and never ticked.
pub(super) fn node_type(
    setup: &Arc<Setup>,
    data: Option<&Data>,
    open: &[String],
) -> NodeType<Station> {
    let (setup, data, open) = (Arc::clone(setup), data.cloned(), open.to_vec());
    NodeType::any(
        "RunMachine",
        "Runs the machine of another file from its first state to a final one, and \
         succeeds or fails as that does. Its keys of a blackboard are its own.",
        move |binder| {
            let file = match binder.input::<Str>("file")? {
                In::Literal(file) => file.to_string(),
                // Read at load: a name from the blackboard could be wrong while the job runs.
                In::Key(_) => return Err(BindError::Host("'file' has to be a name".to_owned())),
            };
            let mut all = open.clone();
            all.push(file.clone());
            // Files that run each other would be loaded without end.
            if open.contains(&file) {
                let circle = all.join(" -> ");
                let problem = format!("files run each other: {circle}; break the circle");
                return Err(BindError::Host(problem));
            }
            let Some(data) = &data else {
                return Ok(Box::new(Nested(None)) as Box<dyn AnyLeaf<Station>>);
            };
            let job = Loader::nested(data, library(&setup, data, &all), &file)
                .and_then(|(loader, text)| MachineJob::load(loader, &text))
                .map_err(|error| BindError::Host(error.to_string()))?;
            Ok(Box::new(Nested(Some(job))) as Box<dyn AnyLeaf<Station>>)
        },
    )
    .keywords(&["machine", "states", "table", "fsm"])
    .drives(nodes::ARM)
    .input::<Str>("file", "machine file beside the cell file")
}

/// The machine; `None` if its file was not read.
struct Nested(Option<MachineJob>);

impl AnyLeaf<Station> for Nested {
    fn tick(&mut self, begins: bool, cx: &mut Cx<'_, '_, Station>) -> Result<Status, Fault> {
        let Some(job) = &mut self.0 else {
            return Ok(Status::Failure);
        };
        // A new run starts in the first state, also after one that was halted in between.
        if begins {
            job.reset();
        }
        let status = job.tick(cx.world);
        // Logged, because its states are not nodes of the displayed graph.
        let machine = &job.run().machine;
        for happening in machine.trace() {
            if let Happening::Entered(state) = happening {
                let name = machine.table().state_name(*state);
                cx.world.out.log(format_args!("  -> {name}"));
            }
        }
        Ok(status)
    }

    fn halt(&mut self, cx: &mut Cx<'_, '_, Station>, _reason: ResetReason) -> Halt {
        if let Some(job) = &mut self.0 {
            job.stop(cx.world);
        }
        Halt::Done
    }

    fn invalidated(&mut self) {}

    fn save(&self, record: &mut Vec<u8>) {
        record.extend(self.0.iter().flat_map(MachineJob::save));
    }

    fn restore(&mut self, bytes: &[u8]) -> bool {
        let Some(job) = &mut self.0 else {
            return false;
        };
        let before = job.save();
        let restored = job.restore(bytes).is_ok();
        if !restored {
            // It cannot fail: this machine wrote the bytes.
            let _taken = job.restore(&before).is_ok();
        }
        restored
    }

    fn forget(&mut self) {
        if let Some(job) = &mut self.0 {
            job.reset();
        }
    }
}
