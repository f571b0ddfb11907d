//! Prompt templates: those that come with the program, those of the user, and how they are filled.

mod library;
mod render;
mod techniques;
mod template;

pub use library::{Library, Origin, Problem, Shipped};
pub use render::{Prompt, RenderError, estimate_tokens, render};
pub use techniques::Techniques;
pub use template::{FrontMatter, Template, TemplateError, hash};
