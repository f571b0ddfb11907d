//! Ratings by persons: standings of models and prompts, and how far persons agree on the same answers.

use std::collections::BTreeMap;

use nearmiss_record::Record;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Choice, RatedAnswer, Rating};
use schemars::JsonSchema;
use serde::Serialize;

use super::TemplateVersion;
use super::bradley_terry::{Comparisons, NoStrengths, Strength};
use super::statistics::{cohen, fleiss};

/// By what ratings are summed up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StandingsBy {
    /// Who answered.
    Model,
    /// How it was asked: frame, techniques and the version of the template.
    Prompt,
}

/// Standing of one model or prompt configuration.
#[derive(Debug, Clone, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Standing {
    /// Which.
    #[schemars(title = "name")]
    pub name: String,
    /// Ratings in which it was shown.
    #[schemars(title = "shown")]
    pub shown: u32,
    /// Comparisons with another one: in a rating of three answers, the best one beats both others.
    #[schemars(title = "games")]
    pub games: u32,
    /// Of them won.
    #[schemars(title = "wins")]
    pub wins: u32,
    /// Of them tied.
    #[schemars(title = "ties")]
    pub ties: u32,
    /// Of them lost.
    #[schemars(title = "losses")]
    pub losses: u32,
    /// How often it was marked as wrong, or was among answers that were all called wrong.
    #[schemars(title = "wrong")]
    pub wrong: u32,
    /// Its strength, a logarithm with mean 0; null if there is none.
    #[schemars(title = "strength", extend("decimals" = 2))]
    pub strength: Option<f64>,
    /// The lower end of its interval of 95 %.
    #[schemars(title = "low", extend("decimals" = 2))]
    pub low: Option<f64>,
    /// The upper end.
    #[schemars(title = "high", extend("decimals" = 2))]
    pub high: Option<f64>,
}

impl Record for Standing {
    const NAME: &'static str = "runs-ratings";
    const TITLE: &'static str = "`runs ratings --format json`: one model or prompt a line";
}

/// All standings, strongest first; without strengths, by share of wins.
#[derive(Debug, Clone, PartialEq)]
pub struct Standings {
    /// One each.
    pub rows: Vec<Standing>,
    /// Why there are no strengths.
    pub without: Option<NoStrengths>,
}

impl Standings {
    /// Sums ratings up. Two answers of the same model, or to the same prompt, are no game.
    #[must_use]
    pub fn from_ratings(ratings: &[Rating], by: StandingsBy) -> Self {
        let name = |answer: &RatedAnswer| match by {
            StandingsBy::Model => answer.model.clone(),
            StandingsBy::Prompt => prompt(answer),
        };
        let mut places: BTreeMap<String, usize> = BTreeMap::new();
        for answer in ratings.iter().flat_map(|r| &r.answers) {
            let next = places.len();
            places.entry(name(answer)).or_insert(next);
        }
        let mut rows = vec![Standing::default(); places.len()];
        for (name, &place) in &places {
            rows[place].name.clone_from(name);
        }
        let mut comparisons = Comparisons::new(rows.len());
        for rating in ratings {
            let shown: Vec<usize> = rating.answers.iter().map(|a| places[&name(a)]).collect();
            let mut once = shown.clone();
            once.sort_unstable();
            once.dedup();
            once.iter().for_each(|&i| rows[i].shown += 1);
            for (answer, &i) in rating.answers.iter().zip(&shown) {
                rows[i].wrong += u32::from(answer.wrong || rating.choice == Choice::AllWrong);
            }
            match rating.choice {
                Choice::AllWrong => {}
                Choice::Best(best) => {
                    let Some(&winner) = shown.get(best) else {
                        continue;
                    };
                    for &loser in shown.iter().filter(|&&i| i != winner) {
                        comparisons.win(winner, loser);
                        rows[winner].wins += 1;
                        rows[loser].losses += 1;
                    }
                }
                Choice::Tie => {
                    for (at, &one) in shown.iter().enumerate() {
                        for &other in shown[at + 1..].iter().filter(|&&i| i != one) {
                            comparisons.tie(one, other);
                            rows[one].ties += 1;
                            rows[other].ties += 1;
                        }
                    }
                }
            }
        }
        let strengths = comparisons.strengths();
        let without = strengths.as_ref().err().cloned();
        for (place, row) in rows.iter_mut().enumerate() {
            row.games = row.wins + row.ties + row.losses;
            row.take(strengths.as_ref().ok().map(|all| all[place]));
        }
        rows.sort_by(|a, b| {
            let key = |row: &Standing| row.strength.unwrap_or(row.share());
            key(b).total_cmp(&key(a)).then_with(|| a.name.cmp(&b.name))
        });
        Self { rows, without }
    }
}

/// How an answer was asked, with the version of the template where that is known.
fn prompt(answer: &RatedAnswer) -> String {
    let version = answer
        .template
        .as_ref()
        .and_then(TemplateVersion::from_stored);
    match version {
        Some(version) => {
            let parts: Vec<&str> = answer.prompt.split(" · ").take(2).collect();
            format!("{} · {version}", parts.join(" · "))
        }
        None => answer.prompt.clone(),
    }
}

impl Standing {
    fn take(&mut self, strength: Option<Strength>) {
        self.strength = strength.map(|s| s.log);
        self.low = strength.map(|s| s.interval().0);
        self.high = strength.map(|s| s.interval().1);
    }

    /// Wins and half of the ties among its games; 0 without any.
    fn share(&self) -> f64 {
        if self.games == 0 {
            return 0.0;
        }
        (f64::from(self.wins) + 0.5 * f64::from(self.ties)) / f64::from(self.games)
    }
}

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
    use super::*;
    use nearmiss_scene::verdict::Task;

    fn rating(choice: Choice, answers: &[(&str, &str, bool)]) -> Rating {
        let answers = answers.iter().map(|(model, prompt, wrong)| RatedAnswer {
            run: None,
            model: (*model).into(),
            prompt: (*prompt).into(),
            wrong: *wrong,
            reason: None,
            template: None,
        });
        Rating {
            id: 1,
            created_ms: 0,
            person: "ada".into(),
            scenario: "s".into(),
            task: Task::Safety,
            blind: true,
            seed: 1,
            choice,
            notes: String::new(),
            answers: answers.collect(),
        }
    }

    #[test]
    fn games_are_counted_pair_by_pair() {
        let ratings = [
            rating(
                Choice::Best(1),
                &[("a", "p", false), ("b", "p", false), ("c", "q", true)],
            ),
            rating(Choice::Tie, &[("a", "p", false), ("b", "q", false)]),
            rating(Choice::Best(0), &[("a", "p", false), ("b", "q", true)]),
            rating(Choice::AllWrong, &[("a", "p", false), ("c", "p", false)]),
            rating(Choice::Best(0), &[("c", "p", false), ("a", "q", false)]),
        ];
        let standings = Standings::from_ratings(&ratings, StandingsBy::Model);
        let row = |name: &str| {
            let row = standings.rows.iter().find(|r| r.name == name);
            row.map(|r| (r.shown, r.games, r.wins, r.ties, r.losses, r.wrong))
        };
        assert_eq!(row("a"), Some((5, 4, 1, 1, 2, 1)));
        assert_eq!(row("b"), Some((3, 4, 2, 1, 1, 1)));
        assert_eq!(row("c"), Some((3, 2, 1, 0, 1, 2)));
        assert_eq!(standings.without, None);
        assert!(
            standings
                .rows
                .windows(2)
                .all(|w| w[0].strength >= w[1].strength)
        );
        let prompts = Standings::from_ratings(&ratings, StandingsBy::Prompt);
        let q = prompts.rows.iter().find(|r| r.name == "q");
        // The best of the first rating beats the one other prompt; the same prompt is no game.
        assert_eq!(
            q.map(|r| (r.games, r.wins, r.ties, r.losses)),
            Some((4, 0, 1, 3))
        );
    }

    #[test]
    fn too_few_ratings_have_no_strengths_and_say_why() {
        let one = [rating(
            Choice::Best(0),
            &[("a", "p", false), ("b", "p", false)],
        )];
        let standings = Standings::from_ratings(&one, StandingsBy::Model);
        assert_eq!(standings.without, Some(NoStrengths::Unbounded));
        assert_eq!(standings.rows[0].name, "a");
        assert_eq!(Standings::from_ratings(&[], StandingsBy::Model).rows, []);
    }
}

#[cfg(test)]
mod rater_agreement_tests {
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
