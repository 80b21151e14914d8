"""A client of the arm and of the hand: fci-hand.py grip X Y Z | next. The first one ends by
SIGKILL while it carries the object at X Y Z (m); the other one opens a connection after it."""

import os
import signal
import sys
import time

from franky import Affine, CartesianMotion, Gripper, JointMotion, RealtimeConfig, Robot

HOST = "127.0.0.1"
# The hand points down here, and no joint is near a singular position.
READY = [0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398]

robot = Robot(HOST, realtime_config=RealtimeConfig.Ignore)
robot.relative_dynamics_factor = 0.1
hand = Gripper(HOST)


def tool():
    return robot.current_cartesian_state.pose.end_effector_pose


def grip(x, y, z):
    robot.move(JointMotion(READY))
    hand.open(0.1)
    turned = tool().quaternion

    def to(height, **more):
        robot.move(CartesianMotion(Affine([x, y, height], turned)), **more)

    to(z + 0.12)
    to(z)
    assert hand.grasp(0.05, 0.05, 30, epsilon_inner=0.02, epsilon_outer=0.03), hand.width
    assert hand.is_grasped and 0.045 < hand.width < 0.075, hand.width
    to(z + 0.1)
    to(z + 0.2, asynchronous=True)
    time.sleep(0.3)
    os.kill(os.getpid(), signal.SIGKILL)


def following():
    before = tool().translation[2]
    assert 0.045 < hand.width < 0.075, hand.width
    robot.move(JointMotion([*robot.current_joint_positions[:6], READY[6] + 0.2]))
    assert abs(tool().translation[2] - before) < 1e-3


if sys.argv[1] == "grip":
    grip(*(float(word) for word in sys.argv[2:]))
else:
    following()
