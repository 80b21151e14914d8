//! Each node, tick by tick, as BehaviorTree.CPP documents it.

use crate::support::ticks;

#[track_caller]
fn assert_ticks(xml: &str, scripts: &[(&str, &str)], expected: &[&str]) {
    assert_eq!(ticks(xml, scripts, expected.len()), expected, "{xml}");
}

#[test]
fn a_sequence_continues_while_running_and_starts_over_after_a_failure() {
    let xml = "<Sequence><A/><B/><C/></Sequence>";
    let expected = ["R A, B", "F B", "R A, B", "S B, C"];
    assert_ticks(xml, &[("B", "RFRS")], &expected);
}

#[test]
fn a_fallback_continues_while_running() {
    let xml = "<Fallback><A/><B/></Fallback>";
    let expected = ["R A, B", "S B", "R A, B"];
    assert_ticks(xml, &[("A", "F"), ("B", "RSR")], &expected);
}

#[test]
fn reactive_nodes_ask_from_the_first_child_and_stop_the_others() {
    let xml = "<ReactiveSequence><A/><B/></ReactiveSequence>";
    let expected = ["R A, B", "F A, !B", "R A, B", "S A, B"];
    assert_ticks(xml, &[("A", "SFS"), ("B", "RRS")], &expected);
    let xml = "<ReactiveFallback><A/><B/></ReactiveFallback>";
    let expected = ["R A, B", "S A, !B", "R A, B", "F A, B"];
    assert_ticks(xml, &[("A", "FSF"), ("B", "RRF")], &expected);
}

#[test]
fn a_sequence_with_memory_keeps_its_child_over_a_failure() {
    let xml = "<SequenceWithMemory><A/><B/><C/></SequenceWithMemory>";
    let expected = ["R A", "F B", "R B", "S C", "R A"];
    assert_ticks(xml, &[("B", "FS")], &expected);
}

#[test]
fn a_parallel_ends_as_soon_as_its_counts_decide() {
    let xml = "<Parallel success_count=\"2\" failure_count=\"2\"><A/><B/><C/></Parallel>";
    // C is not ticked in the tick in which A and B decide.
    let expected = ["R A, B, C", "S A, B, !C"];
    assert_ticks(xml, &[("A", "RS"), ("B", "RS"), ("C", "R")], &expected);
    let expected = ["R A, B, C", "F B, !C"];
    assert_ticks(xml, &[("A", "F"), ("B", "RF"), ("C", "R")], &expected);
    // Two successes cannot be reached after two failures of three.
    let xml = "<Parallel success_count=\"-1\" failure_count=\"3\"><A/><B/><C/></Parallel>";
    assert_ticks(xml, &[("A", "F"), ("B", "R"), ("C", "R")], &["F A"]);
    let xml = "<Parallel><A/><B/></Parallel>";
    let expected = ["R A, B", "S A"];
    assert_ticks(xml, &[("A", "RS")], &expected);
}

#[test]
fn a_parallel_of_all_waits_for_all() {
    let xml = "<ParallelAll max_failures=\"2\"><A/><B/><C/></ParallelAll>";
    let expected = ["R A, B, C", "R C", "S C"];
    assert_ticks(xml, &[("A", "F"), ("C", "RRS")], &expected);
    let expected = ["R A, B, C", "F C"];
    assert_ticks(xml, &[("A", "F"), ("B", "F"), ("C", "RS")], &expected);
}

#[test]
fn decorators_of_answers() {
    assert_ticks(
        "<Inverter><A/></Inverter>",
        &[("A", "RSF")],
        &["R A", "F A", "S A"],
    );
    assert_ticks(
        "<ForceSuccess><A/></ForceSuccess>",
        &[("A", "RFS")],
        &["R A", "S A", "S A"],
    );
    assert_ticks(
        "<ForceFailure><A/></ForceFailure>",
        &[("A", "RFS")],
        &["R A", "F A", "F A"],
    );
    let xml = "<KeepRunningUntilFailure><A/></KeepRunningUntilFailure>";
    assert_ticks(xml, &[("A", "SRF")], &["R A", "R A", "F A"]);
}

#[test]
fn a_repeat_starts_the_next_run_in_the_tick_in_which_one_ends() {
    let xml = "<Repeat num_cycles=\"3\"><A/></Repeat>";
    assert_ticks(xml, &[("A", "S")], &["R A", "R A", "S A", "R A"]);
    // A child that was running: its end and the next start are one tick.
    assert_ticks(xml, &[("A", "RSRSRS")], &["R A", "R A, A", "R A, A", "S A"]);
    assert_ticks(xml, &[("A", "RSF")], &["R A", "F A, A"]);
    let xml = "<Repeat num_cycles=\"-1\"><A/></Repeat>";
    assert_ticks(xml, &[("A", "SSSF")], &["R A", "R A", "R A", "F A"]);
}

#[test]
fn a_retry_counts_failures() {
    let xml = "<RetryUntilSuccessful num_attempts=\"2\"><A/></RetryUntilSuccessful>";
    assert_ticks(xml, &[("A", "F")], &["R A", "F A", "R A"]);
    assert_ticks(xml, &[("A", "RFS")], &["R A", "S A, A"]);
}

#[test]
fn a_timeout_fails_before_it_ticks_its_child() {
    let xml = "<Timeout msec=\"200\"><A/></Timeout>";
    let expected = ["R A", "R A", "F !A", "R A"];
    assert_ticks(xml, &[("A", "R")], &expected);
    assert_ticks(xml, &[("A", "RSF")], &["R A", "S A", "F A"]);
    assert_ticks(
        "<Timeout msec=\"0\"><A/></Timeout>",
        &[("A", "RS")],
        &["R A", "S A"],
    );
}

#[test]
fn times() {
    let xml = "<Delay delay_msec=\"150\"><A/></Delay>";
    assert_ticks(xml, &[("A", "RS")], &["R", "R", "R A", "S A", "R"]);
    assert_ticks("<Sleep msec=\"200\"/>", &[], &["R", "R", "S", "R"]);
}

#[test]
fn run_once() {
    let xml = "<RunOnce then_skip=\"false\"><A/></RunOnce>";
    assert_ticks(xml, &[("A", "RF")], &["R A", "F A", "F", "F"]);
    let xml = "<Sequence><RunOnce><A/></RunOnce><B/></Sequence>";
    assert_ticks(xml, &[("A", "RF")], &["R A", "F A", "S B", "S B"]);
    let xml = "<Fallback><RunOnce><A/></RunOnce><B/></Fallback>";
    assert_ticks(xml, &[("A", "RS")], &["R A", "S A", "S B", "S B"]);
}

#[test]
fn constant_answers() {
    assert_ticks("<AlwaysSuccess/>", &[], &["S", "S"]);
    assert_ticks("<Fallback><AlwaysFailure/><A/></Fallback>", &[], &["S A"]);
}

#[test]
fn if_then_else_asks_once() {
    let xml = "<IfThenElse><C/><A/><B/></IfThenElse>";
    // The then branch that fails is the answer: the else branch does not run.
    let expected = ["R C", "R C, A", "F A", "R C, B", "S B"];
    let scripts = [("C", "RSF"), ("A", "RF"), ("B", "RS")];
    assert_ticks(xml, &scripts, &expected);
    let xml = "<IfThenElse><C/><A/></IfThenElse>";
    assert_ticks(xml, &[("C", "FS")], &["F C", "S C, A"]);
}

#[test]
fn preconditions_are_asked_on_entry_and_while_in_every_tick() {
    let set = |value| format!("<Script code=\"on := {value}\"/>");
    // `_skipIf` does not stop what runs.
    let xml = format!("<Sequence>{}<A _skipIf=\"on\"/><B/></Sequence>", set(true));
    assert_ticks(&xml, &[("A", "R")], &["S B"]);
    let xml = format!("<Sequence>{}<A _skipIf=\"on\"/><B/></Sequence>", set(false));
    assert_ticks(&xml, &[("A", "RS")], &["R A", "S A, B"]);
    let xml = format!(
        "<Fallback><Inverter>{}</Inverter><A _skipIf=\"on\"/><B/></Fallback>",
        set(true)
    );
    assert_ticks(&xml, &[], &["S B"]);
    let xml = format!(
        "<Sequence>{}<A _successIf=\"on\"/><B/></Sequence>",
        set(true)
    );
    assert_ticks(&xml, &[], &["S B"]);
    let xml = format!(
        "<Sequence>{}<A _failureIf=\"!on\"/><B/></Sequence>",
        set(false)
    );
    assert_ticks(&xml, &[], &["F"]);
    let xml = "<Parallel success_count=\"2\"><Sequence><Script code=\"on := true\"/><Sleep \
               msec=\"150\"/><Script code=\"on := false\"/></Sequence><Sequence><A _while=\"on\"/>\
               <B/></Sequence></Parallel>";
    assert_ticks(xml, &[("A", "R")], &["R A", "R A", "S !A, B"]);
}

#[test]
fn scripts_after_a_node() {
    let xml = "<Sequence><ForceSuccess><A _onSuccess=\"x := 1\" _onFailure=\"x := 2\"/>\
               </ForceSuccess><B text=\"{x}\"/></Sequence>";
    assert_ticks(
        xml,
        &[("A", "RSF")],
        &["R A", "S A, B text=1", "S A, B text=2"],
    );
    let xml = "<Sequence><ForceSuccess><A _post=\"done := true\"/></ForceSuccess>\
               <ScriptCondition code=\"done == true\"/></Sequence>";
    assert_ticks(xml, &[("A", "F")], &["S A"]);
}

#[test]
fn scripts_set_and_compare() {
    let xml = "<Sequence><Script code=\"a := 3; b := 'red'; c := a\"/>\
               <ScriptCondition code=\"a &gt;= 3 &amp;&amp; a &lt; 4 &amp;&amp; b == 'red'\"/>\
               <ScriptCondition code=\"!(c != 3) || b == 'blue'\"/><B text=\"{c}\"/></Sequence>";
    assert_ticks(xml, &[], &["S B text=3"]);
    let xml = "<Sequence><SetBlackboard output_key=\"k\" value=\"7\"/>\
               <ScriptCondition code=\"2 &gt; k\"/></Sequence>";
    assert_ticks(xml, &[], &["F"]);
    let xml = "<Sequence><Script code=\"a := 2\"/><ScriptCondition code=\"a\"/></Sequence>";
    assert_ticks(xml, &[], &["S"]);
}

#[test]
fn comparisons_with_a_key_that_has_no_value() {
    for (code, holds) in [
        ("k == 3", false),
        ("k &lt; 3", false),
        ("k &gt; 3", false),
        ("k != 3", true),
        ("k &gt;= 3", true),
        ("k &lt;= 3", true),
        ("!(k == 3)", true),
    ] {
        let xml = format!("<ScriptCondition code=\"{code}\"/>");
        assert_ticks(&xml, &[], &[if holds { "S" } else { "F" }]);
    }
}

#[test]
fn a_precondition_node_asks_when_its_child_starts() {
    let xml = "<Sequence><Script code=\"on := false\"/><Precondition if=\"on\" else=\"SUCCESS\">\
               <A/></Precondition><B/></Sequence>";
    assert_ticks(xml, &[], &["S B"]);
    let xml = xml.replace("else=\"SUCCESS\"", "");
    assert_ticks(&xml, &[], &["F"]);
}

#[test]
fn a_subtree_answers_as_its_root() {
    let xml = "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\">\
               <Fallback><SubTree ID=\"Inner\"/><B/></Fallback></BehaviorTree>\
               <BehaviorTree ID=\"Inner\"><Sequence><A/></Sequence></BehaviorTree></root>";
    assert_ticks(xml, &[("A", "RF")], &["R A", "S A, B"]);
}
