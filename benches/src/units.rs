//! Figures for people.

/// A distance with a fitting unit.
pub(crate) fn length(metres: f64) -> String {
    match metres {
        m if m >= 1.0 => format!("{m:.2} m"),
        m if m >= 1e-4 => format!("{:.3} mm", m * 1e3),
        m => format!("{:.3} µm", m * 1e6),
    }
}

/// A time with a fitting unit.
pub(crate) fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{s:.2} s"),
        s if s >= 1e-3 => format!("{:.2} ms", s * 1e3),
        s => format!("{:.1} µs", s * 1e6),
    }
}
