//! What the user wants: folders, the configuration file, themes, tags, views; built-in defaults, then file, then environment.

mod config;
mod folders;
mod measures;
mod planner;
mod tags;
mod theme;
mod tracks;

pub use config::{Config, ConfigError, Keys};
pub use folders::{Folders, TextFile, read_thresholds};
pub use planner::Planning;
pub use tags::{SavedView, SavedViews, Tags};
pub use theme::{AUTO, NamedTheme, ROLES, Theme, ThemeColor, ThemeFile};
pub use tracks::TrackTable;
