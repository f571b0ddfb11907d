//! The user's folders and configuration file, in layers: built-in defaults, file, environment.

mod file;
mod folders;

pub use file::{Config, ConfigError};
pub use folders::Folders;
