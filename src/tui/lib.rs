//! The interactive terminal workbench.

mod action;
mod background;
mod clock;
mod external_editor;
mod features;
/// The workbench without a terminal, for benches.
#[doc(hidden)]
pub mod headless;
mod keymap;
mod layout;
mod loaded;
mod message;
mod model;
mod pixels;
mod reload;
mod request;
mod run;
mod screenshot;
mod services;
mod session;
mod shell;
mod terminal;
#[cfg(test)]
mod tests;
mod theme;
mod update;
mod views;
mod widgets;

pub use run::{RunResult, run};
pub use screenshot::screen;
pub use shell::{key_bindings, keys, terminal_here, theme_mistakes, themes};
