//! The steps of a scene to look at, and how to describe them.

use super::Failure;
use super::at::{AT, At, worst_step};
use super::set::{Settable, number, on_or_off};
use nearmiss_ask::prompts::{MOST_DECIMALS, Techniques};
use nearmiss_base::system::unknown;
use nearmiss_scene::description::{EgoAxes, Form, Frame};
use nearmiss_scene::metrics::{MeasureList, Thresholds};
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_settings::Config;
use nearmiss_study::evaluation::Settings;

/// Which steps are looked at, and which obstacle.
#[derive(Debug, clap::Args)]
pub struct Span {
    /// End of the window: a time step (32), seconds (3.2s), worst (the most severe moment, see `nearmiss help
    /// measures`), or the worst by one measure: worst:risk, worst:ttc, worst:distance [default: the last step; two
    /// steps earlier for the safety task].
    #[arg(long, value_name = AT, allow_negative_numbers = true)]
    at: Option<At>,
    /// Steps in the window [default: from the template, else 10].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = history)]
    history: Option<u32>,
    /// Describe only this obstacle; the trajectory frame needs it.
    #[arg(long, value_name = "ID", allow_negative_numbers = true)]
    obstacle: Option<i64>,
}

/// How a scene is described, by the keys of a template.
#[derive(Debug, Clone, Default)]
pub struct Wording {
    stride: Option<u32>,
    radius: Option<f64>,
    precision: Option<u8>,
    form: Option<Form>,
    contact: Option<bool>,
    road: Option<bool>,
    axes: Option<EgoAxes>,
    measures: Option<MeasureList>,
}

impl Settable for Wording {
    fn keys() -> Vec<&'static str> {
        vec![
            "stride",
            "radius",
            "precision",
            "form",
            "contact",
            "road",
            "axes",
            "measures",
        ]
    }

    fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        match key {
            "stride" => self.stride = Some(number(value, 1, u32::MAX)?),
            "radius" => self.radius = Some(metres(value)?),
            "precision" => self.precision = Some(number(value, 0, MOST_DECIMALS as u8)?),
            "form" => self.form = Some(form(value)?),
            "contact" => self.contact = Some(on_or_off(value)?),
            "road" => self.road = Some(on_or_off(value)?),
            "axes" => self.axes = Some(axes(value)?),
            _ => self.measures = Some(measures(value)?),
        }
        Ok(())
    }
}

/// A positive number of metres.
fn metres(word: &str) -> Result<f64, String> {
    let metres = word.parse::<f64>().ok();
    metres
        .filter(|m| m.is_finite() && *m > 0.0)
        .ok_or_else(|| "expected a positive number of metres".into())
}

/// Options of a description that one frame has.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct OfFrames {
    /// Cartesian frame: describe the road near the ego too, its lanelets with their lines [default: from the template,
    /// else no].
    #[arg(long, value_name = "yes|no", num_args = 0..=1, require_equals = true, default_missing_value = "yes", value_parser = on_or_off)]
    pub road: Option<bool>,
    /// Ego frame: heading (gaps along the ego's heading), lane (s and d along its lane) or centre (places of centres,
    /// without distances and gaps) [default: from the template, else heading].
    #[arg(long, value_name = "AXES", value_parser = axes)]
    pub axes: Option<EgoAxes>,
    /// Metrics frame: the measures that are its columns, separated by commas, such as ttc,thw,drac; see `nearmiss help
    /// measures` [default: from the template, else distance, times, drac and risk].
    #[arg(long, value_name = "MEASURES", value_parser = measures)]
    pub measures: Option<MeasureList>,
}

/// `heading` or `lane`.
fn axes(word: &str) -> Result<EgoAxes, String> {
    EgoAxes::parse(word).ok_or_else(|| unknown("axes", word, EgoAxes::ALL.map(EgoAxes::name)))
}

/// Steps of a window: no recording is longer than the most.
pub fn history(word: &str) -> Result<u32, String> {
    match word.parse() {
        Ok(steps @ 1..=100_000) => Ok(steps),
        _ => Err("expected 1 to 100000 steps".into()),
    }
}

impl Span {
    /// The options with which steps were chosen, for people; nothing if none was.
    pub fn chosen(&self) -> Option<&'static str> {
        match (self.at, self.history) {
            (Some(_), Some(_)) => Some("--at and --history"),
            (Some(_), None) => Some("--at"),
            (None, Some(_)) => Some("--history"),
            (None, None) => None,
        }
    }

    /// Whether the end of the window is left to the program.
    pub fn is_default_end(&self) -> bool {
        self.at.is_none()
    }

    /// The window in a scene, of so many steps.
    pub fn window(
        &self,
        scene: &Scene,
        thresholds: &Thresholds,
        task: Option<Task>,
        history: usize,
    ) -> Result<Window, Failure> {
        if task == Some(Task::Recording) {
            return match self.chosen() {
                Some(chosen) => Err(Failure::input(format!(
                    "--task recording asks about the whole recording; remove {chosen}"
                ))),
                None => Ok(Window::full(scene)),
            };
        }
        let steps = scene.steps();
        let worst = |by| worst_step(scene, thresholds, by);
        let at = self
            .at
            .map(|at| at.step(&steps, scene.scenario.dt(), worst));
        // The paper's safety inference looks at a window that ends two steps before the last one.
        let back = if task == Some(Task::Safety) {
            Window::AFTER_SAFETY
        } else {
            0
        };
        let last = at.transpose()?.unwrap_or(steps.end - 1 - back);
        Ok(Window::ending_at(scene, last, history))
    }

    /// What the user says, here and in the configuration, about how a scene is described.
    pub fn settings(
        &self,
        wording: &Wording,
        techniques: Option<Techniques>,
        frame: Frame,
        config: &Config,
    ) -> Result<Settings, Failure> {
        let settings = Settings {
            history: self.history.map(|steps| steps as usize).or(config.history),
            stride: wording.stride.map(|steps| steps as usize),
            radius: wording.radius.or(config.radius),
            precision: wording.precision.map(usize::from),
            form: wording.form,
            contact: wording.contact,
            techniques,
            road: wording.road,
            axes: wording.axes,
            measures: wording.measures,
            obstacle: self.obstacle,
        };
        match settings.misplaced(&[frame], "--set ") {
            Some(why) => Err(Failure::input(why)),
            None => Ok(settings),
        }
    }
}

/// `prose` or `compact`.
pub fn form(word: &str) -> Result<Form, String> {
    Form::parse(word).ok_or_else(|| "expected prose or compact".into())
}

fn measures(text: &str) -> Result<MeasureList, String> {
    let list = MeasureList::parse(text);
    list.map_err(|wrong| format!("{wrong}\n`nearmiss metrics --list` lists all"))
}
