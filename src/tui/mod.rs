//! The interactive terminal workbench.

mod action;
mod background;
mod clock;
mod keymap;
mod layout;
mod loaded;
mod message;
mod model;
mod outside;
mod reload;
mod run;
mod screen;
mod screens;
mod session;
mod shell;
/// The workbench without a terminal, for benches.
#[doc(hidden)]
pub mod stage;
mod tasks;
mod terminal;
#[cfg(test)]
mod tests;
mod theme;
mod update;
mod user_file;
mod views;
mod widgets;

pub use run::{RunResult, run};
pub use screen::screen;
pub use shell::{keys, terminal_here, theme_mistakes, themes};
