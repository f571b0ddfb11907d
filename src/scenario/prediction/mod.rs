//! Where everyone may go next, from what was seen up to now: straight on, turning, or along the lanes.
//!
//! Nothing here can see what comes after the present: see [`ObservedHistory`].

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
