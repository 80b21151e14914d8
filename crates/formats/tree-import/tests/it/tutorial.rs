//! What the tutorial of BehaviorTree.CPP teaches: ports, subtrees, remapping, reactive nodes,
//! includes. The trees are our own.

use crate::support::{json, ticks};

/// Runs it with and without a kill after each tick.
#[track_caller]
fn assert_run(xml: &str, scripts: &[(&str, &str)], expected: &[&str]) {
    assert_eq!(ticks(xml, scripts, expected.len()), expected);
}

#[test]
fn a_first_tree() {
    let xml = r#"<root BTCPP_format="4"><BehaviorTree ID="Fetch"><Sequence name="fetch">
        <Condition ID="LampOn"/>
        <Action ID="OpenHand" name="open"/> <Action ID="Approach"/> <Action ID="CloseHand"/>
        </Sequence></BehaviorTree></root>"#;
    let expected = [
        "R LampOn, open, Approach",
        "R Approach",
        "S Approach, CloseHand",
    ];
    assert_run(xml, &[("Approach", "RRS")], &expected);
}

#[test]
fn ports_carry_values_between_leaves() {
    let xml = r#"<root BTCPP_format="4"><BehaviorTree ID="Talk"><Sequence>
        <Say text="good morning"/>
        <Think out="{idea}"/>
        <Say text="{idea}"/>
        <Say text="{=}"/>
        </Sequence></BehaviorTree></root>"#;
    let expected = "S Say text='good morning', Think, Say_2 text='Think', Say_3 text=nothing";
    assert_run(xml, &[], &[expected]);
}

#[test]
fn a_reactive_tree_stops_what_runs() {
    let xml = r#"<root BTCPP_format="4"><BehaviorTree ID="Trip"><ReactiveSequence>
        <BatteryFull/>
        <Sequence><Say text="go"/><Drive goal="1;2;3"/><Say text="there"/></Sequence>
        </ReactiveSequence></BehaviorTree></root>"#;
    let lines = ticks(xml, &[("BatteryFull", "SSFS"), ("Drive", "RRRRS")], 6);
    let answers: String = lines
        .iter()
        .filter_map(|line| line.chars().next())
        .collect();
    assert_eq!(answers, "RRFRRS", "{lines:?}");
    assert!(lines[2].contains("!Drive"), "{lines:?}");
    assert!(lines[3].contains("Say text="), "it starts over: {lines:?}");
}

const REMAPPED: &str = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
    <BehaviorTree ID="Main"><Sequence>
        <Script code="goal := 'shelf'"/>
        <SubTree ID="Move" target="{goal}" result="{reached}"/>
        <Say text="{reached}"/>
        <SubTree ID="Move" name="again" target="table"/>
        <SubTree ID="Speak" _autoremap="true"/>
    </Sequence></BehaviorTree>
    <BehaviorTree ID="Move"><Fallback>
        <Drive goal="{target}"/>
        <Report out="{result}"/>
    </Fallback></BehaviorTree>
    <BehaviorTree ID="Speak"><Sequence>
        <Say text="{reached}"/>
        <Say text="{_private}"/>
    </Sequence></BehaviorTree></root>"#;

#[test]
fn subtrees_share_what_is_remapped() {
    let lines = ticks(REMAPPED, &[("Drive", "RF")], 3);
    assert_eq!(lines[0], "R Drive goal='shelf'");
    // `result` of the first use is `reached`; the second use has a separate key.
    let expected = "R Drive goal='shelf', Report, Say text='Report', Drive goal='table'";
    assert_eq!(lines[1], expected);
    let expected = "S Drive goal='table', Report, Say text='Report', Say_2 text=nothing";
    assert_eq!(lines[2], expected);
}

#[test]
fn keys_of_a_subtree_are_its_own() {
    let text = json(REMAPPED);
    assert!(text.contains("\"again.result\""), "{text}");
    assert!(text.contains("\"Speak._private\""), "{text}");
    assert!(
        !text.contains("\"target\": {\"type\": \"number\""),
        "{text}"
    );
}

#[test]
fn a_literal_that_a_subtree_writes_is_the_first_value_of_its_key() {
    let xml = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
        <BehaviorTree ID="Main"><Repeat num_cycles="2"><SubTree ID="Inner" word="one"/></Repeat>
        </BehaviorTree>
        <BehaviorTree ID="Inner"><Sequence><Say text="{word}"/>
        <SetBlackboard output_key="word" value="two"/></Sequence></BehaviorTree></root>"#;
    assert_run(xml, &[], &["R Say text='one'", "S Say text='two'"]);
}

#[test]
fn a_literal_that_a_condition_of_a_subtree_tests() {
    let xml = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
        <BehaviorTree ID="Main"><SubTree ID="Outer" word="one"/></BehaviorTree>
        <BehaviorTree ID="Outer"><SubTree ID="Inner" word="{word}"/></BehaviorTree>
        <BehaviorTree ID="Inner"><Sequence><ScriptCondition code="word == 'one'"/><A/></Sequence>
        </BehaviorTree></root>"#;
    assert_run(xml, &[], &["S A"]);
}

#[test]
fn a_port_takes_values_of_several_types() {
    let xml = r#"<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence>
        <Script code="a := 3; b := true; c := 'red'"/>
        <Say text="{a}"/><Say text="{b}"/><Say text="{c}"/><Say text="1.5"/><Say text="hello"/>
        </Sequence></BehaviorTree></root>"#;
    let expected =
        "S Say text=3, Say_2 text=1, Say_3 text='red', Say_4 text=1.5, Say_5 text='hello'";
    assert_run(xml, &[], &[expected]);
}

#[test]
fn the_outermost_blackboard() {
    let xml = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
        <BehaviorTree ID="Main"><Sequence><Script code="top := 5"/><SubTree ID="A"/></Sequence>
        </BehaviorTree>
        <BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree>
        <BehaviorTree ID="B"><Say text="{@top}"/></BehaviorTree></root>"#;
    assert_run(xml, &[], &["S Say text=5"]);
}

#[test]
fn included_files_and_models() {
    let main = r#"<root BTCPP_format="4" main_tree_to_execute="Main"><include path="./lib/a.xml"/>
        <BehaviorTree ID="Main"><SubTree ID="Inner" speed="2"/></BehaviorTree></root>"#;
    let inner = r#"<root BTCPP_format="4"><include path="../other.xml"/><BehaviorTree ID="Inner">
        <Action ID="Drive" speed="{speed}"/></BehaviorTree><TreeNodesModel><Action ID="Drive">
        <input_port name="speed" type="double"/><input_port name="gear" type="int" default="1"/>
        <output_port name="done" type="bool"/></Action></TreeNodesModel></root>"#;
    let include = |name: &str| match name {
        "lib/a.xml" => Some(inner.to_owned()),
        _ => None,
    };
    let errors = tree_import::import("main.xml", main, &include, None, None).unwrap_err();
    assert!(
        errors.to_string().contains("'other.xml' cannot be read"),
        "{errors}"
    );
    let inner = inner.replace("<include path=\"../other.xml\"/>", "");
    let include = |name: &str| (name == "lib/a.xml").then(|| inner.clone());
    let imported = tree_import::import("main.xml", main, &include, None, None).unwrap();
    let ports = &imported.leaves[0].ports;
    let told: Vec<String> = ports
        .iter()
        .map(|(n, t, a)| format!("{n} {t} {a}"))
        .collect();
    assert_eq!(
        told,
        ["done bool write", "gear number read", "speed number read"]
    );
    assert!(imported.json.contains("\"speed\": 2"), "{}", imported.json);
    assert!(
        imported.json.contains("\"default\": 1"),
        "{}",
        imported.json
    );
}

#[test]
fn a_file_that_includes_itself_is_read_once() {
    let inner = r#"<root BTCPP_format="4"><include path="../main.xml"/><BehaviorTree ID="Inner">
         <AlwaysSuccess/></BehaviorTree></root>"#;
    for name in ["main.xml", "trees/main.xml", "./main.xml"] {
        for path in ["main.xml", "./main.xml", "lib/a.xml"] {
            let main = format!(
                "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><include path=\"{path}\"/>\
                 <BehaviorTree ID=\"Main\"><AlwaysSuccess/></BehaviorTree></root>"
            );
            let include = |name: &str| match name {
                "main.xml" => Some(main.clone()),
                "lib/a.xml" => Some(inner.to_owned()),
                _ => None,
            };
            let imported = tree_import::import(name, &main, &include, None, None);
            assert!(imported.is_ok(), "{name}, {path}: {:?}", imported.err());
        }
    }
}
