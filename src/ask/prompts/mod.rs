//! Prompt templates: shipped ones, the user's, and rendering.

mod answer_form;
mod chosen;
mod defaults;
mod guard;
mod includes;
mod library;
mod pack;
mod rename;
mod render;
mod shipped;
mod techniques;
mod template;
mod tokens;

pub use answer_form::{answer_form, answer_keys};
pub use chosen::choose_template;
pub use defaults::{AxesOfEgo, Defaults, MOST_DECIMALS, Wording};
pub use includes::hash;
pub use library::{Fallback, Library, Origin, Problem};
pub use pack::Pack;
pub use rename::{renamed, template_file};
pub use render::{Prompt, RenderError, render};
pub use shipped::Shipped;
pub use techniques::Techniques;
pub use template::{FrontMatter, Template, TemplateError};
pub use tokens::estimate_tokens;
