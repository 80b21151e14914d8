//! Types of ROS 2 with their published hashes (REP 2016), of ROS 2 Jazzy and later.

/// A message or service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RosType {
    /// `package/msg/Name` or `package/srv/Name`.
    pub name: &'static str,
    /// RIHS01 hash of its description. A node with another hash does not connect.
    pub hash: &'static str,
}

macro_rules! types {
    ($($constant:ident = $name:literal, $hash:literal;)*) => {
        $(
            #[doc = concat!("`", $name, "`.")]
            pub const $constant: RosType = RosType { name: $name, hash: $hash };
        )*
        /// All that the bridge uses.
        pub const ALL: &[RosType] = &[$($constant),*];
    };
}

types! {
    // Hashes as published with ROS 2; they cannot be computed from the name.
    JOINT_STATE = "sensor_msgs/msg/JointState",
        "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e";
    TF_MESSAGE = "tf2_msgs/msg/TFMessage",
        "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087";
    CLOCK = "rosgraph_msgs/msg/Clock",
        "RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564";
    STRING = "std_msgs/msg/String",
        "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18";
    MARKER_ARRAY = "visualization_msgs/msg/MarkerArray",
        "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf";
    POSE_STAMPED = "geometry_msgs/msg/PoseStamped",
        "RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8";
    TRIGGER = "std_srvs/srv/Trigger",
        "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f";
}

impl RosType {
    /// As DDS names it: `package::msg::dds_::Name_`.
    pub fn dds_name(self) -> String {
        let mut parts: Vec<&str> = self.name.split('/').collect();
        let last = parts.pop().unwrap_or_default();
        format!("{}::dds_::{last}_", parts.join("::"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_of_ros_becomes_one_of_dds() {
        assert_eq!(TRIGGER.dds_name(), "std_srvs::srv::dds_::Trigger_");
        for known in ALL {
            assert_eq!(known.hash.len(), "RIHS01_".len() + 64, "{}", known.name);
        }
    }
}
