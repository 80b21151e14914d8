//! Spheres of the object on the tool: they are added and removed, and keep away from obstacles
//! and from the robot as its own spheres do.

use nalgebra::Vector3;

use crate::ball::{Ball, MAX_CARRIED};
use crate::groups::group;
use crate::tree::Attachment;
use crate::{RmpFlow, SetupError, TargetId};

impl RmpFlow {
    /// Replaces the spheres on the tool: centre in the target frame `id` (m), and radius (m),
    /// at least zero. Does not allocate.
    ///
    /// # Errors
    /// [`SetupError`] for more than [`MAX_CARRIED`] spheres, a number that is not
    /// finite, or an unknown frame; the tool then carries nothing.
    pub fn carry(
        &mut self,
        id: TargetId,
        spheres: &[(Vector3<f64>, f64)],
    ) -> Result<(), SetupError> {
        // First: a refused call must not leave the spheres of another object.
        self.drop_carried();
        if spheres.len() > MAX_CARRIED {
            return Err(SetupError::Length {
                what: "carried spheres (at most)",
                found: spheres.len(),
                expected: MAX_CARRIED,
            });
        }
        // All numbers before any is used: a refused call leaves the tool empty, not half full.
        let numbers = spheres.iter().flat_map(|(c, r)| [c.x, c.y, c.z, *r]);
        for value in numbers {
            if !value.is_finite() {
                let what = "a carried sphere".to_owned();
                return Err(SetupError::NotFinite { what, value });
            }
        }
        let Some(frame) = self.frame(id).map(|frame| frame.attachment.clone()) else {
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
        self.carrier = Some(id);
        group(&self.carried, &mut self.carried_groups);
        self.self_collision.carry(&self.carried);
        Ok(())
    }

    /// Removes all spheres from the tool.
    pub fn drop_carried(&mut self) {
        self.carrier = None;
        self.carried.clear();
        self.carried_groups.clear();
        self.self_collision.carry(&[]);
    }

    /// Number of spheres on the tool.
    pub fn carried_count(&self) -> usize {
        self.carried.len()
    }
}
