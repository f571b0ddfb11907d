//! What the user wants: folders, the configuration file, themes, tags, views; built-in defaults, then file, then environment.

mod config;
mod editor_keys;
mod external_planner;
mod folders;
mod planner;
mod tags;
mod text_file;
mod theme;
mod validation;
mod views;

pub use config::{Config, ConfigError};
pub use editor_keys::Keys;
pub use folders::Folders;
pub use planner::Planning;
pub use tags::Tags;
pub use text_file::TextFile;
pub use theme::{AUTO, NamedTheme, ROLES, Theme, ThemeColor, ThemeFile};
pub use views::{SavedView, SavedViews};
