//! `--at`: a moment of a scene, as a time step, in seconds, or the worst one.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use strum::{IntoStaticStr, VariantArray};

use super::Failure;
use nearmiss_scene::metrics::{Headline, Thresholds};
use nearmiss_scene::scenario::Scene;

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

/// What can be written after `--at`.
pub const AT: &str = "STEP|SECONDS|worst[:risk|ttc|distance]";

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
    /// The step among `steps` that are `dt` seconds apart; `worst` finds the worst one.
    ///
    /// # Errors
    /// There is no such step, or no obstacle by which one is worse than another.
    pub fn step(
        self,
        steps: &Range<i64>,
        dt: f64,
        worst: impl FnOnce(WorstBy) -> Option<i64>,
    ) -> Result<i64, Failure> {
        let step = match self {
            Self::Step(step) => step,
            // Beyond the range of integers it is beyond that of the steps.
            Self::Seconds(seconds) => (seconds / dt).round() as i64,
            Self::Worst(by) => {
                return worst(by).ok_or_else(|| {
                    Failure::input(format!(
                        "--at {self}: no obstacle is there with the ego, none has a value, or there is no ego; name a step",
                    ))
                });
            }
        };
        if steps.contains(&step) {
            return Ok(step);
        }
        let (first, last) = (steps.start, steps.end - 1);
        Err(Failure::input(format!(
            "--at {self}: the recording has steps {first} to {last} ({:.1} s to {:.1} s)",
            first as f64 * dt,
            last as f64 * dt
        )))
    }
}

/// The worst step of a scene.
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
        for wrong in ["", "s", "3.2", "nans", "best", "worst:", "worst:drac"] {
            assert!(wrong.parse::<At>().is_err(), "{wrong}");
        }
        let step = |at: At| at.step(&(0..50), 0.1, |_| Some(7)).map_err(|f| f.message);
        assert_eq!(step(At::Seconds(3.2)).unwrap(), 32);
        assert_eq!(step(At::Worst(WorstBy::Severity)).unwrap(), 7);
        let error = step(At::Seconds(9.0)).unwrap_err();
        assert!(error.contains("steps 0 to 49 (0.0 s to 4.9 s)"), "{error}");
    }
}
