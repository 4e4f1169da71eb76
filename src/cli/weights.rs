//! Where the weights of the metric come from.

/// The choice on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Weights {
    /// The problem's own
    Metric,
    /// Metres that a body can move per radian or metre of a joint
    Reach,
    /// 1 for every coordinate
    Ones,
}

/// The weights of a robot of `nv` velocity coordinates; none for metres of reach. `metric` are the
/// problem's.
///
/// # Errors
/// The problem's weights where it has none; a usage error.
pub(super) fn weights(
    choice: Option<Weights>,
    metric: Option<&Vec<f64>>,
    nv: usize,
) -> Result<Option<Vec<f64>>, String> {
    match choice {
        None => Ok(metric.cloned()),
        Some(Weights::Reach) => Ok(None),
        Some(Weights::Ones) => Ok(Some(vec![1.0; nv])),
        Some(Weights::Metric) => {
            let none = "--weights metric needs a problem with a metric; use reach or ones";
            Ok(Some(metric.cloned().ok_or(none)?))
        }
    }
}
