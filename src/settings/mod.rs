//! The user's folders and configuration file, in layers: built-in defaults, file, environment.

mod file;
mod folders;
mod keys;
mod mistakes;
mod planner;
mod settings;
mod tags;
mod text_file;

pub use file::{Config, ConfigError};
pub use folders::Folders;
pub use keys::Keys;
pub use mistakes::Mistake;
pub use planner::{Allowed, PlannerKey};
pub use settings::{Lines, Setting};
pub use tags::Tags;
pub use text_file::TextFile;
