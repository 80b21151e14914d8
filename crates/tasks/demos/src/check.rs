//! Checks that are shared by several kinds of `[task]`.

use cell_model::{ArmSpec, Cell, Checker, ModelError, suggest};
use nalgebra::Vector3;
use robocell_skills::ability::{self, Need};
use robocell_skills::{ArmSetup, ObjectSetup, Tool};

/// Largest number of objects in a stack.
pub const MAX_STACK: usize = 16;

/// Names of the cell's objects.
pub(crate) fn object_names(cell: &Cell) -> Vec<&str> {
    let objects = cell.objects.iter();
    objects.map(|object| object.name.as_str()).collect()
}

/// Checks that the objects exist, each named once.
pub(crate) fn order(
    at: &Checker<'_>,
    key: &str,
    order: &[String],
    names: &[&str],
) -> Result<(), ModelError> {
    for (index, name) in order.iter().enumerate() {
        let key = format!("{key}.{index}");
        known(at, &key, name, "object", names)?;
        if order.iter().take(index).any(|other| other == name) {
            let allowed = "an object is in a stack once";
            return Err(at.refuse(&key, format!("'{name}'"), allowed));
        }
    }
    if order.is_empty() || order.len() > MAX_STACK {
        let allowed = format!("1 to {MAX_STACK} are allowed");
        return Err(at.refuse(key, format!("{} names", order.len()), allowed));
    }
    Ok(())
}

/// Refuses a place on the floor that is farther than `reach_m` from the base of `arm`, in the
/// plane: the job could only fail there.
pub(crate) fn within_reach(
    at: &Checker<'_>,
    key: &str,
    arm: Option<&ArmSpec>,
    [x, y]: [f64; 2],
    reach_m: f64,
) -> Result<(), ModelError> {
    let Some(arm) = arm else {
        return Ok(());
    };
    let base = arm.base.translation.vector;
    let distance_m = (x - base.x).hypot(y - base.y);
    if distance_m <= reach_m {
        return Ok(());
    }
    let allowed = format!(
        "it is {distance_m:.2} m from the base of '{}', which reaches {reach_m} m",
        arm.name
    );
    Err(at.refuse(key, format!("[{x}, {y}]"), allowed))
}

/// Refuses points (m, world frame) to which the joints of `arm` cannot bring its tool, pointing
/// down (ADR 0026).
pub(crate) fn tool_gets_to(
    at: &Checker<'_>,
    key: &str,
    arm: Option<&ArmSpec>,
    points: impl IntoIterator<Item = [f64; 3]>,
) -> Result<(), ModelError> {
    let Some(spec) = arm else {
        return Ok(());
    };
    let arm = ArmSetup::of(spec);
    for point in points {
        if let Some(lack) = ability::lacks(&arm, Need::Reach(spec, &[Vector3::from(point)])) {
            let [x, y, z] = point;
            let allowed = format!(
                "'{}' {lack}, pointing down; move it nearer, or the base of the arm",
                arm.name
            );
            return Err(at.refuse(key, format!("[{x:.3}, {y:.3}, {z:.3}]"), allowed));
        }
    }
    Ok(())
}

/// Refuses an arm that cannot take the objects called `names` between two fingers.
pub(crate) fn fingers_grip(
    at: &Checker<'_>,
    cell: &Cell,
    arm: usize,
    names: &[String],
) -> Result<(), ModelError> {
    let Some(spec) = cell.arms.get(arm) else {
        return Ok(());
    };
    let (setup, key) = (ArmSetup::of(spec), format!("arm.{arm}.robot"));
    let refused = |why: String| Err(at.refuse(&key, format!("'{}'", spec.robot.name), why));
    // A suction tool would take the object, but the job opens and closes fingers and grades
    // their width.
    if setup.tool == Tool::Suction {
        return refused("this job needs two fingers, and it has suction".to_owned());
    }
    let objects = cell.objects.iter().filter(|o| names.contains(&o.name));
    for object in objects.map(ObjectSetup::of) {
        if let Some(lack) = ability::lacks(&setup, Need::Grip(Some(&object))) {
            return refused(ability::refusal(&setup.name, Some(&object.name), lack));
        }
    }
    Ok(())
}

/// Refuses a `name` that is not in `names`; `what` is the kind of thing for the message.
pub(crate) fn known(
    at: &Checker<'_>,
    key: &str,
    name: &str,
    what: &str,
    names: &[&str],
) -> Result<(), ModelError> {
    if names.contains(&name) {
        return Ok(());
    }
    let advice = suggest::advice(name, names);
    let allowed = format!("no such {what}; {advice}");
    Err(at.refuse(key, format!("'{name}'"), allowed))
}

/// Refuses a task without the name of its behaviour file.
pub(crate) fn behaviour(at: &Checker<'_>, name: &str) -> Result<(), ModelError> {
    if name.is_empty() {
        let allowed = "the name of a file in cells/ is needed";
        return Err(at.refuse("task.behaviour", "''", allowed));
    }
    Ok(())
}

/// Refuses a quaternion whose length is not 1 within `tolerance`.
pub(crate) fn unit_quaternion(
    at: &Checker<'_>,
    key: &str,
    quaternion: &[f64; 4],
    tolerance: f64,
) -> Result<(), ModelError> {
    let norm = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
    if (norm - 1.0).abs() <= tolerance {
        return Ok(());
    }
    let allowed = "a unit quaternion w x y z is needed";
    Err(at.refuse(key, format!("of length {norm}"), allowed))
}
