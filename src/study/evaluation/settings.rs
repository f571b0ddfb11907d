//! Settings of a case: from the user, else the template, else the defaults; and those that a batch asks in several values.

use std::cmp::Ordering;
use std::hash::{Hash, Hasher};

use nearmiss_ask::llm::{Effort, Parameters};
use nearmiss_ask::prompts::{AxesOfEgo, Defaults, Library, Techniques, Wording};
use nearmiss_drive::planner::{self, Forecast};
use nearmiss_drive::simulation::{self, TrafficMode};
use nearmiss_record::fields::Fields;
use nearmiss_scene::description::{EgoAxes, Form, Frame, OF_ONE_FRAME, Options};
use nearmiss_scene::metrics::MeasureList;
use nearmiss_scene::verdict::Task;

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
        let measures = template_measures(template).and_then(Result::ok);
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
pub(super) fn template_measures(template: &Defaults) -> Option<Result<MeasureList, String>> {
    let ids = template.measures.as_ref()?;
    Some(MeasureList::from_ids(ids.iter().map(String::as_str)))
}

/// Of an attacker the metrics, of the rest the ego frame, where the task has it; else the first that it has.
#[must_use]
pub fn default_frame(library: &Library, task: Task) -> Frame {
    let first = match task {
        Task::Attacker => Frame::Metrics,
        _ => Frame::Ego,
    };
    let mut frames = std::iter::once(first).chain(Frame::ALL);
    let has = |frame: &Frame| library.find(task.name(), frame.name()).is_some();
    frames.find(has).unwrap_or(first)
}

/// The default: every step is planned again, and others follow their lanes.
#[must_use]
pub fn default_planning() -> simulation::Settings {
    simulation::Settings {
        planner: planner::Settings::default(),
        forecast: Forecast::Lane,
        replan: 1,
        without: None,
        traffic: TrafficMode::Recorded,
        policy: None,
    }
}

nearmiss_record::fields! {
    /// One value of each axis; `None` where the setting is no axis. The keys are those of experiments, stored questions
    /// and reports.
    #[derive(Copy)]
    pub struct AxisValues {
        "axes" {
            /// Form of the description.
            form: Option<Form>;
            /// Steps between described ones.
            stride: Option<usize>;
            /// How much the model is to reason.
            effort: Option<Effort>;
            /// Sampling temperature, from 0.
            temperature: Option<f64>, Takes::Number(0.0, f64::MAX);
            /// Seed of the sampling.
            seed: Option<u64>;
            /// Whether the model may call tools.
            tools: Option<bool>;
        }
    }
}

/// The words for the values of the axis of tools.
#[must_use]
pub fn tools_word(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}

impl AxisValues {
    /// Whether no setting is an axis.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// What is sent beside the messages, with these values in the place of others.
    #[must_use]
    pub fn parameters(&self, usual: Parameters) -> Parameters {
        Parameters {
            effort: self.effort.or(usual.effort),
            temperature: self.temperature.or(usual.temperature),
            seed: self.seed.or(usual.seed),
            tools: match self.tools {
                Some(true) => Some(usual.tools.unwrap_or_default()),
                Some(false) => None,
                None => usual.tools,
            },
            ..usual
        }
    }

    /// How scenes are described, with these values in the place of others.
    #[must_use]
    pub fn settings(&self, usual: Settings) -> Settings {
        Settings {
            form: self.form.or(usual.form),
            stride: self.stride.or(usual.stride),
            ..usual
        }
    }

    /// The same as the store and tables have it; `None` without a value.
    #[must_use]
    pub fn to_stored(&self) -> Option<String> {
        (!self.is_empty()).then(|| self.to_string())
    }

    /// The values in an order. Temperatures are not negative, so that their bits are in the order of the numbers.
    fn order(&self) -> impl Ord + Hash + use<> {
        (
            self.form.map(Form::name),
            self.stride,
            self.effort,
            self.temperature.map(f64::to_bits),
            self.seed,
            self.tools,
        )
    }
}

/// `effort low, temperature 0.7`.
impl std::fmt::Display for AxisValues {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let words = Self::rows().iter();
        let words = words.filter_map(|row| Some(format!("{} {}", row.key, self.text(row.key)?)));
        f.write_str(&words.collect::<Vec<_>>().join(", "))
    }
}

impl std::str::FromStr for AxisValues {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut values = Self::default();
        let unknown = || format!("the settings `{text}` are not known to this version");
        for part in text.split(", ") {
            let (key, value) = part.split_once(' ').ok_or_else(unknown)?;
            let row = Self::row(key).map_err(|_| unknown())?;
            values.set(key, &row.parse(value)).map_err(|_| unknown())?;
        }
        Ok(values)
    }
}

impl Eq for AxisValues {}

impl PartialOrd for AxisValues {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for AxisValues {
    fn cmp(&self, other: &Self) -> Ordering {
        self.order().cmp(&other.order())
    }
}

impl Hash for AxisValues {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.order().hash(state);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::batch::Experiment;

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

    #[test]
    fn every_combination_is_a_way_with_a_name_that_is_read_back() {
        let axes = Experiment {
            effort: [Effort::Low, Effort::High].into_iter().collect(),
            temperature: [0.0, 0.7].into_iter().collect(),
            form: [Form::Compact, Form::Prose].into_iter().collect(),
            ..Experiment::default()
        };
        let all = axes.axis_values();
        let words: Vec<String> = all.iter().map(ToString::to_string).collect();
        assert_eq!(all.len(), 8);
        assert_eq!(words[0], "form compact, effort low, temperature 0");
        assert_eq!(words[7], "form prose, effort high, temperature 0.7");
        for (one, words) in all.iter().zip(&words) {
            assert_eq!(words.parse::<AxisValues>().unwrap(), *one);
        }
        let keys: Vec<&str> = axes.several().map(|(key, _)| key).collect();
        assert_eq!(keys, ["form", "effort", "temperature"]);
        assert_eq!(all[0].differences(&all[1]), ["temperature"]);
        assert_eq!(all[0].differences(&all[7]).len(), 3);
        let tools = Experiment {
            tools: [false, true].into_iter().collect(),
            ..Experiment::default()
        };
        let both = tools.axis_values();
        assert_eq!(both[0].differences(&both[1]), ["tools"]);
        let sent = both
            .iter()
            .map(|one| one.parameters(Parameters::default()).tools);
        let sent: Vec<_> = sent.collect();
        for one in &both {
            assert_eq!(one.to_string().parse::<AxisValues>().unwrap(), *one);
        }
        assert_eq!(sent, [None, Some(nearmiss_ask::llm::ToolLimits::default())]);
        assert!("effort lazy".parse::<AxisValues>().is_err() && "".parse::<AxisValues>().is_err());
    }

    #[test]
    fn a_single_value_is_no_axis() {
        let same = Experiment {
            stride: [3, 3].into_iter().collect(),
            ..Experiment::default()
        };
        assert_eq!(same.stride.one(), Some(3));
        assert_eq!(same.axis_values(), [AxisValues::default()]);
        assert_eq!(AxisValues::default().to_stored(), None);
    }
}
