//! Keys of `rmw_zenoh` (its `docs/design.md`, and `liveliness_utils.cpp` of ROS 2 Jazzy).
//!
//! | what | key |
//! |---|---|
//! | messages | `DOMAIN/TOPIC/TYPE/HASH` |
//! | a node | `@ros2_lv/DOMAIN/SESSION/NODE/NODE/NN/ENCLAVE/NAMESPACE/NAME` |
//! | an endpoint | `@ros2_lv/DOMAIN/SESSION/NODE/ID/KIND/ENCLAVE/NAMESPACE/NAME/TOPIC/TYPE/HASH/QOS` |
//!
//! In the keys that announce nodes and endpoints, `%` replaces `/`, and alone means "empty".

use crate::ros::types::RosType;

/// Enclave and namespace that are empty.
// A part of a key must not be empty.
const EMPTY: &str = "%";
/// Reliable, volatile, and the last ten messages are kept; defaults are left out.
const QOS: &str = "::,10:,:,:,,";

/// Kind of an endpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Of a topic.
    Publisher,
    /// Of a topic.
    Subscription,
    /// Server of a service.
    Service,
}

impl Kind {
    fn code(self) -> &'static str {
        match self {
            Self::Publisher => "MP",
            Self::Subscription => "MS",
            Self::Service => "SS",
        }
    }
}

/// A node of ROS 2 in a session of zenoh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Node {
    /// ROS domain.
    pub domain: u32,
    /// Id of the session, as zenoh prints it.
    pub session: String,
    /// Number in the session.
    pub id: u32,
    /// `/line1`, or empty.
    pub namespace: String,
    /// Name in the namespace.
    pub name: String,
}

/// A publisher, subscription or server of a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// Number in the session.
    pub id: u32,
    /// Kind.
    pub kind: Kind,
    /// Full name, from `/` on.
    pub topic: String,
    /// Type of its messages.
    pub ros_type: RosType,
}

impl Node {
    /// Key of the token that announces the node.
    pub fn token(&self) -> String {
        format!("{}/NN/{}", self.owner(self.id), self.path())
    }

    /// Key of the token that announces an endpoint of it.
    pub fn endpoint_token(&self, endpoint: &Endpoint) -> String {
        let Endpoint {
            id,
            kind,
            topic,
            ros_type,
        } = endpoint;
        let (owner, kind, path) = (self.owner(*id), kind.code(), self.path());
        let (topic, dds, hash) = (mangled(topic), ros_type.dds_name(), ros_type.hash);
        format!("{owner}/{kind}/{path}/{topic}/{dds}/{hash}/{QOS}")
    }

    /// Key of the messages of an endpoint.
    pub fn topic_key(&self, endpoint: &Endpoint) -> String {
        let (topic, ros_type) = (endpoint.topic.trim_matches('/'), endpoint.ros_type);
        let (dds, hash) = (ros_type.dds_name(), ros_type.hash);
        format!("{}/{topic}/{dds}/{hash}", self.domain)
    }

    fn owner(&self, id: u32) -> String {
        format!("@ros2_lv/{}/{}/{}/{id}", self.domain, self.session, self.id)
    }

    /// Enclave, namespace and name.
    fn path(&self) -> String {
        let namespace = match self.namespace.as_str() {
            "" => EMPTY.to_owned(),
            namespace => mangled(namespace),
        };
        format!("{EMPTY}/{namespace}/{}", mangled(&self.name))
    }
}

fn mangled(name: &str) -> String {
    name.replace('/', "%")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros::types::STRING;

    #[test]
    fn keys_are_those_of_rmw_zenoh() {
        let mut node = Node {
            domain: 2,
            session: "aac3178e146ba6f1fc6e6a4085e77f21".to_owned(),
            id: 0,
            namespace: String::new(),
            name: "listener".to_owned(),
        };
        let endpoint = Endpoint {
            id: 10,
            kind: Kind::Subscription,
            topic: "/chatter".to_owned(),
            ros_type: STRING,
        };
        let owner = "@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0";
        assert_eq!(node.token(), format!("{owner}/0/NN/%/%/listener"));
        let hash = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18";
        let string = format!("std_msgs::msg::dds_::String_/{hash}");
        assert_eq!(
            node.endpoint_token(&endpoint),
            format!("{owner}/10/MS/%/%/listener/%chatter/{string}/::,10:,:,:,,")
        );
        assert_eq!(node.topic_key(&endpoint), format!("2/chatter/{string}"));
        node.namespace = "/line1/left".to_owned();
        assert_eq!(node.token(), format!("{owner}/0/NN/%/%line1%left/listener"));
    }
}
