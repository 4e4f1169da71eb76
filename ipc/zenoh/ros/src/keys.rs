//! Under which keys rmw_zenoh's nodes find and call each other (its `docs/design.md`).

use crate::{Message, Service, message_hash, service_hash};

/// Who hears of tokens.
const ADMIN: &str = "@ros2_lv";
/// rmw_zenoh's words for the default quality of service: reliable, volatile, the last ten.
const DEFAULT_QOS: &str = "::,10:,:,:,,";
/// Any type hash: callers of older distributions have none, and those that compute it wrongly are served too.
const ANY: &str = "*";

/// What an entity of a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It publishes messages.
    Publisher,
    /// It gets them.
    Subscription,
    /// It answers a service.
    Server,
    /// It calls one.
    Client,
}

impl Kind {
    fn word(self) -> &'static str {
        match self {
            Self::Publisher => "MP",
            Self::Subscription => "MS",
            Self::Server => "SS",
            Self::Client => "SC",
        }
    }
}

/// A name in the graph, with what is said there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Its name, which begins with `/`.
    name: String,
    /// As DDS writes its type.
    kind: String,
    hash: String,
}

impl Topic {
    /// Where messages are published.
    #[must_use]
    pub fn of_message<M: Message>(name: &str) -> Self {
        Self::new(name, M::NAME, message_hash::<M>())
    }

    /// Where a service is called.
    #[must_use]
    pub fn of_service<S: Service>(name: &str) -> Self {
        Self::new(name, S::NAME, service_hash::<S>())
    }

    fn new(name: &str, kind: &str, hash: String) -> Self {
        let parts: Vec<&str> = kind.split('/').collect();
        Self {
            name: format!("/{}", name.trim_matches('/')),
            kind: format!(
                "{}::dds_::{}_",
                parts[..parts.len() - 1].join("::"),
                parts[parts.len() - 1]
            ),
            hash,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What a publisher puts to, and a client asks.
    #[must_use]
    pub fn key(&self, domain: u32) -> String {
        self.key_of(domain, &self.hash)
    }

    /// What a server and a subscription listen to.
    #[must_use]
    pub fn any_key(&self, domain: u32) -> String {
        self.key_of(domain, ANY)
    }

    fn key_of(&self, domain: u32, hash: &str) -> String {
        format!("{domain}/{}/{}/{hash}", &self.name[1..], self.kind)
    }
}

/// A node, as others see it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Node {
    /// `ROS_DOMAIN_ID`.
    pub domain: u32,
    /// Its session's Zenoh id, in hexadecimal.
    pub session: String,
    /// Its name, without namespace.
    pub name: String,
}

impl Node {
    /// The token that says that it is there.
    #[must_use]
    pub fn token(&self) -> String {
        self.of_entity(0, "NN")
    }

    /// The token of the node's entity with this number.
    #[must_use]
    pub fn entity(&self, number: u32, kind: Kind, topic: &Topic) -> String {
        let Topic {
            name,
            kind: type_name,
            hash,
        } = topic;
        let entity = self.of_entity(number, kind.word());
        format!(
            "{entity}/{}/{type_name}/{hash}/{DEFAULT_QOS}",
            mangled(name)
        )
    }

    /// Neither enclave nor namespace: both are `/`.
    fn of_entity(&self, number: u32, kind: &str) -> String {
        let Self {
            domain,
            session,
            name,
        } = self;
        format!("{ADMIN}/{domain}/{session}/0/{number}/{kind}/%/%/{name}")
    }
}

fn mangled(name: &str) -> String {
    name.replace('/', "%")
}

/// What travels beside a message: which one of whom it is. A reply repeats its request's number and
/// client, or the client drops it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// Counts from 1 for each client or publisher.
    pub sequence: i64,
    /// When it was sent (ns since 1970).
    pub sent_ns: i64,
    /// Who sent it, or whose request is replied to.
    pub gid: [u8; 16],
}

impl Attachment {
    const BYTES: usize = 33;

    /// As bytes: both numbers little-endian, how long the id is, the id.
    #[must_use]
    pub fn bytes(&self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        bytes[..8].copy_from_slice(&self.sequence.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.sent_ns.to_le_bytes());
        bytes[16] = 16;
        bytes[17..].copy_from_slice(&self.gid);
        bytes
    }

    /// Of bytes; `None` where they are no attachment.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let bytes: &[u8; Self::BYTES] = bytes.try_into().ok()?;
        let number = |at: usize| {
            bytes[at..at + 8]
                .try_into()
                .map(i64::from_le_bytes)
                .ok()
        };
        (bytes[16] == 16).then_some(())?;
        Some(Self {
            sequence: number(0)?,
            sent_ns: number(8)?,
            gid: bytes[17..].try_into().ok()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::moveit_msgs::{GetMotionPlan, PlanningScene};

    const HASH: &str = "RIHS01_0e118e1d8d53d5fe";

    #[test]
    fn keys_and_tokens_are_as_the_design_page_writes_them() {
        let topic = Topic::of_service::<GetMotionPlan>("/taut/shorten");
        let key = topic.key(3);
        assert!(
            key.starts_with(&format!(
                "3/taut/shorten/moveit_msgs::srv::dds_::GetMotionPlan_/{HASH}"
            )),
            "{key}"
        );
        assert_eq!(
            topic.any_key(0),
            "0/taut/shorten/moveit_msgs::srv::dds_::GetMotionPlan_/*"
        );
        let node = Node {
            domain: 3,
            session: "3b2a".to_owned(),
            name: "taut".to_owned(),
        };
        assert_eq!(node.token(), "@ros2_lv/3/3b2a/0/0/NN/%/%/taut");
        let entity = node.entity(4, Kind::Server, &topic);
        let begin = "@ros2_lv/3/3b2a/0/4/SS/%/%/taut/%taut%shorten/moveit_msgs::srv::dds_::GetMotionPlan_/RIHS01_";
        assert!(
            entity.starts_with(begin) && entity.ends_with("/::,10:,:,:,,"),
            "{entity}"
        );
        let scene = Topic::of_message::<PlanningScene>("monitored_planning_scene");
        assert_eq!(
            scene.any_key(1),
            "1/monitored_planning_scene/moveit_msgs::msg::dds_::PlanningScene_/*"
        );
    }

    #[test]
    fn an_attachment_comes_back_and_others_are_none() {
        let sent = Attachment {
            sequence: 7,
            sent_ns: -1,
            gid: std::array::from_fn(|at| at as u8),
        };
        let bytes = sent.bytes();
        assert_eq!(Attachment::read(&bytes), Some(sent));
        assert_eq!(Attachment::read(&bytes[1..]), None);
        let mut other = bytes;
        other[16] = 15;
        assert_eq!(Attachment::read(&other), None);
    }
}
