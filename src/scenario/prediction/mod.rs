//! Where everyone may go next, from what was seen up to now: straight on, turning, or along the lanes.
//!
//! Nothing here can see what comes after the present: see [`ObservedHistory`].

mod lanes;
mod observed_history;
mod path;
mod predictor;
mod present;
mod speeds;

pub use observed_history::{Observed, ObservedHistory, Who};
pub use path::Path;
pub use predictor::{Course, Model, Prediction, Predictor, Trajectory, Way};
pub use present::Present;
pub use speeds::Speeds;
