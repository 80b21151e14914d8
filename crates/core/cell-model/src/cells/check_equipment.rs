//! Ranges of the numbers of a cell's equipment.

use crate::cells::file::{CellFile, ConveyorTable, DispenserTable, SensorTable, SupplyTable};
use crate::check::Checker;
use crate::error::ModelError;
use crate::suggest;

/// Upper bound of the speed of a belt, and of an object that it brings (m/s).
const MAX_SPEED_M_S: f64 = 5.0;

impl Checker<'_> {
    /// Refuses equipment with invalid names or numbers.
    pub(crate) fn equipment(&self, cell: &CellFile) -> Result<(), ModelError> {
        if let Some(conveyor) = &cell.conveyor {
            self.conveyor(conveyor, cell)?;
        }
        if let Some(dispenser) = &cell.dispenser {
            self.dispenser(dispenser, cell)?;
        }
        let most = ipc_types::equipment::MAX_SENSORS;
        if cell.sensors.len() > most {
            let count = format!("{} entries", cell.sensors.len());
            return Err(self.refuse("sensor", count, format!("at most {most} are possible")));
        }
        let sensors = cell.sensors.iter().enumerate();
        sensors
            .map(|(index, sensor)| (format!("sensor.{index}"), sensor))
            .try_for_each(|(key, sensor)| self.sensor(&key, sensor))
    }

    fn conveyor(&self, conveyor: &ConveyorTable, cell: &CellFile) -> Result<(), ModelError> {
        let refuse = |allowed: String| {
            let name = format!("'{}'", conveyor.fixture);
            Err(self.refuse("conveyor.fixture", name, allowed))
        };
        let mut fixtures = cell.fixtures.iter();
        let Some(fixture) = fixtures.find(|fixture| fixture.name == conveyor.fixture) else {
            let names: Vec<&str> = cell.fixtures.iter().map(|f| f.name.as_str()).collect();
            let advice = suggest::advice(&conveyor.fixture, &names);
            return refuse(format!("no such fixture; {advice}"));
        };
        if !fixture.solid {
            // Nothing can rest on it: the belt would move no object.
            let allowed = "that fixture has solid = false, so no object can be on it; a solid \
                           fixture is needed: remove solid = false, or name another fixture";
            return refuse(allowed.to_owned());
        }
        self.speed("conveyor.velocity_m_s", &conveyor.velocity_m_s)?;
        conveyor
            .supply
            .as_ref()
            .map_or(Ok(()), |supply| self.supply(supply, cell))
    }

    fn supply(&self, supply: &SupplyTable, cell: &CellFile) -> Result<(), ModelError> {
        self.parked("conveyor.supply.objects", &supply.objects, cell)?;
        self.position("conveyor.supply.position_m", &supply.position_m)?;
        self.number("conveyor.supply.yaw_rad", supply.yaw_rad, -7.0, 7.0)?;
        self.spawn("conveyor.supply.spawn", supply.spawn)?;
        self.speed("conveyor.supply.velocity_m_s", &supply.velocity_m_s)?;
        self.number(
            "conveyor.supply.flipped_share",
            supply.flipped_share,
            0.0,
            1.0,
        )?;
        let waiting = f64::from(supply.max_waiting);
        self.number("conveyor.supply.max_waiting", waiting, 1.0, 36.0)?;
        self.number(
            "conveyor.supply.cool_down_s",
            supply.cool_down_s,
            0.0,
            3600.0,
        )
    }

    fn dispenser(&self, dispenser: &DispenserTable, cell: &CellFile) -> Result<(), ModelError> {
        self.parked("dispenser.objects", &dispenser.objects, cell)?;
        self.position("dispenser.position_m", &dispenser.position_m)?;
        self.numbers("dispenser.spread_m", &dispenser.spread_m, 0.0, 1.0)?;
        self.number("dispenser.layer_m", dispenser.layer_m, 0.0, 1.0)?;
        let parts = f64::from(dispenser.per_drop);
        self.number("dispenser.per_drop", parts, 1.0, 100.0)?;
        self.number("dispenser.interval_s", dispenser.interval_s, 0.0, 3600.0)
    }

    fn sensor(&self, key: &str, sensor: &SensorTable) -> Result<(), ModelError> {
        self.position(&format!("{key}.position_m"), &sensor.position_m)?;
        self.numbers(
            &format!("{key}.direction"),
            &sensor.direction,
            -1.0e3,
            1.0e3,
        )?;
        let length = sensor.direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        // Only a direction of length zero is refused: any other one is normalised later.
        self.number(&format!("{key}.direction"), length, 1.0e-6, 1.0e4)?;
        self.number(&format!("{key}.range_m"), sensor.range_m, 1.0e-3, 20.0)
    }

    // Equipment brings objects that are out of the simulation; one that is in it cannot be
    // brought.
    fn parked(&self, key: &str, name: &str, cell: &CellFile) -> Result<(), ModelError> {
        let parked = cell.objects.iter().filter(|object| object.parked);
        let parked: Vec<&str> = parked.map(|object| object.name.as_str()).collect();
        if parked.contains(&name) {
            return Ok(());
        }
        let advice = suggest::advice(name, &parked);
        let allowed = format!("it must be an object with parked = true; {advice}");
        Err(self.refuse(key, format!("'{name}'"), allowed))
    }

    fn speed(&self, key: &str, velocity: &[f64; 3]) -> Result<(), ModelError> {
        self.numbers(key, velocity, -MAX_SPEED_M_S, MAX_SPEED_M_S)
    }
}
