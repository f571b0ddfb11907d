//! How well what a question looks like tells its answer: without a look at how anybody moves.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use super::statistics::auc;
use nearmiss_record::Record;
use nearmiss_scene::verdict::Task;
use nearmiss_store::NewItem;

/// What is looked at: a name for tables, and the words for it.
pub const SURFACE: [(&str, &str); 5] = [
    ("position", "last time step of the window"),
    ("steps", "steps in the window"),
    ("obstacles", "obstacles near the ego in it"),
    ("length", "tokens of the question"),
    ("ego speed", "speed of the ego at its end"),
];

/// The surface of the questions of one slot, and how far it separates dangerous from safe windows: areas under the ROC
/// curve, 0.5 where it says nothing; `None` where there are not both.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Leak {
    /// The task.
    #[schemars(with = "String", title = "Task")]
    pub task: Task,
    /// The frame of the description; null for the built-in judge.
    #[schemars(title = "Frame")]
    pub frame: Option<String>,
    /// The prompting techniques.
    #[schemars(title = "Techniques")]
    pub techniques: Option<String>,
    /// The lead; null for all together, where there are several or none.
    #[schemars(title = "Lead")]
    pub lead: Option<String>,
    /// Dangerous windows.
    #[schemars(title = "Dangerous")]
    pub dangerous: usize,
    /// Safe ones.
    #[schemars(title = "Safe")]
    pub safe: usize,
    /// Areas under the ROC curve, by [`SURFACE`].
    #[serde(serialize_with = "by_surface")]
    #[schemars(with = "Surface")]
    pub auc: [Option<f64>; SURFACE.len()],
    /// The area of a logistic regression on all of them, on scenarios that it was not fitted to.
    #[schemars(title = "all, by regression", extend("decimals" = 2))]
    pub model_auc: Option<f64>,
}

impl Record for Leak {
    const NAME: &'static str = "leak";
    const TITLE: &'static str = "What the surface of the questions tells";
}

/// Areas under the ROC curve, in the order of [`SURFACE`].
#[derive(Serialize, JsonSchema)]
struct Surface {
    /// Of the last time step of the window.
    #[schemars(title = "position", extend("decimals" = 2))]
    position: Option<f64>,
    /// Of the steps in the window.
    #[schemars(title = "steps", extend("decimals" = 2))]
    steps: Option<f64>,
    /// Of the obstacles near the ego in it.
    #[schemars(title = "obstacles", extend("decimals" = 2))]
    obstacles: Option<f64>,
    /// Of the tokens of the question.
    #[schemars(title = "length", extend("decimals" = 2))]
    length: Option<f64>,
    /// Of the speed of the ego at its end.
    #[schemars(title = "ego speed", extend("decimals" = 2))]
    ego_speed: Option<f64>,
}

fn by_surface<S: Serializer>(auc: &[Option<f64>; SURFACE.len()], to: S) -> Result<S::Ok, S::Error> {
    let [position, steps, obstacles, length, ego_speed] = *auc;
    let named = Surface {
        position,
        steps,
        obstacles,
        length,
        ego_speed,
    };
    named.serialize(to)
}

/// One question.
struct Seen<'a> {
    scenario: &'a str,
    dangerous: bool,
    surface: [f64; SURFACE.len()],
}

/// The leaks of a batch's questions about scenes as they are: each question once, however many models are asked and however often.
#[must_use]
pub fn leaks<'a>(items: impl IntoIterator<Item = &'a NewItem>) -> Vec<Leak> {
    type Slot<'a> = (Task, Option<&'a str>, Option<&'a str>, Option<&'a str>);
    let mut slots: BTreeMap<Slot<'a>, Vec<Seen<'a>>> = BTreeMap::new();
    let mut once = BTreeSet::new();
    for item in items.into_iter().filter(|item| item.transform.is_none()) {
        let (Some(facts), Some(dangerous)) = (&item.facts, item.collides) else {
            continue;
        };
        let (frame, techniques) = (item.frame.as_deref(), item.techniques.as_deref());
        let lead = item.lead.as_deref();
        if !once.insert((&item.path, item.task, frame, techniques, lead, facts.steps)) {
            continue;
        }
        let (first, last) = facts.steps;
        let seen = || Seen {
            scenario: &item.scenario,
            dangerous,
            surface: [
                last as f64,
                (last - first + 1) as f64,
                facts.obstacles as f64,
                facts.tokens as f64,
                facts.speed,
            ],
        };
        let all = slots.entry((item.task, frame, techniques, None));
        all.or_default().push(seen());
        if lead.is_some() {
            let of_lead = slots.entry((item.task, frame, techniques, lead));
            of_lead.or_default().push(seen());
        }
    }
    let one = |((task, frame, techniques, lead), seen): (Slot<'a>, Vec<Seen<'a>>)| {
        let dangerous = seen.iter().filter(|one| one.dangerous).count();
        let of = |at: usize| {
            let values = seen.iter().map(|one| (one.surface[at], one.dangerous));
            auc(&values.collect::<Vec<_>>())
        };
        Leak {
            task,
            frame: frame.map(Into::into),
            techniques: techniques.map(Into::into),
            lead: lead.map(Into::into),
            dangerous,
            safe: seen.len() - dangerous,
            auc: std::array::from_fn(of),
            model_auc: auc(&out_of_fold(&seen)),
        }
    };
    // With a single lead, all together are the same questions once more.
    let leads = |(task, frame, techniques, _): &Slot<'a>| {
        let same = |slot: &&Slot<'a>| (slot.0, slot.1, slot.2) == (*task, *frame, *techniques);
        slots.keys().filter(same).count() - 1
    };
    let twice: Vec<Slot<'a>> = slots
        .keys()
        .filter(|slot| slot.3.is_none() && leads(slot) == 1)
        .copied()
        .collect();
    slots.retain(|slot, _| !twice.contains(slot));
    slots.into_iter().map(one).collect()
}

/// Parts of the scenarios that are predicted by a regression fitted to the others.
const FOLDS: usize = 5;

/// What a regression fitted to the other scenarios gives each question, and whether it is dangerous.
fn out_of_fold(seen: &[Seen<'_>]) -> Vec<(f64, bool)> {
    let scenarios: BTreeSet<&str> = seen.iter().map(|one| one.scenario).collect();
    let fold: BTreeMap<&str, usize> = scenarios
        .into_iter()
        .enumerate()
        .map(|(place, name)| (name, place % FOLDS))
        .collect();
    let mut found = Vec::with_capacity(seen.len());
    for part in 0..FOLDS {
        let is_out = |one: &&Seen<'_>| fold[one.scenario] == part;
        let others: Vec<&Seen<'_>> = seen.iter().filter(|one| !is_out(one)).collect();
        let out: Vec<&Seen<'_>> = seen.iter().filter(is_out).collect();
        let regression = Regression::fit(&others);
        found.extend(
            out.iter()
                .map(|one| (regression.score(&one.surface), one.dangerous)),
        );
    }
    found
}

/// A logistic regression on standardised values.
struct Regression {
    mean: [f64; SURFACE.len()],
    deviation: [f64; SURFACE.len()],
    weights: [f64; SURFACE.len()],
}

impl Regression {
    /// Steps of the gradient descent, their size, and the weight of the squared weights that keeps these bounded.
    const STEPS: usize = 300;
    const RATE: f64 = 0.5;
    const RIDGE: f64 = 0.01;

    fn fit(seen: &[&Seen<'_>]) -> Self {
        let n = seen.len().max(1) as f64;
        let mean =
            std::array::from_fn(|at| seen.iter().map(|one| one.surface[at]).sum::<f64>() / n);
        let deviation = std::array::from_fn(|at| {
            let squares = seen.iter().map(|one| (one.surface[at] - mean[at]).powi(2));
            (squares.sum::<f64>() / n).sqrt()
        });
        let mut fitted = Self {
            mean,
            deviation,
            weights: [0.0; SURFACE.len()],
        };
        let mut offset = 0.0;
        for _ in 0..Self::STEPS {
            let mut slope = fitted.weights.map(|weight| Self::RIDGE * weight);
            let mut lift = 0.0;
            for one in seen {
                let values = fitted.standardised(&one.surface);
                let score = offset + fitted.score(&one.surface);
                let error = 1.0 / (1.0 + (-score).exp()) - f64::from(u8::from(one.dangerous));
                slope
                    .iter_mut()
                    .zip(values)
                    .for_each(|(slope, value)| *slope += error * value / n);
                lift += error / n;
            }
            let weights = fitted.weights.iter_mut().zip(slope);
            weights.for_each(|(weight, slope)| *weight -= Self::RATE * slope);
            offset -= Self::RATE * lift;
        }
        fitted
    }

    /// Each value less its mean, in standard deviations; 0 of what never differs.
    fn standardised(&self, surface: &[f64; SURFACE.len()]) -> [f64; SURFACE.len()] {
        std::array::from_fn(|at| {
            if self.deviation[at] > 0.0 {
                (surface[at] - self.mean[at]) / self.deviation[at]
            } else {
                0.0
            }
        })
    }

    fn score(&self, surface: &[f64; SURFACE.len()]) -> f64 {
        let values = self.standardised(surface);
        values
            .iter()
            .zip(self.weights)
            .map(|(value, weight)| value * weight)
            .sum()
    }
}

#[cfg(test)]
#[path = "leaks_tests.rs"]
mod tests;
