//! The channels of a recording, by name.

use ipc_types::topic::Process;
use ipc_types::{
    ArmCommand, ArmStatus, ClientInput, Decision, Keyframe, MAX_ARMS, TraceLine, Wire, WorldPiece,
};

use crate::{foxglove, layout};

/// A channel of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    /// `WorldPiece`s, cut after the used objects.
    World,
    /// `ArmCommand`s of an arm.
    Command(u8),
    /// `ArmStatus`es of an arm.
    Status(u8),
    /// `Decision`s.
    Decision,
    /// `TraceLine`s that draw pictures.
    Trace,
    /// `TraceLine`s for people.
    Log,
    /// `Keyframe`s of a process, cut after the record.
    Keyframe(Process),
    /// `ClientInput`s of an arm, cut after the received bytes.
    Client(u8),
    /// The run file (JSON).
    Run,
    /// The scene of the page (JSON).
    Scene,
    /// Health of a process, once a second (JSON).
    Health(Process),
    /// What the monitor adds to the page: incidents, restarts, requests of people (JSON).
    Page,
    /// Messages that were not recorded (JSON).
    Gaps,
    /// Generation of physics from here on (JSON); starts a chunk.
    Epoch,
    /// `foxglove.FrameTransforms` (JSON).
    Transforms,
    /// `foxglove.SceneUpdate` (JSON).
    SceneUpdate,
    /// `foxglove.JointStates` of an arm (JSON).
    JointStates(u8),
    /// Tracking error: difference between joints and setpoints of an arm (JSON).
    Tracking(u8),
    /// `foxglove.Log` (JSON).
    FoxgloveLog,
}

/// Schema of a channel: name, encoding, data.
pub(crate) struct Schema {
    pub(crate) name: &'static str,
    pub(crate) encoding: &'static str,
    pub(crate) data: String,
}

impl Channel {
    /// Whether its messages repeat while the cell is paused.
    pub(crate) fn is_of_state(self) -> bool {
        matches!(self, Self::World | Self::Status(_))
    }

    /// All channels of a cell of `arms` arms.
    pub fn all(arms: u8) -> Vec<Self> {
        // The order gives the numbers in the file; readers go by names, so it may change.
        let mut all = vec![Self::World, Self::Decision, Self::Trace, Self::Log];
        for arm in 0..arms {
            all.extend([
                Self::Command(arm),
                Self::Status(arm),
                Self::JointStates(arm),
                Self::Tracking(arm),
            ]);
            all.push(Self::Keyframe(Process::Controller(arm)));
            all.push(Self::Client(arm));
        }
        all.push(Self::Keyframe(Process::Task));
        all.extend(Process::all(arms).into_iter().map(Self::Health));
        all.extend([Self::Run, Self::Scene, Self::Page, Self::Gaps, Self::Epoch]);
        all.extend([Self::Transforms, Self::SceneUpdate, Self::FoxgloveLog]);
        all
    }

    /// Its name in the file.
    pub fn name(self) -> String {
        match self {
            Self::World => "world".to_owned(),
            Self::Command(arm) => format!("arm/{arm}/command"),
            Self::Status(arm) => format!("arm/{arm}/status"),
            Self::Decision => "decision".to_owned(),
            Self::Trace => "trace".to_owned(),
            Self::Log => "log".to_owned(),
            Self::Keyframe(process) => format!("keyframe/{}", process.name()),
            Self::Client(arm) => format!("arm/{arm}/client"),
            Self::Run => "run".to_owned(),
            Self::Scene => "scene".to_owned(),
            Self::Health(process) => format!("health/{}", process.name()),
            Self::Page => "page".to_owned(),
            Self::Gaps => "gaps".to_owned(),
            Self::Epoch => "epoch".to_owned(),
            Self::Transforms => "/tf".to_owned(),
            Self::SceneUpdate => "/scene".to_owned(),
            Self::JointStates(arm) => format!("/joint_states/{arm}"),
            Self::Tracking(arm) => format!("/tracking/{arm}"),
            Self::FoxgloveLog => "/log".to_owned(),
        }
    }

    /// The channel called `name`; `None` for an unknown one.
    pub fn of_name(name: &str) -> Option<Self> {
        // All arms a cell can have: the name alone does not
        // tell how many the recorded cell had.
        let arms = u8::try_from(MAX_ARMS).unwrap_or(u8::MAX);
        Self::all(arms).into_iter().find(|c| c.name() == name)
    }

    /// Whether its messages are structs of ipc-types, bit for bit, packed.
    pub fn is_wire(self) -> bool {
        match self {
            Self::World
            | Self::Command(_)
            | Self::Status(_)
            | Self::Decision
            | Self::Trace
            | Self::Log
            | Self::Keyframe(_)
            | Self::Client(_) => true,
            Self::Run
            | Self::Scene
            | Self::Health(_)
            | Self::Page
            | Self::Gaps
            | Self::Epoch
            | Self::Transforms
            | Self::SceneUpdate
            | Self::JointStates(_)
            | Self::Tracking(_)
            | Self::FoxgloveLog => false,
        }
    }

    // A format of its own name: a reader that takes it for plain structs would read garbage.
    pub(crate) fn message_encoding(self) -> &'static str {
        if self.is_wire() {
            "robocell/packed"
        } else {
            "json"
        }
    }

    pub(crate) fn schema(self) -> Schema {
        let json = |name, data: &str| Schema {
            name,
            encoding: "jsonschema",
            data: data.to_owned(),
        };
        match self {
            Self::World => own::<WorldPiece>("WorldPiece"),
            Self::Command(_) => own::<ArmCommand>("ArmCommand"),
            Self::Status(_) => own::<ArmStatus>("ArmStatus"),
            Self::Decision => own::<Decision>("Decision"),
            Self::Trace | Self::Log => own::<TraceLine>("TraceLine"),
            Self::Keyframe(_) => own::<Keyframe>("Keyframe"),
            Self::Client(_) => own::<ClientInput>("ClientInput"),
            Self::Run => json("robocell.Run", r#"{"type":"object"}"#),
            Self::Scene => json("robocell.Scene", r#"{"type":"object"}"#),
            Self::Health(_) => json("robocell.Health", HEALTH),
            Self::Page => json("robocell.Page", PAGE),
            Self::Gaps => json("robocell.Gap", GAP),
            Self::Epoch => json("robocell.Epoch", EPOCH),
            Self::Transforms => json("foxglove.FrameTransforms", foxglove::FRAME_TRANSFORMS),
            Self::SceneUpdate => json("foxglove.SceneUpdate", foxglove::SCENE_UPDATE),
            Self::JointStates(_) => json("foxglove.JointStates", foxglove::JOINT_STATES),
            Self::Tracking(_) => json("robocell.TrackingErrors", foxglove::TRACKING),
            Self::FoxgloveLog => json("foxglove.Log", foxglove::LOG),
        }
    }
}

/// Of a struct of the wire.
fn own<T: Wire>(name: &'static str) -> Schema {
    Schema {
        name,
        encoding: layout::ENCODING,
        data: layout::of::<T>(),
    }
}

const HEALTH: &str = r#"{"type":"object","properties":{"pid":{"type":"integer"},"generation":{"type":"integer"},"cycles":{"type":"integer"},"missed":{"type":"integer"},"rejected":{"type":"integer"},"fenced":{"type":"integer"},"rate_hz":{"type":"number"},"late_p50_us":{"type":"number"},"late_p99_us":{"type":"number"},"late_max_us":{"type":"number"},"body_p50_us":{"type":"number"},"body_p99_us":{"type":"number"},"note":{"type":"string"}}}"#;
const PAGE: &str = r#"{"type":"object","properties":{"lines":{"type":"array","items":{"type":"object"}},"spans":{"type":"array","items":{"type":"object"}},"incident":{"type":"object"}}}"#;
const GAP: &str = r#"{"type":"object","properties":{"channel":{"type":"string"},"count":{"type":"integer"},"before_seq":{"type":"integer"},"why":{"type":"string"}}}"#;
const EPOCH: &str =
    r#"{"type":"object","properties":{"epoch":{"type":"integer"}},"required":["epoch"]}"#;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_leads_back_to_its_channel() {
        for channel in Channel::all(2) {
            assert_eq!(Channel::of_name(&channel.name()), Some(channel));
            let has_layout = channel.schema().encoding == layout::ENCODING;
            assert_eq!(channel.is_wire(), has_layout);
        }
        assert_eq!(Channel::of_name("arm/9/command"), None);
    }
}
