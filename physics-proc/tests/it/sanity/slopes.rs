//! Friction of faces: an object that slides on a slope has the acceleration
//! g (sin a - mu cos a) and does not turn; below the limit it is at rest.

use cell_model::Shape;
use nalgebra::{Isometry3, Translation3, Vector3};

use super::scene::{Running, Scene, about, box_of, every_shape};

const GRAVITY: f64 = 9.81;
/// Friction is right to this share.
const RIGHT: f64 = 0.01;
/// Largest turn about the normal of the slope in a second of sliding (degrees).
const TURN_DEGREES: f64 = 1.0;
/// Largest way of an object held for ten seconds (m).
const HELD_M: f64 = 0.1e-3;
/// Turns of an object about the normal of the slope (degrees).
const ALL_TURNS: [f64; 8] = [0.0, 10.0, 22.5, 30.0, 45.0, 60.0, 75.0, 90.0];

/// A wide plane through (0, 0, 0), steep by `slope` (rad): down is towards +x.
struct Slope {
    scene: Scene,
    plane: Isometry3<f64>,
    angle: f64,
    placed: Vec<(String, usize)>,
}

impl Slope {
    fn new(slope: f64, friction: f64, arm: bool) -> Self {
        let mut scene = Scene::new(arm);
        let tilt = about(Vector3::y_axis(), slope.to_degrees());
        let plane = Isometry3::from_parts(Translation3::new(0.0, 0.0, 4.0), tilt);
        let below = plane * Translation3::new(0.0, 0.0, -0.05);
        scene.fixture("slope", box_of([6.0, 60.0, 0.1]), below, friction);
        Self {
            scene,
            plane,
            angle: slope,
            placed: Vec::new(),
        }
    }

    /// Puts an object on the slope, in a lane of its own.
    fn place(&mut self, name: &str, shape: Shape, friction: f64, pose: Isometry3<f64>, turn: f64) {
        let lane = self.placed.len() as f64 * 0.5 - 15.0;
        let turn_about = about(Vector3::z_axis(), turn);
        let at = self.plane * Translation3::new(-2.0, lane, 0.0) * turn_about * pose;
        let object = self.scene.rough_object(shape, 0.5, friction, at);
        self.placed
            .push((format!("{name} turned by {turn}"), object));
    }

    /// Puts every shape that does not roll on the slope.
    fn place_all(&mut self, friction: f64, turns: &[f64]) {
        for (name, shape, pose) in every_shape() {
            if name == "ball" {
                continue;
            }
            // What lies on its side rolls as soon as its axis is not along the slope.
            let along = name.ends_with("lying");
            let turns = if along { &[0.0][..] } else { turns };
            for turn in turns {
                self.place(name, shape.clone(), friction, pose, *turn);
            }
        }
    }

    fn start(self) -> (Running, Isometry3<f64>, f64, Vec<(String, usize)>) {
        (self.scene.start(), self.plane, self.angle, self.placed)
    }
}

/// Asserts that everything on the slope slides with `friction` and does not turn.
fn check_sliding(slope: Slope, friction: f64) {
    let (mut running, plane, angle, placed) = slope.start();
    running.run(0.2);
    let start: Vec<_> = placed
        .iter()
        .map(|(_, o)| (running.velocity(*o), running.pose(*o)))
        .collect();
    running.run(0.5);
    for ((name, object), (velocity, pose)) in placed.iter().zip(start) {
        let gained = plane.rotation.inverse() * (running.velocity(*object) - velocity);
        let shown = (angle.sin() - gained.x / 0.5 / GRAVITY) / angle.cos();
        let turned = running.pose(*object).rotation.angle_to(&pose.rotation);
        let said = format!(
            "{name}, friction {friction}, {:.1} degrees: shows friction {shown}, aside {} m/s, turned by {} degrees in 0.5 s",
            angle.to_degrees(),
            gained.y,
            turned.to_degrees()
        );
        assert!((shown / friction - 1.0).abs() < RIGHT, "{said}");
        assert!(gained.y.abs() < RIGHT * friction * GRAVITY * 0.5, "{said}");
        assert!(turned.to_degrees() < 0.5 * TURN_DEGREES, "{said}");
    }
}

/// Asserts that everything on the slope stays where it is for ten seconds.
fn check_held(slope: Slope, seconds: f64) {
    let (mut running, _, angle, placed) = slope.start();
    running.run(0.5);
    let start: Vec<_> = placed.iter().map(|(_, o)| running.place(*o)).collect();
    running.run(seconds);
    for ((name, object), before) in placed.iter().zip(start) {
        let way = (running.place(*object) - before).norm();
        let slope = angle.to_degrees();
        assert!(
            way < HELD_M,
            "{name} moved by {way} m at {slope:.2} degrees"
        );
    }
}

fn check(friction: f64, turns: &[f64], arm: bool, seconds: f64) {
    let mut slope = Slope::new(f64::atan(friction) + 0.07, friction, arm);
    slope.place_all(friction, turns);
    check_sliding(slope, friction);
    let mut slope = Slope::new(f64::atan(0.99 * friction), friction, arm);
    slope.place_all(friction, turns);
    check_held(slope, seconds);
}

#[test]
fn faces_slide_with_their_friction_and_hold_up_to_it() {
    check(0.6, &[0.0, 10.0, 45.0], false, 2.0);
    check(0.1, &[30.0], false, 1.0);
}

#[test]
#[ignore = "slow: .ci/long"]
fn every_shape_slides_and_holds_in_every_direction_with_every_friction() {
    for arm in [false, true] {
        for friction in [0.1, 0.3, 0.6] {
            check(friction, &ALL_TURNS, arm, 10.0);
        }
    }
}

#[test]
fn what_overhangs_an_edge_slides_as_any_other() {
    let friction = 0.4;
    let angle = f64::atan(friction) + 0.07;
    let mut scene = Scene::new(false);
    let tilt = about(Vector3::y_axis(), angle.to_degrees());
    let plane = Isometry3::from_parts(Translation3::new(0.0, 0.0, 2.0), tilt);
    let below = plane * Translation3::new(0.0, 0.0, -0.05);
    scene.fixture("slope", box_of([4.0, 0.2, 0.1]), below, friction);
    let mut placed = Vec::new();
    for (index, turn) in [0.0, 20.0].into_iter().enumerate() {
        // A bar across the slope, with 40 % of its length beside it.
        let at = Translation3::new(-1.5 + 0.7 * index as f64, 0.06, 0.01);
        let pose = plane * at * about(Vector3::z_axis(), turn);
        let bar = scene.rough_object(box_of([0.05, 0.32, 0.02]), 0.5, friction, pose);
        placed.push((format!("bar turned by {turn}"), bar));
    }
    let slope = Slope {
        scene,
        plane,
        angle,
        placed,
    };
    check_sliding(slope, friction);
}

#[test]
fn an_object_slides_on_another_one_with_their_friction() {
    let friction = 0.5;
    let mut slope = Slope::new(f64::atan(friction) + 0.07, 1.5, false);
    let carried = [("box", 0.0), ("box", 10.0), ("box", 45.0)];
    for (name, turn) in carried {
        // The lower one has 1.0 with the slope and stays.
        slope.place("base", box_of([1.0, 0.2, 0.02]), friction, up(0.01), 0.0);
        slope.placed.pop();
        let lane = slope.placed.len() as f64 * 0.5 - 15.0;
        let at = slope.plane
            * Translation3::new(-2.3, lane, 0.02)
            * about(Vector3::z_axis(), turn)
            * up(0.025);
        let object = slope
            .scene
            .rough_object(box_of([0.1, 0.1, 0.05]), 0.5, friction, at);
        slope
            .placed
            .push((format!("{name} turned by {turn}"), object));
    }
    check_sliding(slope, friction);
}

fn up(height: f64) -> Isometry3<f64> {
    Isometry3::translation(0.0, 0.0, height)
}
