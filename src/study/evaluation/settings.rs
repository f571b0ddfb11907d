//! Settings of a case: from the user, else the template, else the defaults.

use nearmiss_ask::prompts::{AxesOfEgo, Defaults, Techniques, Wording};
use nearmiss_scene::description::{EgoAxes, Form, Frame, OF_ONE_FRAME, Options};
use nearmiss_scene::metrics::MeasureList;

/// The user's settings; `None` leaves the decision to the template.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// Steps in the window.
    pub history: Option<usize>,
    /// Steps between described ones.
    pub stride: Option<usize>,
    /// Obstacles within this distance of the ego are described, metres, and farther away those that can reach it soon.
    pub radius: Option<f64>,
    /// Decimals.
    pub precision: Option<usize>,
    /// Sentences or a table.
    pub form: Option<Form>,
    /// Whether descriptions say that bodies touch.
    pub contact: Option<bool>,
    /// Whether the Cartesian frame describes the road near the ego.
    pub road: Option<bool>,
    /// What the ego frame measures along and across.
    pub axes: Option<EgoAxes>,
    /// The measures of the metrics frame.
    pub measures: Option<MeasureList>,
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
    /// An option that none of these frames has, in words; `prefix` stands before its name, as `--` does.
    #[must_use]
    pub fn misplaced(&self, frames: &[Frame], prefix: &str) -> Option<String> {
        let given = [
            self.road.is_some(),
            self.axes.is_some(),
            self.measures.is_some(),
        ];
        let mut given = OF_ONE_FRAME.iter().zip(given).filter(|(_, given)| *given);
        let ((name, frame), _) =
            given.find(|((_, frame), _)| !frames.iter().any(|f| f.words() == Some(*frame)))?;
        let frame = frame.name();
        Some(format!(
            "{prefix}{name} is an option of the {frame} frame; add that frame or remove the option"
        ))
    }

    /// The effective settings with a template of these defaults.
    #[must_use]
    pub fn with(&self, template: &Defaults) -> EffectiveSettings {
        let usual = Options::default();
        let form = template.form.map(|wording| match wording {
            Wording::Prose => Form::Prose,
            Wording::Compact => Form::Compact,
        });
        let axes = template.axes.map(|axes| match axes {
            AxesOfEgo::Heading => EgoAxes::Heading,
            AxesOfEgo::Lane => EgoAxes::Lane,
            AxesOfEgo::Centre => EgoAxes::Centre,
        });
        // What a template names wrongly is an error where its messages are made.
        let measures = measures_of(template).and_then(Result::ok);
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
                reach: usual.reach,
                precision: self
                    .precision
                    .or(template.precision)
                    .unwrap_or(usual.precision),
                stride: self
                    .stride
                    .or(template.stride.map(usize::from))
                    .unwrap_or(usual.stride),
                // An explicit stride holds.
                most_times: template
                    .times
                    .filter(|_| self.stride.is_none())
                    .map(usize::from),
                nearest: template.nearest.unwrap_or(usual.nearest),
                form: self.form.or(form).unwrap_or(usual.form),
                contact: self.contact.or(template.contact).unwrap_or(usual.contact),
                road: self.road.or(template.road).unwrap_or(usual.road),
                axes: self.axes.or(axes).unwrap_or(usual.axes),
                measures: self.measures.or(measures),
                obstacle: self.obstacle,
            },
        }
    }
}

/// The measures that a template asks for, or what is wrong with their names.
pub(super) fn measures_of(template: &Defaults) -> Option<Result<MeasureList, String>> {
    let ids = template.measures.as_ref()?;
    Some(MeasureList::from_ids(ids.iter().map(String::as_str)))
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
