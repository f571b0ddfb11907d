//! Predicts the motion of all road users from their observed history: straight on, turning, or along the lanes.
//!
//! Predictions cannot access the future: see [`ObservedHistory`].

mod lanes;
mod observed_history;
mod path;
mod predictor;
mod present;
mod speeds;

pub use observed_history::{Observed, ObservedHistory, TrackedObject};
pub use path::Path;
pub use predictor::{Course, Model, PredictedPath, Prediction, Predictor, Trajectory};
pub use present::Present;
pub use speeds::Speeds;
