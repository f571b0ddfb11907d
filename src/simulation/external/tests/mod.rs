//! Planners that misbehave.
