//! Settings of a case: from the user, else the template, else the defaults.

use crate::description::{Form, Options};
use crate::prompts::{Defaults, Techniques, Wording};

/// The user's settings; `None` leaves the decision to the template.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// Steps in the window.
    pub history: Option<usize>,
    /// Steps between described ones.
    pub stride: Option<usize>,
    /// Obstacles farther from the ego are left out, metres.
    pub radius: Option<f64>,
    /// Decimals.
    pub precision: Option<usize>,
    /// Sentences or a table.
    pub form: Option<Form>,
    /// Whether descriptions say that bodies touch.
    pub contact: Option<bool>,
    /// Which techniques are on.
    pub techniques: Option<Techniques>,
    /// The obstacle that is described.
    pub obstacle: Option<i64>,
}

/// Effective settings of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectiveSettings {
    /// Steps in the window.
    pub history: usize,
    /// Which techniques are on.
    pub techniques: Techniques,
    /// How the scene is described.
    pub options: Options,
}

/// Steps in a window by default: the second that the paper's safety inference looks at.
const HISTORY: usize = 10;

impl Settings {
    /// The effective settings with a template of these defaults.
    #[must_use]
    pub fn with(&self, template: &Defaults) -> EffectiveSettings {
        let usual = Options::default();
        let form = template.form.map(|wording| match wording {
            Wording::Prose => Form::Prose,
            Wording::Compact => Form::Compact,
        });
        EffectiveSettings {
            history: self
                .history
                .or(template.history.map(usize::from))
                .unwrap_or(HISTORY),
            techniques: self
                .techniques
                .or(template.techniques)
                .unwrap_or(Techniques::ALL),
            options: Options {
                radius: self.radius.or(template.radius).unwrap_or(usual.radius),
                precision: self
                    .precision
                    .or(template.precision)
                    .unwrap_or(usual.precision),
                stride: self
                    .stride
                    .or(template.stride.map(usize::from))
                    .unwrap_or(usual.stride),
                form: self.form.or(form).unwrap_or(usual.form),
                contact: self.contact.or(template.contact).unwrap_or(usual.contact),
                obstacle: self.obstacle,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_user_before_the_template_before_the_program() {
        let template = Defaults {
            radius: Some(50.0),
            form: Some(Wording::Compact),
            techniques: Some(Techniques::default()),
            contact: Some(true),
            ..Defaults::default()
        };
        let user = Settings {
            radius: Some(20.0),
            ..Settings::default()
        };
        let decided = user.with(&template);
        assert_eq!(decided.options.radius, 20.0);
        assert_eq!(decided.options.form, Form::Compact);
        assert!(decided.options.contact && !user.with(&Defaults::default()).options.contact);
        assert_eq!(decided.techniques, Techniques::default());
        assert_eq!((decided.history, decided.options.stride), (HISTORY, 1));
    }
}
