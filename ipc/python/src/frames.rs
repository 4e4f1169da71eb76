//! Frames of sensors: what Python says of one, and hears.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use taut_ipc::control::{CloudFrame, FrameSummary, PointField, PointLayout};

/// A field as tuples have it: name, offset, datatype, count.
type Field = (String, u32, u8, u32);

/// What a frame is besides its points.
pub fn head(dict: &Bound<'_, PyDict>) -> PyResult<CloudFrame> {
    let fields: Vec<Field> = value(dict, "fields")?;
    let field = |(name, offset, datatype, count)| PointField {
        name,
        offset,
        datatype,
        count,
    };
    Ok(CloudFrame {
        taken_ns: value(dict, "taken_ns")?,
        pose: value(dict, "pose")?,
        robot: value(dict, "robot")?,
        link: value(dict, "link")?,
        joints: value(dict, "joints")?,
        layout: PointLayout {
            height: value(dict, "height")?,
            width: value(dict, "width")?,
            point_step: value(dict, "point_step")?,
            row_step: value(dict, "row_step")?,
            is_bigendian: value(dict, "is_bigendian")?,
            fields: fields.into_iter().map(field).collect(),
        },
    })
}

fn value<'py, T: FromPyObjectOwned<'py>>(dict: &Bound<'py, PyDict>, name: &str) -> PyResult<T> {
    let given = dict.as_any().get_item(name)?;
    given.extract().map_err(Into::into)
}

/// What came of a frame.
pub fn summary<'py>(py: Python<'py>, summary: &FrameSummary) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("version", summary.scene_version)?;
    dict.set_item("hash", format!("{:016x}", summary.scene_hash))?;
    for (name, count) in [
        ("came", summary.came),
        ("not_finite", summary.not_finite),
        ("on_robot", summary.on_robot),
        ("in_padding", summary.in_padding),
        ("thinned", summary.thinned),
        ("points", summary.points),
    ] {
        dict.set_item(name, count)?;
    }
    dict.set_item("warnings", &summary.warnings)?;
    Ok(dict)
}
