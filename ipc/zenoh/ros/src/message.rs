//! Messages and services: a struct each, whose fields in their order are the interface.

use crate::field::{Field, Types};
use crate::messages::service_msgs::ServiceEventInfo;
use crate::{Bounded, FieldType};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;

/// What a message without fields has, so that it is something.
pub(crate) const NOTHING: (&str, FieldType) = (
    "structure_needs_at_least_one_member",
    FieldType {
        id: 3,
        capacity: 0,
        nested: "",
    },
);

/// A message, such as `geometry_msgs/msg/Pose`.
pub trait Message: Field + Serialize + DeserializeOwned {
    /// Package, kind and name.
    const NAME: &'static str;
}

/// A request and its reply.
pub trait Service {
    /// Package, kind and name, such as `moveit_msgs/srv/GetMotionPlan`.
    const NAME: &'static str;
    /// Of a call's start and end, as introspection publishes it.
    const EVENT: &'static str;
    /// What is asked.
    type Request: Message;
    /// What is replied.
    type Response: Message;
}

/// The message's type, with all that it is made of.
pub(crate) fn of_message<M: Message>() -> (&'static str, Types) {
    let mut types = Types::new();
    M::describe(&mut types);
    (M::NAME, types)
}

/// The service's type: its request, its reply, and the event of both.
pub(crate) fn of_service<S: Service>() -> (&'static str, Types) {
    let mut types = Types::new();
    let request = S::Request::describe(&mut types);
    let response = S::Response::describe(&mut types);
    let event = vec![
        ("info", ServiceEventInfo::describe(&mut types)),
        ("request", Bounded::<S::Request, 1>::describe(&mut types)),
        ("response", Bounded::<S::Response, 1>::describe(&mut types)),
    ];
    types.insert(S::EVENT, event);
    let parts = vec![
        ("request_message", request),
        ("response_message", response),
        ("event_message", FieldType::message(S::EVENT)),
    ];
    types.insert(S::NAME, parts);
    (S::NAME, types)
}

/// The text of a message's `.msg` file, for callers that have no ROS to take it from: the fields
/// alone.
#[must_use]
pub fn definition<M: Message>() -> String {
    let (name, types) = of_message::<M>();
    text(&types[name])
}

/// Names and `.msg` texts of a message and of all that it is made of.
#[must_use]
pub fn definitions<M: Message>() -> Vec<(&'static str, String)> {
    let (_, types) = of_message::<M>();
    let texts = types.iter();
    texts
        .map(|(name, fields)| (*name, text(fields)))
        .collect()
}

fn text(fields: &[(&'static str, FieldType)]) -> String {
    let own: BTreeSet<&str> = [NOTHING.0].into();
    let lines = fields
        .iter()
        .filter(|(name, _)| !own.contains(name))
        .map(|(name, kind)| format!("{} {name}\n", kind.words()));
    lines.collect()
}

/// Structs that are messages. The name in quotes is the message's own; what is written about a
/// field is ours.
macro_rules! messages {
    ($($(#[$doc:meta])* $struct:ident = $name:literal {
        $($(#[$of:meta])* $field:ident: $type:ty,)*
    })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $struct {
            $($(#[$of])* #[allow(missing_docs)] pub $field: $type,)*
        }

        impl crate::Message for $struct {
            const NAME: &'static str = $name;
        }

        impl crate::Field for $struct {
            fn describe(types: &mut crate::field::Types) -> crate::FieldType {
                if !types.contains_key($name) {
                    types.insert($name, Vec::new());
                    #[allow(unused_mut)]
                    let mut fields = vec![$(
                        (stringify!($field).trim_start_matches("r#"), <$type as crate::Field>::describe(types)),
                    )*];
                    types.insert($name, fields);
                }
                crate::FieldType::message($name)
            }
        }
    )*};
}

/// Services by the names of their parts.
macro_rules! services {
    ($($(#[$doc:meta])* $service:ident = $name:literal $event:literal: $request:ty => $response:ty;)*) => {$(
        $(#[$doc])*
        pub enum $service {}

        impl crate::Service for $service {
            const NAME: &'static str = $name;
            const EVENT: &'static str = $event;
            type Request = $request;
            type Response = $response;
        }
    )*};
}

pub(crate) use {messages, services};
