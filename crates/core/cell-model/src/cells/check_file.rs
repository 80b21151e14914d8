//! Ranges of the numbers in a cell file.

use crate::cells::file::{CellFile, Disturbance, FixtureTable, ObjectTable, SpawnArea, numbered};
use crate::check::{Checker, MAX_COORDINATE_M};
use crate::error::ModelError;
use crate::robots::robot::Robot;
use crate::shape::Shape;
use crate::suggest;

/// Largest number of fixtures: a goal has a bit for each that is an obstacle.
const MAX_FIXTURES: usize = 64;
/// Largest number of objects that are obstacles: a goal has a bit for each.
const MAX_OBSTACLE_OBJECTS: usize = 64;
/// Largest number of policies of a cell: an error lists them in one message.
const MAX_POLICIES: usize = 16;

/// Refuses a cell with invalid names or numbers.
pub(crate) fn check(file: &str, text: &str, cell: &CellFile) -> Result<(), ModelError> {
    let checker = Checker::new(file, text);
    checker.number("time_limit_s", cell.time_limit_s, 0.1, 1.0e5)?;
    checker.numbers(
        "camera.eye_m",
        &cell.camera.eye_m,
        -MAX_COORDINATE_M,
        MAX_COORDINATE_M,
    )?;
    checker.numbers(
        "camera.target_m",
        &cell.camera.target_m,
        -MAX_COORDINATE_M,
        MAX_COORDINATE_M,
    )?;
    let light = cell.light;
    checker.ranges(
        "light",
        &[
            ("from_x", light.from_x, -5.0, 5.0),
            ("from_y", light.from_y, -5.0, 5.0),
            ("direct", light.direct, 0.0, 1.0),
            ("from_above", light.from_above, 0.0, 1.0),
            ("from_below", light.from_below, 0.0, 1.0),
        ],
    )?;
    // Counts before names: names are compared in pairs.
    checker.counts(cell)?;
    checker.names(cell)?;
    for (index, arm) in cell.arms.iter().enumerate() {
        let key = format!("arm.{index}");
        checker.position(&format!("{key}.base_position_m"), &arm.base_position_m)?;
        checker.number(&format!("{key}.base_yaw_rad"), arm.base_yaw_rad, -7.0, 7.0)?;
    }
    for (index, object) in cell.objects.iter().enumerate() {
        checker.object(&format!("object.{index}"), object)?;
    }
    for (index, fixture) in cell.fixtures.iter().enumerate() {
        checker.fixture(&format!("fixture.{index}"), fixture)?;
    }
    if let Some(height) = cell.clear_below_m {
        checker.number("clear_below_m", height, -MAX_COORDINATE_M, MAX_COORDINATE_M)?;
    }
    checker.disturbance(&cell.disturbance)?;
    checker.equipment(cell)
}

/// Refuses a home position that the robot cannot take.
pub(crate) fn home(
    file: &str,
    text: &str,
    arm: usize,
    home: &[f64],
    robot: &Robot,
) -> Result<(), ModelError> {
    let checker = Checker::new(file, text);
    let key = format!("arm.{arm}.home_joint_positions");
    if home.len() != robot.arm_joints.len() {
        let allowed = format!("{} are needed for {}", robot.arm_joints.len(), robot.name);
        return Err(checker.refuse(&key, format!("{} numbers", home.len()), allowed));
    }
    let joints = home.iter().zip(robot.arm_specs()).enumerate();
    for (index, (position, spec)) in joints {
        checker.number(&format!("{key}.{index}"), *position, spec.lower, spec.upper)?;
    }
    Ok(())
}

impl Checker<'_> {
    fn disturbance(&self, disturbance: &Disturbance) -> Result<(), ModelError> {
        let ranges = [
            ("position_offset_m", disturbance.position_offset_m, 0.0, 1.0),
            ("position_noise_m", disturbance.position_noise_m, 0.0, 1.0),
            ("yaw_offset_rad", disturbance.yaw_offset_rad, 0.0, 3.2),
            ("yaw_noise_rad", disturbance.yaw_noise_rad, 0.0, 3.2),
            ("drive_delay_s", disturbance.drive_delay_s, 0.0, 1.0),
        ];
        self.ranges("disturbance", &ranges)
    }

    fn counts(&self, cell: &CellFile) -> Result<(), ModelError> {
        let counts = cell.objects.iter().map(|object| object.count.unwrap_or(1));
        let objects = counts.map(|count| count as usize).sum();
        let limits = [
            ("arm", cell.arms.len(), 1, ipc_types::MAX_ARMS),
            ("object", objects, 0, ipc_types::MAX_OBJECTS),
            ("fixture", cell.fixtures.len(), 0, MAX_FIXTURES),
            ("policies", cell.policies.len(), 1, MAX_POLICIES),
        ];
        for (key, count, low, high) in limits {
            if !(low..=high).contains(&count) {
                return Err(self.refuse(
                    key,
                    format!("{count} entries"),
                    format!("{low} to {high} are allowed"),
                ));
            }
        }
        self.obstacles(cell)?;
        let known: Vec<&str> = cell.policies.iter().map(String::as_str).collect();
        if !known.contains(&cell.default_policy.as_str()) {
            let allowed = format!(
                "it must be one of policies; {}",
                suggest::advice(&cell.default_policy, &known)
            );
            return Err(self.refuse("default_policy", &cell.default_policy, allowed));
        }
        Ok(())
    }

    /// Refuses too many obstacles. A goal has a bit for each of them: without one, an arm could
    /// not be allowed to touch an object.
    fn obstacles(&self, cell: &CellFile) -> Result<(), ModelError> {
        let mut count = 0;
        for (index, object) in cell.objects.iter().enumerate() {
            if object.obstacle {
                count += object.count.unwrap_or(1) as usize;
            }
            if count > MAX_OBSTACLE_OBJECTS {
                return Err(self.refuse(
                    &format!("object.{index}.obstacle"),
                    format!("{count} objects that are obstacles"),
                    format!("0 to {MAX_OBSTACLE_OBJECTS} are allowed"),
                ));
            }
        }
        Ok(())
    }

    fn names(&self, cell: &CellFile) -> Result<(), ModelError> {
        self.unique("arm", cell.arms.iter().map(|arm| arm.name.as_str()))?;
        self.unique(
            "object",
            cell.objects.iter().map(|object| object.name.as_str()),
        )?;
        self.unique(
            "sensor",
            cell.sensors.iter().map(|sensor| sensor.name.as_str()),
        )?;
        self.numbered_names(cell)?;
        self.unique(
            "fixture",
            cell.fixtures.iter().map(|fixture| fixture.name.as_str()),
        )
    }

    /// Refuses an object with a name that a series gives to one of its objects.
    fn numbered_names(&self, cell: &CellFile) -> Result<(), ModelError> {
        let series = cell.objects.iter().filter(|object| object.count.is_some());
        let numbered = series
            .flat_map(|object| (0..object.count.unwrap_or(0)).map(move |i| numbered(object, i)));
        let numbered: Vec<String> = numbered.collect();
        for (index, object) in cell.objects.iter().enumerate() {
            if numbered.contains(&object.name) {
                let key = format!("object.{index}.name");
                let allowed = "a series of objects has that name; rename one of them";
                return Err(self.refuse(&key, format!("'{}'", object.name), allowed));
            }
        }
        Ok(())
    }

    /// Refuses a name that is not a short word.
    pub(crate) fn name(&self, key: &str, name: &str) -> Result<(), ModelError> {
        // Names become parts of keys on blackboards, which are short texts.
        let word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if name.is_empty() || name.len() > 32 || !name.chars().all(word) {
            let allowed = "1 to 32 of a-z, 0-9 and _ are allowed";
            return Err(self.refuse(key, format!("'{name}'"), allowed));
        }
        Ok(())
    }

    fn unique<'b>(
        &self,
        what: &str,
        names: impl Iterator<Item = &'b str>,
    ) -> Result<(), ModelError> {
        let mut seen: Vec<&str> = Vec::new();
        for (index, name) in names.enumerate() {
            let key = format!("{what}.{index}.name");
            self.name(&key, name)?;
            if seen.contains(&name) {
                return Err(self.refuse(
                    &key,
                    format!("'{name}'"),
                    "that name is taken; rename one of them",
                ));
            }
            seen.push(name);
        }
        Ok(())
    }

    fn shape(&self, key: &str, shape: &Shape) -> Result<(), ModelError> {
        shape.lengths().iter().try_for_each(|(name, length)| {
            self.number(&format!("{key}.{name}"), *length, 1.0e-3, MAX_COORDINATE_M)
        })?;
        if let Shape::Bin { size_m, wall_m } = *shape {
            let thinnest = size_m.iter().fold(f64::INFINITY, |least, s| least.min(*s));
            // Walls thicker than this would leave no inside.
            self.number(&format!("{key}.wall_m"), wall_m, 1.0e-3, 0.45 * thinnest)?;
        }
        Ok(())
    }

    pub(crate) fn spawn(&self, key: &str, spawn: SpawnArea) -> Result<(), ModelError> {
        self.number(&format!("{key}.x_m"), spawn.x_m, 0.0, 1.0)?;
        self.number(&format!("{key}.y_m"), spawn.y_m, 0.0, 1.0)?;
        self.number(&format!("{key}.yaw_rad"), spawn.yaw_rad, 0.0, 3.2)
    }

    fn object(&self, key: &str, object: &ObjectTable) -> Result<(), ModelError> {
        let count = object.count.map_or(1.0, f64::from);
        // The names of a series have at most three digits.
        self.number(&format!("{key}.count"), count, 1.0, 999.0)?;
        self.position(&format!("{key}.pitch_m"), &object.pitch_m)?;
        self.shape(&format!("{key}.shape"), &object.shape)?;
        for (index, shape) in object.other_shapes.iter().enumerate() {
            self.shape(&format!("{key}.other_shapes.{index}"), shape)?;
        }
        let damping = object.angular_damping;
        self.number(&format!("{key}.angular_damping"), damping, 0.0, 100.0)?;
        self.number(&format!("{key}.mass_kg"), object.mass_kg, 1.0e-3, 100.0)?;
        self.number(&format!("{key}.friction"), object.friction, 0.0, 5.0)?;
        // A larger spread would let a seed make the friction negative.
        self.number(
            &format!("{key}.friction_spread"),
            object.friction_spread,
            0.0,
            object.friction,
        )?;
        self.position(&format!("{key}.position_m"), &object.position_m)?;
        self.orientation(key, object.orientation_wxyz, object.yaw_rad)?;
        self.spawn(&format!("{key}.spawn"), object.spawn)?;
        self.numbers(&format!("{key}.colour"), &object.colour, 0.0, 1.0)
    }

    fn orientation(
        &self,
        key: &str,
        wxyz: Option<[f64; 4]>,
        yaw_rad: f64,
    ) -> Result<(), ModelError> {
        if let Some(q) = wxyz {
            let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            self.number(&format!("{key}.orientation_wxyz"), norm, 0.999, 1.001)?;
        }
        self.number(&format!("{key}.yaw_rad"), yaw_rad, -7.0, 7.0)
    }

    fn fixture(&self, key: &str, fixture: &FixtureTable) -> Result<(), ModelError> {
        self.shape(&format!("{key}.shape"), &fixture.shape)?;
        self.number(&format!("{key}.friction"), fixture.friction, 0.0, 5.0)?;
        self.position(&format!("{key}.position_m"), &fixture.position_m)?;
        self.orientation(key, fixture.orientation_wxyz, fixture.yaw_rad)?;
        self.numbers(&format!("{key}.colour"), &fixture.colour, 0.0, 1.0)
    }
}
