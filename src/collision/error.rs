//! Why a robot and a scene do not go together.

use crate::scene::SceneError;
use crate::shape::ScaleError;

/// A robot and a scene that do not go together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CollisionModelError {
    /// A pair, touch link or padding names nothing.
    #[error(
        "the scene {what}, but {name:?} is neither a link nor an object; links: {links}; objects: {objects}"
    )]
    UnknownName {
        /// What the scene does with the name.
        what: String,
        /// The one that is unknown.
        name: String,
        /// The other name of the pair; the same where there is one only.
        beside: String,
        /// Valid links.
        links: String,
        /// Valid objects.
        objects: String,
    },
    /// An object hangs on nothing.
    #[error("object {object:?} is attached to {link:?}, which is no link; links: {links}")]
    UnknownLink {
        /// Object.
        object: String,
        /// What should carry it.
        link: String,
        /// Valid links.
        links: String,
    },
    /// An object is placed by what moves.
    #[error(
        "object {object:?} is placed in the frame of the link {link:?}, which is not the world; attach it to {link:?} (attached_collision_objects), or give its pose in the world"
    )]
    FrameOfLink {
        /// Object.
        object: String,
        /// The link.
        link: String,
    },
    /// An object is placed by what is not there.
    #[error("object {object:?}: {source}")]
    UnknownFrame {
        /// Object.
        object: String,
        /// The frame, and the valid ones.
        source: Box<SceneError>,
    },
    /// A frame of the scene has the name of one that the robot has elsewhere.
    #[error(
        "the scene's frame {name:?} has the name of a link or of the robot's world, which is elsewhere; rename it"
    )]
    FrameTaken {
        /// Its name.
        name: String,
    },
    /// A scale that leaves no solid.
    #[error(
        "the scene scales {name:?} by {scale}, which leaves no solid: {source}; take a scale nearer to 1"
    )]
    Scale {
        /// Link or object.
        name: String,
        /// Its scale.
        scale: f64,
        /// What is wrong.
        source: ScaleError,
    },
    /// A change to the scene that cannot be made.
    #[error(transparent)]
    Change(#[from] SceneError),
}
