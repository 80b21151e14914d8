//! Frames with targets: the tool, and other frames of the robot.

use nalgebra::{DMatrix, Isometry3, Matrix3, UnitQuaternion, Vector3};

use crate::state::check_values;
use crate::tree::Attachment;
use crate::{AxisTargetParameters, RmpFlow, SetupError, TargetParameters, setup};

/// Names one target frame of an [`RmpFlow`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TargetId(usize);

/// A frame with its targets, if any.
#[derive(Debug, Clone)]
pub(crate) struct TargetFrame {
    pub(crate) attachment: Attachment,
    pub(crate) position: Option<Vector3<f64>>,
    pub(crate) orientation: Option<Matrix3<f64>>,
    pub(crate) target: TargetParameters,
    pub(crate) axis_target: AxisTargetParameters,
}

impl RmpFlow {
    /// Adds a frame that can be given targets, with the gains of the tuning. Its drag and
    /// inertia act at once.
    ///
    /// # Errors
    /// [`SetupError::UnknownFrame`].
    pub fn add_target_frame(&mut self, name: &str) -> Result<TargetId, SetupError> {
        let tree = &self.kinematics.tree;
        let attachment = setup::attach(&self.chain, tree, name, "as target frame")?;
        self.targets.push(Some(TargetFrame {
            attachment,
            position: None,
            orientation: None,
            target: self.parameters.target,
            axis_target: self.parameters.axis_target,
        }));
        Ok(TargetId(self.targets.len() - 1))
    }

    /// Removes a target frame: its targets, drag and inertia. Spheres that it carries are
    /// dropped. Returns whether it existed; its id is not given to another frame.
    pub fn remove_target_frame(&mut self, id: TargetId) -> bool {
        let removed = self.targets.get_mut(id.0).and_then(Option::take).is_some();
        if removed && self.carrier == Some(id) {
            self.drop_carried();
        }
        removed
    }

    /// Sets or clears the position target of a frame, m in the base frame. A frame that was
    /// removed has none.
    ///
    /// # Errors
    /// [`SetupError::NotFinite`]; nothing is changed.
    pub fn set_position_target(
        &mut self,
        id: TargetId,
        position: Option<Vector3<f64>>,
    ) -> Result<(), SetupError> {
        if let Some(position) = &position {
            check_values("position target", position.as_slice(), 3)?;
        }
        if let Some(frame) = self.frame_mut(id) {
            frame.position = position;
        }
        Ok(())
    }

    /// Sets or clears the orientation target of a frame, in the base frame. A frame that was
    /// removed has none.
    ///
    /// # Errors
    /// [`SetupError::NotFinite`]; nothing is changed.
    pub fn set_orientation_target(
        &mut self,
        id: TargetId,
        orientation: Option<UnitQuaternion<f64>>,
    ) -> Result<(), SetupError> {
        if let Some(orientation) = &orientation {
            check_values("orientation target", orientation.coords.as_slice(), 4)?;
        }
        if let Some(frame) = self.frame_mut(id) {
            frame.orientation = orientation.map(|o| o.to_rotation_matrix().into_inner());
        }
        Ok(())
    }

    /// Sets separate gains of a frame, for its position target and its orientation target.
    /// Allocates nothing.
    ///
    /// # Errors
    /// [`SetupError`] for a value that is not allowed; nothing is changed.
    pub fn set_target_gains(
        &mut self,
        id: TargetId,
        target: TargetParameters,
        axis_target: AxisTargetParameters,
    ) -> Result<(), SetupError> {
        // The range checks are those of a whole tuning; the tuning itself is put back.
        let of_tuning = (self.parameters.target, self.parameters.axis_target);
        (self.parameters.target, self.parameters.axis_target) = (target, axis_target);
        let valid = self.parameters.validate();
        (self.parameters.target, self.parameters.axis_target) = of_tuning;
        valid?;
        if let Some(frame) = self.frame_mut(id) {
            (frame.target, frame.axis_target) = (target, axis_target);
        }
        Ok(())
    }

    /// Pose of a target frame at the last evaluation, base frame.
    pub fn target_frame_pose(&self, id: TargetId) -> Option<Isometry3<f64>> {
        let frame = self.frame(id)?;
        Some(self.kinematics.pose(&frame.attachment))
    }

    /// Pose of a target frame at joint positions `q`, base frame. The kinematics stay at `q`
    /// until the next evaluation.
    ///
    /// # Errors
    /// [`SetupError::Length`] or [`SetupError::NotFinite`].
    pub fn target_frame_pose_at(
        &mut self,
        id: TargetId,
        q: &[f64],
    ) -> Result<Option<Isometry3<f64>>, SetupError> {
        check_values("joint positions", q, self.joint_count())?;
        // Velocities are zero: poses do not need them.
        self.scratch.fill(0.0);
        self.kinematics.update(q, &self.scratch);
        Ok(self.target_frame_pose(id))
    }

    /// Writes the 6 x N Jacobian of a target frame's origin at the last
    /// evaluation: rows linear then angular, base frame. `out` must be 6 x N.
    ///
    /// # Errors
    /// [`SetupError::Length`] when `out` has another size.
    pub fn target_frame_jacobian(
        &self,
        id: TargetId,
        out: &mut DMatrix<f64>,
    ) -> Result<(), SetupError> {
        if out.shape() != (6, self.joint_count()) {
            return Err(SetupError::Length {
                what: "Jacobian (6 rows, one column a joint)",
                found: out.ncols(),
                expected: self.joint_count(),
            });
        }
        if let Some(frame) = self.frame(id) {
            self.kinematics.jacobian(&frame.attachment, out);
        }
        Ok(())
    }

    pub(crate) fn frame(&self, id: TargetId) -> Option<&TargetFrame> {
        self.targets.get(id.0)?.as_ref()
    }

    fn frame_mut(&mut self, id: TargetId) -> Option<&mut TargetFrame> {
        self.targets.get_mut(id.0)?.as_mut()
    }
}
