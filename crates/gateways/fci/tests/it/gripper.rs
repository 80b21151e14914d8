//! The hand.

use fci::{Fingers, GRIPPER_STATE_BYTES, Gripper, GripperFramed, GripperRequest};

use crate::support::robot;

/// A hand whose fingers follow at once, down to an object of this width (m).
struct Bench {
    gripper: Gripper,
    fingers: Fingers,
    object: f64,
    requests: u32,
}

impl Bench {
    fn new(object: f64) -> Self {
        Self {
            gripper: Gripper::new(robot().gripper.as_ref().unwrap()),
            fingers: Fingers {
                width: 0.08,
                ..Fingers::default()
            },
            object,
            requests: 0,
        }
    }

    fn ask(&mut self, request: GripperRequest) {
        self.requests += 1;
        let framed = GripperFramed {
            command: 1,
            id: self.requests,
            request,
            size: 0,
        };
        self.gripper.request(&framed, &self.fingers);
    }

    fn cycle(&mut self) {
        let (width, force) = self.gripper.advance(&self.fingers);
        let next = width.max(self.object);
        self.fingers = Fingers {
            width: next,
            velocity: (next - self.fingers.width) * 1000.0,
            force: if width < self.object { force } else { 0.0 },
        };
    }

    /// Runs a request; its status and the cycles that it took.
    fn run(&mut self, request: GripperRequest) -> (u16, u32) {
        self.ask(request);
        for cycle in 0..5000 {
            if let Some(reply) = self.gripper.take_reply() {
                return (reply.status, cycle);
            }
            self.cycle();
        }
        unreachable!("no reply to {request:?}");
    }

    fn is_grasped(&self) -> bool {
        let mut state = [0; GRIPPER_STATE_BYTES];
        self.gripper.write_state(1, &self.fingers, &mut state);
        state[20] == 1
    }
}

fn grasp(width: f64) -> GripperRequest {
    GripperRequest::Grasp {
        width,
        inner: 0.005,
        outer: 0.005,
        speed: 0.1,
        force: 30.0,
    }
}

#[test]
fn a_motion_takes_the_time_of_its_speed() {
    let mut bench = Bench::new(0.0);
    let (status, cycles) = bench.run(GripperRequest::Move {
        width: 0.03,
        speed: 0.1,
    });
    assert_eq!(status, 0);
    assert!((495..=505).contains(&cycles), "{cycles}");
}

#[test]
fn a_grasp_holds_an_object_of_the_width_asked_for() {
    let mut bench = Bench::new(0.05);
    assert_eq!(bench.run(grasp(0.05)).0, 0);
    assert!(bench.is_grasped());
    assert_eq!(bench.gripper.advance(&bench.fingers), (0.0, 30.0));
    bench.gripper.disconnect();
    assert_eq!(bench.gripper.advance(&bench.fingers), (0.0, 30.0));
    let opened = bench.run(GripperRequest::Move {
        width: 0.08,
        speed: 0.1,
    });
    assert_eq!(opened.0, 0);
    assert!(!bench.is_grasped());
}

#[test]
fn a_grasp_of_another_width_is_unsuccessful() {
    let mut bench = Bench::new(0.02);
    assert_eq!(bench.run(grasp(0.05)).0, 2);
    assert!(!bench.is_grasped());
}

#[test]
fn a_motion_against_an_object_fails_and_a_wrong_one_is_refused() {
    let mut bench = Bench::new(0.05);
    let wanted = GripperRequest::Move {
        width: 0.02,
        speed: 0.1,
    };
    assert_eq!(bench.run(wanted).0, 1);
    for (width, speed) in [(0.1, 0.1), (-0.01, 0.1), (f64::NAN, 0.1), (0.05, 0.0)] {
        assert_eq!(bench.run(GripperRequest::Move { width, speed }), (1, 0));
    }
}

#[test]
fn a_stop_aborts() {
    let mut bench = Bench::new(0.0);
    bench.ask(GripperRequest::Homing);
    bench.ask(grasp(0.05));
    bench.cycle();
    bench.ask(GripperRequest::Stop);
    let statuses: Vec<u16> = std::iter::from_fn(|| bench.gripper.take_reply())
        .map(|reply| reply.status)
        .collect();
    assert_eq!(statuses, [3, 3, 0]);
}
