//! What the jobs take out of a cell file in the same way.

use behavior::matrix::{Definition, Table, Vocabulary};
use cell_model::{ArmSpec, Cell};
use robocell_task::SetupError;
use robocell_task::settings::behaviour_text;

use super::Named;

/// The cell's first arm, with a suction gripper.
pub(crate) fn suction_arm(cell: &Cell) -> Result<&ArmSpec, SetupError> {
    let arm = cell.arms.first();
    let arm =
        arm.ok_or_else(|| SetupError::new(cell, "there is no [[arm]]; this job needs one"))?;
    if arm.robot.suction.is_none() {
        let name = &arm.robot.name;
        let problem = format!("robot '{name}' has no suction gripper; this job needs one");
        return Err(SetupError::new(cell, problem));
    }
    Ok(arm)
}

/// Bits of [`ipc_types::ArmGoal::obstacle_mask`] of the obstacles with such a name.
pub(crate) fn obstacle_bits(cell: &Cell, named: impl Fn(&str) -> bool) -> u64 {
    let obstacles = cell.obstacles().take(64).enumerate();
    obstacles
        .filter(|(_, obstacle)| named(&obstacle.name))
        .fold(0, |mask, (bit, _)| mask | 1 << bit)
}

/// The matrix in the behaviour file of that name, of events `E`, states `S` and
/// handlers `H`.
pub(crate) fn matrix<E: Named, S: Named, H: Named>(
    cell: &Cell,
    name: &str,
) -> Result<Table, SetupError> {
    let text = behaviour_text(cell, name)?;
    let vocabulary = Vocabulary {
        events: E::NAMES,
        states: S::NAMES,
        handlers: H::NAMES,
        behaviors: &[],
    };
    Definition::load(&format!("cells/{name}"), &text, &vocabulary)
        .map_err(|problems| SetupError::new(cell, problems.to_string()))
}
