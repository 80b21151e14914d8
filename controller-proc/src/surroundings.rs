//! All obstacles of an arm: fixtures, other arms, objects.

use cell_model::{ArmSpec, Cell, FixtureSpec};
use ipc_types::{ArmState, ObjectState};
use nalgebra::Isometry3;
use rmp::{ObstacleId, ObstacleSet, RmpFlow, TargetId};

use crate::checkpoint::{CheckpointError, Codec};
use crate::error::RmpFlowError;
use crate::obstacle_objects::ObstacleObjects;
use crate::other_arm::OtherArm;

/// The surroundings of an arm.
pub struct Surroundings {
    fixtures: Vec<ObstacleId>,
    /// Fixtures in force, bit per fixture that is an obstacle.
    fixture_mask: u64,
    /// The solid ones among them.
    solid_mask: u64,
    others: Vec<OtherArm>,
    objects: ObstacleObjects,
}

/// The motion policies of an arm among its surroundings.
pub(crate) struct Among {
    pub(crate) flow: RmpFlow,
    /// The frame of the tool.
    pub(crate) tool: TargetId,
    pub(crate) surroundings: Surroundings,
    /// Number of places for obstacles.
    pub(crate) capacity: usize,
}

impl Among {
    /// The motion policies of arm `arm` of `cell`, which is `spec`.
    ///
    /// # Errors
    /// [`RmpFlowError`] if the robot's files contradict each other, or an obstacle is not
    /// valid.
    pub(crate) fn new(cell: &Cell, arm: usize, spec: &ArmSpec) -> Result<Self, RmpFlowError> {
        let robot = &spec.robot;
        let setup = |source| RmpFlowError::Setup {
            robot: robot.name.clone(),
            source,
        };
        let mut surroundings = Surroundings::new(cell, arm, &spec.base);
        let capacity = surroundings.obstacle_count(cell);
        let mut flow = robot.motion_policies(capacity).map_err(setup)?;
        let tool = flow
            .add_target_frame(robot.tcp_frame_name())
            .map_err(setup)?;
        surroundings.add_to(cell, &spec.base, flow.obstacles_mut())?;
        Ok(Self {
            flow,
            tool,
            surroundings,
            capacity,
        })
    }
}

impl Surroundings {
    /// The surroundings of arm `arm` of `cell`, whose base is at `base`.
    pub fn new(cell: &Cell, arm: usize, base: &Isometry3<f64>) -> Self {
        Self {
            fixtures: Vec::new(),
            fixture_mask: u64::MAX,
            solid_mask: solid_mask(cell),
            others: OtherArm::all_but(cell, arm),
            objects: ObstacleObjects::new(cell, base),
        }
    }

    /// Number of places in a set of obstacles.
    pub fn obstacle_count(&self, cell: &Cell) -> usize {
        let arms: usize = self.others.iter().map(OtherArm::part_count).sum();
        let parts = |fixture: &FixtureSpec| fixture.shape.obstacles(fixture.pose).len();
        let fixtures: usize = cell.obstacles().map(parts).sum();
        fixtures + arms + self.objects.part_count()
    }

    /// Adds everything to `set`; fixtures first, in the order of their mask.
    ///
    /// # Errors
    /// [`RmpFlowError`] with the name of the obstacle that is not valid.
    pub fn add_to(
        &mut self,
        cell: &Cell,
        base: &Isometry3<f64>,
        set: &mut ObstacleSet,
    ) -> Result<(), RmpFlowError> {
        for fixture in cell.obstacles() {
            let parts = fixture.shape.obstacles(Isometry3::identity());
            let pose = base.inverse() * fixture.pose;
            let id = set
                .add_parts(pose, &parts)
                .map_err(|source| RmpFlowError::Obstacle {
                    fixture: fixture.name.clone(),
                    source,
                })?;
            self.fixtures.push(id);
        }
        // After the fixtures, whose ids are the bits of the mask in a goal.
        for other in &mut self.others {
            other.add_to(set).map_err(|source| RmpFlowError::OtherArm {
                arm: other.name().to_owned(),
                source,
            })?;
        }
        let added = self.objects.add_to(set);
        added.map_err(|(object, source)| RmpFlowError::Object { object, source })
    }

    /// Takes the measured joints of the other arms. Their velocity is not used: a policy knows
    /// its own approach, not that of the other arm.
    pub fn observe_arms(&mut self, arms: &[ArmState], set: &mut ObstacleSet) {
        for other in &mut self.others {
            other.place(arms, set);
        }
    }

    /// Takes the poses of the objects; see [`ObstacleObjects::place`].
    pub fn observe_objects(
        &mut self,
        objects: &[ObjectState],
        mask: u64,
        held: Option<usize>,
        set: &mut ObstacleSet,
    ) {
        self.objects.place(objects, mask, held, set);
    }

    /// Fixtures that are solid, bit per fixture that is an obstacle: the others guide motion
    /// policies around something, and paths need no such guide.
    pub fn solid_mask(&self) -> u64 {
        self.solid_mask
    }

    /// Puts the fixtures of `mask` in force, and no others.
    pub fn mask_fixtures(&mut self, mask: u64, set: &mut ObstacleSet) {
        if mask != self.fixture_mask {
            self.fixture_mask = mask;
            self.apply_mask(set);
        }
    }

    fn apply_mask(&self, set: &mut ObstacleSet) {
        for (bit, id) in self.fixtures.iter().enumerate() {
            // Fixtures beyond the 64th share the last bit.
            let enabled = self.fixture_mask >> bit.min(63) & 1 == 1;
            // The id is from this set, so it is known.
            let _known = set.set_enabled(*id, enabled).is_ok();
        }
    }

    /// Writes or reads the state from cycle to cycle; objects are placed again in every cycle.
    pub(crate) fn checkpoint(
        &mut self,
        codec: &mut Codec<'_>,
        set: &mut ObstacleSet,
    ) -> Result<(), CheckpointError> {
        codec.u64(&mut self.fixture_mask)?;
        codec.same("other arms", self.others.len() as u64)?;
        codec.same("obstacle objects", self.objects.len() as u64)?;
        for other in &mut self.others {
            other.checkpoint(codec, set)?;
        }
        if codec.reads() {
            self.apply_mask(set);
        }
        Ok(())
    }
}

/// Bit 63 is the one of all fixtures from the 64th on.
fn solid_mask(cell: &Cell) -> u64 {
    let fixtures = cell.obstacles().enumerate();
    let unsolid = fixtures.filter(|(_, fixture)| !fixture.solid);
    unsolid.fold(u64::MAX, |mask, (bit, _)| mask & !(1 << bit.min(63)))
}
