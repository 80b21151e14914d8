//! The names in a skill, looked up before it leads an arm.

use pyo3::prelude::*;

use super::{Goal, Skill, What};
use crate::inner::Inner;

impl Skill {
    /// Looks up the objects and places that it names.
    ///
    /// # Errors
    /// The name that the cell does not know, with the nearest that it knows.
    pub(crate) fn check_names(&self, inner: &Inner) -> PyResult<()> {
        let (objects, place) = match &self.what {
            What::Move { goal, holding, .. } => {
                let (object, place) = match goal {
                    Goal::Object(object, _) => (Some(object), None),
                    Goal::Place(object, place, _) => (Some(object), Some(place)),
                    Goal::Pose(..) | Goal::Up(_) => (None, None),
                };
                ([object, holding.as_ref()], place)
            }
            What::Pick { object, .. } => ([Some(object), None], None),
            What::Place { object, place, .. } => ([Some(object), None], Some(place)),
            What::Close(object) => ([object.as_ref(), None], None),
            _ => ([None, None], None),
        };
        for object in objects.into_iter().flatten() {
            inner.object(object)?;
        }
        place.map_or(Ok(()), |place| inner.place(place).map(|_| ()))
    }
}
