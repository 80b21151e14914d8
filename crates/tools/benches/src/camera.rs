//! Costs of pictures: colour, depth and mask of the cameras of two demos, drawn in turns.

use std::hint::black_box;
use std::io::stdout;

use camera::{Light, Scene, View, draw};
use cell_model::{Cell, Data};
use cell_rt::monotonic_ns;
use cell_rt::priority::{self, CONTROLLER_PRIORITY};
use cell_sim::OneProcess;
use cell_sim::eval::template;
use ipc_types::WorldState;

use crate::error::CoreError;
use crate::reference::{self, Kernel};
use crate::report::{Report, Samples};

/// Demos, their number of bins, and the simulated time at which they are drawn (s), by which
/// every bin is stacked.
const SCENES: [(&str, f64); 2] = [("franka-stack", 12.0), ("ur10-bin-stack", 900.0)];
/// Cameras, with the word for them in the rows.
const CAMERAS: [(&str, &str); 2] = [("front", "fixed"), ("wrist", "wrist")];
/// Pictures of each camera.
const PICTURES: usize = 200;
const SEED: u64 = 3;

/// Measures and prints.
pub(crate) fn run(json: bool) -> Result<(), CoreError> {
    let mut states = Vec::new();
    for (demo, time_s) in SCENES {
        states.push(state(demo, time_s)?);
    }
    // After the simulation, which would keep a core from everything else.
    let granted = priority::request(CONTROLLER_PRIORITY, Some(0));
    let mut report = Report::new("camera", granted.fifo, &granted.refused);
    let (kernel, mut fixed) = (Kernel::new(), Samples::with_capacity(PICTURES));
    let mut rows: Vec<(String, Samples)> = Vec::new();
    for ((demo, _), (cell, _)) in SCENES.iter().zip(&states) {
        for (name, word) in CAMERAS {
            let size = cell.cameras.iter().find(|camera| camera.name == name);
            let pixels = size.map_or(0, |camera| camera.width);
            let row = format!("{demo}, rgb + depth + mask, {pixels}, {word}");
            rows.push((row, Samples::with_capacity(PICTURES)));
        }
    }
    for _ in 0..PICTURES {
        let began_ns = monotonic_ns();
        kernel.work();
        fixed.record(monotonic_ns().saturating_sub(began_ns));
        let mut rows = rows.iter_mut();
        for (cell, state) in &states {
            for (name, _) in CAMERAS {
                let camera = cell.cameras.iter().find(|camera| camera.name == name);
                let (Some(camera), Some((_, samples))) = (camera, rows.next()) else {
                    continue;
                };
                let began_ns = monotonic_ns();
                // All that a user pays for one picture: the shapes of the scene as well.
                let scene = Scene::new(cell, state);
                let picture = draw(&scene, &View::of(cell, state, camera), &Light::default());
                samples.record(monotonic_ns().saturating_sub(began_ns));
                black_box(picture);
            }
        }
    }
    let names: Vec<String> = rows.iter().map(|(name, _)| name.clone()).collect();
    let rows = rows.into_iter();
    report.rows = rows.map(|(name, samples)| samples.into_row(name)).collect();
    report.rows.push(fixed.into_row(reference::NAME.to_owned()));
    report.notes.push(reference::NOTE.to_owned());
    for name in names {
        report.compare(&name, reference::NAME);
    }
    for ((demo, _), (cell, state)) in SCENES.iter().zip(&states) {
        let time_s = state.header.tick as f64 * 1.0e-3;
        let links: usize = cell.arms.iter().map(|arm| arm.robot.links.len()).sum();
        report.notes.push(format!(
            "{demo}: seed {SEED} at {time_s:.1} s, {} fixtures, {} objects, {links} links",
            cell.fixtures.len(),
            cell.objects.len(),
        ));
    }
    report
        .write(&mut stdout().lock(), json)
        .map_err(CoreError::Output)
}

/// The cell and its state at `time_s`, or at the end of the job before that.
fn state(demo: &str, time_s: f64) -> Result<(Cell, Box<WorldState>), CoreError> {
    let mut spec = template(demo, "");
    spec.seed = SEED;
    spec.time_limit_s = Some(time_s);
    let cell = spec.load_cell_from(&Data::checkout())?;
    spec.policy.clone_from(&cell.default_policy);
    let mut sim = OneProcess::new(&demos::policies(), &spec, cell.clone())?;
    while sim.tick()? {}
    Ok((cell, Box::new(*sim.state())))
}
