//! Moments and windows of a scene, as a user names them: a step, seconds, the worst.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use nearmiss_ask::prompts::Techniques;
use nearmiss_scene::description::Frame;
use nearmiss_scene::metrics::{Headline, Thresholds};
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::Settings;
use nearmiss_study::evaluation::batch::Experiment;
use strum::{IntoStaticStr, VariantArray};

/// Which steps are looked at, and which obstacle.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Span {
    /// The last step; where none is named that of the recording, and of the safety task two steps earlier.
    pub at: Option<At>,
    /// Steps in the window.
    pub history: Option<usize>,
    /// The only obstacle that is described.
    pub obstacle: Option<i64>,
}

impl Span {
    /// The options with which steps were chosen, for people; nothing if none was.
    #[must_use]
    pub fn chosen(&self) -> Option<&'static str> {
        match (self.at, self.history) {
            (Some(_), Some(_)) => Some("--at and --history"),
            (Some(_), None) => Some("--at"),
            (None, Some(_)) => Some("--history"),
            (None, None) => None,
        }
    }

    /// The window in a scene, of so many steps unless another number is named.
    ///
    /// # Errors
    /// There is no such step, or the task is about the whole recording.
    pub fn window(
        &self,
        scene: &Scene,
        thresholds: &Thresholds,
        task: Option<Task>,
        history: usize,
    ) -> Result<Window, String> {
        if task == Some(Task::Recording) {
            return match self.chosen() {
                Some(chosen) => Err(format!(
                    "--task recording asks about the whole recording; remove {chosen}"
                )),
                None => Ok(Window::full(scene)),
            };
        }
        let steps = scene.steps();
        let worst = |by| worst_step(scene, thresholds, by);
        let at = self
            .at
            .map(|at| at.step("--at", &steps, scene.scenario.dt(), worst));
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
    ///
    /// # Errors
    /// A setting does not fit the frame.
    pub fn settings(
        &self,
        set: &Experiment,
        techniques: Option<Techniques>,
        frame: Frame,
    ) -> Result<Settings, String> {
        let set = set.settings(techniques);
        let settings = Settings {
            history: self.history.or(set.history),
            obstacle: self.obstacle,
            ..set
        };
        match settings.misplaced(&[frame], "--set ") {
            Some(why) => Err(why),
            None => Ok(settings),
        }
    }
}

/// A moment, as the user names it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum At {
    /// A time step.
    Step(i64),
    /// Seconds since time step 0: the nearest step.
    Seconds(f64),
    /// The moment that matters by severity, or the worst one by a measure.
    Worst(WorstBy),
}

/// What the worst moment is the worst by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum WorstBy {
    /// See [`Headline::worst`].
    Severity,
    /// The lowest risk score, where it is nearest.
    Risk,
    /// The lowest time to collision.
    Ttc,
    /// The smallest distance.
    Distance,
}

nearmiss_record::named!(WorstBy);

/// A moment that is named by its time.
///
/// # Errors
/// The word is neither a step nor seconds.
pub fn moment(word: &str) -> Result<At, String> {
    match word.parse() {
        Ok(at @ (At::Step(_) | At::Seconds(_))) => Ok(at),
        _ => Err("expected a time step (32) or seconds (3.2s)".into()),
    }
}

impl FromStr for At {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        if word == "worst" {
            return Ok(Self::Worst(WorstBy::Severity));
        }
        if let Some(by) = word.strip_prefix("worst:") {
            return WorstBy::parse(by).map(Self::Worst).ok_or_else(|| {
                "expected worst:severity, worst:risk, worst:ttc or worst:distance".into()
            });
        }
        if let Ok(step) = word.parse() {
            return Ok(Self::Step(step));
        }
        let seconds = word
            .strip_suffix('s')
            .and_then(|s| s.trim().parse().ok())
            .filter(|s: &f64| s.is_finite());
        seconds
            .map(Self::Seconds)
            .ok_or_else(|| "expected a time step (32), seconds (3.2s), worst or worst:risk".into())
    }
}

impl serde::Serialize for At {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl fmt::Display for At {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step(step) => write!(f, "{step}"),
            Self::Seconds(seconds) => write!(f, "{seconds}s"),
            Self::Worst(WorstBy::Severity) => f.write_str("worst"),
            Self::Worst(by) => write!(f, "worst:{}", by.name()),
        }
    }
}

impl At {
    /// The step among `steps` that are `dt` seconds apart; `worst` finds the worst one, and `option` is where it was named.
    ///
    /// # Errors
    /// There is no such step, or no obstacle by which one is worse than another.
    pub fn step(
        self,
        option: &str,
        steps: &Range<i64>,
        dt: f64,
        worst: impl FnOnce(WorstBy) -> Option<i64>,
    ) -> Result<i64, String> {
        let step = match self {
            Self::Step(step) => step,
            // Beyond the range of integers it is beyond that of the steps.
            Self::Seconds(seconds) => (seconds / dt).round() as i64,
            Self::Worst(by) => {
                return worst(by).ok_or_else(|| {
                    format!(
                        "{option} {self}: no obstacle is there with the ego, none has a value, or there is no ego; name a step",
                    )
                });
            }
        };
        if steps.contains(&step) {
            return Ok(step);
        }
        let (first, last) = (steps.start, steps.end - 1);
        Err(format!(
            "{option} {self}: the recording has steps {first} to {last} ({:.1} s to {:.1} s)",
            first as f64 * dt,
            last as f64 * dt
        ))
    }
}

/// The worst step of a scene.
#[must_use]
pub fn worst_step(scene: &Scene, thresholds: &Thresholds, by: WorstBy) -> Option<i64> {
    let headline = Headline::compute(scene, thresholds);
    let nearest = match by {
        WorstBy::Severity => return headline.worst().map(|moment| moment.step),
        WorstBy::Risk => headline.risk,
        WorstBy::Ttc => headline.ttc,
        WorstBy::Distance => headline.distance,
    };
    nearest.map(|nearest| nearest.step)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn moments_are_steps_seconds_or_the_worst() {
        assert_eq!("32".parse(), Ok(At::Step(32)));
        assert_eq!("-3".parse(), Ok(At::Step(-3)));
        assert_eq!("3.2s".parse(), Ok(At::Seconds(3.2)));
        assert_eq!("worst".parse(), Ok(At::Worst(WorstBy::Severity)));
        assert_eq!("worst:risk".parse(), Ok(At::Worst(WorstBy::Risk)));
        assert_eq!(At::Worst(WorstBy::Ttc).to_string(), "worst:ttc");
        assert_eq!(moment("2s"), Ok(At::Seconds(2.0)));
        assert!(moment("worst").is_err());
        for wrong in ["", "s", "3.2", "nans", "best", "worst:", "worst:drac"] {
            assert!(wrong.parse::<At>().is_err(), "{wrong}");
        }
        let step = |at: At| at.step("--at", &(0..50), 0.1, |_| Some(7));
        assert_eq!(step(At::Seconds(3.2)).unwrap(), 32);
        assert_eq!(step(At::Worst(WorstBy::Severity)).unwrap(), 7);
        let error = step(At::Seconds(9.0)).unwrap_err();
        assert!(error.contains("steps 0 to 49 (0.0 s to 4.9 s)"), "{error}");
    }
}
