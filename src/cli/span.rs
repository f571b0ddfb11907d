//! The steps of a scene to look at, and how to describe them.

use super::Failure;
use super::at::{AT, At, worst_step};
use nearmiss_ask::prompts::{MOST_DECIMALS, Techniques};
use nearmiss_base::system::unknown;
use nearmiss_scene::description::{EgoAxes, Form, Frame};
use nearmiss_scene::metrics::{MeasureList, Thresholds};
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_settings::Config;
use nearmiss_study::evaluation::Settings;

/// Which steps are looked at, and how they are described.
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
    /// Describe every Nth step, and always the last [default: from the template, else 1].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    stride: Option<u32>,
    /// Describe obstacles within this distance of the ego, metres, and farther away those that can reach it soon
    /// [default: from the template, else 30].
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    radius: Option<f64>,
    /// Decimals of metres, m/s and m/s²; radians get one more [default: from the template, else 2].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=MOST_DECIMALS as i64))]
    precision: Option<u8>,
    /// Wording: prose (sentences) or compact (a table) [default: from the template, else compact].
    #[arg(long, value_parser = form)]
    form: Option<Form>,
    /// Name contact between bodies in the description. This gives away the answer to the collision task; without it
    /// only the distance shows it [default: from the template, else no].
    #[arg(long, value_name = "yes|no", num_args = 0..=1, require_equals = true, default_missing_value = "yes", value_parser = yes)]
    contact: Option<bool>,
    #[command(flatten)]
    pub of_frames: OfFrames,
    /// Describe only this obstacle; the trajectory frame needs it.
    #[arg(long, value_name = "ID", allow_negative_numbers = true)]
    obstacle: Option<i64>,
}

/// Options of a description that one frame has.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct OfFrames {
    /// Cartesian frame: describe the road near the ego too, its lanelets with their lines [default: from the template,
    /// else no].
    #[arg(long, value_name = "yes|no", num_args = 0..=1, require_equals = true, default_missing_value = "yes", value_parser = yes)]
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
                None => Ok(Window::whole(scene)),
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
        techniques: Option<Techniques>,
        frame: Frame,
        config: &Config,
    ) -> Result<Settings, Failure> {
        let radius = self.radius.or(config.radius);
        if radius.is_some_and(|r| !(r.is_finite() && r > 0.0)) {
            return Err(Failure::input(
                "--radius must be a positive number of metres",
            ));
        }
        let settings = Settings {
            history: self.history.map(|steps| steps as usize).or(config.history),
            stride: self.stride.map(|steps| steps as usize),
            radius,
            precision: self.precision.map(usize::from),
            form: self.form,
            contact: self.contact,
            techniques,
            road: self.of_frames.road,
            axes: self.of_frames.axes,
            measures: self.of_frames.measures,
            obstacle: self.obstacle,
        };
        match settings.misplaced(&[frame], "--") {
            Some(why) => Err(Failure::input(why)),
            None => Ok(settings),
        }
    }
}

/// `yes` or `no`.
fn yes(word: &str) -> Result<bool, String> {
    match word {
        "yes" | "true" => Ok(true),
        "no" | "false" => Ok(false),
        _ => Err("expected yes or no".into()),
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
