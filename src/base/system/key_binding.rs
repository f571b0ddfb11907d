//! An action of the workbench with its keys, as data.

use serde::Serialize;

/// An action with its keys.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct KeyBinding {
    /// Where the keys work.
    pub scope: &'static str,
    /// The action, as in keymap.toml.
    pub action: &'static str,
    /// Its keys, the first one first.
    pub keys: Vec<String>,
    /// What it does.
    pub summary: &'static str,
}
