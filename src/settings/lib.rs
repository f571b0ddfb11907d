//! What the user wants: folders, the configuration file, themes, tags, views; built-in defaults, then file, then environment.

mod config;
mod folders;
mod planner;
mod theme;
mod user_files;
mod values;

pub use config::{Config, ConfigError, Keys};
pub use folders::Folders;
pub use planner::PlannerKey;
pub use theme::{AUTO, NamedTheme, ROLES, Theme, ThemeColor, ThemeFile};
pub use user_files::{SavedView, SavedViews, Tags, TextFile};
pub use values::Setting;
