//! A tree of BehaviorTree.CPP as the job of a cell: subtrees of a file provide its leaves.

use std::path::Path;

use robocell_tests::assert::refused;
use robocell_tests::cell::base;
use robocell_tests::program::{Said, finish, robocell};
use robocell_tests::recording::{same, verify};

const MISSION: &str = r#"<root BTCPP_format="4" main_tree_to_execute="Mission">
  <BehaviorTree ID="Mission">
    <Sequence>
      <Script code="goal := 'mark'"/>
      <Fallback>
        <OnTable object="cube" place="{goal}"/>
        <RetryUntilSuccessful num_attempts="3">
          <SubTree ID="Bring" what="cube" where="{goal}"/>
        </RetryUntilSuccessful>
      </Fallback>
      <Retreat/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Bring">
    <Sequence>
      <Grasp object="{what}"/>
      <PutDown object="{what}" place="{where}"/>
      <OnTable object="{what}" place="{where}"/>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <Action ID="Grasp"><input_port name="object" type="std::string"/></Action>
  </TreeNodesModel>
</root>
"#;

const LEAVES: &str = r#"{
  "format": "behavior-tree/1",
  "subtrees": {
    "Grasp": {
      "ports": {"object": {"type": "text"}},
      "root": {"id": "pick", "type": "Pick", "ports": {"object": {"port": "object"}}}
    },
    "PutDown": {
      "ports": {"object": {"type": "text"}, "place": {"type": "text"}},
      "root": {"id": "place", "type": "Place",
        "ports": {"object": {"port": "object"}, "place": {"port": "place"}}}
    },
    "OnTable": {
      "ports": {"object": {"type": "text"}, "place": {"type": "text"}},
      "root": {"id": "at", "type": "At",
        "ports": {"object": {"port": "object"}, "place": {"port": "place"}}}
    },
    "Retreat": {"root": {"id": "home", "type": "Home"}}
  }
}
"#;

/// `robocell bt import` of the mission in the folder.
fn import(base: &Path, folder: &Path) -> Said {
    let at = |name: &str| folder.join(name).display().to_string();
    let arguments = [
        "bt",
        "import",
        &at("mission.xml"),
        "--leaves",
        &at("leaves.tree.json"),
    ];
    finish(robocell(base, &arguments))
}

fn hash(said: &Said) -> String {
    assert_eq!(said.code, 0, "{said:?}");
    said.json()["state_hash"]
        .as_str()
        .expect("a hash")
        .to_owned()
}

#[test]
fn an_imported_tree_does_the_job_of_a_cell_and_resumes() {
    let base = base();
    let mut new = robocell(base.path(), &["new", "mine", "--as", "json"]);
    new.current_dir(base.path());
    assert_eq!(finish(new).code, 0);
    let data = base.path().join("mine");
    let cells = data.join("cells");
    std::fs::write(cells.join("mission.xml"), MISSION).expect("a file");
    std::fs::write(cells.join("leaves.tree.json"), LEAVES).expect("a file");
    let imported = import(base.path(), &cells);
    assert_eq!((imported.code, imported.stderr.as_str()), (0, ""));
    let tree = cells.join("mine.tree.json");
    std::fs::write(&tree, &imported.stdout).expect("a file");
    let tree = tree.display().to_string();
    let checked = finish(robocell(base.path(), &["bt", "check", &tree]));
    assert_eq!(checked.code, 0, "{checked:?}");
    assert!(
        checked.stdout.ends_with(": no errors, 0 warnings\n"),
        "{checked:?}"
    );

    let spare = LEAVES.replace(
        "\"Retreat\"",
        "\"Spare\": {\"root\": {\"id\": \"a\", \"type\": \"Home\"}}, \"Retreat\"",
    );
    std::fs::write(cells.join("leaves.tree.json"), spare).expect("a file");
    let warned = finish(robocell(base.path(), &["bt", "check", &tree]));
    assert!(
        warned.stdout.contains("subtree 'Spare' is not used"),
        "{warned:?}"
    );
    assert!(
        warned.stdout.ends_with(": no errors, 1 warning\n"),
        "{warned:?}"
    );

    let data = data.display().to_string();
    let run = ["run", "mine", "--data", &data, "--until-done", "--json"];
    let one = finish(robocell(
        base.path(),
        &[&run[..], &["--one-process"]].concat(),
    ));
    let script = base.path().join("kill.jsonl");
    let kill = |at| format!("{{\"at_s\": {at}, \"do\": \"kill\", \"process\": \"task\"}}\n");
    std::fs::write(&script, kill(1.5) + &kill(3.5) + &kill(5.5)).expect("a script");
    let (script, file) = (script.display().to_string(), base.path().join("run.mcap"));
    let name = file.display().to_string();
    let four = [
        "--headless",
        "--speed",
        "max",
        "--script",
        &script,
        "--record",
        &name,
    ];
    let killed = finish(robocell(base.path(), &[&run[..], &four].concat()));
    assert_eq!(hash(&killed), hash(&one));
    assert_eq!(killed.json()["task_restarts"], 3, "{killed:?}");
    same(&verify(base.path(), &file, &["--json"]));
}

#[test]
fn leaves_that_are_not_provided_are_named_and_those_that_do_not_fit_refused() {
    let base = base();
    let folder = base.path();
    std::fs::write(folder.join("mission.xml"), MISSION).expect("a file");
    let without = LEAVES.replace("\"Retreat\"", "\"Retreet\"");
    std::fs::write(folder.join("leaves.tree.json"), without).expect("a file");
    let imported = import(base.path(), folder);
    assert_eq!(imported.code, 0, "{imported:?}");
    assert!(
        imported.stderr.contains("Retreat (action, first in"),
        "{imported:?}"
    );
    assert!(!imported.stderr.contains("Grasp"), "{imported:?}");
    let other = LEAVES.replace(
        "\"place\": {\"type\": \"text\"}",
        "\"place\": {\"type\": \"number\"}",
    );
    std::fs::write(folder.join("leaves.tree.json"), other).expect("a file");
    let words = [
        "mission.xml:6:9: OnTable: port 'place' of the subtree 'OnTable' (",
        "leaves.tree.json:13) is of type number, here it is the key 'goal' of type text",
    ];
    refused(&import(base.path(), folder), 3, &words);
    std::fs::remove_file(folder.join("leaves.tree.json")).expect("it is removed");
    refused(&import(base.path(), folder), 3, &["leaves.tree.json"]);
}
