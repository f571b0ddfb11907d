//! Agreement of persons who rated the same answers.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::statistics::{cohen, fleiss};
use nearmiss_record::Record;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Choice, RatedAnswer, Rating};

/// What a person made of answers, whatever the order in which they were shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Judgement {
    /// This one is the best, by place among the answers in their own order.
    Best(usize),
    Tie,
    AllWrong,
}

/// Answers as they are told from others: by their runs, else by who gave them.
type Shown = (Task, String, Vec<(Option<i64>, String, String)>);

/// How far two persons agree.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PersonPair {
    /// One person.
    pub first: String,
    /// The other.
    pub second: String,
    /// Sets of answers that both rated.
    pub n: usize,
    /// The share of them that both judged alike.
    pub agreement: f64,
    /// Cohen's kappa; null where chance alone makes them agree always.
    pub kappa: Option<f64>,
}

/// How far persons agree.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct RaterAgreement {
    /// Sets of answers that several persons rated.
    pub n: usize,
    /// Fleiss' kappa of all of them; null where chance alone makes all agree always.
    pub kappa: Option<f64>,
    /// Each two persons who rated the same.
    pub pairs: Vec<PersonPair>,
}

impl Record for RaterAgreement {
    const NAME: &'static str = "runs-ratings-agreement";
    const TITLE: &'static str = "`runs ratings agreement --format json`: how far persons agree";
}

impl RaterAgreement {
    /// From ratings, the oldest first: of several by one person on the same answers the newest counts.
    #[must_use]
    pub fn from_ratings(ratings: &[Rating]) -> Self {
        let mut things: BTreeMap<Shown, BTreeMap<&str, Judgement>> = BTreeMap::new();
        for rating in ratings {
            let (shown, judgement) = judged(rating);
            let persons = things.entry(shown).or_default();
            persons.insert(&rating.person, judgement);
        }
        things.retain(|_, persons| persons.len() > 1);
        let mut both: BTreeMap<(&str, &str), Vec<(Judgement, Judgement)>> = BTreeMap::new();
        for persons in things.values() {
            for (first, a) in persons {
                for (second, b) in persons.range(*first..).skip(1) {
                    both.entry((first, second)).or_default().push((*a, *b));
                }
            }
        }
        let all: Vec<Vec<Judgement>> = things
            .values()
            .map(|persons| persons.values().copied().collect())
            .collect();
        let pairs = both.into_iter().map(|((first, second), choices)| {
            let same = choices.iter().filter(|(a, b)| a == b).count();
            PersonPair {
                first: first.into(),
                second: second.into(),
                n: choices.len(),
                agreement: same as f64 / choices.len() as f64,
                kappa: cohen(&choices),
            }
        });
        Self {
            n: things.len(),
            kappa: fleiss(&all),
            pairs: pairs.collect(),
        }
    }
}

fn judged(rating: &Rating) -> (Shown, Judgement) {
    let name = |answer: &RatedAnswer| {
        let run = answer.run.map(|run| run.0);
        (run, answer.model.clone(), answer.prompt.clone())
    };
    let mut order: Vec<usize> = (0..rating.answers.len()).collect();
    order.sort_by_key(|place| name(&rating.answers[*place]));
    let judgement = match rating.choice {
        Choice::Best(best) => {
            let place = order.iter().position(|place| *place == best);
            Judgement::Best(place.unwrap_or(best))
        }
        Choice::Tie => Judgement::Tie,
        Choice::AllWrong => Judgement::AllWrong,
    };
    let shown = order.iter().map(|place| name(&rating.answers[*place]));
    let shown = (rating.task, rating.scenario.clone(), shown.collect());
    (shown, judgement)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn rating(person: &str, scenario: &str, choice: Choice, models: [&str; 2]) -> Rating {
        let answer = |model: &str| RatedAnswer {
            model: model.into(),
            ..RatedAnswer::default()
        };
        Rating {
            id: 1,
            created_ms: 0,
            person: person.into(),
            scenario: scenario.into(),
            task: Task::Safety,
            blind: true,
            seed: 0,
            choice,
            notes: String::new(),
            answers: models.map(answer).into(),
        }
    }

    #[test]
    fn persons_agree_on_answers_whatever_their_order() {
        let (ab, ba) = (["lab/a", "lab/b"], ["lab/b", "lab/a"]);
        let ratings = [
            rating("ada", "1", Choice::Best(0), ab),
            rating("bob", "1", Choice::Best(1), ba),
            rating("ada", "2", Choice::Tie, ab),
            rating("bob", "2", Choice::Tie, ab),
            rating("ada", "3", Choice::Best(0), ab),
            // The second time counts.
            rating("ada", "3", Choice::Best(1), ab),
            rating("bob", "3", Choice::AllWrong, ab),
            rating("cyd", "4", Choice::Tie, ab),
        ];
        let found = RaterAgreement::from_ratings(&ratings);
        assert_eq!((found.n, found.pairs.len()), (3, 1));
        let pair = &found.pairs[0];
        assert_eq!(
            (pair.first.as_str(), pair.second.as_str(), pair.n),
            ("ada", "bob", 3)
        );
        // 2 of 3 alike; by chance 1/3·1/3 + 1/3·1/3 = 2/9: (2/3 - 2/9)/(7/9) = 4/7.
        assert!((pair.kappa.unwrap() - 4.0 / 7.0).abs() < 1e-12);
        assert_eq!(
            RaterAgreement::from_ratings(&ratings[..1]),
            RaterAgreement::default()
        );
    }
}
