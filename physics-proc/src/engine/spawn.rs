//! Nothing may start inside something else.

use cell_model::Cell;

use crate::engine::shapes::overlap;
use crate::error::WorldError;

/// Objects resting on a table touch it; this much is still resting (m).
const RESTING_M: f64 = 1.0e-3;

/// Checks that no object of the cell overlaps another or a fixture; what is not
/// in the cell yet, or not solid, blocks nothing.
pub(crate) fn check(cell: &Cell) -> Result<(), WorldError> {
    let objects = cell.objects.iter().enumerate();
    for (index, object) in objects.filter(|(_, object)| !object.parked) {
        let earlier = cell
            .objects
            .iter()
            .take(index)
            .filter(|other| !other.parked)
            .map(|other| (&other.name, &other.shape, &other.pose));
        let fixtures = cell
            .fixtures
            .iter()
            .filter(|fixture| fixture.solid)
            .map(|other| (&other.name, &other.shape, &other.pose));
        for (name, shape, pose) in earlier.chain(fixtures) {
            let depth = overlap(&object.shape, &object.pose, shape, pose);
            if depth > RESTING_M {
                return Err(WorldError::Overlap {
                    object: object.name.clone(),
                    other: name.clone(),
                    depth,
                });
            }
        }
    }
    Ok(())
}
