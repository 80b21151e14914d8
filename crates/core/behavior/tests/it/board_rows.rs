//! Access to blackboards: what the reference library allows and refuses.

use behavior::board::{Access, Board, BoardError, Fault};
use behavior::value::{Value, ValueType};

#[test]
fn a_key_that_was_never_registered_cannot_be_read() {
    let mut board = Board::new();
    board
        .declare("x", ValueType::Integer, Some(Value::Integer(3)))
        .unwrap();
    let client = board.client("reader");
    assert_eq!(client.get::<i64>(&board, "x"), Err(Fault::Access));
    assert_eq!(client.get::<i64>(&board, "y"), Err(Fault::Access));
}

#[test]
fn a_reader_cannot_write() {
    let mut board = Board::new();
    let client = board.client("reader");
    client
        .register::<i64>(&mut board, "x", Access::Read)
        .unwrap();
    assert_eq!(client.set(&mut board, "x", 3_i64), Err(Fault::Access));
    assert_eq!(client.unset(&mut board, "x"), Err(Fault::Access));
}

#[test]
fn a_writer_reads_what_it_wrote() {
    let mut board = Board::new();
    let client = board.client("writer");
    client
        .register::<i64>(&mut board, "x", Access::Write)
        .unwrap();
    client.set(&mut board, "x", 3_i64).unwrap();
    assert_eq!(client.get::<i64>(&board, "x"), Ok(3));
}

#[test]
fn an_exclusive_writer_is_alone() {
    let mut board = Board::new();
    let (first, second) = (board.client("first"), board.client("second"));
    first
        .register::<bool>(&mut board, "x", Access::Exclusive)
        .unwrap();
    let refused = second
        .register::<bool>(&mut board, "x", Access::Write)
        .unwrap_err();
    assert_eq!(
        refused.to_string(),
        "'second' cannot write blackboard key 'x': 'first' writes it exclusively"
    );
    second
        .register::<bool>(&mut board, "x", Access::Read)
        .unwrap();
}

#[test]
fn a_namespace_goes_in_front() {
    let mut board = Board::new();
    let client = board.client_in("arm", "/robot");
    client
        .register::<f64>(&mut board, "x", Access::Write)
        .unwrap();
    client.set(&mut board, "x", 0.5).unwrap();
    assert_eq!(client.absolute("x"), "/robot/x");
    let index = board.index("/robot/x").unwrap();
    assert_eq!(board.value(index), Some(Value::Number(0.5)));
    assert_eq!(board.index("x"), None);
}

#[test]
fn a_required_key_without_a_value_is_named() {
    let mut board = Board::new();
    let (reader, writer) = (board.client("reader"), board.client("writer"));
    reader
        .register::<i64>(&mut board, "x", Access::Read)
        .unwrap();
    writer
        .register::<i64>(&mut board, "x", Access::Write)
        .unwrap();
    let missing = BoardError::Unset {
        client: "reader".to_owned(),
        key: "x".to_owned(),
    };
    assert_eq!(reader.verify(&board), Err(missing));
    assert_eq!(
        reader
            .get::<i64>(&board, "x")
            .map_err(|f| matches!(f, Fault::Unset(_))),
        Err(true)
    );
    assert_eq!(writer.verify(&board), Ok(()));
    writer.set(&mut board, "x", 1_i64).unwrap();
    assert_eq!(reader.verify(&board), Ok(()));
}

#[test]
fn a_value_is_there_until_it_is_taken_away() {
    let mut board = Board::new();
    let client = board.client("writer");
    client
        .register::<i64>(&mut board, "x", Access::Write)
        .unwrap();
    client.set(&mut board, "x", 3_i64).unwrap();
    assert_eq!(client.exists(&board, "x"), Ok(true));
    client.unset(&mut board, "x").unwrap();
    assert_eq!(client.exists(&board, "x"), Ok(false));
}

#[test]
fn values_survive_in_a_record_by_the_names_of_their_keys() {
    let mut board = Board::new();
    let kept = board
        .declare("kept", ValueType::Integer, Some(Value::Integer(1)))
        .unwrap();
    let gone = board
        .declare("gone", ValueType::Bool, Some(Value::Bool(true)))
        .unwrap();
    let turned = board.declare("turned", ValueType::Bool, None).unwrap();
    assert!(board.set(kept, Value::Integer(7)) && board.set(turned, Value::Bool(true)));
    board.unset(gone);
    let mut record = Vec::new();
    board.save(&mut record);

    let mut edited = Board::new();
    let new = edited
        .declare("new", ValueType::Integer, Some(Value::Integer(5)))
        .unwrap();
    let turned = edited.declare("turned", ValueType::Integer, None).unwrap();
    let kept = edited.declare("kept", ValueType::Integer, None).unwrap();
    let carried = edited.restore(&record).unwrap();
    assert_eq!((carried.keys, carried.lost), (1, 2));
    assert_eq!(edited.value(kept), Some(Value::Integer(7)));
    assert_eq!(edited.value(new), Some(Value::Integer(5)));
    assert_eq!(edited.value(turned), None);

    board.reset();
    board.restore(&record).unwrap();
    assert_eq!(board.value(gone), None);
    assert!(board.restore(record.get(..9).unwrap()).is_err());
    assert!(
        board
            .restore(b"something else")
            .unwrap_err()
            .to_string()
            .contains("blackboard")
    );
}

#[test]
fn nodes_of_one_name_in_two_trees_are_two_clients() {
    let mut board = Board::new();
    board.declare("x", ValueType::Bool, None).unwrap();
    let register =
        |board: &mut Board| board.register("node", "x", ValueType::Bool, Access::Exclusive);
    register(&mut board).unwrap();
    register(&mut board).unwrap();
    board.next_tree();
    let refused = register(&mut board).unwrap_err();
    assert!(matches!(refused, BoardError::Exclusive { .. }), "{refused}");
}
