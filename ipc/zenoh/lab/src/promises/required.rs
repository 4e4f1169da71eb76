//! What is to be done where something cannot be run.

/// Whether what cannot be run is a failure.
pub(super) fn is_all_required() -> bool {
    std::env::var_os("TAUT_REQUIRE_ALL").is_some_and(|value| value == "1")
}
