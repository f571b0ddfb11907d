//! How long before a collision the built-in judge detects it, and how often it raises false alarms.

use std::sync::Arc;

use super::recorded::accused;
use super::{Confusion, Label};
use crate::judge::{self, Criterion, judge};
use crate::metrics::Thresholds;
use crate::scenario::prediction::{Model, ObservedHistory};
use crate::scenario::{Scene, Window};
use crate::verdict::Task;

/// End of the window before a collision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lead {
    /// Two steps before the last recorded one. The scripts of "From Words to Collisions" end every window there, those of
    /// safe scenarios too; at any lead, this one included, those have their first window.
    Paper,
    /// This many seconds before the first step at which the bodies of the ego and anyone else overlap; to the
    /// nearest step.
    Seconds(f64),
}

/// A predictor that is evaluated, by name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// As on the command line: `reference/…`.
    pub name: &'static str,
    /// Its criterion.
    pub criterion: Criterion,
}

/// Settings of the evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Where the windows of collisions end.
    pub leads: Vec<Lead>,
    /// Steps in a window, at least one.
    pub history: usize,
    /// Only obstacles whose centre is this near to the ego's at the end of a window, metres.
    pub radius: f64,
    /// The judge that is evaluated.
    pub candidates: Vec<Candidate>,
    /// Thresholds of the risk scores: the obstacles that a yes names depend on them.
    pub thresholds: Arc<Thresholds>,
    /// Whether every window of safe scenarios is looked at, for [`Answers::alarms`].
    pub every_window: bool,
}

/// Alarms over every window of safe scenarios.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Alarms {
    /// Windows looked at, one for each step that has a whole window behind it.
    pub windows: u32,
    /// Windows with an alarm.
    pub alarmed: u32,
    /// Alarms: runs of windows with one; those less than a second apart are one alarm.
    pub alarms: u32,
    /// Seconds that the windows' last steps span.
    pub seconds: f64,
}

/// One candidate's answers about one scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Answers {
    /// At each lead of the setting; `None` if the recording begins later than the window would end.
    pub said: Vec<Option<WindowVerdict>>,
    /// Over all windows, of a safe scenario.
    pub alarms: Alarms,
}

/// Yes or no to one window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindowVerdict {
    /// No obstacle is critical.
    No,
    /// One is; of a collision whose obstacle is known it names this one, see [`super::recorded::accused`].
    Yes,
    /// It names another obstacle than the one that is known to collide: it is counted as a no,
    /// as with language models, see [`super::Scored::positive`].
    Another,
}

/// A scenario with its label.
#[derive(Debug, Clone, Copy)]
pub struct Labelled<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The label.
    pub label: Label,
    /// The first step with an exact overlap of the ego with an obstacle.
    pub contact: Option<i64>,
}

impl<'a> Labelled<'a> {
    /// A scene with its exact geometric truth, or with a label that says otherwise.
    #[must_use]
    pub fn new(scene: &'a Scene, label: Option<Label>) -> Self {
        let whole = Window::ending_at(scene, i64::MAX, 1);
        let collision = judge(scene, Task::Collision, &whole);
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
}

/// The last step of the first whole window; of a shorter recording its last step.
fn first_whole(scene: &Scene, history: usize) -> i64 {
    let steps = scene.steps();
    let before = i64::try_from(history.max(1) - 1).unwrap_or(i64::MAX);
    steps.start.saturating_add(before).min(steps.end - 1)
}

impl Alarms {
    /// Alarms that are nearer in time are one, seconds.
    pub const APART: f64 = 1.0;
}

impl Setting {
    /// Every candidate's answers about a scenario, in order.
    #[must_use]
    pub fn ask(&self, case: &Labelled<'_>) -> Vec<Answers> {
        let ask = |candidate: &Candidate| {
            let says = |window: Window| self.says(candidate, case, &window);
            // A safe scenario has the same window at every lead.
            let same = match case.label {
                Label::Safe => case.window(Lead::Paper, self.history).map(says),
                Label::Collision(_) => None,
            };
            let at = |lead: &Lead| same.or_else(|| case.window(*lead, self.history).map(says));
            Answers {
                said: self.leads.iter().map(at).collect(),
                alarms: match case.label {
                    Label::Safe if self.every_window => self.alarms(candidate, case.scene),
                    _ => Alarms::default(),
                },
            }
        };
        self.candidates.iter().map(ask).collect()
    }

    fn says(&self, candidate: &Candidate, case: &Labelled<'_>, window: &Window) -> WindowVerdict {
        let (scene, criterion) = (case.scene, &candidate.criterion);
        let Label::Collision(Some(who)) = case.label else {
            return match self.dangerous(candidate, scene, window) {
                true => WindowVerdict::Yes,
                false => WindowVerdict::No,
            };
        };
        let named = judge::critical(scene, window, criterion, self.radius, &self.thresholds);
        match accused(true, named.iter().copied()).contains(&who) {
            true => WindowVerdict::Yes,
            false if named.is_empty() => WindowVerdict::No,
            false => WindowVerdict::Another,
        }
    }

    fn dangerous(&self, candidate: &Candidate, scene: &Scene, window: &Window) -> bool {
        let past = ObservedHistory::from_window(scene, window);
        let prospects = candidate.criterion.prospects(&past, Some(self.radius));
        prospects.iter().any(|p| candidate.criterion.critical(p))
    }

    fn alarms(&self, candidate: &Candidate, scene: &Scene) -> Alarms {
        let mut found = Alarms::default();
        let dt = scene.scenario.dt();
        let mut before: Option<i64> = None;
        for last in first_whole(scene, self.history)..scene.steps().end {
            let window = Window::ending_at(scene, last, self.history);
            let alarm = self.dangerous(candidate, scene, &window);
            found.windows += 1;
            found.alarmed += u32::from(alarm);
            if alarm {
                let new = before.is_none_or(|before| (last - before) as f64 * dt > Alarms::APART);
                found.alarms += u32::from(new);
                before = Some(last);
            }
        }
        found.seconds = f64::from(found.windows) * dt;
        found
    }
}

impl Alarms {
    /// Adds the alarms of another scenario.
    pub fn add(&mut self, other: &Self) {
        self.windows += other.windows;
        self.alarmed += other.alarmed;
        self.alarms += other.alarms;
        self.seconds += other.seconds;
    }

    /// Alarms a minute; `None` if nothing was looked at.
    #[must_use]
    pub fn per_minute(&self) -> Option<f64> {
        (self.seconds > 0.0).then(|| f64::from(self.alarms) * 60.0 / self.seconds)
    }
}

/// Counts the answers of one candidate at one lead, by their places in the setting; a yes that names another is a no.
#[must_use]
pub fn confusion<'a>(
    answers: impl IntoIterator<Item = (Label, &'a [Answers])>,
    candidate: usize,
    lead: usize,
) -> Confusion {
    counted(answers, (candidate, lead), |said| {
        said == WindowVerdict::Yes
    })
}

/// The same where every yes counts, whomever it names.
#[must_use]
pub fn any_yes<'a>(
    answers: impl IntoIterator<Item = (Label, &'a [Answers])>,
    candidate: usize,
    lead: usize,
) -> Confusion {
    counted(answers, (candidate, lead), |said| said != WindowVerdict::No)
}

fn counted<'a>(
    answers: impl IntoIterator<Item = (Label, &'a [Answers])>,
    (candidate, lead): (usize, usize),
    is_yes: impl Fn(WindowVerdict) -> bool,
) -> Confusion {
    let mut counts = Confusion::default();
    for (label, of_scenario) in answers {
        if let Some(said) = of_scenario[candidate].said[lead] {
            counts.count(is_yes(said), label.collides());
        }
    }
    counts
}

impl Candidate {
    /// The reference judge as it answers everywhere.
    pub const REFERENCE: Self = Self {
        name: judge::MODEL,
        criterion: Criterion::REFERENCE,
    };

    /// The names that [`Self::named`] knows.
    pub const NAMES: [&str; 3] = [
        judge::MODEL,
        "reference/constant-velocity",
        "reference/constant-acceleration",
    ];

    /// The candidates with a name: of what the judge is compared with, one for each of the `horizons`, seconds.
    #[must_use]
    pub fn named(name: &str, horizons: &[f64]) -> Option<Vec<Self>> {
        let place = Self::NAMES.iter().position(|known| *known == name)?;
        let model = match place {
            0 => return Some(vec![Self::REFERENCE]),
            1 => Model::ConstantVelocity,
            _ => Model::ConstantAcceleration,
        };
        let of = |&horizon: &f64| Self {
            name: Self::NAMES[place],
            // A single motion either touches or not.
            criterion: Criterion {
                model,
                horizon,
                threshold: 1.0,
            },
        };
        Some(horizons.iter().map(of).collect())
    }
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
    /// As stores keep it, those of earlier versions too; it is read again like what people write.
    #[must_use]
    pub fn stored(self) -> String {
        match self {
            Self::Paper => STORED_END.into(),
            Self::Seconds(_) => self.to_string(),
        }
    }

    /// Describes where the windows of the safety task end; without a lead if none is given.
    #[must_use]
    pub fn words(lead: Option<Self>) -> String {
        match lead {
            None => {
                "windows end two steps before the end of every recording, as the paper's scripts had it".into()
            }
            Some(Self::Paper) => {
                "windows end two steps before the end of recordings with a collision; safe ones have their first window".into()
            }
            Some(Self::Seconds(seconds)) => {
                format!("windows end {seconds} s before collisions; safe scenarios have their first window")
            }
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
            _ => Err(format!("`end` or seconds from 0 to {LONGEST} are needed")),
        }
    }
}

/// No recording is longer, seconds.
const LONGEST: f64 = 3600.0;
