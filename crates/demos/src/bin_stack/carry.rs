//! What the cells of the matrix do with a bin in the hand.

use behavior::matrix::Next;
use ipc_types::Pose;

use super::columns::{ORDER, Slot};
use super::names::State;
use super::paths::{self, Route};
use super::scene::Bin;
use super::turn::Turn;
use robocell_skills::matrix::goto;
use robocell_skills::{KeptPose, pose};

/// Carrying.
impl Turn<'_, '_, '_> {
    /// What is in the hand goes to the station or onto a column.
    pub(super) fn choose_way(&mut self) -> Next {
        let Some(bin) = self.scene.held() else {
            return Next::Stay;
        };
        let cup = pose::isometry(&self.scene.tcp);
        self.memory.bin = Some(bin.object);
        self.memory.in_hand = Some(KeptPose::from(&(cup.inverse() * bin.pose)));
        self.memory.acting = None;
        self.memory.closed = true;
        self.memory.turning = self.scene.inside(&bin);
        self.job.held = Some(bin.object);
        if self.scene.on_belt(&bin) {
            self.memory.supply.picked(self.scene.setup, self.now);
        }
        if self.memory.turning {
            return self.flip(&bin);
        }
        self.place(&bin)
    }

    fn flip(&mut self, bin: &Bin) -> Next {
        let setup = self.scene.setup;
        self.out
            .log(format_args!("[decide] -> flip {}", setup.name(bin.object)));
        let station = &setup.task.station;
        let turned = paths::points_up(&self.scene.tcp);
        let before = self.in_holder(station.lift_m, station.slide_m);
        let turning = paths::turning(setup);
        let path = self.path();
        let path = if turned {
            // By hand, or before a restart: it is there already.
            path.into_holder()
        } else {
            path.lift()
                .to(turning.down)
                .into_holder()
                .by_joints(turning.up, station.up_joint_positions)
        };
        let path = path.leaning(station.up_joint_positions);
        path.slowly(before).settle();
        goto(State::Flipping)
    }

    fn place(&mut self, bin: &Bin) -> Next {
        let setup = self.scene.setup;
        let Some(slot) = self.scene.occupied().next(setup.columns.levels()) else {
            return Next::Stay;
        };
        let (i, j) = ORDER.get(slot.column).copied().unwrap_or_default();
        let name = setup.name(bin.object);
        self.out.log(format_args!(
            "[decide] -> place {name} in column ({i}, {j}), level {}",
            slot.level
        ));
        self.memory.slot = Some((slot.column, slot.level));
        let goal = self.over_slot(slot, 0.0);
        let over = Pose {
            position: [
                goal.position[0],
                goal.position[1],
                setup.task.carry_height_m,
            ],
            ..goal
        };
        self.path_from(bin)
            .lift()
            .clear_of_holder()
            .around_to(over)
            .settle();
        goto(State::Placing)
    }

    pub(super) fn over_holder(&mut self) -> Next {
        let station = self.scene.setup.task.station.clone();
        let gap = self.scene.setup.task.place_gap_m;
        let slid_in = self.in_holder(station.lift_m, 0.0);
        let down = self.in_holder(gap, 0.0);
        let wait = u64::from(station.wait_steps) * 1000 / 60;
        self.path()
            .into_holder()
            .leaning(station.up_joint_positions)
            .slowly(slid_in)
            .settle()
            .slowly(down)
            .wait(wait);
        goto(State::Detach)
    }

    pub(super) fn over_column(&mut self) -> Next {
        let Some((column, level)) = self.memory.slot else {
            return Next::Stay;
        };
        let gap = self.scene.setup.task.place_gap_m;
        let down = self.over_slot(Slot { column, level }, gap);
        self.path().slowly(down);
        goto(State::Detach)
    }

    pub(super) fn open_gripper(&mut self) -> Next {
        self.memory.closed = false;
        self.memory.acting = Some(self.now);
        self.out.log(format_args!("<open gripper>"));
        Next::Stay
    }

    pub(super) fn count_or_regrip(&mut self) -> Next {
        self.memory.acting = None;
        self.memory.stuck = 0;
        self.job.held = None;
        let bin = self.memory.bin.and_then(|bin| self.scene.bin(bin));
        let Some(bin) = bin.filter(|_| self.memory.turning) else {
            self.memory.set_down = self.memory.bin;
            return self.go_home();
        };
        self.memory.turning = false;
        self.memory.in_hand = None;
        self.out.log(format_args!(
            "[decide] -> grip {} again from its bottom",
            self.scene.setup.name(bin.object)
        ));
        let above = self.above(&bin, self.scene.setup.task.hover_m);
        self.out_of_holder().to(above);
        goto(State::Picking)
    }

    /// The cup down out of the bin, back to the arm, and turned down.
    pub(super) fn out_of_holder(&mut self) -> Route<'_> {
        let setup = self.scene.setup;
        let tcp = self.scene.tcp;
        let down = paths::pushed_down(setup, &tcp);
        let back = paths::moved_back(setup, &down);
        let turning = paths::turning(setup);
        let high = setup.task.station.position_m[2] + setup.height_m + setup.task.hover_m;
        let raised = pose::shifted(&turning.down, [0.0, 0.0, high - turning.down.position[2]]);
        let station = &setup.task.station;
        self.path()
            .into_holder()
            .leaning(station.up_joint_positions)
            .slowly(down)
            .settle()
            .to(back)
            .to(turning.up)
            .by_joints(turning.down, station.down_joint_positions)
            .to(raised)
    }

    fn in_holder(&self, height: f64, back: f64) -> Pose {
        paths::in_holder(self.scene.setup, &self.in_hand(), height, back)
    }

    fn over_slot(&self, slot: Slot, gap: f64) -> Pose {
        paths::over_slot(self.scene.setup, slot, &self.in_hand(), gap)
    }

    fn in_hand(&self) -> Pose {
        self.memory.in_hand.map_or(Pose::IDENTITY, Pose::from)
    }
}
