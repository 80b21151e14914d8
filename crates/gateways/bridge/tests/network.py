"""The bridge, seen from another network namespace; `.ci/bridge-network` makes both.

This runs in the namespace of the viewer, and starts the cell in the other one. Messages are
decoded by rosbags and by mcap-ros2-support, and travel by eclipse-zenoh.
"""

import argparse
import json
import math
import os
import pathlib
import secrets
import subprocess
import sys
import time
import traceback
import urllib.request

import zenoh
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_typestore
from websockets.sync.client import connect

CELL_HOST = "10.77.0.1"
VIEW = f"tcp/{CELL_HOST}:7447"
CONTROL = f"tcp/{CELL_HOST}:7448"
ROS = get_typestore(Stores.ROS2_JAZZY)
# rosbags knows no services; this is the published hash.
TRIGGER = "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"
TOLERANCE_M = 0.005

parser = argparse.ArgumentParser()
parser.add_argument("--programs", type=pathlib.Path, required=True)
parser.add_argument("--bridge", type=pathlib.Path, required=True)
parser.add_argument("--cell-namespace", required=True)
parser.add_argument("--kills", type=int, default=50)
args = parser.parse_args()
robocell = args.programs / "robocell"


def in_cell_namespace(*command, **how):
    space = ["ip", "netns", "exec", args.cell_namespace]
    return subprocess.Popen([*space, *map(str, command)], **how)


def ask(*command):
    """What robocell answers; the run directory is the same for both namespaces."""
    return subprocess.run([robocell, *command], capture_output=True, text=True, check=True).stdout


def status():
    return json.loads(ask("status", "--json"))


def cycles():
    """Generation and missed cycles of the processes in the control loop."""
    return {
        p["name"]: (p["generation"], p["missed_cycles"])
        for p in status()["processes"]
        if p["name"] == "physics" or p["name"].startswith("controller")
    }


def generations(of):
    return {name: generation for name, (generation, _) in of.items()}


def missed(before, after):
    return {name: after[name][1] - before[name][1] for name in after}


def told(what, detail=""):
    print(f"ok: {what} {detail}".rstrip(), flush=True)


class Bridge:
    """The bridge as a process, with its log."""

    def __init__(self, *options):
        self.path = pathlib.Path("bridge.log")
        with self.path.open("w") as log:
            self.process = in_cell_namespace(args.bridge, "--listen", VIEW, *options, stderr=log)
        self.wait_for("joined cell")

    def log(self):
        return self.path.read_text()

    def wait_for(self, text, timeout_s=10):
        until = time.monotonic() + timeout_s
        while text not in self.log():
            assert time.monotonic() < until, f"no {text!r} in the log:\n{self.log()}"
            assert self.process.poll() is None, f"the bridge has ended:\n{self.log()}"
            time.sleep(0.02)

    def kill(self):
        # `ip netns exec` becomes the program: it is the process itself.
        self.process.kill()
        self.process.wait()


def session(endpoint, token=None):
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("connect/timeout_ms", "3000")
    config.insert_json5("scouting/multicast/enabled", "false")
    if token:
        config.insert_json5("transport/auth/usrpwd/user", '"control"')
        config.insert_json5("transport/auth/usrpwd/password", json.dumps(token))
    return zenoh.open(config)


def type_of(key):
    """ROS name of the type in a key, and its hash."""
    dds, digest = key.split("/")[-2:]
    return dds.replace("::dds_::", "::").rstrip("_").replace("::", "/"), digest


class Reader:
    """Keeps what arrives on all topics."""

    def __init__(self, of):
        self.messages = {}
        self.subscriber = of.declare_subscriber("0/**", self.take)

    def take(self, sample):
        now_ns = time.time_ns()
        attached = sample.attachment.to_bytes()
        source_ns = int.from_bytes(attached[8:16], "little", signed=True)
        topic = "/" + str(sample.key_expr).split("/", 1)[1].rsplit("/", 2)[0]
        age_ms = (now_ns - source_ns) * 1e-6
        message = (now_ns, age_ms, str(sample.key_expr), sample.payload.to_bytes())
        self.messages.setdefault(topic, []).append(message)

    def newest(self, topic, timeout_s=5):
        """The next message of a topic, decoded."""
        seen = len(self.messages.get(topic, []))
        until = time.monotonic() + timeout_s
        while len(self.messages.get(topic, [])) <= seen:
            assert time.monotonic() < until, f"nothing on {topic}"
            time.sleep(0.005)
        _, _, key, payload = self.messages[topic][-1]
        return ROS.deserialize_cdr(payload, type_of(key)[0])

    def clock(self):
        return self.newest("/clock").clock

    def arm(self):
        return json.loads(self.newest("/robocell/state").data)["arms"][0]

    def distance_m(self, position):
        """Of the tool from a position."""
        return math.dist(self.arm()["tcp"], position)


def attachment(sequence):
    numbers = sequence.to_bytes(8, "little") + time.time_ns().to_bytes(8, "little")
    return numbers + b"\x10" + bytes(range(16))


def key_of(topic, message_type):
    package, kind, name = message_type.split("/")
    digest = TRIGGER if kind == "srv" else ROS.hash_rihs01(message_type)
    return f"0{topic}/{package}::{kind}::dds_::{name}_/{digest}"


def send_target(by, position, stamp):
    types = ROS.types
    time_type, header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    pose, point = types["geometry_msgs/msg/Pose"], types["geometry_msgs/msg/Point"]
    turn, stamped = types["geometry_msgs/msg/Quaternion"], types["geometry_msgs/msg/PoseStamped"]
    message = stamped(
        header(stamp=time_type(stamp.sec, stamp.nanosec), frame_id="world"),
        # The tool points down.
        pose(point(*position), turn(1.0, 0.0, 0.0, 0.0)),
    )
    payload = ROS.serialize_cdr(message, "geometry_msgs/msg/PoseStamped")
    key = key_of("/target_pose", "geometry_msgs/msg/PoseStamped")
    by.put(key, bytes(payload), attachment=attachment(1))


def call(by, service):
    """Calls a service of type Trigger; success and message."""
    key = key_of(service, "std_srvs/srv/Trigger")
    request = b"\x00\x01\x00\x00\x00"
    for answer in by.get(key, payload=request, attachment=attachment(7), timeout=5):
        reply = answer.ok
        sequence = int.from_bytes(reply.attachment.to_bytes()[:8], "little")
        assert sequence == 7, "the answer names its request"
        payload = reply.payload.to_bytes()
        length = int.from_bytes(payload[8:12], "little")
        return bool(payload[4]), payload[12 : 12 + length - 1].decode()
    raise AssertionError(f"no answer of {service}")


def moves_to(reader, position, timeout_s=20):
    """Waits until the tool is there and at rest; its distance (m)."""
    until = time.monotonic() + timeout_s
    while reader.distance_m(position) > TOLERANCE_M:
        assert time.monotonic() < until, f"the tool is at {reader.arm()['tcp']}, not at {position}"
    time.sleep(1)
    distance_m = reader.distance_m(position)
    assert distance_m < TOLERANCE_M, f"{distance_m} m away from {position}"
    return distance_m


def rates_and_ages(reader, seconds=10.0, rate_hz=100.0):
    reader.newest("/joint_states")
    reader.messages.clear()
    time.sleep(seconds)
    joints = reader.messages["/joint_states"]
    # The time between the first and the last message.
    rate = (len(joints) - 1) / ((joints[-1][0] - joints[0][0]) * 1e-9)
    ages = sorted(age for _, age, _, _ in joints)
    p50, p99 = ages[len(ages) // 2], ages[int(0.99 * len(ages))]
    assert rate >= 0.95 * rate_hz, f"/joint_states arrives at {rate} 1/s"
    told("/joint_states arrives", f"{rate:.1f} 1/s, age p50 {p50:.2f} ms, p99 {p99:.2f} ms")


def two_libraries_and_hashes(reader):
    reader.newest("/robocell/markers")
    for topic in ["/joint_states", "/tf", "/clock", "/robocell/markers", "/robocell/state"]:
        _, _, key, payload = reader.messages[topic][-1]
        name, digest = type_of(key)
        assert digest == ROS.hash_rihs01(name), f"hash of {name}"
        one = ROS.deserialize_cdr(payload, name)
        text, _ = ROS.generate_msgdef(name, ros_version=2)
        schema = Schema(id=1, name=name, encoding="ros2msg", data=text.encode())
        other = DecoderFactory().decoder_for("cdr", schema)(payload)
        if topic == "/joint_states":
            assert list(one.name) == list(other.name) and len(one.name) == 9, one.name
            assert list(one.position) == list(other.position)
        elif topic == "/tf":
            frames = [t.child_frame_id for t in one.transforms]
            assert frames == [t.child_frame_id for t in other.transforms]
            assert "panda_hand" in frames, frames
        elif topic == "/robocell/markers":
            scales = [m.scale.x for m in one.markers]
            assert scales and scales == [m.scale.x for m in other.markers]
    told("decoded by rosbags and mcap-ros2-support, with the published type hashes")


def announced(by):
    tokens = [str(reply.ok.key_expr) for reply in by.liveliness().get("@ros2_lv/0/**")]
    kinds = [token.split("/")[5] for token in tokens]
    found = {kind: kinds.count(kind) for kind in kinds}
    assert found == {"NN": 1, "MP": 6, "MS": 1, "SS": 6}, tokens
    told("liveliness tokens announce", str(found))


def refused_without_control():
    bridge = Bridge()
    by = session(VIEW)
    reader = Reader(by)
    before = reader.arm()["tcp"]
    send_target(by, (0.4, 0.2, 0.5), reader.clock())
    bridge.wait_for("/target_pose: refused: the bridge was started without --control")
    success, message = call(by, "/gripper/close")
    assert not success and "--control" in message, message
    time.sleep(1)
    assert reader.distance_m(before) < 1e-3, "the tool moved"
    by.close()
    bridge.kill()
    told("without --control a target and a service are refused and logged")


def only_with_the_token(bridge, token):
    for wrong in ["0" * 32, None]:
        try:
            session(CONTROL, wrong)
        except zenoh.ZError:
            continue
        raise AssertionError("a client without the token was let in")
    viewer = session(VIEW)
    send_target(viewer, (0.4, 0.2, 0.5), Reader(viewer).clock())
    bridge.wait_for("/target_pose: refused: commands are accepted at the endpoint")
    viewer.close()
    told("clients without the token are not let in, and viewers are refused")
    return session(CONTROL, token)


def commands(hand, reader):
    for position in [(0.45, 0.2, 0.45), (0.5, -0.15, 0.35)]:
        send_target(hand, position, reader.clock())
        distance_m = moves_to(reader, position)
        told("a pose target moves the tool", f"to within {1e3 * distance_m:.2f} mm")
    success, message = call(hand, "/gripper/close")
    assert success, message
    until = time.monotonic() + 10
    while reader.arm()["gripper_width_m"] > 1e-3:
        assert time.monotonic() < until, "the gripper does not close"
    told("/gripper/close closes the gripper")


def link_cut(hand, reader, bridge, seconds=5):
    """Targets are sent all the while; those that the network held back are not followed."""
    at_rest = (0.5, -0.15, 0.35)
    earlier = cycles()
    time.sleep(seconds)
    before = cycles()
    stamp = reader.clock()
    subprocess.run(["ip", "link", "set", "veth-v", "down"], check=True)
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        send_target(hand, (0.45, 0.25, 0.5), stamp)
        time.sleep(0.1)
    subprocess.run(["ip", "link", "set", "veth-v", "up"], check=True)
    after = cycles()
    assert generations(after) == generations(before), "a process was restarted"
    quiet, cut = missed(earlier, before), missed(before, after)
    # The same time without a cut is the measure; noise of the machine is allowed for.
    assert all(cut[name] <= 2 * quiet[name] + 20 for name in cut), f"{cut}, without cut {quiet}"
    until = time.monotonic() + 40
    while True:
        try:
            reader.newest("/joint_states", timeout_s=1)
            break
        except AssertionError:
            assert time.monotonic() < until, "no message after the cut"
    time.sleep(2)
    distance_m = reader.distance_m(at_rest)
    assert distance_m < TOLERANCE_M, f"a stale target was followed: {distance_m} m away"
    stale = bridge.log().count("s old by the clock")
    told(f"link cut for {seconds} s:", f"missed {cut} ({quiet} in as long before),")
    told("stale targets are not followed:", f"{stale} refused")
    position = (0.45, 0.1, 0.45)
    send_target(hand, position, reader.clock())
    moves_to(reader, position)
    told("the next target is followed")


def viewer_page(link):
    """The page and its messages, by the link of a viewer."""
    address, token = link.removeprefix("http://").split("/?token=")
    headers = {"Authorization": f"Bearer {token}"}
    with connect(f"ws://{address}/ws", additional_headers=headers) as page:
        page.send(json.dumps({"id": 1, "do": "pause"}))
        until = time.monotonic() + 10
        while True:
            assert time.monotonic() < until, "no answer to a command"
            message = page.recv(timeout=10)
            answer = json.loads(message) if isinstance(message, str) else {}
            if answer.get("t") == "ack":
                break
    assert not answer["ok"] and not status()["paused"], answer
    browser = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    with browser.open(link) as page:
        assert page.status == 200
    told("page:", f"a viewer is told {answer['message']!r}")


def bridge_killed(options, count):
    before, tick, began = cycles(), status()["tick"], time.monotonic()
    for _ in range(count):
        bridge = Bridge(*options)
        time.sleep(0.1)
        bridge.kill()
    rate = (status()["tick"] - tick) / (time.monotonic() - began)
    after = cycles()
    assert generations(after) == generations(before), "a process was restarted"
    assert rate > 900, f"{rate} ticks per second"
    detail = f"{rate:.0f} ticks/s, missed cycles {missed(before, after)}"
    told(f"bridge killed {count} times:", detail)
    bridge, by = Bridge(*options), session(VIEW)
    Reader(by).newest("/joint_states")
    by.close()
    bridge.kill()
    told("a new one serves")


def main():
    token, token_file = secrets.token_hex(24), pathlib.Path("token").absolute()
    token_file.touch(mode=0o600)
    token_file.write_text(token)
    options = ["--control", token_file, "--control-listen", CONTROL]
    run = [robocell, "run", "reach", "--listen", f"{CELL_HOST}:8600"]
    cell = in_cell_namespace(*run, stdout=subprocess.DEVNULL)
    until = time.monotonic() + 20
    while subprocess.run([robocell, "status"], capture_output=True).returncode:
        assert time.monotonic() < until and cell.poll() is None, "the cell does not start"
        time.sleep(0.1)
    secrets_file = pathlib.Path(os.environ["ROBOCELL_RUN_DIR"]) / "cell/page.json"
    of_page = json.loads(secrets_file.read_text())
    page = f"http://{CELL_HOST}:8600/?token="
    viewer_page(page + of_page["viewer_token"])
    refused_without_control()
    bridge, viewer = Bridge(*options), session(VIEW)
    reader = Reader(viewer)
    rates_and_ages(reader)
    two_libraries_and_hashes(reader)
    announced(viewer)
    viewer.close()
    hand = only_with_the_token(bridge, token)
    reader = Reader(hand)
    commands(hand, reader)
    link_cut(hand, reader, bridge)
    hand.close()
    bridge.kill()
    bridge_killed(options, args.kills)
    ask("down")
    cell.wait()


try:
    main()
except BaseException:
    traceback.print_exc()
    sys.stdout.flush()
    # Threads of zenoh, and the cell, would keep this process.
    os._exit(1)
