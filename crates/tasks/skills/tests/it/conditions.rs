//! The conditions, as trees and files ask for them.

use std::sync::Arc;

use behavior::Status;
use cell_model::{Cell, Data};
use ipc_types::Pose;
use robocell_skills::settings::Pattern;
use robocell_skills::{PlaceTable, Setup, nodes};
use serde_json::{Value as Json, json};

use crate::bench::{Bench, LEFT, RIGHT};

/// Centre of an object in the first slot of the place `shelf`; the second is 0.1 m along y.
pub(crate) const SLOT: [f64; 3] = [0.4, -0.7, 0.025];

/// A tree of that node for the left arm of a cell of two arms, six cubes and `shelf`.
pub(crate) fn bench(node: &Json) -> Bench {
    let cell = Cell::load(&Data::checkout(), "franka-pyramid", 1, None).unwrap();
    let mut setup = Setup::new(&cell, []);
    let shelf = PlaceTable {
        position_m: [SLOT[0], SLOT[1], 0.0],
        yaw_rad: 0.0,
        pattern: Some(Pattern::Grid {
            count: [1, 2, 1],
            pitch_m: [0.1; 3],
            order: None,
        }),
    };
    setup.add_place("shelf", &shelf);
    let setup = Arc::new(setup);
    let mut node = node.clone();
    node["id"] = "node".into();
    let file = json!({"format": "behavior-tree/1", "name": "bench", "root": node});
    let library = nodes::library(&setup);
    Bench::of((&cell, setup), &library, LEFT, &file)
}

/// Whether the condition about the first cube holds once `arrange` has changed the cell.
fn holds(name: &str, mut ports: Json, arrange: impl FnOnce(&mut Bench)) -> bool {
    ports["object"] = "cube_1".into();
    asked(name, &ports, arrange)
}

fn asked(name: &str, ports: &Json, arrange: impl FnOnce(&mut Bench)) -> bool {
    let mut bench = bench(&json!({"type": name, "ports": ports}));
    // Away from the others.
    *bench.object(0) = [0.5, -0.3, 0.025];
    arrange(&mut bench);
    let answer = bench.tick();
    assert!(bench.holds_still(), "a condition moves nothing");
    assert_ne!(answer, Status::Running);
    answer == Status::Success
}

/// A turn about the x axis (rad).
fn tilt(bench: &mut Bench, angle: f64) {
    let (sin, cos) = (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
    bench.state.objects[0].pose.orientation_wxyz = [cos, sin, 0.0, 0.0];
}

#[test]
fn upright_means_that_the_top_is_up() {
    let upright = |angle| holds("Upright", json!({}), |bench| tilt(bench, angle));
    let answers = [0.0, 0.19, 0.21, std::f64::consts::PI].map(upright);
    assert_eq!(answers, [true, true, false, false]);
}

#[test]
fn fallen_means_below_a_height_or_no_longer_in_the_cell() {
    let fallen = |z: f64| {
        holds("Fallen", json!({"below_m": 0.01}), |bench| {
            bench.object(0)[2] = z;
        })
    };
    assert_eq!([0.02, 0.009, -1.0].map(fallen), [false, true, true]);
    let cleared = |bench: &mut Bench| bench.state.objects[0].flags = 0;
    assert!(holds("Fallen", json!({}), cleared));
}

#[test]
fn no_other_condition_holds_of_an_object_that_is_not_in_the_cell() {
    let cleared = |bench: &mut Bench| {
        *bench.object(0) = SLOT;
        bench.state.objects[0].flags = 0;
    };
    for name in ["Reachable", "AtRest", "Uncovered", "Upright", "Holding"] {
        assert!(!holds(name, json!({}), cleared), "{name}");
    }
    assert!(!holds("At", json!({"place": "shelf"}), cleared));
}

#[test]
fn an_object_is_not_in_its_place_until_the_fingers_around_it_are_open() {
    let at = |width: f64| {
        holds("At", json!({"place": "shelf"}), |bench| {
            *bench.object(0) = SLOT;
            let arm = &mut bench.state.arms[LEFT];
            arm.tcp = crate::bench::pose(SLOT[0], SLOT[1], SLOT[2]);
            // The pads have left it, and are on both sides of it.
            (arm.gripper.width, arm.gripper.beam_object) = (width, 1);
        })
    };
    assert_eq!([0.051, 0.06, 0.08].map(at), [false, false, true]);
}

#[test]
fn uncovered_means_that_no_other_object_is_on_it_unless_a_gripper_has_that() {
    let on_top = |z: f64, holder: Option<usize>| {
        holds("Uncovered", json!({}), |bench| {
            *bench.object(4) = [0.51, -0.3, z];
            if let Some(arm) = holder {
                bench.state.arms[arm].gripper.held_object = 5;
            }
        })
    };
    assert!(!on_top(0.075, None), "a cube on it");
    assert!(on_top(0.025 + 0.08, None), "a cube far above it");
    assert!(on_top(0.075, Some(LEFT)) && on_top(0.075, Some(RIGHT)));
}

#[test]
fn at_rest_means_slow() {
    let at_rest = |speed: f64| {
        holds("AtRest", json!({}), |bench| {
            bench.state.objects[0].twist.linear[1] = speed;
        })
    };
    assert_eq!([0.0, 0.009, 0.011].map(at_rest), [true, true, false]);
}

#[test]
fn reachable_is_measured_from_the_base_of_the_arm() {
    let reachable = |x: f64| {
        holds("Reachable", json!({}), |bench| {
            // The base of the left arm is at y = -0.4.
            *bench.object(0) = [x, -0.4, 0.025];
        })
    };
    assert_eq!([0.5, 0.7, 0.9].map(reachable), [true, true, false]);
}

#[test]
fn holding_is_what_the_gripper_of_this_arm_has() {
    let held = |arm: usize, object: u32, ports: &Json| {
        asked("Holding", ports, |bench| {
            bench.state.arms[arm].gripper.held_object = object;
        })
    };
    let first = json!({"object": "cube_1"});
    assert!(held(LEFT, 1, &first) && held(LEFT, 1, &json!({})));
    assert!(!held(LEFT, 2, &first) && held(LEFT, 2, &json!({})));
    assert!(!held(RIGHT, 1, &first) && !held(RIGHT, 1, &json!({})));
}

#[test]
fn an_object_is_at_a_place_in_a_slot_of_it_and_in_no_gripper() {
    let at = |off: [f64; 3], holder: Option<usize>| {
        holds("At", json!({"place": "shelf"}), |bench| {
            let [x, y, z] = SLOT;
            *bench.object(0) = [x + off[0], y + off[1], z + off[2]];
            if let Some(arm) = holder {
                bench.state.arms[arm].gripper.held_object = 1;
            }
        })
    };
    assert!(at([0.0; 3], None) && at([0.0, 0.1, 0.0], None), "two slots");
    assert!(at([0.019, 0.0, 0.0], None) && !at([0.021, 0.0, 0.0], None));
    assert!(!at([0.0, 0.0, 0.05], None), "a layer above");
    assert!(!at([0.0; 3], Some(LEFT)) && !at([0.0; 3], Some(RIGHT)));
}

#[test]
fn a_place_is_full_when_each_slot_has_an_object() {
    let full = |count: usize| {
        asked("Full", &json!({"place": "shelf"}), |bench| {
            for (object, y) in [0.0, 0.1].into_iter().take(count).enumerate() {
                *bench.object(object + 1) = [SLOT[0], SLOT[1] + y, SLOT[2]];
            }
        })
    };
    assert_eq!([0, 1, 2].map(full), [false, false, true]);
}

#[test]
fn started_open_and_sensors_are_as_the_cell_says() {
    for started in [false, true] {
        let asked = asked("Started", &json!({}), |bench| bench.job.started = started);
        assert_eq!(asked, started);
    }
    let open = |width: f64| {
        asked("GripperOpen", &json!({}), |bench| {
            bench.state.arms[LEFT].gripper.width = width;
        })
    };
    assert_eq!([0.08, 0.073, 0.071].map(open), [true, true, false]);
    let cell = Cell::load(&Data::checkout(), "ur10-bin-stack", 1, None).unwrap();
    for (sees, expected) in [(0, Status::Failure), (3, Status::Success)] {
        let setup = Arc::new(Setup::new(&cell, []));
        let last = setup.sensors.len() - 1;
        let root = json!({"id": "n", "type": "Sensor", "ports": {"sensor": "belt_end"}});
        let file = json!({"format": "behavior-tree/1", "name": "bench", "root": root});
        let library = nodes::library(&setup);
        let index = setup.sensor("belt_end").unwrap();
        let mut bench = Bench::of((&cell, setup), &library, LEFT, &file);
        bench.state.equipment.sensors = [0; 8];
        bench.state.equipment.sensors[last + 1] = 7;
        bench.state.equipment.sensors[index] = sees;
        assert_eq!(bench.tick(), expected);
    }
}

#[test]
fn a_condition_about_a_name_in_a_key_is_false_until_the_key_names_an_object() {
    let cell = Cell::load(&Data::checkout(), "franka-pyramid", 1, None).unwrap();
    let setup = Arc::new(Setup::new(&cell, []));
    let file = json!({
        "format": "behavior-tree/1", "name": "bench",
        "blackboard": {"local": {"what": {"type": "text", "default": ""}}},
        "root": {"id": "n", "type": "Upright", "ports": {"object": {"bb": "local.what"}}}
    });
    let library = nodes::library(&setup);
    let mut bench = Bench::of((&cell, setup), &library, LEFT, &file);
    let text = |name: &str| behavior::Value::Text(behavior::Str::new(name).unwrap());
    assert_eq!(bench.tick(), Status::Failure);
    bench.set_local("what", text("cube_9"));
    assert_eq!(bench.tick(), Status::Failure);
    bench.set_local("what", text("cube_2"));
    assert_eq!(bench.tick(), Status::Success);
    bench.state.objects[1].pose = Pose {
        orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
        ..bench.state.objects[1].pose
    };
    assert_eq!(bench.tick(), Status::Failure);
}
