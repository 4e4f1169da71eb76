//! What an object is.

use crate::message::messages;

messages! {
    /// A key in a database of objects.
    ObjectType = "object_recognition_msgs/msg/ObjectType" {
        key: String,
        db: String,
    }
}
