//! The timeline beside the clock: the measure of its strips, and disagreements between answers and judge.

use crate::model::{Model, OpenId, ShownAnswer};
use nearmiss_scene::metrics::{Danger, Measure, Series, measure};

/// Contents of the timeline's strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Heat {
    /// The risk score.
    #[default]
    Risk,
    /// The time to collision.
    Ttc,
    /// The distance.
    Distance,
    /// The measure that is plotted.
    Plotted,
    /// Nothing.
    Off,
}

/// A disagreement that is looked for in another scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seek {
    /// The opening of that scenario.
    pub opening: OpenId,
}

/// An answer that differs from the built-in judge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Disagreement {
    /// The step at which it was asked; of one about a whole recording, the one that decides.
    pub step: i64,
    /// Its column.
    pub column: usize,
    /// The obstacle of which it says something else; `None` where its yes or no differs.
    pub obstacle: Option<i64>,
}

impl Model {
    /// Measures for the strips, in order; the plotted one only if it is another.
    #[must_use]
    pub fn next_heat(&self) -> Heat {
        let own = ["risk", "ttc", "distance"].contains(&self.plot.measure.id);
        match self.heat {
            Heat::Risk => Heat::Ttc,
            Heat::Ttc => Heat::Distance,
            Heat::Distance if !own => Heat::Plotted,
            Heat::Distance | Heat::Plotted => Heat::Off,
            Heat::Off => Heat::Risk,
        }
    }

    /// The measure that the strips show, with its values; nothing without an ego, or where they are turned off.
    #[must_use]
    pub fn heat_series(&self) -> Option<(&'static Measure, &Series)> {
        let shown = self.opened.as_ref()?.series.as_ref();
        let (id, series) = match self.heat {
            Heat::Risk => ("risk", shown),
            Heat::Ttc => ("ttc", shown),
            Heat::Distance => ("distance", shown),
            Heat::Plotted => (self.plot.measure.id, self.plot.series.as_deref()),
            Heat::Off => return None,
        };
        Some((measure(id)?, series?))
    }

    /// Answers that are shown and say yes where the built-in judge says no, or no where it says yes; by step.
    #[must_use]
    pub fn disagreements(&self) -> Vec<Disagreement> {
        let Some(reference) = &self.answers.reference else {
            return Vec::new();
        };
        let (_, last) = self.clock.range();
        let columns = self.answers.columns.iter().enumerate();
        let differing = columns.filter_map(|(column, c)| {
            let verdict = c.answer()?.verdict()?;
            let truth = c.truth_or(Some(&reference.verdict))?;
            let step = c
                .steps
                .map(|(_, last)| last)
                .or(reference.decisive_step)
                .unwrap_or(last);
            (verdict.dangerous != truth.dangerous).then_some(Disagreement {
                step,
                column,
                obstacle: None,
            })
        });
        let mut all: Vec<Disagreement> = differing.collect();
        all.sort();
        all
    }

    /// The one after that which is looked at, in this scenario.
    #[must_use]
    pub fn next_of(&self, all: Vec<Disagreement>) -> Option<Disagreement> {
        let step = self.clock.step();
        let shown = match self.answers.shown {
            ShownAnswer::Column(column) => Some(column),
            ShownAnswer::Reference => None,
        };
        let walked = self.answers.walked.filter(|d| all.contains(d));
        let here = |d: &Disagreement| {
            let is_last = walked.is_none_or(|walked| walked == *d);
            d.step == step && Some(d.column) == shown && is_last
        };
        match all.iter().position(here) {
            Some(at) => all.get(at + 1).copied(),
            None => all.into_iter().find(|d| d.step >= step),
        }
    }
}

/// How dangerous a value is, 0 to 7, where the strip has no score: by a threshold, 7 at or beyond it and 0 from ten
/// times as far on; without one, within what occurs, `range` from the least to the most dangerous value.
#[must_use]
pub fn heat(value: f64, danger: Danger, threshold: Option<f64>, range: (f64, f64)) -> u8 {
    const STEPS: [f64; 7] = [1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0];
    let Some(threshold) = threshold.filter(|t| *t != 0.0) else {
        let (least, most) = range;
        let part = if most == least {
            0.0
        } else {
            (value - least) / (most - least)
        };
        return (part.clamp(0.0, 1.0) * 7.0).round() as u8;
    };
    if danger.reaches(value, threshold) {
        return 7;
    }
    // As far from danger as so many thresholds; a value of the other sign is farther than any.
    let ratio = match danger {
        Danger::High => threshold / value,
        Danger::Low | Danger::Neutral if threshold > 0.0 => value / threshold,
        Danger::Low | Danger::Neutral => threshold / value,
    };
    if ratio <= 0.0 || !ratio.is_finite() {
        return 0;
    }
    let beyond = STEPS.iter().filter(|&&step| ratio > step).count();
    7 - u8::try_from(beyond).unwrap_or(7)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_grows_towards_the_threshold_and_beyond_it_is_full() {
        let of = |value, danger, threshold| heat(value, danger, threshold, (10.0, 0.0));
        let low = [0.5, 1.5, 2.5, 5.0, 40.0].map(|v| of(v, Danger::Low, Some(1.5)));
        assert_eq!(low, [7, 7, 5, 3, 0]);
        let high = [4.0, 3.0, 2.0, 0.5, 0.0, -1.0].map(|v| of(v, Danger::High, Some(3.0)));
        assert_eq!(high, [7, 7, 6, 2, 0, 0]);
        let braking = [-9.0, -8.0, -4.0, 0.0, 2.0].map(|v| of(v, Danger::Low, Some(-8.0)));
        assert_eq!(braking, [7, 7, 5, 0, 0]);
        assert_eq!(
            [0.0, 5.0, 10.0].map(|v| of(v, Danger::Low, None)),
            [7, 4, 0]
        );
    }
}
