//! What other tools are told of the robot in a recording.

use std::collections::BTreeMap;

use cell_record::{Channel, Recording};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use robocell_tests::cell::base;
use robocell_tests::program::{finish, robocell};
use serde_json::Value;

/// Numbers of `/tf` have six decimals, and a pose is the product of ten of them.
const NEAR_M: f64 = 5.0e-5;
const NEAR_RAD: f64 = 5.0e-5;

/// Parent and pose of each frame.
type Frames = BTreeMap<String, (String, Isometry3<f64>)>;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn pose(transform: &Value) -> Isometry3<f64> {
    let (t, q) = (&transform["translation"], &transform["rotation"]);
    let turn = Quaternion::new(
        number(&q["w"]),
        number(&q["x"]),
        number(&q["y"]),
        number(&q["z"]),
    );
    Isometry3::from_parts(
        Translation3::new(number(&t["x"]), number(&t["y"]), number(&t["z"])),
        UnitQuaternion::from_quaternion(turn),
    )
}

/// Takes the transforms of a message.
fn take(frames: &mut Frames, message: &[u8]) {
    let said: Value = serde_json::from_slice(message).expect("JSON");
    for transform in said["transforms"].as_array().expect("transforms") {
        let text = |key: &str| transform[key].as_str().expect("a frame").to_owned();
        let of = (text("parent_frame_id"), pose(transform));
        frames.insert(text("child_frame_id"), of);
    }
}

/// Pose of a frame in the world, along its parents.
fn in_world(frames: &Frames, name: &str) -> Isometry3<f64> {
    let (mut pose, mut at) = (Isometry3::identity(), name);
    while at != "world" {
        let (parent, step) = frames.get(at).unwrap_or_else(|| panic!("no frame {at}"));
        pose = step * pose;
        at = parent;
    }
    pose
}

/// The tool in the link that carries it, out of the scene.
fn tool(scene: &Value) -> (String, Isometry3<f64>) {
    let arm = &scene["arms"][0];
    let at = |index: usize| number(&arm["tool"][index]);
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(at(3), at(4), at(5), at(6)));
    let link = arm["tool_link"].as_str().expect("a link");
    let name = arm["name"].as_str().expect("a name");
    let pose = Isometry3::from_parts(Translation3::new(at(0), at(1), at(2)), turn);
    (format!("{name}/{link}"), pose)
}

#[test]
fn the_links_lead_to_the_tool_that_physics_measured() {
    let base = base();
    let file = base.path().join("run.mcap");
    let name = file.display().to_string();
    let mut arguments = vec!["run", "franka-stack", "--headless", "--timeout", "3"];
    arguments.extend(["--speed", "max", "--record", &name]);
    let said = finish(robocell(base.path(), &arguments));
    assert_eq!(said.code, 5, "out of time: {said:?}");
    let recording = Recording::open(&file).expect("a recording");
    let (link, tool) = tool(recording.scene());
    let (mut frames, mut compared, mut farthest) = (Frames::new(), 0, 0.0_f64);
    let mut scene = None;
    let mut tracked = 0;
    for entry in recording.messages() {
        let entry = entry.expect("a message");
        match entry.channel {
            Channel::Transforms => take(&mut frames, &entry.bytes),
            Channel::SceneUpdate => scene = serde_json::from_slice::<Value>(&entry.bytes).ok(),
            Channel::Tracking(0) => tracked += 1,
            _ => {}
        }
        // Frames that do not move are told of once a second.
        if entry.channel != Channel::Transforms || !frames.contains_key("panda/base_link") {
            continue;
        }
        let measured = in_world(&frames, "panda/tcp");
        let computed = in_world(&frames, &link) * tool;
        let apart = (measured.translation.vector - computed.translation.vector).norm();
        let turned = measured.rotation.angle_to(&computed.rotation);
        assert!(
            apart < NEAR_M && turned < NEAR_RAD,
            "{apart} m, {turned} rad at {} s",
            entry.time_s()
        );
        let home = frames["panda/panda_link1"].1.rotation.angle();
        farthest = farthest.max(home.abs());
        compared += 1;
    }
    assert!(compared > 50 && tracked > 50, "{compared}, {tracked}");
    assert!(farthest > 0.05, "the arm moved: {farthest}");

    let scene = scene.expect("a scene");
    let entities = scene["entities"].as_array().expect("entities");
    let hand = entities.iter().find(|one| one["id"] == "panda/panda_link5");
    let hand = hand.expect("a link");
    assert_eq!(hand["frame_id"], "panda/panda_link5");
    let solids = ["cubes", "spheres", "cylinders"].map(|kind| {
        let list = hand[kind].as_array();
        list.map_or(0, Vec::len)
    });
    assert!(solids.iter().sum::<usize>() > 0, "{hand}");
    for entity in entities {
        let frame = entity["frame_id"].as_str().expect("a frame");
        assert!(frame == "world" || frames.contains_key(frame), "{frame}");
    }
}

#[test]
fn the_layout_for_foxglove_shows_channels_that_are_recorded() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/foxglove-layout.json");
    let text = std::fs::read_to_string(path).expect("the layout");
    let layout: Value = serde_json::from_str(&text).expect("JSON");
    let panels = layout["configById"].as_object().expect("panels");
    let mut topics = Vec::new();
    for panel in panels.values() {
        let paths = panel["paths"].as_array().into_iter().flatten();
        topics.extend(paths.filter_map(|path| path["value"].as_str()));
        topics.extend(panel["topicToRender"].as_str());
        let shown = panel["topics"].as_object().into_iter().flatten();
        topics.extend(shown.map(|(topic, _)| topic.as_str()));
    }
    assert!(topics.len() > 14, "{topics:?}");
    let names: Vec<String> = Channel::all(1).into_iter().map(Channel::name).collect();
    for topic in topics {
        let topic = topic.split('.').next().unwrap_or_default();
        assert!(names.iter().any(|name| name == topic), "{topic}");
    }
}
