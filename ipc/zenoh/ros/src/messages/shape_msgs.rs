//! Shapes in their own frames.

use super::geometry_msgs::{Point, Polygon};
use crate::Bounded;
use crate::message::messages;

messages! {
    /// Box 1, sphere 2, cylinder 3, cone 4, prism 5.
    SolidPrimitive = "shape_msgs/msg/SolidPrimitive" {
        r#type: u8,
        dimensions: Bounded<f64, 3>,
        /// A prism's outline.
        polygon: Polygon,
    }

    /// Three corners by number.
    MeshTriangle = "shape_msgs/msg/MeshTriangle" {
        vertex_indices: [u32; 3],
    }

    /// Triangles.
    Mesh = "shape_msgs/msg/Mesh" {
        triangles: Vec<MeshTriangle>,
        vertices: Vec<Point>,
    }

    /// a x + b y + c z + d = 0.
    Plane = "shape_msgs/msg/Plane" {
        coef: [f64; 4],
    }
}
