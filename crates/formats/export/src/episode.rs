//! A recorded episode as frames: a state, and the action that was taken on it.

use std::collections::BTreeMap;
use std::path::Path;

use cell_model::Cell;
use cell_record::{Channel, Recording};
use cell_run::spec::RunSpec;
use cell_sim::action::{Hold, NUMBERS, action_of};
use ipc_types::decision::Outcome;
use ipc_types::{Decision, Wire, WorldPiece, WorldState};

use crate::ExportError;

/// An action of all arms.
pub(crate) type Action = Vec<[f32; NUMBERS]>;

/// A frame.
pub(crate) struct Frame {
    pub(crate) state: Box<WorldState>,
    pub(crate) action: Action,
}

/// An episode.
pub(crate) struct Episode {
    pub(crate) spec: RunSpec,
    pub(crate) cell: Cell,
    pub(crate) rate_hz: u32,
    /// One for each action, at least one.
    pub(crate) frames: Vec<Frame>,
    /// The last state.
    pub(crate) end: Box<WorldState>,
    /// Whether the task was done.
    pub(crate) success: bool,
    /// Force of a closing gripper (N).
    pub(crate) grip_force: f64,
}

impl Episode {
    /// Reads a recording of `eval --record`.
    pub(crate) fn read(path: &Path, data: &cell_model::Data) -> Result<Self, ExportError> {
        let refuse = |why: String| ExportError::Episode {
            path: path.to_owned(),
            why,
        };
        let recording = Recording::open(path)?;
        let spec = recording.run().clone();
        let Some(rate_hz) = spec.action_hz else {
            let why = "its actions have no rate; `robocell eval DEMO --seeds A..B --rate 20 --record DIR` \
                       records episodes that can be exported";
            return Err(refuse(why.to_owned()));
        };
        let hold = Hold::new(rate_hz).map_err(|error| refuse(error.to_string()))?;
        let cell = spec.load_cell_from(data)?;
        let (states, decisions) = messages(&recording)?;
        let Some(last) = states.last_key_value().map(|(tick, _)| *tick) else {
            return Err(refuse("it has no state".to_owned()));
        };
        let success = decisions.last_key_value();
        let success = success.is_some_and(|(_, one)| one.outcome == Outcome::Done.code());
        let grip_force = decisions.values().flat_map(|one| one.goals);
        let grip_force = grip_force.map(|goal| goal.grip_force).fold(0.0, f64::max);
        let mut end = None;
        let mut frames = Vec::new();
        for (tick, state) in states {
            if tick == last {
                end = Some(state.clone());
            }
            // The last state of most episodes is between two actions, or no action follows it.
            if !hold.begins(tick) || tick == last {
                continue;
            }
            let decision = decisions.get(&tick);
            let decision = decision.ok_or_else(|| {
                refuse(format!("the decision at {:.2} s is missing", seconds(tick)))
            })?;
            frames.push(Frame {
                action: actions(&cell, decision).map_err(|what| {
                    refuse(format!("at {:.2} s {what}; an action has a pose and a gripper, so a data set of this cell is not written", seconds(tick)))
                })?,
                state,
            });
        }
        let Some(end) = end.filter(|_| !frames.is_empty()) else {
            return Err(refuse("it is shorter than one action".to_owned()));
        };
        Ok(Self {
            spec,
            cell,
            rate_hz,
            frames,
            end,
            success,
            grip_force,
        })
    }
}

fn seconds(tick: u64) -> f64 {
    tick as f64 * 1.0e-3
}

/// The actions of all arms, or what one of them has that an action cannot say.
fn actions(cell: &Cell, decision: &Decision) -> Result<Action, String> {
    if decision.io != Decision::zeroed().io {
        return Err("the task commands equipment of the cell".to_owned());
    }
    let arms = cell.arms.iter().zip(&decision.goals);
    arms.map(|(arm, goal)| {
        action_of(goal).map_err(|field| format!("the goal of arm '{}' has a {field}", arm.name))
    })
    .collect()
}

type States = BTreeMap<u64, Box<WorldState>>;

fn messages(recording: &Recording) -> Result<(States, BTreeMap<u64, Decision>), ExportError> {
    let (mut states, mut decisions) = (States::new(), BTreeMap::new());
    for entry in recording.messages() {
        let entry = entry?;
        match entry.channel {
            Channel::Decision => drop(decisions.insert(entry.tick, entry.read()?)),
            Channel::World => {
                let piece: WorldPiece = entry.read()?;
                let state = states.entry(entry.tick);
                piece.put(state.or_insert_with(|| Box::new(WorldState::zeroed())));
            }
            _ => {}
        }
    }
    Ok((states, decisions))
}
