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
    for (kind, rows, width, words) in [
        ("<f4", 1001, 1, "1001 rows; at most 1000"),
        ("<f8", 1, 65, "rows of 65 numbers; at most 64"),
    ] {
        let size = if kind == "<f4" { 4 } else { 8 };
        let value = array(
            kind,
            zeros(size * rows * width),
            &[rows as u64, width as u64],
        );
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

/// Stored, each of its bytes would be a value of 40 bytes.
#[test]
fn a_message_of_too_many_values_is_refused_before_it_is_stored() {
    let most = "more than 100000 values";
    let array = |length: u32, values: usize| {
        let head = [&b"\x81\xa7actions\xdd"[..], &length.to_be_bytes()].concat();
        [head, vec![1; values]].concat()
    };
    let map = |length: u32, values: usize| {
        let head = [&b"\xdf"[..], &length.to_be_bytes()].concat();
        [head, vec![1; values]].concat()
    };
    let nested = [vec![0x91; 200_000], vec![1]].concat();
    for message in [
        array(16_000_000, 16_000_000),
        array(u32::MAX, 3),
        map(60_000, 120_000),
        map(u32::MAX, 0),
        nested,
    ] {
        let error = actions(Convention::OpenPi, &message).unwrap_err();
        assert!(error.to_string().contains(most), "{error}");
    }
    // The map, its key, the array and its numbers.
    let fits = actions(Convention::OpenPi, &array(99_997, 99_997)).unwrap_err();
    assert!(fits.to_string().contains("numbers; at most 64"), "{fits}");
    let over = actions(Convention::OpenPi, &array(99_998, 99_998)).unwrap_err();
    assert!(over.to_string().contains(most), "{over}");
}

#[test]
fn values_of_every_kind_are_counted_with_their_length() {
    // One answer with an entry of each kind beside its actions.
    let kinds: [&[u8]; 24] = [
        b"\x7f",
        b"\xc0",
        b"\xc3",
        b"\xff",
        b"\xcc\x01",
        b"\xcd\0\x01",
        b"\xce\0\0\0\x01",
        b"\xcf\0\0\0\0\0\0\0\x01",
        b"\xd0\x01",
        b"\xd1\0\x01",
        b"\xd2\0\0\0\x01",
        b"\xd3\0\0\0\0\0\0\0\x01",
        b"\xca\0\0\0\0",
        b"\xcb\0\0\0\0\0\0\0\0",
        b"\xa2hi",
        b"\xd9\x02hi",
        b"\xda\0\x02hi",
        b"\xdb\0\0\0\x02hi",
        b"\xc4\x02hi",
        b"\xc5\0\x02hi",
        b"\xc6\0\0\0\x02hi",
        b"\xd5\x01hi",
        b"\xc7\x02\x01hi",
        b"\xdc\0\x01\x01",
    ];
    for kind in kinds {
        // The value is followed by more values than are read: they have to be counted as such.
        let few = [b"\x82\xa1k", kind, b"\xa7actions\x91\x91\x01"].concat();
        assert_eq!(
            actions(Convention::OpenPi, &few),
            Ok(vec![vec![1.0]]),
            "{kind:?}"
        );
        let many = [
            &b"\x82\xa1k"[..],
            kind,
            b"\xa7actions\xdd\0\x02\0\0",
            &vec![1; 0x2_0000],
        ]
        .concat();
        let error = actions(Convention::OpenPi, &many).unwrap_err().to_string();
        assert!(
            error.contains("more than 100000 values"),
            "{kind:?}: {error}"
        );
    }
}

#[test]
fn what_a_server_says_is_quoted_in_part_however_long_it_is() {
    let long = Value::Binary(vec![b'x'; 1 << 20]);
    let error = map(vec![
        ("type", "error".into()),
        (
            "payload",
            map(vec![("why", long.clone()), ("end", "out of memory".into())]),
        ),
    ]);
    let told = actions(Convention::VlaEval, &bytes(&error)).unwrap_err();
    let told = told.to_string();
    assert!(
        told.contains("out of memory") && told.len() < 1000,
        "{told}"
    );
    let keys = Value::Map(vec![(long, 1.into()), ("last".into(), 2.into())]);
    let told = refused(&keys);
    assert!(told.contains("last") && told.len() < 1000, "{told}");
}
