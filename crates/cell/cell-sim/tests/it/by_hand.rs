//! An arm that the operator leads.

use cell_model::Data;
use cell_sim::OneProcess;
use cell_sim::eval::template;
use ipc_types::contact::BodyKind;
use ipc_types::operator::OperatorAction;
use ipc_types::{Contacts, OperatorRequest, Pose, Wire as _};
use nalgebra::Vector3;

/// Leads the tool of `franka-stack` straight down to `height_m` with a limit of `contact_limit` N
/// (0: the default) while the task is paused; returns the cell after four seconds.
fn pressed_down(height_m: f64, contact_limit: f64) -> OneProcess {
    let spec = template("franka-stack", "fsm");
    let cell = spec.load_cell_from(&Data::checkout()).unwrap();
    let mut sim = OneProcess::new(&demos::policies(), &spec, cell).unwrap();
    let ask = |sim: &mut OneProcess, action: OperatorAction, pose: Pose| {
        sim.answer_request(&OperatorRequest {
            action: action.code(),
            pose,
            contact_limit,
            ..OperatorRequest::zeroed_at_identity()
        })
    };
    ask(&mut sim, OperatorAction::TaskPause, Pose::IDENTITY);
    // From above: on its way the tool is tilted, and a finger would touch first.
    for height_m in [0.15, height_m] {
        let pose = Pose {
            position: [0.45, 0.35, height_m],
            // Straight down.
            orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
        };
        sim.tick().unwrap();
        ask(&mut sim, OperatorAction::Target, pose);
        for _ in 0..4_000 {
            sim.tick().unwrap();
        }
    }
    sim
}

/// Largest contact force on the arm (N).
fn force(sim: &OneProcess) -> f64 {
    let mut contacts = Contacts::zeroed();
    sim.plant().world().write_contacts(&mut contacts);
    let on_arm = contacts.list().iter();
    let on_arm = on_arm.filter(|of| {
        [of.a, of.b]
            .iter()
            .any(|body| body >> 16 == BodyKind::Arm.code())
    });
    on_arm
        .map(|of| Vector3::from(of.force).norm())
        .fold(0.0, f64::max)
}

#[test]
fn a_target_inside_of_the_table_ends_at_the_contact() {
    let stopped = pressed_down(-0.01, 0.0);
    let panel = &stopped.state().panel;
    assert_eq!(panel.contact_stops, 1);
    assert_eq!(panel.contact_with >> 16, BodyKind::Fixture.code());
    assert!(panel.contact_force > 30.0, "{}", panel.contact_force);
    // The target is where the tool touched: the fingers are 10 mm longer than to the TCP.
    let touched_m = panel.target.position[2];
    assert!((0.005..0.015).contains(&touched_m), "{touched_m}");
    assert!(force(&stopped) < 30.0, "{}", force(&stopped));
    let pressing = pressed_down(-0.01, 1000.0);
    assert_eq!(pressing.state().panel.contact_stops, 0);
    assert!(force(&pressing) > 100.0, "{}", force(&pressing));
    // A target that touches nothing is kept.
    let free = pressed_down(0.05, 0.0);
    assert_eq!(free.state().panel.contact_stops, 0);
    assert!((free.state().arms()[0].tcp.position[2] - 0.05).abs() < 2e-3);
}
