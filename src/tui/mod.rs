//! The workbench in the terminal.

mod action;
mod clock;
mod keymap;
mod layout;
mod loaded;
mod message;
mod model;
mod overlays;
mod run;
mod screen;
mod tasks;
mod terminal;
#[cfg(test)]
mod tests;
mod theme;
mod update;
mod views;
mod widgets;

pub use run::{Ended, run};
pub use screen::screen;
