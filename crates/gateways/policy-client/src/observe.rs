//! The observations that are sent, from the cell and its state.

use std::collections::{BTreeMap, VecDeque};

use cell_model::Cell;
use cell_model::cells::cell::CameraSpec;
use cell_model::runs::policy_server::{Fault, FaultKind};
use ipc_types::WorldState;

use crate::codec::{Content, Observations};
use crate::schedule::STEP_MS;

/// Prefix of the names of pictures.
const PIXELS: &str = "pixels/";

/// Makes the observations of a cell.
pub(crate) struct Eye {
    cell: Cell,
    /// The cell with a displaced camera.
    displaced: Option<Cell>,
    fault: Option<Fault>,
    numbers: bool,
    objects: bool,
    prompt: bool,
    cameras: Vec<String>,
    /// Centres of the slots of the job (m).
    slots: Vec<[f64; 3]>,
    /// Observed states, the newest last, for faults that send an older one.
    past: VecDeque<Box<WorldState>>,
}

impl Eye {
    /// The observations of `names`; all without any.
    ///
    /// # Errors
    /// A sentence about a name that is not one of an observation, or a camera that the cell does not
    /// have.
    pub(crate) fn new(
        cell: &Cell,
        names: &BTreeMap<String, String>,
        fault: Option<Fault>,
        slots: Vec<[f64; 3]>,
    ) -> Result<Self, String> {
        let all: Vec<String> = cell
            .cameras
            .iter()
            .map(|camera| camera.name.clone())
            .collect();
        let known = |name: &str| {
            let camera = name.strip_prefix(PIXELS);
            ["agent_pos", "environment_state", "prompt"].contains(&name)
                || camera.is_some_and(|camera| all.iter().any(|known| known == camera))
        };
        if let Some(name) = names.keys().find(|name| !known(name)) {
            let pixels: Vec<String> = all
                .iter()
                .map(|camera| format!("{PIXELS}{camera}"))
                .collect();
            return Err(format!(
                "--names: '{name}' is no observation; agent_pos, environment_state, prompt, {} are allowed",
                pixels.join(", ")
            ));
        }
        let sent = |name: &str| names.is_empty() || names.contains_key(name);
        let displaced = fault
            .as_ref()
            .map_or(Ok(None), |fault| displaced(cell, fault))?;
        Ok(Self {
            displaced,
            fault,
            numbers: sent("agent_pos"),
            objects: sent("environment_state"),
            prompt: sent("prompt"),
            cameras: all
                .into_iter()
                .filter(|name| sent(&format!("{PIXELS}{name}")))
                .collect(),
            slots,
            past: VecDeque::new(),
            cell: cell.clone(),
        })
    }

    /// Takes the state at the start of a step.
    pub(crate) fn see(&mut self, state: &WorldState) {
        let kept = match self.fault.as_ref().map(|fault| &fault.kind) {
            None | Some(FaultKind::Move { .. }) => return,
            // While states are dropped, the newest one of before is the one that is sent.
            Some(FaultKind::Drop) if self.is_faulty(state.header.tick) && !self.past.is_empty() => {
                return;
            }
            Some(FaultKind::Drop) => 1,
            Some(FaultKind::Late(ms)) => ms.div_ceil(STEP_MS) + 1,
        };
        self.past.push_back(Box::new(*state));
        while self.past.len() as u64 > kept {
            self.past.pop_front();
        }
    }

    /// Forgets the states before.
    pub(crate) fn clear(&mut self) {
        self.past.clear();
    }

    fn is_faulty(&self, tick: u64) -> bool {
        self.fault
            .as_ref()
            .is_some_and(|fault| fault.ticks.contains(&tick))
    }

    /// The observations at a state, given the commanded positions of all arms, world frame (m).
    pub(crate) fn observe(&self, state: &WorldState, goals: &[[f64; 3]]) -> Observations {
        let faulty = self.is_faulty(state.header.tick);
        let seen = self
            .past
            .front()
            .filter(|_| faulty)
            .map_or(state, |past| &**past);
        let cell = self
            .displaced
            .as_ref()
            .filter(|_| faulty)
            .unwrap_or(&self.cell);
        let mut all = Observations::new();
        if self.numbers {
            all.push(("agent_pos".to_owned(), Content::Numbers(arms(seen, goals))));
        }
        if self.objects {
            let objects = seen.objects().iter().map(|object| object.pose.position);
            let numbers = objects
                .chain(self.slots.iter().copied())
                .flatten()
                .map(single);
            all.push((
                "environment_state".to_owned(),
                Content::Numbers(numbers.collect()),
            ));
        }
        // The names are those of the cell.
        let pictures = camera::observe(cell, seen, &self.cameras).unwrap_or_default();
        let pictures = self.cameras.iter().zip(pictures).map(|(name, picture)| {
            let content = Content::Picture(picture.height, picture.width, picture.rgb);
            (format!("{PIXELS}{name}"), content)
        });
        all.extend(pictures);
        if self.prompt {
            all.push(("prompt".to_owned(), Content::Text(cell.description.clone())));
        }
        all
    }
}

/// By arm: position of the TCP, commanded position (m), width of the gripper (m), and 1 where it
/// holds something.
fn arms(state: &WorldState, goals: &[[f64; 3]]) -> Vec<f32> {
    let arms = state.arms().iter().zip(goals);
    let numbers = arms.flat_map(|(arm, goal)| {
        let held = f64::from(u8::from(arm.gripper.held_object > 0));
        let numbers = arm.tcp.position.into_iter().chain(*goal);
        numbers.chain([arm.gripper.width, held])
    });
    numbers.map(single).collect()
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "observations are numbers of 32 bits"
)]
fn single(number: f64) -> f32 {
    number as f32
}

fn displaced(cell: &Cell, fault: &Fault) -> Result<Option<Cell>, String> {
    let FaultKind::Move { camera, by_m } = &fault.kind else {
        return Ok(None);
    };
    let mut cell = cell.clone();
    let names: Vec<String> = cell
        .cameras
        .iter()
        .map(|camera| camera.name.clone())
        .collect();
    let found: Option<&mut CameraSpec> = cell.cameras.iter_mut().find(|one| one.name == *camera);
    let Some(found) = found else {
        let names = names.join(", ");
        return Err(format!(
            "--fault {fault}: the cell has no camera '{camera}'; it has {names}"
        ));
    };
    for (coordinate, by) in found.pose.translation.vector.iter_mut().zip(by_m) {
        *coordinate += by;
    }
    Ok(Some(cell))
}
