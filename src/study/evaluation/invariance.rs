//! Invariance: whether answers stay the same when a scene is rotated, mirrored, moved or renumbered.

use std::collections::{BTreeMap, BTreeSet};

use super::confusion::{Share, Tally};
use super::{AnswerStatus, PromptConfig, Scored};
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::Verdict;

/// Two answers of one way of asking: about a scene, and about the same scene changed.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// About the scene as it is.
    pub original: &'a Scored,
    /// About the changed one, with the ids of the original: see [`Scored::mapped_back`].
    pub changed: &'a Scored,
    /// The change.
    pub transform: Transform,
}

/// Effect of a scene change on the answers of one prompt configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Invariance {
    /// How it was asked.
    pub configuration: PromptConfig,
    /// The change of the scenes.
    pub transform: Transform,
    /// Verdicts that turned from yes to no or from no to yes, of the pairs with two verdicts.
    pub flipped: Share,
    /// Verdicts that name other obstacles as the danger, of the same pairs: see [`Verdict::danger`].
    pub renamed: Share,
    /// The mean of the score afterwards less the score before, over all obstacles that both verdicts of a pair score.
    pub risk_change: Option<f64>,
    /// The mean of the size of that difference.
    pub risk_distance: Option<f64>,
    /// Obstacles that those two are the means of.
    pub scores: u32,
    /// Pairs in which one answer or both hold no verdict.
    pub without_verdict: u32,
    /// Pairs of one and the same answer, as the change leaves the words the same: nothing was asked that could flip,
    /// and none of the other counts has them.
    pub same_words: u32,
}

impl Scored {
    /// The same answer with obstacle ids mapped from old to new; ids not in the map stay. The ground truth is
    /// unchanged: it refers to the original.
    #[must_use]
    pub fn mapped_back(mut self, ids: &BTreeMap<i64, i64>) -> Self {
        let verdicts = self.reference.iter_mut().chain(match &mut self.status {
            AnswerStatus::Verdict(verdict) => Some(verdict),
            AnswerStatus::Unparsed(_) | AnswerStatus::Failed(_) | AnswerStatus::Unasked(_) => None,
        });
        for verdict in verdicts {
            let listed = verdict.obstacles.iter_mut().map(|o| &mut o.id);
            let critical = verdict.critical.iter_mut().flatten().map(|c| &mut c.id);
            for id in listed.chain(critical) {
                *id = ids.get(id).copied().unwrap_or(*id);
            }
        }
        self
    }

    fn verdict(&self) -> Option<&Verdict> {
        match &self.status {
            AnswerStatus::Verdict(verdict) => Some(verdict),
            AnswerStatus::Unparsed(_) | AnswerStatus::Failed(_) | AnswerStatus::Unasked(_) => None,
        }
    }
}

/// Finds the pairs among answers, by the names that [`Transform::name`] gives changed scenes: same scenario, way,
/// sample and window. Ids have to be mapped back before.
#[must_use]
pub fn pairs(answers: &[Scored]) -> Vec<Pair<'_>> {
    let named = |answer: &'_ Scored| Transform::of_name(&answer.scenario).1;
    let originals = answers.iter().filter(|a| named(a).is_none());
    let originals: BTreeMap<_, &Scored> = originals
        .map(|a| {
            (
                (a.scenario.as_str(), &a.configuration, a.sample, a.window),
                a,
            )
        })
        .collect();
    let pair = |changed| {
        let changed: &Scored = changed;
        let (scenario, transform) = Transform::of_name(&changed.scenario);
        let original = originals.get(&(
            scenario,
            &changed.configuration,
            changed.sample,
            changed.window,
        ))?;
        Some(Pair {
            original,
            changed,
            transform: transform?,
        })
    };
    answers.iter().filter_map(pair).collect()
}

/// Counts pairs, by way and change.
#[must_use]
pub fn invariance<'a>(pairs: impl IntoIterator<Item = Pair<'a>>) -> Vec<Invariance> {
    let mut groups: BTreeMap<(&PromptConfig, String), Vec<Pair<'a>>> = BTreeMap::new();
    for pair in pairs {
        let key = (&pair.original.configuration, pair.transform.to_string());
        groups.entry(key).or_default().push(pair);
    }
    groups
        .into_values()
        .filter_map(|pairs| from_pairs(&pairs))
        .collect()
}

/// Of pairs of one way and change.
fn from_pairs(pairs: &[Pair<'_>]) -> Option<Invariance> {
    let first = pairs.first()?;
    let (mut flipped, mut renamed) = (Tally::default(), Tally::default());
    let mut changes: Vec<f64> = Vec::new();
    let (mut without_verdict, mut same_words) = (0, 0);
    for pair in pairs {
        let Some((a, b)) = pair.original.verdict().zip(pair.changed.verdict()) else {
            without_verdict += 1;
            continue;
        };
        if pair.original.run.is_some() && pair.original.run == pair.changed.run {
            same_words += 1;
            continue;
        }
        let unit = pair.original.unit();
        flipped.count(unit, a.dangerous != b.dangerous);
        let named = |verdict: &Verdict| BTreeSet::from_iter(verdict.danger());
        renamed.count(unit, named(a) != named(b));
        let scores = scores(a);
        changes.extend(b.obstacles.iter().filter_map(|o| {
            let before = scores.get(&o.id)?;
            Some(f64::from(o.risk_score) - f64::from(*before))
        }));
    }
    let mean = |values: &mut dyn Iterator<Item = f64>| {
        (!changes.is_empty()).then(|| values.sum::<f64>() / changes.len() as f64)
    };
    Some(Invariance {
        configuration: first.original.configuration.clone(),
        transform: first.transform,
        flipped: flipped.share(),
        renamed: renamed.share(),
        risk_change: mean(&mut changes.iter().copied()),
        risk_distance: mean(&mut changes.iter().map(|c| c.abs())),
        scores: changes.len() as u32,
        without_verdict,
        same_words,
    })
}

fn scores(verdict: &Verdict) -> BTreeMap<i64, u8> {
    verdict
        .obstacles
        .iter()
        .map(|o| (o.id, o.risk_score))
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::tests_scored::{answer, failed};
    use nearmiss_scene::verdict::CriticalObstacle;
    use nearmiss_store::RunId;

    #[test]
    fn flips_names_and_scores_are_counted_by_way_and_change() {
        let mirrored = |name: &str| Transform::Mirror.name(name);
        let answers = [
            answer("a", "m/x", true, &[(1, 0), (2, 4)]),
            answer("b", "m/x", true, &[(1, 1)]),
            answer("c", "m/x", false, &[]),
            answer("d", "m/x", false, &[]),
            // The same; a flip that names no obstacle; another one named; no verdict; no original.
            answer(&mirrored("a"), "m/x", true, &[(1, 0), (2, 5)]),
            answer(&mirrored("b"), "m/x", false, &[(1, 4)]),
            answer(&mirrored("c"), "m/x", false, &[(7, 1)]),
            failed(&mirrored("d"), "m/x"),
            answer(&mirrored("e"), "m/x", false, &[]),
            answer(&Transform::Renumber(1).name("a"), "m/x", true, &[(1, 0)]),
            answer(&mirrored("a"), "m/y", true, &[]),
        ];
        let found = invariance(pairs(&answers));
        assert_eq!(found.len(), 2, "{found:#?}");
        let mirror = &found[0];
        assert_eq!(
            (mirror.transform, mirror.configuration.model.as_str()),
            (Transform::Mirror, "m/x")
        );
        let counts = |share: &Share| (share.hits, share.of, share.scenarios);
        assert_eq!(counts(&mirror.flipped), (1, 3, 3));
        assert_eq!(counts(&mirror.renamed), (2, 3, 3));
        assert_eq!((mirror.scores, mirror.without_verdict), (3, 1));
        // 0 → 0, 4 → 5 and 1 → 4.
        assert!((mirror.risk_change.unwrap() - 4.0 / 3.0).abs() < 1e-12);
        assert!((mirror.risk_distance.unwrap() - 4.0 / 3.0).abs() < 1e-12);
        assert_eq!(counts(&found[1].flipped), (0, 1, 1));
        assert_eq!(found[1].risk_change, Some(0.0));
    }

    #[test]
    fn windows_of_one_scenario_are_pairs_of_their_own() {
        let of = |name: &str, window, dangerous| Scored {
            window: Some(window),
            ..answer(name, "m/x", dangerous, &[])
        };
        let mirrored = Transform::Mirror.name("a");
        let answers = [
            of("a", (0, 9), true),
            of("a", (20, 29), false),
            of(&mirrored, (0, 9), true),
            of(&mirrored, (20, 29), false),
        ];
        let found = invariance(pairs(&answers));
        assert_eq!((found[0].flipped.hits, found[0].flipped.of), (0, 2));
    }

    #[test]
    fn the_same_answer_to_the_same_words_is_no_stable_answer() {
        let of_run = |name: &str, run| Scored {
            run: Some(RunId(run)),
            ..answer(name, "m/x", true, &[(1, 0)])
        };
        let turned = |name: &str| Transform::Mirror.name(name);
        let answers = [
            of_run("a", 1),
            of_run("b", 2),
            of_run(&turned("a"), 1),
            of_run(&turned("b"), 3),
        ];
        let found = invariance(pairs(&answers));
        let [mirror] = &found[..] else {
            panic!("{found:?}")
        };
        assert_eq!(
            (mirror.same_words, mirror.flipped.of, mirror.scores),
            (1, 1, 1)
        );
        let found = invariance(pairs(&answers[..3]));
        assert_eq!((found[0].same_words, found[0].flipped.interval), (1, None));
    }

    #[test]
    fn ids_are_mapped_back_in_both_verdicts() {
        let mut scored = answer("a", "m/x", true, &[(1, 0), (3, 2)]);
        if let AnswerStatus::Verdict(verdict) = &mut scored.status {
            verdict.critical = Some(vec![CriticalObstacle::new(1)]);
        }
        scored.reference = Some(scored.verdict().unwrap().clone());
        let back = scored.mapped_back(&BTreeMap::from([(1, 2), (2, 1)]));
        let ids = |v: &Verdict| v.obstacles.iter().map(|o| o.id).collect::<Vec<_>>();
        assert_eq!(ids(back.verdict().unwrap()), [2, 3]);
        assert_eq!(back.verdict().unwrap().danger(), [2]);
        assert_eq!(ids(back.reference.as_ref().unwrap()), [2, 3]);
    }
}
