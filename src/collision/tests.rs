//! What a new scene leaves as it is.
