//! The same wrong input gives the same sentence, whichever way a cell is run: four
//! processes, one process, many seeds, Python, and the page of a running cell.

use std::fs;
use std::path::Path;
use std::process::Command;

use robocell_tests::cell::{TestCell, base};
use robocell_tests::page_socket::PageSocket;
use robocell_tests::program::{Said, finish, robocell};
use serde_json::{Value, json};

/// One wrong input.
struct Input {
    cell: &'static str,
    /// File of the data folder, a part of it, and that part with the mistake.
    edit: (&'static str, &'static str, &'static str),
    policy: Option<&'static str>,
    set: Option<&'static str>,
    /// A line of a script.
    script: Option<&'static str>,
    /// Body of `decide` of a task in Python, with the mistake.
    python: Option<&'static str>,
    page: Page,
    sentence: &'static str,
}

/// How the page meets the mistake.
enum Page {
    /// A cell runs with the right files; then the page asks for the scene of the wrong ones.
    Load,
    /// Nothing but a start takes such an input: it is refused before there is a page.
    Start,
    /// It is in the log of the page.
    Log,
    /// A cell runs with the right task; then the page restarts the wrong one.
    Restart,
}

const NONE: Input = Input {
    cell: "cube",
    edit: ("cells/cube.toml", "", ""),
    policy: None,
    set: None,
    script: None,
    python: None,
    page: Page::Load,
    sentence: "",
};

const INPUTS: [Input; 12] = [
    Input {
        edit: ("cells/cube.toml", "mass_kg = 0.1", "mass_kg = -0.1"),
        sentence: "cells/cube.toml:29: object.0.mass_kg is -0.1; 0.001 to 100 is allowed",
        ..NONE
    },
    Input {
        policy: Some("jsno"),
        sentence: "unknown policy 'jsno' for demo 'cube'; did you mean 'json'?",
        ..NONE
    },
    Input {
        edit: (
            "cells/cube/cube.machine.toml",
            "object = \"cube\", above_m = 0.1 },",
            "object = \"cub\", above_m = 0.1 },",
        ),
        policy: Some("table"),
        sentence: "cube.machine.toml:12:12: MoveTo: unknown object 'cub'; did you mean 'cube'?",
        ..NONE
    },
    Input {
        edit: ("cells/cube/cube.tree.json", "\"Holding\"", "\"Holdin\""),
        policy: Some("json"),
        sentence: "cube.tree.json:21:36: unknown node type 'Holdin'; did you mean 'Holding'?",
        ..NONE
    },
    Input {
        edit: (
            "cells/cube/cube.machine.toml",
            "source = \"fetching\"",
            "source = \"fetchin\"",
        ),
        policy: Some("table"),
        sentence: "cube.machine.toml:48:10: unknown state 'fetchin'; did you mean 'fetching'?",
        ..NONE
    },
    // A warning: the cell runs all the same.
    Input {
        edit: (
            "robots/panda/panda.urdf",
            "<limit",
            "<limit foo=\"1\"/><limit",
        ),
        set: Some("time_limit_s=0.5"),
        sentence: "panda.urdf:45: 'panda_joint1' has a second limit, which is ignored",
        ..NONE
    },
    Input {
        edit: (
            "robots/panda/panda.urdf",
            "link=\"panda_link1\"",
            "link=\"panda_link9\"",
        ),
        sentence: "panda.urdf:40: joint 'panda_joint1' is attached to 'panda_link9'; no such link",
        ..NONE
    },
    Input {
        script: Some(r#"{"at_s": 1, "do": "drag", "object": "cub", "to": [0.4, 0.1, 0.1]}"#),
        page: Page::Start,
        sentence: ":1: unknown object 'cub'; did you mean 'cube'?",
        ..NONE
    },
    Input {
        edit: ("cells/cube.toml", "name = \"table\"", "name = \"board\""),
        set: Some("fixture.table.friction=0.5"),
        sentence: "fixture.table.friction is not a key of this cell; fixture: known are: board",
        ..NONE
    },
    Input {
        python: Some("raise ValueError('the camera is not calibrated')"),
        page: Page::Restart,
        sentence: "task.py:7: in decide: ValueError: the camera is not calibrated",
        ..NONE
    },
    Input {
        python: Some("cell.arm.do(skills.pick('cubee'))"),
        page: Page::Restart,
        sentence: "task.py:7: in decide: ValueError: unknown object 'cubee'; did you mean 'cube'?",
        ..NONE
    },
    Input {
        cell: "franka-stack",
        script: Some(r#"{"at_s": 0.1, "do": "drag", "object": "red_cube", "to": [0.3, 1.4, 0.2]}"#),
        page: Page::Log,
        sentence: "red_cube stayed out of reach",
        ..NONE
    },
];

impl Input {
    /// The data folder in `dir`, with or without the mistake.
    fn write(&self, dir: &Path, wrong: bool) {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        for folder in ["cells", "cells/cube", "robots/panda"] {
            let to = dir.join(folder);
            fs::create_dir_all(&to).unwrap();
            for file in fs::read_dir(root.join(folder)).unwrap().flatten() {
                if file.path().is_file() {
                    fs::copy(file.path(), to.join(file.file_name())).unwrap();
                }
            }
        }
        if wrong {
            let (file, from, to) = self.edit;
            let text = fs::read_to_string(dir.join(file)).unwrap();
            assert!(text.contains(from), "{file}: {from}");
            fs::write(dir.join(file), text.replacen(from, to, 1)).unwrap();
        }
        if let Some(line) = self.script {
            fs::write(dir.join("script.jsonl"), line).unwrap();
        }
        if let Some(body) = self.python {
            let body = if wrong { body } else { "pass" };
            let text = format!(
                "from robocell.task import policy, skills\n\n\n@policy\nclass Task:\n    \
                 def decide(self, cell):\n        {body}\n"
            );
            fs::write(dir.join("task.py"), text).unwrap();
        }
    }

    /// The options of `run` and `eval`, but for the policy.
    fn options(&self, dir: &Path) -> Vec<String> {
        let file = |name: &str| dir.join(name).display().to_string();
        let given = [
            ("--data", Some(dir.display().to_string())),
            ("--set", self.set.map(str::to_owned)),
            ("--script", self.script.map(|_| file("script.jsonl"))),
            ("--task", self.python.map(|_| file("task.py"))),
        ];
        let given = given.into_iter();
        let given = given.filter_map(|(name, value)| Some([name.to_owned(), value?]));
        given.flatten().collect()
    }

    fn words<'a>(&'a self, command: &'a str, options: &'a [String]) -> Vec<&'a str> {
        let policy = self.policy.into_iter();
        let policy = policy.flat_map(|policy| ["--policy", policy]);
        let words = [command, self.cell].into_iter().chain(policy);
        words.chain(options.iter().map(String::as_str)).collect()
    }

    /// The sentence is in what was said.
    #[track_caller]
    fn check(&self, mode: &str, said: &str) {
        assert!(
            said.contains(self.sentence),
            "{mode}: no {:?} in:\n{said}",
            self.sentence
        );
    }

    fn check_commands(&self, dir: &Path, options: &[String]) {
        let text = |said: Said| format!("{}{}", said.stdout, said.stderr);
        let ask = |words: &[&str]| text(finish(robocell(dir, words)));
        let run = self.words("run", options);
        let headless = ["--headless", "--until-done", "--speed", "max"];
        self.check("four", &ask(&[&run[..], &headless].concat()));
        self.check("json", &ask(&[&run[..], &headless, &["--json"]].concat()));
        let one = ["--one-process", "--until-done"];
        self.check("one", &ask(&[&run[..], &one].concat()));
        self.check("one json", &ask(&[&run[..], &one, &["--json"]].concat()));
        let eval = self.words("eval", options);
        self.check("eval", &ask(&[&eval[..], &["--seeds", "1"]].concat()));
        let rows = dir.join("rows.jsonl").display().to_string();
        let out = ["--seeds", "1", "--out", &rows];
        let said = ask(&[&eval[..], &out].concat());
        let rows = fs::read_to_string(rows).unwrap_or_default();
        self.check("rows", &format!("{said}{rows}"));
    }

    fn check_page(&self, dir: &Path, options: &[String]) {
        self.write(dir, !matches!(self.page, Page::Load | Page::Restart));
        let options: Vec<&str> = options.iter().map(String::as_str).collect();
        let mut words = vec![self.cell, "--speed", "max"];
        if !matches!(self.page, Page::Log) {
            words.push("--paused");
        }
        words.extend(options);
        let mut cell = TestCell::start(&words);
        if matches!(self.page, Page::Start) {
            return self.check("page", &cell.wait_end().stderr);
        }
        let mut page = PageSocket::open(&cell);
        if matches!(self.page, Page::Log) {
            page.wait_log(self.sentence);
            return;
        }
        cell.wait_up();
        self.write(dir, true);
        if matches!(self.page, Page::Restart) {
            page.ask(json!({ "do": "resume" }));
            page.ask(json!({ "do": "restart", "process": "task" }));
            page.wait_log(self.sentence);
            return;
        }
        let policy = self.policy.map_or(Value::Null, |policy| json!(policy));
        let load = json!({
            "do": "load", "demo": self.cell, "policy": policy, "seed": 1, "speed": "max",
        });
        self.check("page", &page.ask(load).to_string());
    }

    fn check_python(&self, dir: &Path) {
        let program = r"
import json, sys, warnings
import robocell
given = json.load(sys.stdin)
warnings.simplefilter('always')
if given.pop('task'):
    sys.path.insert(0, given['data'])
    given['policy'] = __import__('task').Task
try:
    cell = robocell.Cell(**given)
    try:
        cell.run()
    finally:
        print(*cell.log(), cell.summary()['message'], sep='\n')
except Exception as error:
    print(error)
";
        let set = self.set.and_then(|one| one.split_once('='));
        let set = set.map(|(key, value)| json!({ key: value.parse::<f64>().unwrap() }));
        let given = json!({
            "name": self.cell, "data": dir, "set": set, "script": self.script,
            "policy": self.policy.unwrap_or("default"), "task": self.python.is_some(),
        });
        fs::write(dir.join("given.json"), given.to_string()).unwrap();
        let mut command = Command::new(cell_run::python::interpreter());
        command.args(["-B", "-c", program]);
        command.stdin(fs::File::open(dir.join("given.json")).unwrap());
        let said = finish(command);
        self.check("python", &format!("{}{}", said.stdout, said.stderr));
    }
}

/// Why the rows of Python are left out.
fn no_python() -> Option<String> {
    let mut command = Command::new(cell_run::python::interpreter());
    command.args(["-c", "import robocell"]);
    let said = command.output();
    let has = said.as_ref().is_ok_and(|said| said.status.success());
    (!has).then(|| {
        "Python has no package robocell: `PYTHONPATH` or `ROBOCELL_PYTHON` names one".to_owned()
    })
}

#[test]
fn the_same_wrong_input_gives_the_same_sentence_in_every_mode() {
    let no_python = no_python();
    if let Some(why) = &no_python {
        eprintln!("skipped: tasks and cells in Python: {why}");
    }
    for input in INPUTS {
        eprintln!("{}", input.sentence);
        if input.python.is_some() && no_python.is_some() {
            continue;
        }
        let base = base();
        let data = base.path().join("data");
        input.write(&data, true);
        let options = input.options(&data);
        input.check_commands(base.path(), &options);
        if no_python.is_none() {
            input.check_python(&data);
        }
        input.check_page(&data, &options);
    }
}
