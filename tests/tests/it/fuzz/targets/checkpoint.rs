//! Checkpoints of the task, of a controller and of physics: files that outlive a
//! process that was killed.

use cell_model::{Cell, Data};
use cell_rt::RecordFile;
use cell_sim::{OneProcess, eval::template};
use controller_proc::cycle::Cycle;
use ipc_types::tap::KEYFRAME_BYTES;
use physics_proc::world::{StepInput, World};
use tempfile::NamedTempFile;

use super::Target;

/// Demos with all kinds of policies.
const DEMOS: [(&str, &str); 4] = [
    ("franka-stack", "fsm"),
    ("franka-pyramid", "json"),
    ("ur10-palletize", "table"),
    ("ur10-fill-bin", "matrix"),
];
/// Age limit of decisions a controller's checkpoint remembers (ticks).
const LIMIT: u64 = 28;

/// The first byte selects the owner: a task of [`DEMOS`], the file from which physics resumes
/// (8), or a controller (9).
pub(crate) const CHECKPOINT: Target = Target {
    name: "checkpoint",
    run: |bytes| {
        let Some((kind, bytes)) = bytes.split_first() else {
            return;
        };
        let Some((demo, policy)) = DEMOS.get(usize::from(*kind)) else {
            return match kind % 2 {
                0 => physics(bytes),
                _ => controller(bytes),
            };
        };
        let Some(cell) = cell(demo) else {
            return;
        };
        if let Ok(mut task) = demos::policies().task(&cell, policy) {
            let _restored = task.restore(bytes).is_ok();
        }
    },
    corpus: || {
        let mut all = Vec::new();
        for (kind, (demo, policy)) in (0_u8..).zip(DEMOS) {
            let Some(cell) = cell(demo) else { continue };
            let mut spec = template(demo, policy);
            spec.time_limit_s = Some(10.0);
            let Ok(mut sim) = OneProcess::new(&demos::policies(), &spec, cell) else {
                continue;
            };
            for _ in 0..3_000 {
                if !sim.tick().unwrap_or(false) {
                    break;
                }
            }
            all.push([vec![kind], sim.task_checkpoint()].concat());
            if kind == 0 {
                all.extend(record_file(&sim.plant().world().snapshot()));
            }
        }
        all.extend(cell("franka-stack").and_then(|cell| {
            let mut kept = vec![0; KEYFRAME_BYTES];
            let length = Cycle::new(&cell, 0).ok()?.save(LIMIT, &mut kept).ok()?;
            Some([&[9], &kept[..length]].concat())
        }));
        all
    },
};

/// Bytes of a file with `state`, which physics resumes from.
fn record_file(state: &[u8]) -> Option<Vec<u8>> {
    let file = NamedTempFile::new().ok()?;
    let record = RecordFile::new(file.path());
    record.write(state).ok()?;
    let bytes = std::fs::read(file.path()).ok()?;
    Some([vec![8], bytes].concat())
}

/// The engine trusts the bytes of a state; the checksum of its file reveals damage.
fn physics(bytes: &[u8]) {
    let state = NamedTempFile::new().ok().and_then(|file| {
        std::fs::write(file.path(), bytes).ok()?;
        RecordFile::new(file.path()).read().ok()?
    });
    let world = cell("franka-stack").and_then(|cell| World::new(&cell).ok());
    if let (Some(state), Some(mut world)) = (state, world)
        && world.restore(&state).is_ok()
    {
        for _ in 0..10 {
            world.step(&StepInput::default());
        }
    }
}

fn controller(bytes: &[u8]) {
    let cycle = cell("franka-stack").and_then(|cell| Cycle::new(&cell, 0).ok());
    if let Some(mut cycle) = cycle {
        let _restored = cycle.restore(bytes).is_ok();
    }
}

fn cell(demo: &str) -> Option<Cell> {
    Cell::load(&Data::checkout(), demo, 0, None).ok()
}
