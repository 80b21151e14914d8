//! Parts of messages that are refused, that do not count, or that are read in spite of damage.

use ipc_types::contact::{BodyKind, Contact};
use ipc_types::health::FAULT;
use ipc_types::operator::OperatorAction;
use ipc_types::topic::TopicId;
use ipc_types::{
    Contacts, GripperGoal, Header, Health, Input, MAX_INPUTS, OperatorRequest, Pose, Text,
    TraceLine, Validate as _, Wire as _, WorldState, layout_of,
};

#[test]
fn a_message_names_its_first_inputs_and_no_more_than_it_has_room_for() {
    let mut header = Header::caused_by::<WorldState>(1500);
    assert_eq!(header.sim_time_ns, 1_500_000_000);
    assert!(header.inputs().is_empty());
    for seq in 1..=MAX_INPUTS as u64 + 3 {
        header.push_input(Input {
            topic: TopicId::ArmStatus(0).code(),
            generation: 1,
            seq,
            age_ticks: 0,
        });
    }
    let named: Vec<u64> = header.inputs().iter().map(|input| input.seq).collect();
    assert_eq!(named, [1, 2, 3, 4]);
    // A count from damaged memory.
    header.input_count = u32::MAX;
    assert_eq!(header.inputs().len(), MAX_INPUTS);
}

#[test]
fn a_message_answers_the_generation_of_physics_whose_state_it_names() {
    let mut header = Header::caused_by::<WorldState>(10);
    let input = |topic: TopicId, generation| Input {
        topic: topic.code(),
        generation,
        seq: 1,
        age_ticks: 0,
    };
    header.push_input(input(TopicId::ArmStatus(0), 2));
    header.push_input(input(TopicId::WorldState, 3));
    let answers = [1, 2, 3, 4].map(|generation| header.answers(generation));
    assert_eq!(answers, [false, false, true, false]);
    assert!(!Header::caused_by::<WorldState>(10).answers(0));
}

#[test]
fn a_contact_of_an_unknown_kind_of_body_is_refused() {
    let mut contacts = Contacts::zeroed();
    contacts.count = 2;
    contacts.contacts[1] = Contact {
        a: Contact::body(BodyKind::Arm, 1),
        b: Contact::body(BodyKind::Fixture, 70_000),
        ..Contact::zeroed()
    };
    assert_eq!(contacts.validate(), Ok(()));
    let body = contacts.contacts[1].b;
    assert_eq!(
        (body >> 16, body & 0xffff),
        (BodyKind::Fixture.code(), 0xffff)
    );
    contacts.contacts[1].a = 3 << 16;
    assert_eq!(contacts.validate().unwrap_err().field, "contact.body");
    contacts.count = 1;
    assert_eq!(contacts.validate(), Ok(()), "it does not count");
    contacts.count = 97;
    assert_eq!(contacts.validate().unwrap_err().field, "count");
    assert_eq!(contacts.list().len(), 96);
}

#[test]
fn a_count_is_a_gripper_goal_only_where_the_gripper_is_asked_for() {
    let mut request = OperatorRequest::zeroed_at_identity();
    request.count = 250;
    request.action = OperatorAction::Step.code();
    assert_eq!(request.validate(), Ok(()));
    request.action = OperatorAction::Gripper.code();
    assert_eq!(request.validate().unwrap_err().field, "gripper");
    request.count = GripperGoal::Close.code();
    assert_eq!(request.validate(), Ok(()));
    request.seconds = 3601.0;
    assert_eq!(request.validate().unwrap_err().field, "seconds");
}

#[test]
fn a_target_of_the_operator_has_to_be_a_pose_from_the_first_one_on() {
    let mut state = WorldState::zeroed();
    assert_eq!(state.validate(), Ok(()), "none was given yet");
    state.panel.target_seq = 1;
    assert_eq!(state.validate().unwrap_err().field, "orientation_wxyz");
    state.panel.target = Pose::IDENTITY;
    assert_eq!(state.validate(), Ok(()));
    state.panel.target_arm = 2;
    assert_eq!(state.validate().unwrap_err().field, "panel.target_arm");
    state.panel.target_arm = 1;
    state.panel.break_count = 9;
    assert_eq!(state.validate().unwrap_err().field, "panel.break_count");
    assert_eq!(state.panel.breaks().len(), 8);
}

#[test]
fn a_text_that_is_not_utf_8_is_refused_with_its_place_and_shown_as_empty() {
    let line = TraceLine {
        text: Text::new("[drop] red_cube left the gripper"),
        ..TraceLine::zeroed()
    };
    let layout = layout_of::<TraceLine>();
    let text = layout[0].fields.iter().find(|field| field.name == "text");
    let offset = text.unwrap().offset;
    let damaged = |at: usize, byte: u8| {
        let mut bytes = line.as_bytes().to_vec();
        bytes[offset + at] = byte;
        TraceLine::from_bytes(&bytes).unwrap()
    };
    let bad = damaged(7, 0xff);
    let error = bad.validate().unwrap_err();
    assert_eq!((error.field, error.index), ("text", 7));
    assert_eq!(bad.text.as_str(), "");
    assert_eq!(error.to_string(), "text[7] is NaN, allowed is UTF-8 text");
    // Behind its end a text is not looked at.
    let cut = damaged(6, 0);
    assert_eq!((cut.validate(), cut.text.as_str()), (Ok(()), "[drop]"));
    assert_eq!(damaged(100, 0xff).validate(), Ok(()));
}

#[test]
fn a_fault_of_a_process_is_a_note_with_its_mark() {
    let health = |note: String| Health {
        note: Text::new(&note),
        ..Health::zeroed()
    };
    let fault = health(format!("{FAULT}no checkpoint is kept"));
    assert_eq!(fault.fault(), Some("no checkpoint is kept"));
    assert_eq!(health("waits for physics".to_owned()).fault(), None);
    assert_eq!(health(format!("no {FAULT}")).fault(), None);
}
