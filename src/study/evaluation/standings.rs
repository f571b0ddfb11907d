//! Standings from ratings: games, wins, ties, losses and strengths of models or prompt configurations.

use std::collections::BTreeMap;

use serde::Serialize;

use super::TemplateVersion;
use super::bradley_terry::{Comparisons, NoStrengths, Strength};
use nearmiss_record::Record;
use nearmiss_store::{Choice, RatedAnswer, Rating};

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
    let version = answer.template.as_ref().and_then(TemplateVersion::of);
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
