//! Prompt templates: shipped ones, the user's, and rendering.

mod answer_form;
mod guard;
mod library;
mod render;
mod techniques;
mod template;

pub use answer_form::{answer_form, answer_keys};
pub use library::{Fallback, Library, Origin, Pack, Problem, Shipped, choose_template};
pub use render::{Prompt, RenderError, estimate_tokens, render};
pub use techniques::Techniques;
pub use template::{
    AxesOfEgo, Defaults, FrontMatter, MAX_DECIMALS, Template, TemplateError, Wording, hash,
    renamed, template_file,
};
