//! Spheres of what the tool holds: they come and go, and count against obstacles
//! as those of the robot do.

use nalgebra::Vector3;

use crate::ball::{Ball, MAX_CARRIED};
use crate::tree::Attachment;
use crate::{RmpFlow, SetupError, TargetId};

impl RmpFlow {
    /// From now on the tool carries these spheres, and no others: centre in the
    /// target frame `id` (m) and radius (m, >= 0). Does not allocate.
    ///
    /// # Errors
    /// [`SetupError`] for more than [`MAX_CARRIED`] spheres, a number that is not
    /// finite, or a frame that does not exist; then nothing is carried.
    pub fn carry(
        &mut self,
        id: TargetId,
        spheres: &[(Vector3<f64>, f64)],
    ) -> Result<(), SetupError> {
        self.carried.clear();
        if spheres.len() > MAX_CARRIED {
            return Err(SetupError::Length {
                what: "carried spheres (at most)",
                found: spheres.len(),
                expected: MAX_CARRIED,
            });
        }
        let numbers = spheres.iter().flat_map(|(c, r)| [c.x, c.y, c.z, *r]);
        for value in numbers {
            if !value.is_finite() {
                let what = "a carried sphere".to_owned();
                return Err(SetupError::NotFinite { what, value });
            }
        }
        let Some(frame) = self.target_attachment(id) else {
            let (name, wanted_by) = (format!("{id:?}"), "carried spheres".to_owned());
            return Err(SetupError::UnknownFrame { name, wanted_by });
        };
        self.carried
            .extend(spheres.iter().map(|(center, radius)| Ball {
                attachment: Attachment {
                    offset: frame.offset + frame.rotation * center,
                    ..frame.clone()
                },
                radius: radius.max(0.0),
            }));
        Ok(())
    }

    /// The tool carries nothing any more.
    pub fn drop_carried(&mut self) {
        self.carried.clear();
    }

    /// How many spheres are carried.
    pub fn carried_count(&self) -> usize {
        self.carried.len()
    }

    fn target_attachment(&self, id: TargetId) -> Option<Attachment> {
        self.targets.get(id.index()).map(|t| t.attachment.clone())
    }
}
