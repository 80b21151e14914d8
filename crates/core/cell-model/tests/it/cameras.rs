//! Cameras of a cell file, and the refusals of wrong ones.

use cell_model::cells::cell::CameraSpec;
use cell_model::{Cell, Data};
use nalgebra::{Point3, Vector3};

/// franka-stack with the lines of a camera in place of its own.
fn with(lines: &str) -> Result<Vec<CameraSpec>, String> {
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../cells/franka-stack.toml"
    ));
    let text = text.unwrap();
    let (before, after) = text.split_once("[cameras.wrist]").unwrap();
    let (_, after) = after.split_once("\n\n").unwrap();
    let text = format!("{before}[cameras.mine]\n{lines}\n\n{after}");
    let cell = Cell::from_text(&Data::checkout(), "mine", "cells/mine.toml", &text, 1, None);
    cell.map(|cell| cell.cameras)
        .map_err(|error| error.to_string())
}

#[test]
fn every_demo_has_a_front_camera_and_one_per_wrist() {
    for (demo, _) in Data::checkout().demos() {
        let cell = Cell::load(&Data::checkout(), &demo, 1, None).unwrap();
        let names: Vec<&str> = cell.cameras.iter().map(|c| c.name.as_str()).collect();
        let wrists = |arm: &str| format!("{arm}_wrist");
        let expected: Vec<String> = match cell.arms.as_slice() {
            [_] => vec!["front".to_owned(), "wrist".to_owned()],
            arms => std::iter::once("front".to_owned())
                .chain(arms.iter().map(|arm| wrists(&arm.name)))
                .collect(),
        };
        assert_eq!(names, expected, "{demo}");
        let mounts = cell.cameras[1..].iter().map(|c| c.mount.map(|m| m.arm));
        assert!(mounts.eq((0..cell.arms.len()).map(Some)), "{demo}");
    }
}

#[test]
fn a_target_and_a_rotation_say_the_same_view() {
    let aimed = with("eye_m = [1.0, 0.0, 1.0]\ntarget_m = [0.0, 0.0, 1.0]").unwrap();
    let turned = "eye_m = [1.0, 0.0, 1.0]\nrotation_wxyz = [0.5, -0.5, -0.5, 0.5]\nsize = [64, 48]";
    let turned = with(turned).unwrap();
    for camera in [&aimed[1], &turned[1]] {
        let ahead = camera.pose * Point3::new(0.0, 0.0, 1.0);
        assert!(
            (ahead.coords - Vector3::new(0.0, 0.0, 1.0)).norm() < 1e-9,
            "{ahead}"
        );
        let down = camera.pose.rotation * Vector3::y();
        assert!((down + Vector3::z()).norm() < 1e-9, "{down}");
    }
    assert_eq!(
        (aimed[1].width, turned[1].width, turned[1].height),
        (224, 64, 48)
    );
}

/// Lines of a camera at a fixed eye, and parts of its refusal: the place, and the allowed values.
const REFUSED: [[&str; 3]; 10] = [
    [
        "",
        "cameras.mine",
        "one of target_m and rotation_wxyz is needed",
    ],
    [
        "target_m = [0, 0, 0]\nrotation_wxyz = [1, 0, 0, 0]",
        "both",
        "one of target_m and rotation_wxyz is needed",
    ],
    [
        "target_m = [1.0, 0.0, 1.0]",
        "cameras.mine",
        "a target away from the eye",
    ],
    [
        "target_m = [1.0, 0.0, 0.0]",
        "up [0.0, 0.0, 1.0]",
        "not along the view",
    ],
    [
        "rotation_wxyz = [2, 0, 0, 0]",
        "rotation_wxyz",
        "0.999 to 1.001 is allowed",
    ],
    [
        "rotation_wxyz = [1, 0, 0, 0]\nup = [0, 0, 1]",
        "cameras.mine.up",
        "rotation_wxyz says all",
    ],
    [
        "target_m = [0, 0, 0]\nfov_deg = 180",
        "fov_deg",
        "1 to 170 is allowed",
    ],
    [
        "target_m = [0, 0, 0]\nsize = [0, 4]",
        "size.0",
        "1 to 4096 is allowed",
    ],
    [
        "target_m = [0, 0, 0]\nlink = \"pnda/tcp\"",
        "'pnda/tcp'",
        "did you mean 'panda'",
    ],
    [
        "target_m = [0, 0, 0]\nlink = \"panda/panda_hnd\"",
        "panda_hnd",
        "did you mean 'panda_hand'",
    ],
];

#[test]
fn what_is_no_camera_is_refused_with_its_place_and_what_is_allowed() {
    for [lines, place, allowed] in REFUSED {
        let error = with(&format!("eye_m = [1.0, 0.0, 1.0]\n{lines}")).unwrap_err();
        assert!(error.contains("cells/mine.toml"), "{error}");
        assert!(
            error.contains(place) && error.contains(allowed),
            "{place}: {error}"
        );
    }
}
