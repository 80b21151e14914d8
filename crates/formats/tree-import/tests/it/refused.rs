//! What has no counterpart is refused by node and line, all of it at once.

use crate::support::whole;

#[track_caller]
fn assert_refused(xml: &str, expected: &[&str]) {
    let errors = tree_import::import("t.xml", &whole(xml), &|_| None, None, None).unwrap_err();
    let text = errors.to_string();
    for part in expected {
        assert!(text.contains(part), "'{part}' is missing in:\n{text}");
    }
}

#[test]
fn all_nodes_are_named_with_their_lines() {
    let xml = "<Sequence>\n<Switch2 variable=\"{x}\"/>\n<MyDecorator name=\"m\"><A/></MyDecorator>\n\
               <Script code=\"x += 1\"/>\n<A _onHalted=\"x := 1\"/>\n<LoopInt/></Sequence>";
    let expected = [
        "t.xml:2:1: Switch2: Switch2 has no counterpart",
        "t.xml:3:1: MyDecorator 'm': MyDecorator has no counterpart",
        "t.xml:4:1: Script: the script 'x += 1' computes",
        "t.xml:5:1: A: _onHalted:",
        "t.xml:6:1: LoopInt:",
    ];
    assert_refused(xml, &expected);
}

#[test]
fn nodes_inside_of_a_refused_node_are_named_too() {
    let xml = "<Recovery>\n<Switch2/>\n<RateController><LoopInt/></RateController></Recovery>";
    assert_refused(
        xml,
        &[
            "t.xml:1:",
            "t.xml:2:1: Switch2",
            "t.xml:3:1: RateController",
            "LoopInt",
        ],
    );
}

#[test]
fn a_line_of_dashes_is_a_comment() {
    let xml = "<!----- a > b ----->\n<Sequence>\n<!--\n--->\n<Switch2/></Sequence>";
    assert_refused(xml, &["t.xml:5:1: Switch2"]);
}

#[test]
fn a_node_that_is_skipped_needs_a_parent_that_says_what_it_means() {
    assert_refused(
        "<A _skipIf=\"x\"/>",
        &["_skipIf and _while need a Sequence or Fallback"],
    );
    let xml = "<Parallel><A _while=\"x\"/></Parallel>";
    assert_refused(xml, &["need a Sequence or Fallback"]);
    let xml = "<Fallback><Sequence><A _skipIf=\"x == 1\"/></Sequence><B/></Fallback>";
    assert_refused(xml, &["all its children may be skipped"]);
}

#[test]
fn files_that_are_not_such_trees() {
    assert_refused("<root BTCPP_format=\"4\"", &["t.xml:1:", "not XML"]);
    let v3 = "<root BTCPP_format=\"3\"><BehaviorTree><A/></BehaviorTree></root>";
    assert_refused(v3, &["BTCPP_format is \"3\""]);
    let two = "<root BTCPP_format=\"4\"><BehaviorTree ID=\"a\"><A/></BehaviorTree>\
               <BehaviorTree ID=\"b\"><A/></BehaviorTree></root>";
    assert_refused(two, &["the tree to execute is not named", "a, b"]);
    let circle = "<root BTCPP_format=\"4\"><BehaviorTree ID=\"a\"><SubTree ID=\"a\"/>\
                  </BehaviorTree></root>";
    assert_refused(circle, &["a tree is part of itself: a -> a"]);
    assert_refused(
        "<Sequence><SubTree ID=\"Mian\"/></Sequence>",
        &["did you mean 'Main'?"],
    );
    assert_refused("<Sequense><A/></Sequense>", &["did you mean 'Sequence'?"]);
    assert_refused(
        "<Repeat num_cycles=\"{n}\"><A/></Repeat>",
        &["it has to be a number"],
    );
    assert_refused(
        "<Repeat num_cycle=\"2\"><A/></Repeat>",
        &["did you mean 'num_cycles'?"],
    );
    let include = "<root BTCPP_format=\"4\"><include path=\"no.xml\"/>\
                   <BehaviorTree ID=\"a\"><A/></BehaviorTree></root>";
    assert_refused(include, &["the file 'no.xml' cannot be read"]);
}

#[test]
fn one_key_has_one_type() {
    let xml =
        "<Sequence><Script code=\"a := 'red'\"/><ScriptCondition code=\"a == 1\"/></Sequence>";
    assert_refused(xml, &["'a' is a text elsewhere, here it is a number"]);
    let long = "x".repeat(63);
    assert_refused(
        &format!("<A text=\"{long}\"/>"),
        &["a text of 63 bytes; a value has at most 62"],
    );
}

#[test]
fn large_files_end_soon() {
    let deep = format!(
        "{}<A/>{}",
        "<Inverter>".repeat(100_000),
        "</Inverter>".repeat(100_000)
    );
    assert_refused(&deep, &["t.xml:1:"]);
    let wide = format!("<Sequence>{}</Sequence>", "<A/>".repeat(20_000));
    assert_refused(&wide, &["more than 16384 nodes"]);
    let nested = format!("<A _skipIf=\"{}x\"/>", "(".repeat(100_000));
    assert_refused(&nested, &["nested deeper than 32 levels"]);
    let not = format!("<A _skipIf=\"{}x\"/>", "!".repeat(100_000));
    assert_refused(&not, &["nested deeper than 32 levels"]);
}
