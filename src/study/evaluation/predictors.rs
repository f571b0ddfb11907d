//! Built-in predictors side by side: by which criterion each predicts, and how often it raises false alarms.

use super::lead::first_full_step;
use nearmiss_scene::judge::{self, Criterion};
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

impl Alarms {
    /// Alarms that are nearer in time are one, seconds.
    pub const APART: f64 = 1.0;

    /// Adds the alarms of another scenario.
    pub fn add(&mut self, other: &Self) {
        self.windows += other.windows;
        self.alarmed += other.alarmed;
        self.alarms += other.alarms;
        self.seconds += other.seconds;
    }

    /// The share of windows with an alarm; `None` if nothing was looked at.
    #[must_use]
    pub fn share(&self) -> Option<f64> {
        (self.windows > 0).then(|| f64::from(self.alarmed) / f64::from(self.windows))
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

    /// The model of its answers: its name, with the horizon, seconds, where there may be several.
    #[must_use]
    pub fn model(&self) -> String {
        match self.name {
            judge::MODEL => self.name.into(),
            name => format!("{name}:{}", self.criterion.horizon),
        }
    }

    /// Its alarms over every window of `history` steps of a scene, about obstacles within `radius` metres.
    #[must_use]
    pub fn alarms(&self, scene: &Scene, history: usize, radius: f64) -> Alarms {
        let mut found = Alarms::default();
        let dt = scene.scenario.dt();
        let mut before: Option<i64> = None;
        for last in first_full_step(scene, history)..scene.steps().end {
            let window = Window::ending_at(scene, last, history);
            let past = ObservedHistory::from_window(scene, &window);
            let prospects = self.criterion.prospects(&past, Some(radius));
            let alarm = prospects.iter().any(|p| self.criterion.critical(p));
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
