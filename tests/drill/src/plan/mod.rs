//! A plan: everything that a run of a simulated cell depends on.

use cell_run::spec::{RecordSpec, RunSpec, Speed};
use ipc_types::operator::OperatorAction;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{OperatorRequest, Pose, Wire};
use serde::{Deserialize, Serialize};

use crate::scene::Scene;

mod fault;

pub use fault::Fault;

/// Nanoseconds in a millisecond.
pub const MS: u64 = 1_000_000;

/// A run is a pure function of its plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Seed of scene and timing noise.
    pub seed: u64,
    /// Name of the demo; that of the scene where the plan has one.
    pub demo: String,
    /// A scene that no file of the checkout has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<Scene>,
    /// Policy of its task.
    pub policy: String,
    /// Whether physics waits for all processes.
    pub lockstep: bool,
    /// Whether real-time scheduling is granted.
    pub fifo: bool,
    /// Virtual time at which the run ends (ms).
    pub horizon_ms: u64,
    /// Simulated time after which the run ends, if its job is not done before (s); `None` for a
    /// run that only the horizon ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_s: Option<u32>,
    /// Faults, in the order of their times.
    pub faults: Vec<Timed>,
    /// Lines of the script, as in its file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub script: Vec<String>,
    /// Requests of people, in the order of their times.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub people: Vec<Asked>,
}

/// A request of a person, repeated until physics answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Asked {
    /// Since the start of the run (us).
    pub at_us: u64,
    /// See [`Asked::ACTIONS`].
    pub action: String,
    /// Its argument.
    #[serde(default)]
    pub count: u32,
    /// Place, arm and object are drawn from this.
    #[serde(default)]
    pub draw: u64,
}

impl Asked {
    /// The requests by name.
    pub const ACTIONS: [(&str, OperatorAction); 13] = [
        ("pause", OperatorAction::Pause),
        ("resume", OperatorAction::Resume),
        ("step", OperatorAction::Step),
        ("reset", OperatorAction::Reset),
        ("task_pause", OperatorAction::TaskPause),
        ("task_resume", OperatorAction::TaskResume),
        ("task_reset", OperatorAction::TaskReset),
        ("task_start", OperatorAction::TaskStart),
        ("drag", OperatorAction::Drag),
        ("target", OperatorAction::Target),
        ("gripper", OperatorAction::Gripper),
        ("drop_parts", OperatorAction::DropParts),
        ("add_bin", OperatorAction::AddBin),
    ];

    /// The request, if it has one of the names.
    pub fn request(&self) -> Option<OperatorRequest> {
        let named = |(name, _): &&(&str, OperatorAction)| *name == self.action;
        let (_, action) = Self::ACTIONS.iter().find(named)?;
        let mut request = OperatorRequest::zeroed();
        request.action = action.code();
        request.count = self.count;
        request.pose = Pose::IDENTITY;
        // Mostly where an arm can reach, sometimes where nothing is.
        let far = if noise(self.draw, 0, 0).is_multiple_of(8) {
            25.0
        } else {
            0.9
        };
        for (axis, out) in request.pose.position.iter_mut().enumerate() {
            let unit = noise(self.draw, 1, axis as u64) % 2001;
            *out = far * (unit as f64 / 1000.0 - 1.0);
        }
        let below =
            |of: u64, below: u64| u32::try_from(noise(self.draw, of, 0) % below).unwrap_or(0);
        (request.object, request.arm) = (below(2, 8), below(3, 3));
        request.seconds = f64::from(below(4, 200)) * 0.01;
        Some(request)
    }
}

/// A fault at a virtual time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timed {
    /// Since the start of the run (us).
    pub at_us: u64,
    /// What happens then.
    #[serde(flatten)]
    pub fault: Fault,
}

impl Plan {
    /// The run file of its processes.
    ///
    /// # Errors
    /// When a run file has other fields than this one.
    pub fn spec(&self, arms: u8) -> Result<RunSpec, serde_json::Error> {
        let speed = if self.lockstep {
            Speed::Max
        } else {
            Speed::RealTime
        };
        serde_json::from_value(serde_json::json!({
            "run": 1, "cell": "drill", "demo": self.demo, "policy": self.policy,
            "seed": self.seed, "speed": speed, "data_dir": null, "run_dir": "", "root": "",
            "prefix": "", "arms": arms, "robot": null, "script": [], "paused": false,
            "until_done": self.limit_s.is_some(), "time_limit_s": self.limit_s, "real_time": self.fifo, "page": null,
            "record": RecordSpec::default(),
        }))
    }

    /// Whether its scene has no dynamics.
    pub fn is_ideal(&self) -> bool {
        self.scene.as_ref().is_some_and(|scene| scene.ideal)
    }

    /// The same without faults and requests.
    pub fn calm(&self) -> Self {
        Self {
            faults: Vec::new(),
            script: Vec::new(),
            people: Vec::new(),
            ..self.clone()
        }
    }
}

/// Ticks in `seconds`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "times of a plan are positive and short"
)]
pub fn ticks(seconds: f64) -> u64 {
    (seconds * 1000.0).round() as u64
}

/// The process with this name, of a cell of `arms` arms.
pub fn process(name: &str, arms: u8) -> Option<Process> {
    let all = Process::all(arms);
    all.into_iter().find(|process| process.name() == name)
}

/// Names of the topics of a cell of `arms` arms whose messages may be damaged or repeated.
pub fn topics(arms: u8) -> Vec<(String, TopicId)> {
    let mut topics = vec![
        ("state".to_owned(), TopicId::WorldState),
        ("decision".to_owned(), TopicId::Decision),
    ];
    for arm in 0..arms {
        topics.push((format!("command-{arm}"), TopicId::ArmCommand(arm)));
        topics.push((format!("status-{arm}"), TopicId::ArmStatus(arm)));
    }
    let health = |of: Process| (format!("health-{}", of.name()), TopicId::Health(of));
    topics.extend(Process::all(arms).into_iter().map(health));
    topics
}

/// The topic with this name.
pub fn topic(name: &str, arms: u8) -> Option<TopicId> {
    let mut all = topics(arms).into_iter();
    all.find(|(of, _)| of == name).map(|(_, topic)| topic)
}

/// A number that depends on nothing but its arguments: removing an event from a plan leaves all
/// other draws as they were.
pub fn noise(seed: u64, of: u64, count: u64) -> u64 {
    // SplitMix64, by Steele, Lea and Flood (2014).
    let mut z = seed ^ of.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ count.rotate_left(32);
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
