//! Sentences about the bundled scenarios that two people labelled, and how far the rules agree with them.

use std::collections::BTreeMap;

use nearmiss_formats::bundled;
use nearmiss_record::Record;
use nearmiss_scene::scenario::Scene;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{CheckedClaim, Judgement, Quantity, SentenceOutcome, Subject, TimeOrigin, sentences};

/// The sentences, a line of JSON each: written and labelled before the rules saw them, with the claims that a second reading
/// found, too.
const SENTENCES: &str = include_str!("sentences.jsonl");

#[derive(Debug, Deserialize)]
struct Labelled {
    scenario: String,
    window: (i64, i64),
    style: String,
    #[serde(default)]
    context: String,
    text: String,
    claims: Vec<Label>,
    outcome: Option<String>,
}

#[derive(Debug, Deserialize)]
struct Label {
    about: About,
    kind: String,
    outcome: SentenceOutcome,
}

/// Whom a label is about.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum About {
    Obstacle(i64),
    Ego(#[allow(dead_code)] String),
}

/// How far the rules agree with people, on the sentences of a style.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct AgreementRow {
    /// The style of the sentences; "all" for all of them.
    #[schemars(title = "Style")]
    pub style: String,
    /// Sentences.
    #[schemars(title = "Sentences")]
    pub sentences: u32,
    /// Claims that people decided.
    #[schemars(title = "Claims")]
    pub claims: u32,
    /// Those that the rules decided.
    #[schemars(title = "Found")]
    pub found: u32,
    /// Those of them that they decided as people did.
    #[schemars(title = "Alike")]
    pub alike: u32,
    /// Sentences that people call wrong, and the rules right.
    #[schemars(title = "Wrong called right")]
    pub wrong_called_right: u32,
    /// Sentences that people call right, and the rules wrong.
    #[schemars(title = "Right called wrong")]
    pub right_called_wrong: u32,
}

impl Record for AgreementRow {
    const NAME: &'static str = "agreement";
    const TITLE: &'static str = "Sentences of a style a line";
}

impl AgreementRow {
    fn new(style: &str) -> Self {
        Self {
            style: style.into(),
            sentences: 0,
            claims: 0,
            found: 0,
            alike: 0,
            wrong_called_right: 0,
            right_called_wrong: 0,
        }
    }
}

/// The style of sentences in other languages, of which nothing is to be heard.
const FOREIGN: &str = "foreign";

/// The agreement on each style, and on all of them first; those in other languages count by what they are called alone.
#[must_use]
pub fn agreement() -> Vec<AgreementRow> {
    let scenes: BTreeMap<String, Scene> = { bundled().into_iter() }
        .filter_map(|entry| {
            let scenario = entry.read().ok()?;
            let ego = entry.recorded_ego(&scenario).ok()??;
            Some((entry.name, Scene::new(scenario, ego)))
        })
        .collect();
    let mut rows = vec![AgreementRow::new("all")];
    let all = SENTENCES
        .lines()
        .filter_map(|line| serde_json::from_str::<Labelled>(line).ok());
    for one in all {
        let Some(scene) = scenes.get(&one.scenario) else {
            continue;
        };
        let place = rows.iter().position(|row| row.style == one.style);
        let place = place.unwrap_or_else(|| {
            rows.push(AgreementRow::new(&one.style));
            rows.len() - 1
        });
        let counted = one.compared(scene);
        for place in [0, place] {
            let row = &mut rows[place];
            row.sentences += 1;
            row.claims += counted.claims;
            row.found += counted.found;
            row.alike += counted.alike;
            row.wrong_called_right += counted.wrong_called_right;
            row.right_called_wrong += counted.right_called_wrong;
        }
    }
    rows
}

impl Labelled {
    /// What the rules make of it, beside its labels.
    fn compared(&self, scene: &Scene) -> AgreementRow {
        let mut row = AgreementRow::new(&self.style);
        let text = if self.context.is_empty() {
            self.text.clone()
        } else {
            format!("{}\n{}", self.context, self.text)
        };
        let begin = text.len() - self.text.len();
        let subject = Subject::new(scene, TimeOrigin::Recording, Some(self.window));
        let found = sentences(&text, &subject);
        let own: Vec<_> = found.iter().filter(|one| one.span.end > begin).collect();
        let mut claims: Vec<&CheckedClaim> = own.iter().flat_map(|one| &one.claims).collect();
        let decided = |claim: &CheckedClaim| match claim.judgement {
            Judgement::Right => Some(SentenceOutcome::Right),
            Judgement::Wrong => Some(SentenceOutcome::Wrong),
            Judgement::Unknown(_) => None,
        };
        let labels = self.claims.iter().filter(|_| self.style != FOREIGN);
        for label in labels {
            row.claims += 1;
            let fits = |claim: &CheckedClaim| {
                let is_who = match &label.about {
                    About::Obstacle(id) => claim.claim.obstacle == *id,
                    About::Ego(_) => claim.claim.obstacle == scene.ego.id,
                };
                is_who && is_kind(&label.kind, claim.claim.quantity)
            };
            // The one that says the same, where several are of the kind.
            let best = { claims.iter().enumerate() }
                .filter(|(_, claim)| fits(claim) && decided(claim).is_some())
                .max_by_key(|(_, claim)| decided(claim) == Some(label.outcome));
            if let Some((place, claim)) = best {
                row.found += 1;
                row.alike += u32::from(decided(claim) == Some(label.outcome));
                claims.remove(place);
            }
        }
        let outcomes: Vec<SentenceOutcome> = own.iter().map(|one| one.outcome).collect();
        let is_wrong = outcomes.contains(&SentenceOutcome::Wrong);
        let is_right =
            !outcomes.is_empty() && outcomes.iter().all(|one| *one == SentenceOutcome::Right);
        let label = self.outcome.as_deref();
        row.wrong_called_right +=
            u32::from(is_right && (label == Some("wrong") || self.style == FOREIGN));
        row.right_called_wrong += u32::from(is_wrong && label == Some("right"));
        row
    }
}

/// Whether a claim of this quantity is of a kind that people name so: they need not tell a distance from a gap, nor a motion from
/// the velocity that shows it.
fn is_kind(kind: &str, quantity: Quantity) -> bool {
    use Quantity as Q;
    let all: &[Quantity] = match kind {
        "distance" | "min_distance" => &[
            Q::Distance,
            Q::DistanceAlong,
            Q::DistanceAcross,
            Q::GapLong,
            Q::GapLat,
            Q::MinDistance,
            Q::LeastDistance,
        ],
        "gap_long" => &[Q::GapLong, Q::Distance, Q::DistanceAlong],
        "gap_lat" => &[Q::GapLat, Q::Distance, Q::DistanceAcross],
        "ttc" | "ttc_long" | "ttc_lat" => &[Q::Ttc, Q::TtcLong, Q::TtcLat],
        "thw" => &[Q::Headway],
        "speed" => &[Q::Speed, Q::ClosingSpeed],
        "closing_speed" | "velocity_long" | "velocity_lat" => {
            &[Q::ClosingSpeed, Q::VelocityLong, Q::VelocityLat, Q::Speed]
        }
        "acceleration" => &[Q::Acceleration],
        "acceleration_long" | "acceleration_lat" => &[Q::AccelerationLong, Q::AccelerationLat],
        "motion" => &[
            Q::Motion,
            Q::Way,
            Q::Speed,
            Q::VelocityLong,
            Q::VelocityLat,
            Q::Comparison,
        ],
        "lane" => &[Q::Way, Q::Motion],
        "direction" => &[Q::Side],
        "contact" => &[Q::Contact],
        "time" => &[Q::Time],
        "risk" => &[Q::Risk],
        "comparison" | "superlative" => &[Q::Comparison, Q::Motion],
        "position" => &[Q::Position],
        "heading" => &[Q::Heading],
        _ => &[],
    };
    all.contains(&quantity)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rules_agree_with_people() {
        let rows = agreement();
        for row in &rows {
            println!("{row:?}");
        }
        let all = &rows[0];
        assert_eq!(
            all.sentences as usize,
            SENTENCES.lines().count(),
            "every line is read"
        );
        let share = |part: u32, of: u32| f64::from(part) / f64::from(of);
        assert!(share(all.found, all.claims) > 0.6, "{all:?}");
        assert!(share(all.alike, all.found) > 0.95, "{all:?}");
        assert!(
            share(all.wrong_called_right, all.sentences) < 0.03,
            "{all:?}"
        );
        assert!(
            share(all.right_called_wrong, all.sentences) < 0.04,
            "{all:?}"
        );
        let foreign = rows
            .iter()
            .find(|row| row.style == FOREIGN)
            .expect("a foreign row");
        assert_eq!(foreign.wrong_called_right, 0, "never right: {foreign:?}");
    }
}
