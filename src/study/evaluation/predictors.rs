//! Built-in predictors side by side: how long before a collision they see it, and how often they raise false alarms.

use std::sync::Arc;

use super::lead::first_full_step;
use super::windows::{Moment, Recording, SampledWindow, Sampling};
use super::{Label, Labelled, Lead, Scored};
use nearmiss_scene::judge::{self, Criterion};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::prediction::{Model, ObservedHistory};
use nearmiss_scene::scenario::{Scene, Window};

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
    /// How far after its last step the truth of a window looks, seconds.
    pub within: f64,
    /// Only obstacles whose centre is this near to the ego's at the end of a window, metres.
    pub radius: f64,
    /// Who is evaluated.
    pub candidates: Vec<Candidate>,
    /// Thresholds of the risk scores.
    pub thresholds: Arc<Thresholds>,
    /// Whether every window of safe scenarios is looked at, for [`Predictions::alarms`].
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

/// One candidate's answers to the safety task.
#[derive(Debug, Clone, PartialEq)]
pub struct Predictions {
    /// At each lead of the setting, scenario by scenario; those whose recording begins later than the window would
    /// end are left out.
    pub leads: Vec<Vec<Scored>>,
    /// Over all windows of safe scenarios.
    pub alarms: Alarms,
}

impl Setting {
    /// Every candidate's answers about all scenarios, from those about each.
    #[must_use]
    pub fn join(&self, of_each: impl IntoIterator<Item = Vec<Predictions>>) -> Vec<Predictions> {
        let none = Predictions {
            leads: vec![Vec::new(); self.leads.len()],
            alarms: Alarms::default(),
        };
        let mut all = vec![none; self.candidates.len()];
        for of_scenario in of_each {
            for (all, more) in all.iter_mut().zip(of_scenario) {
                all.alarms.add(&more.alarms);
                for (lead, more) in all.leads.iter_mut().zip(more.leads) {
                    lead.extend(more);
                }
            }
        }
        all
    }

    /// The windows of every recording, in their order, by lead.
    #[must_use]
    pub fn windows(&self, recordings: &[Recording]) -> Vec<Vec<Vec<SampledWindow>>> {
        let mut by_recording = vec![vec![Vec::new(); self.leads.len()]; recordings.len()];
        for (at, lead) in self.leads.iter().enumerate() {
            let sampling = Sampling {
                every_recording: false,
                moment: Moment::Before(*lead),
                history: self.history,
                horizon: self.within,
            };
            for one in sampling.draw(recordings) {
                by_recording[one.recording][at].push(one);
            }
        }
        by_recording
    }

    /// Every candidate's answers about the windows of a scenario, by lead.
    #[must_use]
    pub fn ask(
        &self,
        scenario: &str,
        case: &Labelled<'_>,
        windows: &[Vec<SampledWindow>],
    ) -> Vec<Predictions> {
        let ask = |candidate: &Candidate| {
            let answer = |one: &SampledWindow| {
                let (criterion, scene) = (&candidate.criterion, case.scene);
                let window = &one.window;
                let verdict =
                    judge::verdict_by(criterion, scene, window, self.radius, &self.thresholds);
                Scored {
                    window: Some((window.first(), window.last())),
                    critical: one.critical.clone(),
                    ..Scored::built_in(scenario, candidate.name, Some(one.label), verdict)
                }
            };
            let at = |windows: &Vec<SampledWindow>| windows.iter().map(answer).collect();
            Predictions {
                leads: windows.iter().map(at).collect(),
                alarms: match case.label {
                    Label::Safe if self.every_window => self.alarms(candidate, case.scene),
                    _ => Alarms::default(),
                },
            }
        };
        self.candidates.iter().map(ask).collect()
    }

    fn alarms(&self, candidate: &Candidate, scene: &Scene) -> Alarms {
        let mut found = Alarms::default();
        let dt = scene.scenario.dt();
        let mut before: Option<i64> = None;
        for last in first_full_step(scene, self.history)..scene.steps().end {
            let window = Window::ending_at(scene, last, self.history);
            let past = ObservedHistory::from_window(scene, &window);
            let prospects = candidate.criterion.prospects(&past, Some(self.radius));
            let alarm = prospects.iter().any(|p| candidate.criterion.critical(p));
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
    /// Alarms that are nearer in time are one, seconds.
    pub const APART: f64 = 1.0;

    /// Adds the alarms of another scenario.
    fn add(&mut self, other: &Self) {
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

impl Candidate {
    /// The reference judge as it answers everywhere.
    pub const REFERENCE: Self = Self {
        name: judge::MODEL,
        criterion: Criterion::REFERENCE,
    };

    /// The names that [`Self::by_name`] knows.
    pub const NAMES: [&str; 3] = [
        judge::MODEL,
        "reference/constant-velocity",
        "reference/constant-acceleration",
    ];

    /// The candidates with a name: of what the judge is compared with, one for each of the `horizons`, seconds.
    #[must_use]
    pub fn by_name(name: &str, horizons: &[f64]) -> Option<Vec<Self>> {
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
