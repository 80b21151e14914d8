//! Pictures of the cameras of a cell, against rays of the physics engine.

use camera::{Light, NEAR_M, Picture, Scene, View, draw, instances};
use cell_model::cells::setting::Setting;
use cell_model::random::Random;
use cell_model::{Cell, Data, Shape};
use cell_run::spec::RunSpec;
use cell_sim::{OneProcess, eval::template, run};
use ipc_types::WorldState;
use ipc_types::world::OBJECT_ENABLED;
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use parry3d_f64::query::Ray;
use parry3d_f64::shape::SharedShape;
use physics_proc::engine::shapes;

/// Largest difference of two depths of one surface (m).
const SAME_DEPTH_M: f64 = 1.0e-4;
/// Of so many pixels one may differ: those on the edge of a silhouette.
const PIXELS_PER_DIFFERENCE: usize = 10_000;

/// A cell and its state after `seconds` of its job.
fn cell_after(demo: &str, seed: u64, seconds: u64) -> (Cell, Box<WorldState>) {
    let cell = Cell::load(&Data::checkout(), demo, seed, None).expect("a demo");
    let mut spec = template(demo, &cell.default_policy);
    (spec.seed, spec.arms) = (seed, u8::try_from(cell.arms.len()).expect("few arms"));
    let mut sim = OneProcess::new(&demos::policies(), &spec, cell.clone()).expect("a cell");
    for _ in 0..1000 * seconds {
        sim.tick().expect("a tick");
    }
    (cell, Box::new(*sim.state()))
}

fn picture(cell: &Cell, state: &WorldState, name: &str) -> (View, Picture) {
    let spec = cell.cameras.iter().find(|camera| camera.name == name);
    let view = View::of(cell, state, spec.expect("a camera of that name"));
    let picture = draw(&Scene::new(cell, state), &view, &Light::default());
    (view, picture)
}

/// The shapes of the cell as the engine has them, with their names in the mask.
fn engine_shapes(cell: &Cell, state: &WorldState) -> Vec<(SharedShape, Isometry3<f64>, String)> {
    let mut all = Vec::new();
    let mut add_one = |shape: &Shape, pose: Isometry3<f64>, name: &str| {
        let (shape, own) = shapes::shared(shape);
        all.push((shape, pose * own, name.to_owned()));
    };
    // Each panel of a bin is a shape: an eye within one of them sees the others.
    let mut add = |shape: &Shape, pose: Isometry3<f64>, name: &str| {
        let Some(panels) = shape.panels() else {
            return add_one(shape, pose, name);
        };
        for panel in panels {
            let size_m = panel.size.into();
            let pose = pose * Translation3::from(panel.centre);
            add_one(&Shape::Box { size_m }, pose, name);
        }
    };
    for fixture in cell.fixtures.iter().filter(|fixture| fixture.solid) {
        add(&fixture.shape, fixture.pose, &fixture.name);
    }
    for (object, seen) in cell.objects.iter().zip(&state.objects) {
        let [w, x, y, z] = seen.pose.orientation_wxyz;
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        if seen.flags & OBJECT_ENABLED != 0 {
            add(
                &object.shape,
                Isometry3::from_parts(seen.pose.position.into(), rotation),
                &object.name,
            );
        }
    }
    for (arm, seen) in cell.arms.iter().zip(state.arms()) {
        let mut positions = arm.robot.with_arm_positions(&seen.joint_positions);
        for finger in arm
            .robot
            .gripper
            .iter()
            .flat_map(|gripper| gripper.finger_joints)
        {
            positions[finger] = 0.5 * seen.gripper.width;
        }
        for (link, pose) in arm.robot.links.iter().zip(arm.robot.link_poses(&positions)) {
            let name = format!("{}/{}", arm.name, link.name);
            for part in &link.shapes {
                add(&part.shape, arm.base * pose * part.pose, &name);
            }
        }
    }
    all
}

/// Depth and name of what the engine finds along a ray of a pixel; of a shape around the eye
/// nothing is seen.
fn engine_hit<'a>(
    shapes: &'a [(SharedShape, Isometry3<f64>, String)],
    view: &View,
    slopes: [f64; 2],
) -> Option<(f64, &'a str)> {
    let direction = Vector3::new(slopes[0], slopes[1], 1.0);
    let length = direction.norm();
    let hits = shapes.iter().filter_map(|(shape, pose, name)| {
        let to = pose.inverse() * view.pose;
        let (origin, along) = (to * Point3::origin(), to * (direction / length));
        let vector = |v: Vector3<f64>| parry3d_f64::math::Vector::new(v.x, v.y, v.z);
        let ray = Ray::new(vector(origin.coords), vector(along));
        let is_around = shape.contains_local_point(vector(origin.coords));
        let at = shape
            .cast_local_ray(&ray, f64::MAX, true)
            .filter(|_| !is_around)?;
        Some((at / length, name.as_str()))
    });
    let ahead = hits.filter(|(depth, _)| *depth > f64::from(NEAR_M));
    ahead.min_by(|one, other| one.0.total_cmp(&other.0))
}

/// Pixels that were compared with rays of the engine.
#[derive(Clone, Copy, Debug, Default)]
struct Compared {
    pixels: usize,
    /// Pixels in which something is seen.
    seen: usize,
    /// Pixels of another body.
    other: usize,
    /// Pixels of the same body with another depth.
    deep: usize,
}

impl Compared {
    fn add(&mut self, more: Self) {
        self.pixels += more.pixels;
        self.seen += more.seen;
        self.other += more.other;
        self.deep += more.deep;
    }
}

/// Compares those pixels of a camera.
fn compare(
    cell: &Cell,
    state: &WorldState,
    name: &str,
    pixels: impl Fn(usize) -> Vec<usize>,
) -> Compared {
    let (view, picture) = picture(cell, state, name);
    let (names, shapes) = (instances(cell), engine_shapes(cell, state));
    let (width, height) = (view.width as usize, view.height as usize);
    let pixels = pixels(width * height);
    let (mut other, mut deep, mut seen) = (0, 0, 0);
    for at in &pixels {
        let (at, mask, depth) = (*at, picture.mask[*at], picture.depth_m[*at]);
        let slopes = [(at % width, width), (at / width, height)];
        let slopes =
            slopes.map(|(at, count)| (at as f64 + 0.5 - 0.5 * count as f64) / view.focal());
        let hit = engine_hit(&shapes, &view, slopes);
        let ours = (mask > 0).then(|| names[usize::from(mask) - 1].as_str());
        seen += usize::from(ours.is_some());
        if hit.map(|(_, name)| name) != ours {
            other += 1;
        } else if hit.is_some_and(|(theirs, _)| (theirs - f64::from(depth)).abs() > SAME_DEPTH_M) {
            deep += 1;
        }
    }
    Compared {
        pixels: pixels.len(),
        seen,
        other,
        deep,
    }
}

fn agrees(demo: &str, name: &str) {
    let (cell, state) = cell_after(demo, 3, 12);
    let found = compare(&cell, &state, name, |count| (0..count).collect());
    assert!(found.seen > found.pixels / 10, "the camera sees nothing");
    assert!(
        (found.other + found.deep) * PIXELS_PER_DIFFERENCE <= found.pixels,
        "{demo} {name}: {found:?}"
    );
}

/// `cargo test -p robocell-cell-sim --release --test it -- --ignored --nocapture random_pixels`
#[test]
#[ignore = "a series: a million pixels"]
#[allow(clippy::print_stdout, reason = "a series prints its figures")]
fn random_pixels_show_what_rays_of_the_engine_hit() {
    const PIXELS: usize = 1_000_000;
    const EACH: usize = 10_000;
    let mut random = Random::new(11);
    let mut all = Compared::default();
    while all.pixels < PIXELS {
        for (demo, _) in Data::checkout().demos() {
            let (seed, seconds) = (random.below(1000) as u64, random.below(30) as u64);
            let (cell, state) = cell_after(&demo, seed, seconds);
            for camera in &cell.cameras {
                let count = camera.width as usize * camera.height as usize;
                let chosen: Vec<usize> = (0..EACH).map(|_| random.below(count)).collect();
                let found = compare(&cell, &state, &camera.name, |_| chosen.clone());
                all.add(found);
                println!("{demo} seed {seed} {seconds} s {}: {found:?}", camera.name);
            }
        }
    }
    println!("all: {all:?}");
    assert!((all.other + all.deep) * PIXELS_PER_DIFFERENCE <= all.pixels);
}

#[test]
fn a_picture_shows_what_rays_of_the_engine_hit() {
    for (demo, camera) in [
        ("franka-stack", "front"),
        ("franka-stack", "wrist"),
        ("ur10-bin-stack", "front"),
        ("ur10-bin-stack", "wrist"),
    ] {
        agrees(demo, camera);
    }
}

/// Found on another processor means: the same there.
#[test]
fn pictures_have_the_same_bits_on_every_machine() {
    let (cell, state) = cell_after("franka-stack", 3, 0);
    let hashes = ["front", "wrist"].map(|name| picture(&cell, &state, name).1.hashes());
    let known = [
        [
            0x5038_91cd_9f34_9bee,
            0xcaa0_36ef_6594_5040,
            0x4c0f_445c_8759_8e2c,
        ],
        [
            0xdb58_a894_55fc_f3e0,
            0xa519_d800_67be_2965,
            0xf3c6_a2a6_52f2_f44c,
        ],
    ];
    assert_eq!(hashes, known, "{hashes:#018x?}");
}

#[test]
fn settings_change_light_and_colours_and_nothing_else() {
    let load = |set: &[&str]| {
        let set: Vec<Setting> = set
            .iter()
            .map(|text| text.parse().expect("a setting"))
            .collect();
        Cell::load_with(&Data::checkout(), "cube", 3, None, &set).expect("a cell")
    };
    let (_, state) = cell_after("cube", 3, 0);
    let seen = |set: &[&str]| {
        let pictures = camera::observe(&load(set), &state, &["front".to_owned()]);
        pictures.expect("a camera").remove(0)
    };
    let usual = seen(&[]);
    for set in [
        "light.direct=0.2",
        "light.from_x=-1.5",
        "object.cube.colour.0=0.1",
    ] {
        let other = seen(&[set]);
        assert_ne!(usual.rgb, other.rgb, "{set}");
        assert_eq!((&usual.depth_m, &usual.mask), (&other.depth_m, &other.mask));
    }
}

#[test]
fn the_last_picture_is_hashed_on_request() {
    let run = |camera: &str| {
        let spec = RunSpec {
            frame_hash: vec![camera.to_owned()],
            time_limit_s: Some(0.1),
            ..template("cube", "ifelse")
        };
        run::to_the_end(&crate::program(), &spec, |_| {})
    };
    let summary = run("wrist").expect("a run");
    let cell = Cell::load(&Data::checkout(), "cube", 0, None).expect("a demo");
    let mut sim = OneProcess::new(
        &demos::policies(),
        &template("cube", "ifelse"),
        cell.clone(),
    )
    .expect("a cell");
    for _ in 0..100 {
        sim.tick().expect("a tick");
    }
    let [rgb, depth, mask] = picture(&cell, sim.state(), "wrist").1.hashes();
    let known = format!("{rgb:016x} {depth:016x} {mask:016x}");
    assert_eq!(summary.frames["wrist"], known);
    let error = run("rear").expect_err("no such camera").to_string();
    assert!(
        error.contains("--frame-hash") && error.contains("'rear'"),
        "{error}"
    );
}
