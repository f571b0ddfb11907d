//! What would be right without a look at any motion: by the surface of questions, and by trivial rules.

use std::collections::{BTreeMap, BTreeSet};

use nearmiss_record::Record;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{NewItem, SplitPart, WindowFacts};
use schemars::JsonSchema;
use serde::{Serialize, Serializer};

use super::Confusion;
use super::statistics::auc;

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

/// A rule that needs no model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rule {
    /// Yes to everything.
    AlwaysYes,
    /// No to everything.
    AlwaysNo,
    /// Yes where a distance in the window is written as 0.00 m.
    WrittenZero,
    /// Yes where a time to collision at the end of the window is at most so many seconds.
    TtcAtMost(f64),
    /// Yes where an obstacle is nearer than so many metres at some step of the window.
    NearerThan(f64),
}

/// Thresholds of batches without a dev part, seconds and metres: those of a usual warning, and a car's length.
const USUAL: (f64, f64) = (1.5, 5.0);

/// Distances below this are written as 0.00 m.
const WRITTEN_ZERO: f64 = 0.005;

impl Rule {
    /// Its answer; nothing where the facts of the window do not tell.
    #[must_use]
    pub fn answer(self, facts: &WindowFacts) -> Option<bool> {
        match self {
            Self::AlwaysYes => Some(true),
            Self::AlwaysNo => Some(false),
            Self::WrittenZero => facts.nearest.map(|metres| metres < WRITTEN_ZERO),
            Self::NearerThan(limit) => facts.nearest.map(|metres| metres < limit),
            Self::TtcAtMost(limit) => {
                facts.nearest?;
                Some(facts.ttc.is_some_and(|seconds| seconds <= limit))
            }
        }
    }
}

impl std::fmt::Display for Rule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::AlwaysYes => write!(f, "always yes"),
            Self::AlwaysNo => write!(f, "always no"),
            Self::WrittenZero => write!(f, "a distance of 0.00"),
            Self::TtcAtMost(limit) => write!(f, "TTC ≤ {limit:.2} s"),
            Self::NearerThan(limit) => write!(f, "nearest < {limit:.2} m"),
        }
    }
}

/// What a rule comes to.
#[derive(Debug, Clone, PartialEq)]
pub struct RuleScore {
    /// The task.
    pub task: Task,
    /// The rule.
    pub rule: Rule,
    /// Whether its threshold was chosen on the dev part.
    pub is_fitted: bool,
    /// Its answers beside the truth, each question once.
    pub counts: Confusion,
}

/// One question of a task.
struct Asked<'a> {
    facts: &'a WindowFacts,
    dangerous: bool,
    part: Option<SplitPart>,
}

/// The rules on the questions of `part`, or of all, about scenes as they are with the first lead of a batch; each
/// question once, however many models, frames and techniques there are. Thresholds are the best ones of the dev part,
/// where there is one, else the usual ones.
#[must_use]
pub fn rules<'a>(
    items: impl Iterator<Item = &'a NewItem> + Clone,
    first_lead: Option<&str>,
    part: Option<SplitPart>,
) -> Vec<RuleScore> {
    let mut found = Vec::new();
    for task in [Task::Collision, Task::Safety] {
        let asked = asked(items.clone(), task, first_lead);
        if asked.iter().all(|one| one.facts.nearest.is_none()) {
            continue;
        }
        let dev: Vec<&Asked<'_>> = { asked.iter() }
            .filter(|one| one.part == Some(SplitPart::Dev))
            .collect();
        let fitted = |of: fn(f64) -> Rule, value: fn(&WindowFacts) -> Option<f64>, usual: f64| {
            let limit = best(&dev, value);
            (of(limit.unwrap_or(usual)), limit.is_some())
        };
        let rules = [
            (Rule::AlwaysYes, false),
            (Rule::AlwaysNo, false),
            (Rule::WrittenZero, false),
            fitted(Rule::TtcAtMost, |facts| facts.ttc, USUAL.0),
            fitted(Rule::NearerThan, |facts| facts.nearest, USUAL.1),
        ];
        found.extend(rules.map(|(rule, is_fitted)| {
            let mut counts = Confusion::default();
            let wanted = asked
                .iter()
                .filter(|one| part.is_none() || one.part == part);
            for one in wanted {
                if let Some(said) = rule.answer(one.facts) {
                    counts.count(said, one.dangerous);
                }
            }
            RuleScore {
                task,
                rule,
                is_fitted,
                counts,
            }
        }));
    }
    found
}

fn asked<'a>(
    items: impl Iterator<Item = &'a NewItem>,
    task: Task,
    first_lead: Option<&str>,
) -> Vec<Asked<'a>> {
    let mut once = BTreeSet::new();
    let plain = items.filter(|item| {
        let lead = item.lead.as_deref();
        item.task == task && item.transform.is_none() && (lead.is_none() || lead == first_lead)
    });
    let each = plain.filter_map(|item| {
        let (facts, dangerous) = (item.facts.as_ref()?, item.collides?);
        once.insert((&item.path, facts.steps)).then_some(Asked {
            facts,
            dangerous,
            part: item.split,
        })
    });
    each.collect()
}

/// The threshold below which a yes is right most often, halfway between two values; nothing without two. Who has no value
/// is never below it.
fn best(asked: &[&Asked<'_>], value: fn(&WindowFacts) -> Option<f64>) -> Option<f64> {
    let values = asked
        .iter()
        .filter_map(|one| Some((value(one.facts)?, one.dangerous)));
    let mut values: Vec<(f64, bool)> = values.collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut gained = 0_i64;
    let mut found: Option<(i64, f64)> = None;
    for two in values.windows(2) {
        let [(low, dangerous), (high, _)] = [two[0], two[1]];
        // One yes more: right of a dangerous one, wrong of a safe one.
        gained += if dangerous { 1 } else { -1 };
        if low < high && found.is_none_or(|(most, _)| gained > most) {
            found = Some((gained, f64::midpoint(low, high)));
        }
    }
    found.map(|(_, limit)| limit)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::{Leak, leaks};
    use nearmiss_scene::verdict::Task;
    use nearmiss_store::{NewItem, WindowFacts};

    fn item(place: i64, dangerous: bool, last: i64) -> NewItem {
        NewItem {
            path: format!("/data/{place}.xml"),
            scenario: place.to_string(),
            scenario_hash: None,
            ego: None,
            task: Task::Safety,
            frame: Some("ego".into()),
            techniques: Some("base".into()),
            model: "lab/a".into(),
            sample: 0,
            lead: Some("1".into()),
            transform: None,
            window: Some((last - 9, last)),
            facts: Some(WindowFacts {
                steps: (last - 9, last),
                critical: Vec::new(),
                obstacles: (place % 3) as u64,
                speed: 8.0,
                nearest: None,
                ttc: None,
                tokens: 900,
                template_hash: String::new(),
            }),
            scene: None,
            key: None,
            collides: Some(dangerous),
            obstacle: None,
            unaskable: None,
            settings: None,
            split: None,
        }
    }

    fn only(items: &[NewItem]) -> Leak {
        let found = leaks(items);
        let of_lead = found
            .into_iter()
            .find(|leak| leak.lead.as_deref() == Some("1"));
        of_lead.unwrap()
    }

    #[test]
    fn a_late_window_is_a_dangerous_one() {
        let told: Vec<NewItem> = (0..40)
            .map(|at| item(at, at % 2 == 0, 50 + 40 * ((at + 1) % 2)))
            .collect();
        let leak = only(&told);
        assert_eq!((leak.dangerous, leak.safe), (20, 20));
        assert_eq!(leak.auc[0], Some(1.0));
        assert_eq!(
            (leak.auc[1], leak.auc[3], leak.auc[4]),
            (Some(0.5), Some(0.5), Some(0.5))
        );
        assert_eq!(leak.model_auc, Some(1.0), "a regression finds it, too");
    }

    #[test]
    fn matched_windows_say_nothing_and_each_counts_once() {
        let alike = |at: i64| [item(at, true, 50 + at), item(100 + at, false, 50 + at)];
        let mut items: Vec<NewItem> = (0..30).flat_map(alike).collect();
        let again: Vec<NewItem> = items
            .iter()
            .cloned()
            .map(|one| NewItem { sample: 1, ..one })
            .collect();
        items.extend(again);
        let leak = only(&items);
        assert_eq!((leak.dangerous, leak.safe), (30, 30));
        assert_eq!(leak.auc[0], Some(0.5));
        let model = leak.model_auc.unwrap();
        assert!((0.3..0.7).contains(&model), "{model}");
        assert_eq!(leaks(&items).len(), 1, "a single lead is not shown twice");
        let later = NewItem {
            lead: Some("2".into()),
            ..items[0].clone()
        };
        items.push(later);
        let slots: Vec<Option<String>> = leaks(&items).into_iter().map(|leak| leak.lead).collect();
        assert_eq!(slots.len(), 3, "each lead, and all together: {slots:?}");
        assert_eq!(slots[0], None);
    }

    #[test]
    fn one_class_alone_has_no_curve() {
        let leak = only(&[item(0, true, 50), item(1, true, 60)]);
        assert_eq!((leak.auc[0], leak.model_auc), (None, None));
    }
}

#[cfg(test)]
mod rules_tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn item(
        path: &str,
        (nearest, ttc): (f64, Option<f64>),
        dangerous: bool,
        part: SplitPart,
    ) -> NewItem {
        NewItem {
            path: path.into(),
            scenario: path.into(),
            scenario_hash: None,
            ego: None,
            task: Task::Safety,
            frame: None,
            techniques: None,
            model: "lab/a".into(),
            sample: 0,
            lead: Some("1".into()),
            transform: None,
            window: Some((0, 9)),
            facts: Some(WindowFacts {
                steps: (0, 9),
                nearest: Some(nearest),
                ttc,
                ..WindowFacts::default()
            }),
            scene: None,
            key: None,
            collides: Some(dangerous),
            obstacle: None,
            unaskable: None,
            settings: None,
            split: Some(part),
        }
    }

    #[test]
    fn thresholds_are_of_the_dev_part_alone() {
        use SplitPart::{Dev, Test};
        let items = [
            item("a", (2.0, Some(0.75)), true, Dev),
            item("b", (6.0, Some(1.25)), true, Dev),
            item("c", (8.0, Some(3.0)), false, Dev),
            item("d", (9.0, None), false, Dev),
            item("e", (7.5, Some(2.0)), true, Test),
            item("f", (1.0, None), false, Test),
        ];
        let of = |part| rules(items.iter(), Some("1"), part);
        let test = of(Some(Test));
        assert_eq!(
            (test[3].rule, test[3].is_fitted),
            (Rule::TtcAtMost(2.125), true)
        );
        assert_eq!(test[3].counts.accuracy(), Some(1.0));
        assert_eq!(test[4].rule, Rule::NearerThan(7.0));
        assert_eq!(test[4].counts.accuracy(), Some(0.0));
        assert_eq!(of(Some(Dev))[3].counts.accuracy(), Some(1.0));
        assert_eq!(of(None)[0].counts.answered(), 6);
        let other = rules(items.iter(), Some("2"), None);
        assert!(other.is_empty(), "other leads are other questions");
    }

    #[test]
    fn a_written_zero_is_a_contact_to_two_decimals() {
        for (nearest, said) in [(0.0, true), (0.004, true), (0.006, false)] {
            let one = item("a", (nearest, None), true, SplitPart::Dev);
            let facts = one.facts.unwrap();
            assert_eq!(Rule::WrittenZero.answer(&facts), Some(said), "{nearest}");
        }
    }
}
