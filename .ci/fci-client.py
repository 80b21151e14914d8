"""A client of the Franka control interface: fci-client.py SCENARIO [HOST]."""

import math
import sys
import time

import pylibfranka as franka

HOST = sys.argv[2] if len(sys.argv) > 2 else "127.0.0.1"
SECONDS = 10.0


def connect():
    """The robot, once its interface listens."""
    for _ in range(200):
        try:
            return franka.Robot(HOST, franka.RealtimeConfig.kIgnore)
        except franka.NetworkException:
            time.sleep(0.1)
    sys.exit("no interface within 20 s")


def smooth(part):
    return part - math.sin(2 * math.pi * part) / (2 * math.pi)


def drive(robot, start, command_at):
    """A motion of SECONDS; lost cycles and the state at its end."""
    control = start()
    state, _ = control.readOnce()
    first, passed, lost = state, 0.0, 0
    while passed < SECONDS:
        command = command_at(first, passed / SECONDS)
        control.writeOnce(command)
        state, period = control.readOnce()
        lost += round(period.to_sec() * 1000) - 1
        passed += period.to_sec()
    command.motion_finished = True
    control.writeOnce(command)
    for _ in range(50):
        state = robot.read_once()
    return first, state, lost


def modes():
    robot = connect()
    impedance = franka.ControllerMode.JointImpedance

    def position(first, part):
        q = list(first.q_d)
        q[6] += 0.1 * smooth(part)
        return franka.JointPositions(q)

    def velocity(_, part):
        return franka.JointVelocities([0] * 6 + [0.2 / SECONDS * math.sin(math.pi * part) ** 2])

    def pose(first, part):
        matrix = list(first.O_T_EE_d)
        matrix[12] += 0.05 * smooth(part)
        return franka.CartesianPose(matrix)

    def twist(_, part):
        return franka.CartesianVelocities([-0.1 / SECONDS * math.sin(math.pi * part) ** 2] + [0] * 5)

    def torque(_, __):
        return franka.Torques([0.0] * 7)

    # At rest the drives give the torques of gravity, by a model of the same masses.
    state = robot.read_once()
    gravity = robot.load_model().gravity(state)
    off = max(abs(a - b) for a, b in zip(state.tau_J, gravity, strict=True))
    assert off < 0.5, f"gravity: {off} Nm"

    starts = [
        (lambda: robot.start_joint_position_control(impedance), position, 0.1, None),
        (lambda: robot.start_joint_velocity_control(impedance), velocity, 0.1, None),
        (lambda: robot.start_cartesian_pose_control(impedance), pose, None, 0.05),
        (lambda: robot.start_cartesian_velocity_control(impedance), twist, None, -0.05),
        (robot.start_torque_control, torque, 0.0, None),
    ]
    for start, command_at, joint, moved in starts:
        first, last, lost = drive(robot, start, command_at)
        name = command_at.__name__
        assert lost == 0, f"{name}: {lost} cycles lost"
        if joint is not None:
            assert abs(last.q[6] - first.q[6] - joint) < 1e-3, f"{name}: joint 7"
        if moved is not None:
            assert abs(last.O_T_EE[12] - first.O_T_EE[12] - moved) < 1e-3, f"{name}: tool"


def rate():
    """Cycles per second of wall time, and the success rate, while joint 7 turns."""
    robot = connect()
    control = robot.start_joint_velocity_control(franka.ControllerMode.JointImpedance)
    start, passed, cycles, success = time.perf_counter(), 0.0, 0, []
    while passed < SECONDS:
        state, period = control.readOnce()
        passed += period.to_sec()
        cycles += 1
        success.append(state.control_command_success_rate)
        speed = 0.2 / SECONDS * math.sin(math.pi * min(1.0, passed / SECONDS)) ** 2
        command = franka.JointVelocities([0] * 6 + [speed])
        command.motion_finished = passed >= SECONDS
        control.writeOnce(command)
    took = time.perf_counter() - start
    # The rate counts the last hundred cycles.
    mean = sum(success[100:]) / len(success[100:])
    print(f"{cycles / took:.0f} cycles/s, success rate {mean:.3f}")


def reflex(command_at, expected):
    robot = connect()
    control = robot.start_joint_velocity_control(franka.ControllerMode.JointImpedance)
    try:
        for cycle in range(200):
            control.readOnce()
            control.writeOnce(command_at(cycle))
    except franka.ControlException as error:
        assert expected in str(error), error
        robot.automatic_error_recovery()
        return
    sys.exit("no reflex")


def step():
    reflex(
        lambda cycle: franka.JointVelocities([0] * 6 + [0.5 if cycle > 50 else 0.0]),
        "joint_motion_generator_velocity_discontinuity",
    )


def jump():
    reflex(
        lambda cycle: franka.JointVelocities([0] * 6 + [0.009 * max(0, cycle - 50)]),
        "joint_motion_generator_acceleration_discontinuity",
    )


def version():
    """Version 5, as of the Panda, is refused with the version that is served."""
    import socket
    import struct

    robot = connect()
    with socket.create_connection((HOST, 1337)) as client:
        client.sendall(struct.pack("<IIIHH", 0, 0, 16, 5, 4000))
        reply = client.recv(64)
    robot.read_once()
    assert reply[12:] == bytes([1, 10, 0]), reply


if __name__ == "__main__":
    {"modes": modes, "rate": rate, "step": step, "jump": jump, "version": version}[sys.argv[1]]()
