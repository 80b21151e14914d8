//! Where the arm is sent in each substep.

use nalgebra::{Isometry3, Translation3, Vector3};

use super::JOINTS;
use super::geometry;
use super::memory::{Motion, Work, WorkKind};
use super::scene::View;
use super::setup::PalletizeSetup;
use super::steps::Step;
use robocell_skills::KeptPose;

/// Over the rest pose.
pub(super) fn home(setup: &PalletizeSetup) -> Motion {
    let numbers = &setup.numbers.home;
    Motion {
        target: KeptPose::from(&setup.home),
        posture: joints(&setup.home_joints),
        by_joints: false,
        approach: numbers.approach_m,
        std_dev: numbers.std_dev_m,
    }
}

/// To the rest pose from anywhere, also with the tool pointing up.
pub(super) fn home_by_joints(setup: &PalletizeSetup) -> Motion {
    Motion {
        by_joints: true,
        ..home(setup)
    }
}

/// Where `step` sends the arm; `None` where it goes on with what it does.
pub(super) fn motion(
    setup: &PalletizeSetup,
    scene: &View<'_>,
    work: &Work,
    step: Step,
) -> Option<Motion> {
    match step {
        Step::ReachToPick => pick(setup, scene, work),
        Step::TimedLift | Step::LiftToClearance => {
            Some(lift(setup, work, height(setup, scene, work)))
        }
        Step::OrientToHome if is_by_joints(work) => Some(home_by_joints(setup)),
        Step::OrientToHome => Some(home(setup)),
        Step::SwingOut => Some(swing_out(setup, work)),
        Step::MoveToFlipStation => Some(flip(setup)),
        Step::ReleaseFlipStationBin => Some(release(setup, work)),
        Step::LeaveFlipStation => Some(leave(setup, work)),
        Step::ReachToPlace => Some(place(setup, work)),
        _ => None,
    }
}

/// Whether the rest pose is reached joint by joint: from the jig the tool points
/// up, and where the straight way failed the arm may be wound up.
fn is_by_joints(work: &Work) -> bool {
    match work.kind {
        WorkKind::Flip => work.step > 0,
        WorkKind::PlaceFromHome => work.step == 0,
        _ => false,
    }
}

/// To the bin, wherever it is by now.
fn pick(setup: &PalletizeSetup, scene: &View<'_>, work: &Work) -> Option<Motion> {
    let numbers = &setup.numbers.pick;
    let shape = &setup.bins.get(work.bin)?.shape;
    let bin = scene.bin(work.bin)?;
    let (gap, tool) = (numbers.gap_m, &scene.tool.rotation);
    let target = geometry::grasp(&bin.pose, shape, gap, tool, &setup.flip.rotation)?;
    let length = if work.kind == WorkKind::PickFlipped {
        numbers.flip_approach_m
    } else {
        numbers.approach_m
    };
    Some(Motion {
        target: KeptPose::from(&target),
        posture: numbers.posture,
        by_joints: false,
        approach: (target.rotation * Vector3::x() * length).into(),
        std_dev: numbers.std_dev_m,
    })
}

/// Height of the target of a lift (m). With a bin on the cup it stays a little
/// ahead of the tool: near its target the tool keeps its orientation, far from
/// it the bin would swing.
fn height(setup: &PalletizeSetup, scene: &View<'_>, work: &Work) -> f64 {
    let numbers = &setup.numbers.pick;
    let whole = match work.kind {
        WorkKind::Pick => numbers.lift_m,
        WorkKind::PickFlipped => numbers.flip_lift_m,
        _ => return setup.numbers.place.lift_m,
    };
    let lifted = scene.tool.translation.z - work.base.isometry().translation.z;
    (lifted.max(0.0) + numbers.lift_lead_m).min(whole)
}

/// Straight up by `height` from where the step began.
fn lift(setup: &PalletizeSetup, work: &Work, height: f64) -> Motion {
    let picks = matches!(work.kind, WorkKind::Pick | WorkKind::PickFlipped);
    let mut target = work.base.isometry();
    target.translation.vector.z += height;
    Motion {
        target: KeptPose::from(&target),
        posture: if picks {
            setup.numbers.pick.posture
        } else {
            joints(&setup.home_joints)
        },
        by_joints: false,
        approach: [0.0; 3],
        std_dev: 0.0,
    }
}

/// Half way around the base, turned already as it will be at the place.
fn swing_out(setup: &PalletizeSetup, work: &Work) -> Motion {
    let turn = work.base.isometry().rotation;
    let at = Translation3::from(setup.numbers.place.swing_m);
    let target = Isometry3::from_parts(at, turn);
    Motion {
        target: KeptPose::from(&target),
        posture: joints(&setup.home_joints),
        by_joints: false,
        approach: [0.0; 3],
        std_dev: 0.0,
    }
}

fn flip(setup: &PalletizeSetup) -> Motion {
    let numbers = &setup.numbers.flip;
    Motion {
        target: KeptPose::from(&setup.flip),
        posture: numbers.posture,
        by_joints: false,
        approach: numbers.approach_m,
        std_dev: numbers.std_dev_m,
    }
}

/// Back along the tool and aside, on a straight line.
fn release(setup: &PalletizeSetup, work: &Work) -> Motion {
    let numbers = &setup.numbers.flip;
    let back = setup.flip.rotation * Vector3::x() * -numbers.retreat_m;
    let way = back + Vector3::from(numbers.retreat_aside_m);
    let target = Isometry3::from_parts(
        Translation3::from(setup.flip.translation.vector + way),
        setup.flip.rotation,
    );
    Motion {
        target: KeptPose::from(&target),
        posture: work.joints,
        by_joints: false,
        approach: way.into(),
        std_dev: numbers.retreat_std_dev_m,
    }
}

/// Beside the jig and up.
fn leave(setup: &PalletizeSetup, work: &Work) -> Motion {
    let at = Translation3::from(setup.numbers.flip.leave_m);
    Motion {
        target: KeptPose::from(&Isometry3::from_parts(at, setup.flip.rotation)),
        posture: work.joints,
        by_joints: false,
        approach: [0.0; 3],
        std_dev: 0.0,
    }
}

/// To the place, and as far beside it as the bin has crept.
fn place(setup: &PalletizeSetup, work: &Work) -> Motion {
    let numbers = &setup.numbers.place;
    let mut target = work.base.isometry();
    let [x, y] = work.creep;
    target.translation.vector += Vector3::new(x, y, numbers.gap_m);
    Motion {
        target: KeptPose::from(&target),
        posture: joints(&setup.home_joints),
        by_joints: false,
        approach: [0.0, 0.0, -numbers.approach_m],
        std_dev: numbers.std_dev_m,
    }
}

/// Those of the arm: what a message has room for, or a model besides, is not asked.
pub(super) fn joints(all: &[f64]) -> [f64; JOINTS] {
    let mut six = [0.0; JOINTS];
    for (slot, joint) in six.iter_mut().zip(all) {
        *slot = *joint;
    }
    six
}
