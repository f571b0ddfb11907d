//! Where the windows of the safety task end: a lead before the collision of a labelled scenario.

use super::{CriticalMoments, Label};
use nearmiss_record::fields::{FieldValue, Takes, Wrong};
use nearmiss_scene::judge::judge_collision;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use toml::Value;

/// End of the window before a collision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lead {
    /// Two steps before the last recorded one. The scripts of "From Words to Collisions" end every window there,
    /// those of safe scenarios too; at any lead, this one included, those have their first window.
    Paper,
    /// This many seconds before the first step at which the bodies of the ego and anyone else overlap, or have touched
    /// since the step before; to the
    /// nearest step.
    Seconds(f64),
}

/// Steps that the scripts of "From Words to Collisions" describe.
pub const PAPER_STEPS: usize = 10;

/// A scenario with its label.
#[derive(Debug, Clone, Copy)]
pub struct Labelled<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The label.
    pub label: Label,
    /// The first step at which the ego overlaps an obstacle, or has touched it since the step before.
    pub contact: Option<i64>,
}

impl<'a> Labelled<'a> {
    /// A scene with its exact geometric truth, or with a label that says otherwise.
    #[must_use]
    pub fn new(scene: &'a Scene, label: Option<Label>) -> Self {
        let collision = judge_collision(scene, Thresholds::shipped());
        let hit = collision.decisive_step.is_some();
        let who = collision.verdict.obstacles.first().map(|o| o.id);
        Self {
            scene,
            label: label.unwrap_or(if hit {
                Label::Collision(who)
            } else {
                Label::Safe
            }),
            contact: collision.decisive_step,
        }
    }

    /// A scene whose dangerous moments are not contacts: its label is from the first of them.
    #[must_use]
    pub fn by_moments(scene: &'a Scene, moments: &CriticalMoments) -> Self {
        Self {
            scene,
            label: moments.of_recording().0,
            contact: moments.first_step(),
        }
    }

    /// Where the label and the bodies do not agree.
    #[must_use]
    pub fn doubt(&self) -> Option<&'static str> {
        match (self.label, self.contact) {
            (Label::Collision(_), None) => Some(
                "labelled a collision, but no bodies overlap; the last recorded step is used as the collision",
            ),
            (Label::Safe, Some(_)) => Some("labelled safe, but bodies touch"),
            _ => None,
        }
    }

    /// The window at a lead: of a collision, `history` steps that end this long before it, fewer where the
    /// recording begins later; of a safe scenario always its first `history` steps.
    ///
    /// Where a label says collision and no bodies overlap, the last recorded step stands for the contact.
    #[must_use]
    pub fn window(&self, lead: Lead, history: usize) -> Option<Window> {
        let steps = self.scene.steps();
        let last = match (self.label, lead) {
            (Label::Safe, _) => first_whole(self.scene, history),
            (_, Lead::Paper) => steps.end - 1 - Window::AFTER_SAFETY,
            (_, Lead::Seconds(lead)) => {
                let contact = self.contact.unwrap_or(steps.end - 1);
                contact - (lead / self.scene.scenario.dt()).round() as i64
            }
        };
        steps
            .contains(&last)
            .then(|| Window::ending_at(self.scene, last, history))
    }

    /// The window that the scripts of "From Words to Collisions" describe: of a collision its end, for the safety task
    /// two steps before that; of a safe scenario its first `history` steps. `None` for other tasks.
    #[must_use]
    pub fn paper_window(&self, task: Task, history: usize) -> Option<Window> {
        match (task, self.label) {
            (Task::Collision, Label::Collision(_)) => Some(Window::ending_at(
                self.scene,
                self.scene.last_step(),
                history,
            )),
            (Task::Collision | Task::Safety, _) => self.window(Lead::Paper, history),
            (Task::Recording, _) => Some(Window::full(self.scene)),
            (Task::Attacker | Task::Trajectory, _) => None,
        }
    }
}

/// The last step of the first whole window; of a shorter recording its last step.
pub(super) fn first_whole(scene: &Scene, history: usize) -> i64 {
    let steps = scene.steps();
    let before = i64::try_from(history.max(1) - 1).unwrap_or(i64::MAX);
    steps.start.saturating_add(before).min(steps.end - 1)
}

impl std::fmt::Display for Lead {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Paper => f.write_str("end"),
            Self::Seconds(seconds) => write!(f, "{seconds}"),
        }
    }
}

impl Lead {
    /// Whether a contact at this lead is later than a horizon, seconds: the truth of a window does not see it.
    #[must_use]
    pub fn is_beyond(self, horizon: Option<f64>) -> bool {
        matches!((self, horizon), (Self::Seconds(lead), Some(horizon)) if lead > horizon)
    }

    /// As stores keep it, those of earlier versions too; it is read again like what people write.
    #[must_use]
    pub fn stored(self) -> String {
        match self {
            Self::Paper => STORED_END.into(),
            Self::Seconds(_) => self.to_string(),
        }
    }
}

/// The word of stores for the end of recordings.
const STORED_END: &str = "paper";

impl std::str::FromStr for Lead {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if ["end", STORED_END].contains(&text) {
            return Ok(Self::Paper);
        }
        match text.parse::<f64>() {
            Ok(seconds) if (0.0..=LONGEST).contains(&seconds) => Ok(Self::Seconds(seconds)),
            _ => Err(format!("expected `end` or seconds from 0 to {LONGEST}")),
        }
    }
}

/// No recording is longer, seconds.
const LONGEST: f64 = 3600.0;

impl FieldValue for Lead {
    fn read(value: &Value, _: &Takes) -> Result<Self, Wrong> {
        let seconds = value.as_integer().map(|seconds| seconds.to_string());
        let seconds = seconds.or_else(|| value.as_float().map(|seconds| seconds.to_string()));
        let word = seconds.or_else(|| value.as_str().map(Into::into));
        word.ok_or(Wrong::kind())?.parse().map_err(Wrong::because)
    }

    fn write(&self) -> Option<Value> {
        Some(match self {
            Self::Paper => "end".into(),
            Self::Seconds(seconds) => (*seconds).into(),
        })
    }

    fn describe(_: &Takes) -> (String, serde_json::Value) {
        let seconds = serde_json::json!({ "type": "number", "minimum": 0, "maximum": LONGEST });
        (
            format!("seconds from 0 to {LONGEST} or `end`"),
            serde_json::json!({ "anyOf": [seconds, { "const": "end" }] }),
        )
    }
}
