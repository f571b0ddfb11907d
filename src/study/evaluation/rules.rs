//! Trivial rules: what would be right without a model on the questions of a batch. Who is not better reads a table at most.

use std::collections::BTreeSet;

use super::Confusion;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{NewItem, SplitPart, WindowFacts};

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
