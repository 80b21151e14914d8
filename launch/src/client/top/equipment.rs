//! The cell's equipment in `top` and `status`: devices and their states.

use cell_model::Cell;
use ipc_types::EquipmentState;
use ipc_types::equipment::SupplyRefusal;

/// Names of what a state only numbers; empty where the cell cannot be read.
#[derive(Debug, Default)]
pub(crate) struct Names {
    objects: Vec<String>,
    sensors: Vec<String>,
    has_belt: bool,
    has_supply: bool,
    has_dispenser: bool,
    /// By arm: it holds by suction.
    suction: Vec<bool>,
    /// By arm: it has a gripper with fingers.
    fingers: Vec<bool>,
    /// By arm: units of the positions of its joints.
    units: Vec<String>,
}

impl Names {
    /// The names in `cell`.
    pub(crate) fn of(cell: &Cell) -> Self {
        let supply = cell.conveyor.as_ref().and_then(|belt| belt.supply.as_ref());
        Self {
            objects: cell.objects.iter().map(|o| o.name.clone()).collect(),
            sensors: cell.sensors.iter().map(|s| s.name.clone()).collect(),
            has_belt: cell.conveyor.is_some(),
            has_supply: supply.is_some(),
            has_dispenser: cell.dispenser.is_some(),
            fingers: cell
                .arms
                .iter()
                .map(|arm| arm.robot.gripper.is_some())
                .collect(),
            suction: cell
                .arms
                .iter()
                .map(|arm| arm.robot.suction.is_some())
                .collect(),
            units: cell
                .arms
                .iter()
                .map(|arm| units(&arm.robot.arm_units()))
                .collect(),
        }
    }

    /// The object a message names by its index plus 1; `none` for 0.
    pub(super) fn object<'a>(&'a self, index_plus_1: u32, none: &'a str) -> &'a str {
        let index = (index_plus_1 as usize).checked_sub(1);
        index.map_or(none, |index| {
            self.objects.get(index).map_or("an object", String::as_str)
        })
    }

    /// Whether that arm holds by suction.
    pub(super) fn has_suction(&self, arm: usize) -> bool {
        self.suction.get(arm).copied().unwrap_or_default()
    }

    /// Whether that arm is known to have no gripper of any kind.
    pub(super) fn has_no_gripper(&self, arm: usize) -> bool {
        let has = |list: &[bool]| list.get(arm).copied() != Some(false);
        !has(&self.suction) && !has(&self.fingers)
    }

    /// The units of the positions of that arm's joints.
    pub(super) fn units(&self, arm: usize) -> &str {
        self.units.get(arm).map_or("rad", String::as_str)
    }

    /// State of the equipment, one device per line; nothing where there is none.
    pub(crate) fn lines(&self, state: &EquipmentState) -> Vec<String> {
        let mut lines = Vec::new();
        if self.has_belt {
            lines.push(self.belt(state));
        }
        if self.has_dispenser {
            lines.push(format!(
                "dispenser  {} parts dropped, {} still to fall",
                state.parts_dropped, state.parts_waiting
            ));
        }
        let pairs = self.sensors.iter().zip(&state.sensors);
        let sensors: Vec<String> = pairs
            .map(|(name, object)| format!("{name} {}", self.object(*object, "free")))
            .collect();
        if !sensors.is_empty() {
            lines.push(format!("sensors    {}", sensors.join(", ")));
        }
        if state.cleared > 0 && !lines.is_empty() {
            lines.push(format!(
                "cleared    {} fell out of the cell and were put away",
                state.cleared
            ));
        }
        lines
    }

    fn belt(&self, state: &EquipmentState) -> String {
        let runs = if state.conveyor_speed == 0.0 {
            "stopped".to_owned()
        } else {
            format!("runs at {:.2} m/s", state.conveyor_speed)
        };
        if !self.has_supply {
            return format!("belt       {runs}");
        }
        let why = match SupplyRefusal::from_code(state.supply_refusal) {
            _ if state.supply_refusals == 0 => String::new(),
            Some(SupplyRefusal::NoneLeft) => ", the last as none is left".to_owned(),
            Some(SupplyRefusal::TooManyWaiting) => ", the last as enough wait".to_owned(),
            Some(SupplyRefusal::CoolDown) => ", the last as one had just arrived".to_owned(),
            Some(SupplyRefusal::PlaceTaken) => ", the last as its place was taken".to_owned(),
            Some(SupplyRefusal::None) | None => String::new(),
        };
        format!(
            "belt       {runs}; bins: {} arrived, {} refused{why}",
            state.bins_supplied, state.supply_refusals
        )
    }
}

/// Each unit once.
fn units(of: &[&str]) -> String {
    let used = ["rad", "m"].into_iter().filter(|unit| of.contains(unit));
    used.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;
    use cell_model::Data;
    use ipc_types::Wire;

    fn names(demo: &str) -> Names {
        Names::of(&Cell::load(&Data::checkout(), demo, 0, None).unwrap())
    }

    #[test]
    fn a_cell_shows_the_devices_it_has() {
        let mut state = EquipmentState::zeroed();
        assert!(names("franka-stack").lines(&state).is_empty());
        assert!(!names("franka-stack").has_suction(0));
        assert!(!names("franka-stack").has_no_gripper(0));
        (state.conveyor_speed, state.bins_supplied) = (0.3, 2);
        (state.parts_dropped, state.parts_waiting) = (12, 3);
        for (demo, words) in [
            ("ur10-palletize", "runs at 0.30 m/s; bins: 2 arrived"),
            ("ur10-bin-stack", "runs at 0.30 m/s; bins: 2 arrived"),
            ("ur10-fill-bin", "12 parts dropped, 3 still to fall"),
        ] {
            let names = names(demo);
            let text = names.lines(&state).join("\n");
            assert!(text.contains(words), "{demo}: {text}");
            assert_eq!(text.contains("belt"), demo != "ur10-fill-bin", "{text}");
            assert!(names.has_suction(0), "{demo}");
        }
    }

    #[test]
    fn a_sensor_names_the_bin_in_it_and_a_refusal_its_reason() {
        let names = names("ur10-bin-stack");
        let mut state = EquipmentState::zeroed();
        assert!(names.lines(&state).join("\n").contains("free"));
        state.sensors[0] = 1;
        state.supply_refusals = 1;
        state.supply_refusal = SupplyRefusal::NoneLeft.code();
        let text = names.lines(&state).join("\n");
        assert!(text.contains("bin_01"), "{text}");
        assert!(text.contains("belt       stopped"), "{text}");
        assert!(
            text.contains("1 refused, the last as none is left"),
            "{text}"
        );
    }

    #[test]
    fn an_arm_shows_the_units_of_its_joints() {
        assert_eq!(names("franka-stack").units(0), "rad");
        assert_eq!(units(&["m", "rad", "rad"]), "rad,m");
        assert_eq!(units(&["m"]), "m");
    }
}
