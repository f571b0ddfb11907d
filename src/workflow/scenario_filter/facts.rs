//! Facts about a scenario in the list: a few numbers, its tags, its country, and how stored answers fare.

use std::collections::HashMap;
use std::sync::Arc;

use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::judge::judge_under;
use nearmiss_scene::metrics::{Headline, Measure, Nearest, Thresholds};
use nearmiss_scene::scenario::{EgoSource, Scenario, Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Origin, StoredVerdict};

use super::{Agreement, Number, Property};

/// Facts about a scenario, known before it is opened.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Facts {
    /// SHA-256 of the file.
    pub hash: String,
    /// How many obstacles it has.
    pub obstacles: usize,
    /// How long it is, seconds: the ego's motion, or everyone's where there is no ego.
    pub seconds: f64,
    /// Three letters for its country; empty where its benchmark id has none.
    pub country: String,
    /// The tags in the file.
    pub tags: Vec<String>,
    /// The most dangerous values, if there is an ego.
    pub headline: Option<Headline>,
    /// Stored answers to the collision task, held against the built-in judge.
    pub collision: Tally,
    /// Stored answers to the safety task.
    pub safety: Tally,
    /// Stored answers to the recording task.
    pub recording: Tally,
}

/// Stored answers with a yes or no: all of a task, without those in whose place another one counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// How many say what the built-in judge says.
    pub agree: u32,
    /// How many do not.
    pub differ: u32,
}

impl Tally {
    /// All of them.
    #[must_use]
    pub fn count(self) -> u32 {
        self.agree + self.differ
    }
}

/// Verdicts of the store, by scenario.
#[derive(Debug, Default)]
pub struct Verdicts {
    by_hash: HashMap<String, Vec<StoredVerdict>>,
    by_name: HashMap<String, Vec<StoredVerdict>>,
}

impl From<Vec<StoredVerdict>> for Verdicts {
    fn from(all: Vec<StoredVerdict>) -> Self {
        let mut verdicts = Self::default();
        for one in all {
            let of = match &one.scenario_hash {
                Some(hash) => verdicts.by_hash.entry(hash.clone()),
                None => verdicts.by_name.entry(one.scenario.clone()),
            };
            of.or_default().push(one);
        }
        verdicts
    }
}

impl Verdicts {
    /// Those about a scenario: by its hash, and those that are known by its name alone.
    fn about(&self, hash: &str, name: &str) -> impl Iterator<Item = &StoredVerdict> {
        let (by_hash, by_name) = (self.by_hash.get(hash), self.by_name.get(name));
        by_hash.into_iter().chain(by_name).flatten()
    }
}

impl Facts {
    /// Reads a scenario and works them out with this ego.
    ///
    /// # Errors
    /// It or its ego cannot be read.
    pub fn read(
        entry: &Entry,
        ego: &EgoSelection,
        thresholds: &Thresholds,
        verdicts: &Verdicts,
    ) -> Result<Self, String> {
        let scenario = entry.read().map_err(|e| e.to_string())?;
        let ego = ego.resolve(entry, &scenario).map_err(|e| e.to_string())?;
        let scene = ego.map(|ego| Scene::new(Arc::clone(&scenario), ego));
        let measured = scene.as_ref().map(|scene| {
            let headline = Headline::compute(scene, thresholds);
            (scene, headline)
        });
        Ok(Self::new(entry, &scenario, measured, thresholds, verdicts))
    }

    /// Those of a scenario that is open, with its scene and what is most dangerous in it where it has an ego.
    #[must_use]
    pub fn new(
        entry: &Entry,
        scenario: &Scenario,
        measured: Option<(&Scene, Headline)>,
        thresholds: &Thresholds,
        verdicts: &Verdicts,
    ) -> Self {
        let mut facts = Self {
            hash: scenario.hash.to_string(),
            obstacles: scenario.obstacles.len(),
            seconds: length(scenario.steps(), scenario),
            country: country_code(&scenario.header.benchmark_id).to_string(),
            tags: scenario.tags.clone(),
            ..Self::default()
        };
        let Some((scene, headline)) = measured else {
            return facts;
        };
        facts.seconds = length(scene.steps(), scenario);
        facts.headline = Some(headline);
        facts.count(entry, scene, thresholds, verdicts);
        facts
    }

    /// Whether the scenario has something; `None` of the user's tags and the index, which are not facts of a scenario.
    #[must_use]
    pub fn has(&self, property: Property) -> Option<bool> {
        match property {
            Property::Tags | Property::Index => None,
            Property::Error => Some(false),
            Property::Answers => Some(self.tally().count() > 0),
            Property::Ego => Some(self.headline.is_some()),
            Property::Collision => Some(self.headline.as_ref().is_some_and(Headline::collides)),
        }
    }

    /// A number of the scenario; `None` where it has none.
    #[must_use]
    pub fn number(&self, number: Number) -> Option<f64> {
        match number {
            Number::Of(measure) => Some(nearest(self.headline.as_ref()?, measure)?.value),
            Number::Obstacles => Some(self.obstacles as f64),
            Number::Duration => Some(self.seconds),
            Number::Answers => Some(f64::from(self.tally().count())),
        }
    }

    /// The verdicts of stored answers.
    #[must_use]
    pub fn agreement(&self) -> Agreement {
        let tally = self.tally();
        match (tally.differ, tally.agree) {
            (0, 0) => Agreement::Nothing,
            (0, _) => Agreement::Agree,
            _ => Agreement::Differ,
        }
    }

    /// All tallies together.
    #[must_use]
    pub fn tally(&self) -> Tally {
        Tally {
            agree: self.collision.agree + self.safety.agree + self.recording.agree,
            differ: self.collision.differ + self.safety.differ + self.recording.differ,
        }
    }

    /// The tally of a task; of the tasks without a yes or no there is none.
    #[must_use]
    pub fn task_tally(&self, task: Task) -> Tally {
        match task {
            Task::Collision => self.collision,
            Task::Safety => self.safety,
            Task::Recording => self.recording,
            Task::Attacker | Task::Trajectory => Tally::default(),
        }
    }

    /// Holds stored answers about the same ego against the built-in judge. What was told of no window that is known is
    /// left out where the window matters.
    fn count(
        &mut self,
        entry: &Entry,
        scene: &Scene,
        thresholds: &Thresholds,
        verdicts: &Verdicts,
    ) {
        let hash = scene.scenario.hash.to_string();
        let ego = scene.ego.to_string();
        let recorded = matches!(scene.ego.source, EgoSource::Recording(_));
        let mut truths: HashMap<(Task, Option<(i64, i64)>), bool> = HashMap::new();
        for one in verdicts.about(&hash, &entry.name) {
            let same_ego = match one.origin {
                Origin::Recorded => recorded,
                Origin::Asked | Origin::Replayed => one.ego == ego,
            };
            let (tally, window) = match (one.task, one.window) {
                (Task::Collision, _) => (&mut self.collision, None),
                (Task::Recording, _) => (&mut self.recording, None),
                (Task::Safety, Some(window)) => (&mut self.safety, Some(window)),
                _ => continue,
            };
            if !same_ego {
                continue;
            }
            let truth = *truths.entry((one.task, window)).or_insert_with(|| {
                let (first, last) = window.unwrap_or((i64::MAX, i64::MAX));
                let steps = last.saturating_sub(first).saturating_add(1);
                let history = usize::try_from(steps).unwrap_or(1);
                let window = Window::ending_at(scene, last, history);
                judge_under(scene, one.task, &window, thresholds)
                    .verdict
                    .dangerous
            });
            if one.dangerous == truth {
                tally.agree += 1
            } else {
                tally.differ += 1
            }
        }
    }
}

/// Seconds from the first of these steps to the last.
fn length(steps: std::ops::Range<i64>, scenario: &Scenario) -> f64 {
    steps
        .end
        .saturating_sub(steps.start)
        .saturating_sub(1)
        .max(0) as f64
        * scenario.dt()
}

/// The three capitals at the beginning of a benchmark id, or of a name like one; empty where there are none.
#[must_use]
pub fn country_code(id: &str) -> &str {
    let id = id.strip_prefix("C-").unwrap_or(id);
    match id.split_once('_') {
        Some((code, _)) if code.len() == 3 && code.bytes().all(|b| b.is_ascii_uppercase()) => code,
        _ => "",
    }
}

/// The most dangerous value of one of the measures [`HEADLINE`](super::HEADLINE).
#[must_use]
pub fn nearest(headline: &Headline, measure: &Measure) -> Option<Nearest> {
    match measure.id {
        "risk" => headline.risk,
        "distance" => headline.distance,
        _ => headline.ttc,
    }
}

/// A country a line: its code, then its names, the English one first.
const TABLE: &str = include_str!("countries.txt");

/// Letters that a word needs at least to be taken for the beginning of a name: shorter ones begin too many.
const MIN_PREFIX: usize = 4;

/// Codes of the countries that a word names or begins to name, in any case.
#[must_use]
pub fn country_codes(word: &str) -> Vec<&'static str> {
    let word = word.to_lowercase();
    let names_it = |name: &str| {
        let name = name.to_lowercase();
        let begins = |part: &str| part.starts_with(&word);
        // "korea" is in "South Korea", too.
        name == word
            || word.chars().count() >= MIN_PREFIX && (begins(&name) || name.split(' ').any(begins))
    };
    let countries = TABLE.lines().filter_map(|line| line.split_once(' '));
    countries
        .filter(|(_, names)| names.split(", ").any(names_it))
        .map(|(code, _)| code)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_or_its_beginning_gives_the_code() {
        assert_eq!(country_codes("germany"), ["DEU"]);
        assert_eq!(country_codes("Deutschland"), ["DEU"]);
        assert_eq!(country_codes("germ"), ["DEU"]);
        assert_eq!(country_codes("us"), ["USA"]);
        assert_eq!(country_codes("zamunda"), ["ZAM"]);
        assert_eq!(country_codes("korea"), ["KOR", "PRK"]);
        assert!(country_codes("ger").is_empty() && country_codes("").is_empty());
    }

    #[test]
    fn every_line_is_a_code_and_names() {
        for line in TABLE.lines() {
            let (code, names) = line.split_once(' ').unwrap_or_default();
            let capitals = code.chars().all(|c| c.is_ascii_uppercase());
            assert!(code.len() == 3 && capitals && !names.is_empty(), "{line}");
        }
    }
}
