//! The ports of a motion about its path to the target.

use behavior::Str;
use behavior::board::{Fault, In};
use behavior::suggest;
use behavior::tree::{BindError, Binder, NodeType};
use behavior::value::Numbers;
use ipc_types::MAX_JOINTS;

use super::Context;
use crate::setup::Setup;
use crate::skill::Station;
use crate::way::Way;

/// Adds these ports.
pub(super) fn ports(node_type: NodeType<Station>) -> NodeType<Station> {
    node_type
        .input_or(
            "posture",
            Numbers::default(),
            "joint positions to lean to (rad), in the order of the arm's joints",
        )
        .input_or(
            "approach",
            Numbers::default(),
            "approach corridor: x y z of its direction times its length, world frame (m)",
        )
        .input_or(
            "approach_width",
            0.01,
            "width of the approach corridor (standard deviation, m)",
        )
        .within(1.0e-4, 2.0)
        .input_or(
            "ignore",
            Str::EMPTY,
            "obstacles whose names start so do not count",
        )
        .input_or(
            "guide",
            Str::EMPTY,
            "fixtures with solid = false whose names start so count as obstacles",
        )
}

/// The ports of one motion.
#[derive(Clone, Copy)]
pub(super) struct WayPorts {
    posture: In<Numbers>,
    approach: In<Numbers>,
    width: In<f64>,
    ignored: u64,
    guides: u64,
}

impl WayPorts {
    #[allow(clippy::result_large_err, reason = "happens at load, once")]
    pub(super) fn bind(binder: &mut Binder<'_>, setup: &Setup) -> Result<Self, BindError> {
        Ok(Self {
            posture: counted(binder, "posture", 1..=MAX_JOINTS)?,
            approach: counted(binder, "approach", 3..=3)?,
            width: binder.input("approach_width")?,
            ignored: obstacles(binder, setup, "ignore")?,
            guides: obstacles(binder, setup, "guide")?,
        })
    }

    pub(super) fn get(&self, cx: &Context<'_, '_>) -> Result<Way, Fault> {
        let positions = cx.get(&self.posture)?;
        let mut posture = [0.0; MAX_JOINTS];
        for (joint, position) in posture.iter_mut().zip(positions.as_slice()) {
            *joint = *position;
        }
        // A corridor without a direction has no width either; the port's default is not used.
        let approach: Option<[f64; 3]> = cx.get(&self.approach)?.as_slice().try_into().ok();
        Ok(Way {
            posture: (!positions.as_slice().is_empty()).then_some(posture),
            approach_m: approach.unwrap_or_default(),
            std_dev_m: approach.map_or(Ok(0.0), |_| cx.get(&self.width))?,
            ignored: self.ignored,
            guides: self.guides,
        })
    }
}

/// Numbers written in the file, as many as `allowed` or none. Those of a key are known later.
#[allow(clippy::result_large_err, reason = "happens at load, once")]
fn counted(
    binder: &mut Binder<'_>,
    port: &str,
    allowed: std::ops::RangeInclusive<usize>,
) -> Result<In<Numbers>, BindError> {
    let bound = binder.input::<Numbers>(port)?;
    if let In::Literal(numbers) = bound {
        let count = numbers.as_slice().len();
        if count > 0 && !allowed.contains(&count) {
            let needed = match (allowed.start(), allowed.end()) {
                (low, high) if low == high => format!("{low} are needed"),
                (low, high) => format!("{low} to {high} are allowed"),
            };
            let problem = format!("'{port}' has {count} numbers; {needed}");
            return Err(BindError::Host(problem));
        }
    }
    Ok(bound)
}

/// Bits of the obstacles whose names start with the text of the port.
#[allow(clippy::result_large_err, reason = "happens at load, once")]
fn obstacles(binder: &mut Binder<'_>, setup: &Setup, port: &str) -> Result<u64, BindError> {
    let In::Literal(start) = binder.input::<Str>(port)? else {
        return Err(BindError::Host(format!("'{port}' has to be a name")));
    };
    if start.is_empty() || setup.arms.is_empty() {
        // Not given, or a file that is checked without its cell.
        return Ok(0);
    }
    // The mask of a goal has 64 bits, and a cell at most as many obstacles.
    let named = setup.obstacles.iter().take(64).enumerate();
    let named = named.filter(|(_, name)| name.starts_with(start.as_str()));
    let mask = named.fold(0, |mask, (bit, _)| mask | 1 << bit);
    // Refused: with a misspelt name the motion would avoid an obstacle that it should ignore.
    if mask == 0 {
        let known: Vec<&str> = setup.obstacles.iter().map(String::as_str).collect();
        let advice = suggest::advice(start.as_str(), &known);
        let problem = format!("no obstacle has a name that starts with '{start}'; {advice}");
        return Err(BindError::Host(problem));
    }
    Ok(mask)
}
