//! Why a scene, or a change to one, is refused.

/// Why a scene was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// Two objects of one name, standing or attached.
    #[error("object {0:?} is defined twice; object ids must be unique")]
    Duplicate(String),
    /// A pose that is no pose.
    #[error("object {id:?}: {what} is {value}; {rule}")]
    BadPose {
        /// Object.
        id: String,
        /// Position or orientation.
        what: String,
        /// Its value.
        value: String,
        /// What it must be.
        rule: &'static str,
    },
    /// A frame's pose that is no pose.
    #[error("frame {name:?}: {what} is {value}; {rule}")]
    BadFrame {
        /// Frame.
        name: String,
        /// Position or orientation.
        what: String,
        /// Its value.
        value: String,
        /// What it must be.
        rule: &'static str,
    },
    /// A frame and an object of one name.
    #[error(
        "{0:?} is the name of a frame and of an object; rename one, poses may be given in either"
    )]
    NameTaken(String),
    /// A pose in a frame that is not there.
    #[error("{frame:?} is no frame of the scene; valid: {valid}")]
    UnknownFrame {
        /// Its name.
        frame: String,
        /// Names of the world, named frames, objects that stand, and frames on them.
        valid: String,
    },
    /// Frames that hang on one another.
    #[error(
        "the frames of {0} hang on one another in a circle; give one of their poses in the world"
    )]
    FrameCircle(String),
    /// Something that would be left out, were the rest read.
    #[error("{what}: {advice}")]
    Unsupported {
        /// What it is, and where it stands.
        what: String,
        /// Why it is refused, and what to do.
        advice: &'static str,
    },
    /// A size that no solid has.
    #[error("object {id:?}: {source}")]
    Shape {
        /// Object.
        id: String,
        /// What is wrong.
        source: crate::shape::ShapeError,
    },
    /// A mesh that cannot be used.
    #[error("object {id:?}: {source}")]
    Mesh {
        /// Object.
        id: String,
        /// What is wrong.
        source: crate::shape::MeshError,
    },
    /// A cloud or octomap that cannot be used.
    #[error("object {id:?}: {reason}")]
    Cloud {
        /// Object.
        id: String,
        /// What is wrong, with the file.
        reason: String,
    },
    /// A padding that is no length.
    #[error("the padding of {name:?} is {value}; it must be finite and at least 0 (metres)")]
    BadPadding {
        /// Link or object.
        name: String,
        /// Its value.
        value: f64,
    },
    /// A scale that leaves no solid.
    #[error(
        "the scale of {name:?} is {value}; it must be from 0.001 to 1000 (1 leaves sizes as they are)"
    )]
    BadScale {
        /// Link or object.
        name: String,
        /// Its value.
        value: f64,
    },
    /// A length of a sensed object that is none.
    #[error(
        "sensed object {id:?}: {what} is {value} m; it must be {} {most}", if *.what == "radius" { "above 0 and at most" } else { "from 0 to" }
    )]
    BadSensing {
        /// Object.
        id: String,
        /// Which length.
        what: &'static str,
        /// Its value (m).
        value: f64,
        /// The largest that is valid (m).
        most: f64,
    },
    /// Shapes of an object that gets them from its sensor.
    #[error(
        "object {0:?} is sensed: its shape comes with its sensor's frames; leave out its shapes, or `sensed`"
    )]
    SensedShapes(String),
    /// A frame for an object that is not sensed.
    #[error(
        "object {id:?} is not sensed, no frame can be its shape; sensed objects of the world: {known}; make it one: {{\"id\": {id:?}, \"operation\": \"ADD\", \"sensed\": {{\"radius\": 0.005}}}}"
    )]
    NotSensed {
        /// Object.
        id: String,
        /// Those that are.
        known: String,
    },
    /// A change to an object that is not there.
    #[error("cannot {change} object {id:?}, which is not in the scene; objects: {known}")]
    UnknownObject {
        /// What was to be done.
        change: &'static str,
        /// Object.
        id: String,
        /// Objects that it can be done to.
        known: String,
    },
    /// An object that a link carries already.
    #[error(
        "object {id:?} is already attached to {link_name:?}; detach it before it is attached to another link"
    )]
    AlreadyAttached {
        /// Object.
        id: String,
        /// The link that carries it.
        link_name: String,
    },
    /// An object that no link carries.
    #[error("object {id:?} stands in the world, no link carries it; attached objects: {known}")]
    NotAttached {
        /// Object.
        id: String,
        /// Attached objects.
        known: String,
    },
    /// A pose in the world for an object that a link carries.
    #[error(
        "object {id:?} is attached to {link_name:?}, not in the world; change it in attached_collision_objects"
    )]
    Carried {
        /// Object.
        id: String,
        /// The link that carries it.
        link_name: String,
    },
    /// An object that another link carries.
    #[error(
        "object {id:?} is attached to {link_name:?}, not to {wanted:?}; name that link, or none"
    )]
    OtherLink {
        /// Object.
        id: String,
        /// The link that carries it.
        link_name: String,
        /// The link that should.
        wanted: String,
    },
    /// A text that is not the format it should be, with line and column where known.
    #[error("{0}")]
    Syntax(String),
}

impl SceneError {
    /// A change to an object that is not among those that it can be done to.
    pub(super) fn unknown_object(change: &'static str, id: &str, known: String) -> Self {
        Self::UnknownObject {
            change,
            id: id.to_owned(),
            known,
        }
    }

    /// An object that no link carries.
    pub(super) fn not_attached(id: &str, known: String) -> Self {
        Self::NotAttached {
            id: id.to_owned(),
            known,
        }
    }
}
