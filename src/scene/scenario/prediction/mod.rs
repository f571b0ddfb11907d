//! Predicts the motion of all road users from their observed history: straight on, turning, or along the lanes.
//!
//! Predictions cannot access the future: see [`ObservedHistory`].

mod path;
mod predictor;
mod present;

pub use path::Path;
pub use predictor::{Course, Model, PredictedPath, Prediction, Predictor, Speeds, Trajectory};
pub use present::{Observed, ObservedHistory, Present, TrackedObject};
