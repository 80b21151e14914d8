//! Messages of a server, as bytes.

use policy_client::codec::{Convention, actions};
use rmpv::Value;

use crate::server::{map, rows};

fn bytes(value: &Value) -> Vec<u8> {
    let mut bytes = Vec::new();
    rmpv::encode::write_value(&mut bytes, value).unwrap();
    bytes
}

fn refused(value: &Value) -> String {
    actions(Convention::OpenPi, &bytes(value))
        .unwrap_err()
        .to_string()
}

fn array(kind: &str, data: Vec<u8>, shape: &[u64]) -> Value {
    let shape = shape.iter().map(|side| Value::from(*side)).collect();
    let array = map(vec![
        ("__ndarray__", true.into()),
        ("data", Value::Binary(data)),
        ("dtype", kind.into()),
        ("shape", Value::Array(shape)),
    ]);
    map(vec![("actions", array)])
}

#[test]
fn arrays_and_lists_are_read() {
    let two = vec![vec![1.0, 2.0], vec![3.0, 4.0]];
    assert_eq!(actions(Convention::OpenPi, &rows(&two)), Ok(two.clone()));
    let list = |row: &Vec<f32>| Value::Array(row.iter().map(|number| (*number).into()).collect());
    let lists = map(vec![(
        "actions",
        Value::Array(two.iter().map(list).collect()),
    )]);
    assert_eq!(actions(Convention::OpenPi, &bytes(&lists)), Ok(two));
    let doubles: Vec<u8> = [0.5_f64, 1.5]
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    let one = array("float64", doubles, &[2]);
    assert_eq!(
        actions(Convention::OpenPi, &bytes(&one)),
        Ok(vec![vec![0.5, 1.5]])
    );
}

#[test]
fn what_is_no_answer_is_refused_with_its_fault() {
    let zeros = |count| vec![0; count];
    for (value, words) in [
        (map(vec![]), "no \"actions\""),
        (map(vec![("action", 1.into())]), "its keys are \"action\""),
        (Value::from(3), "not a map"),
        (
            map(vec![("actions", "left".into())]),
            "neither an array nor a list",
        ),
        (
            map(vec![("actions", Value::Array(vec!["left".into()]))]),
            "no numbers",
        ),
        (map(vec![("actions", Value::Array(vec![]))]), "empty"),
        (array("<f4", zeros(8), &[4]), "the shape [4] and 8 bytes"),
        (array("<f4", zeros(8), &[1, 1, 2]), "2 dimensions"),
        (array("<f4", zeros(0), &[0, 4]), "empty"),
        (array("<f4", zeros(0), &[4, 0]), "the shape [4, 0]"),
        (array("<f4", zeros(8), &[u64::MAX, u64::MAX]), "8 bytes"),
        (array("|O", zeros(8), &[2]), "float32 and float64"),
    ] {
        let error = refused(&value);
        assert!(error.contains(words), "{error}");
    }
    let nan = rows(&[vec![0.0, f32::NAN]]);
    let error = actions(Convention::OpenPi, &nan).unwrap_err().to_string();
    assert!(error.contains("NaN"), "{error}");
    let error = actions(Convention::OpenPi, b"\x93\x01")
        .unwrap_err()
        .to_string();
    assert!(error.contains("not MessagePack"), "{error}");
}

#[test]
fn an_error_of_a_server_is_told() {
    let message = map(vec![
        ("type", "error".into()),
        ("payload", map(vec![("message", "out of memory".into())])),
    ]);
    let error = actions(Convention::VlaEval, &bytes(&message))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("reports an error") && error.contains("out of memory"),
        "{error}"
    );
}
