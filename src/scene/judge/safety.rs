//! Safety: how probable is it that bodies touch soon, from what was seen until now and nothing later?
//!
//! Risk scores grade the present, as the rubric of the prompts does. What comes is said by the probabilities of contact
//! within the horizon: an obstacle from the threshold on is critical, whatever its score.

use std::collections::HashMap;

use super::collision::{CollisionPrediction, Criterion};
use super::{Judgement, moment, name, reasoning, risk, situation, value};
use crate::metrics::{Encounter, Thresholds};
use crate::scenario::prediction::{ObservedHistory, PredictedPath};
use crate::scenario::{Participant, Scene, Window};
use crate::verdict::{CriticalObstacle, ObstacleRisk, Task, Verdict};

/// Obstacles listed beside the critical ones.
const MOST_LISTED: usize = 5;

/// What is said about one obstacle.
struct Finding {
    prospect: CollisionPrediction,
    critical: bool,
    entry: ObstacleRisk,
    line: String,
}

pub(super) fn judge(scene: &Scene, window: &Window, thresholds: &Thresholds) -> Judgement {
    let criterion = Criterion::REFERENCE;
    // All that is predicted comes from here, and it ends with the window.
    let past = ObservedHistory::from_window(scene, window);
    let prospects = criterion.prospects(&past, None);
    let probability = largest(&prospects);
    let mut found = findings(scene, &criterion, &past, prospects, thresholds);
    // The critical ones first, by their probabilities; then the others, by their risk.
    found.sort_by(|a, b| {
        let score = |f: &Finding| {
            if f.critical {
                None
            } else {
                Some(f.entry.risk_score)
            }
        };
        let probability = |f: &Finding| f.prospect.probability;
        score(a)
            .cmp(&score(b))
            .then(probability(b).total_cmp(&probability(a)))
    });
    let critical = found.iter().filter(|f| f.critical).count();
    found.truncate(critical.max(MOST_LISTED));

    let justification = justification(scene, &criterion, &past, &found);
    let how = format!(
        "Seen: {} to {}; the ego is {}. Nothing later is used, and no goal.\n\nPrediction: positions and headings of the \
         last steps give speed, acceleration and turn; all road users continue along each lane ahead or \
         keep their present turn; accelerations fade and vary. Probability: the weights of the predicted motions of \
         both whose real bodies touch. Critical: at least {:.2} within {:.1} s.",
        moment(scene, window.first()),
        moment(scene, past.now()),
        scene.ego.source.short(),
        criterion.threshold,
        criterion.horizon,
    );
    let lines = found.iter().map(|f| f.line.clone());
    Judgement {
        reasoning: reasoning(&justification, lines, &how),
        decisive_step: Some(past.now()),
        verdict: Verdict {
            task: Task::Safety,
            dangerous: critical > 0,
            obstacles: found.iter().map(|f| f.entry.clone()).collect(),
            justification,
            critical: Some(found.iter().filter_map(Finding::critical).collect()),
            probability: Some(probability),
            token_probability: None,
            unknown: Vec::new(),
        },
        prospects: found.into_iter().map(|f| f.prospect).collect(),
    }
}

/// The verdict by a criterion, on the obstacles that are critical by it: those of the judge's verdict, where the
/// criterion is its own. An obstacle that is farther than `radius` metres from the ego (centre to centre) is left
/// out.
#[must_use]
pub fn verdict_by(
    criterion: &Criterion,
    scene: &Scene,
    window: &Window,
    radius: f64,
    thresholds: &Thresholds,
) -> Verdict {
    let past = ObservedHistory::from_window(scene, window);
    let mut prospects = criterion.prospects(&past, Some(radius));
    let probability = largest(&prospects);
    prospects.retain(|prospect| criterion.critical(prospect));
    let found = findings(scene, criterion, &past, prospects, thresholds);
    Verdict {
        task: Task::Safety,
        dangerous: !found.is_empty(),
        critical: Some(found.iter().filter_map(Finding::critical).collect()),
        obstacles: found.into_iter().map(|f| f.entry).collect(),
        justification: String::new(),
        probability: Some(probability),
        token_probability: None,
        unknown: Vec::new(),
    }
}

/// The probability of a contact: that with the obstacle that is most probably touched.
fn largest(prospects: &[CollisionPrediction]) -> f64 {
    let all = prospects.iter().map(|p| p.probability);
    stated(all.fold(0.0, f64::max))
}

/// Without the dust of a sum of many weights, and never rounded over the threshold.
fn stated(probability: f64) -> f64 {
    (probability * 1e6 + 1e-6).floor() / 1e6
}

impl Finding {
    fn critical(&self) -> Option<CriticalObstacle> {
        self.critical.then_some(CriticalObstacle {
            id: self.prospect.id,
            probability: Some(stated(self.prospect.probability)),
        })
    }
}

fn findings(
    scene: &Scene,
    criterion: &Criterion,
    past: &ObservedHistory<'_>,
    prospects: Vec<CollisionPrediction>,
    thresholds: &Thresholds,
) -> Vec<Finding> {
    let people: HashMap<i64, Participant<'_>> =
        scene.participants().map(|p| (p.obstacle.id, p)).collect();
    let now = past.now();
    let of = |prospect: CollisionPrediction| {
        let who = people.get(&prospect.id)?;
        let encounter = Encounter::at(scene, who, now)?.under(thresholds);
        Some(finding(scene, criterion, &encounter, now, who, prospect))
    };
    prospects.into_iter().filter_map(of).collect()
}

fn finding(
    scene: &Scene,
    criterion: &Criterion,
    encounter: &Encounter<'_>,
    now: i64,
    who: &Participant<'_>,
    prospect: CollisionPrediction,
) -> Finding {
    let critical = criterion.critical(&prospect);
    let score = value("risk", encounter).map_or(5, |r| r as u8);
    let when = match prospect.time {
        Some(0.0) if prospect.is_possible => {
            "possible contact: its predicted occupancy touches the ego".to_string()
        }
        Some(time) if prospect.is_possible => format!(
            "possible contact: the ego reaches its predicted occupancy within {:.1} s with probability {}, in {time:.2} s",
            criterion.horizon,
            probability(prospect.probability),
        ),
        Some(0.0) => "in contact".to_string(),
        Some(time) => format!(
            "contact within {:.1} s with probability {}, in {time:.2} s",
            criterion.horizon,
            probability(prospect.probability),
        ),
        None => format!("no contact predicted within {:.1} s", criterion.horizon),
    };
    let ways = prospect
        .ways
        .as_ref()
        .map_or(String::new(), |(mine, theirs)| {
            format!(" (ego {}, it {})", path_summary(mine), path_summary(theirs))
        });
    let line = format!(
        "{}{}: {when}{ways}; at {}: {}. Risk at present {}.",
        if critical { "Critical: " } else { "" },
        name(who),
        moment(scene, now),
        situation(encounter),
        risk(score)
    );
    Finding {
        entry: ObstacleRisk {
            id: who.obstacle.id,
            risk_score: score,
            reason: when,
            written_score: None,
        },
        prospect,
        critical,
        line,
    }
}

fn justification(
    scene: &Scene,
    criterion: &Criterion,
    past: &ObservedHistory<'_>,
    found: &[Finding],
) -> String {
    let Criterion {
        horizon, threshold, ..
    } = criterion;
    let at = moment(scene, past.now());
    if past.ego().is_none() {
        return format!("At {at}, the recording of the ego has a gap: no prediction is possible.");
    }
    let rule = format!("critical: {threshold:.2} or more");
    match found.first() {
        Some(Finding {
            critical, prospect, ..
        }) => {
            if let (true, Some(time)) = (critical, prospect.time) {
                return if prospect.is_possible {
                    format!(
                        "At {at}, the probability of reaching the predicted occupancy of obstacle {}, a possible contact, \
                         within {horizon:.1} s is {} ({rule}), median time {time:.2} s.",
                        prospect.id,
                        probability(prospect.probability),
                    )
                } else if time == 0.0 {
                    format!(
                        "At {at}, the bodies of the ego and obstacle {} touch.",
                        prospect.id
                    )
                } else {
                    format!(
                        "At {at}, the probability of contact with obstacle {} within {horizon:.1} s is {} ({rule}), median time \
                         {time:.2} s.",
                        prospect.id,
                        probability(prospect.probability),
                    )
                };
            }
            let most = found
                .iter()
                .max_by(|a, b| a.prospect.probability.total_cmp(&b.prospect.probability));
            match most.map(|f| &f.prospect).filter(|p| p.probability > 0.0) {
                Some(p) if p.is_possible => format!(
                    "At {at}, the most probable contact within {horizon:.1} s is a possible one with the predicted occupancy of \
                     obstacle {}: probability {} ({rule}).",
                    p.id,
                    probability(p.probability),
                ),
                Some(p) => format!(
                    "At {at}, the most probable contact within {horizon:.1} s is with obstacle {}: probability {} ({rule}).",
                    p.id,
                    probability(p.probability),
                ),
                None => format!("At {at}, no predicted motions touch within {horizon:.1} s."),
            }
        }
        None => format!("At {at}, there is no other road user."),
    }
}

/// With two decimals; never rounded to impossible, certain, or over the threshold.
fn probability(p: f64) -> String {
    if p > 0.0 && p < 0.01 {
        "below 0.01".into()
    } else {
        // Certainty is a sum of many weights.
        format!("{:.2}", (p * 100.0 + 1e-9).floor() / 100.0)
    }
}

fn path_summary(way: &PredictedPath) -> String {
    match way {
        PredictedPath::Straight => "straight on".into(),
        PredictedPath::Turn => "on with its turn".into(),
        PredictedPath::Lanes(lanelets) => {
            let ids: Vec<String> = lanelets.iter().take(6).map(i64::to_string).collect();
            let more = if lanelets.len() > ids.len() {
                " …"
            } else {
                ""
            };
            format!("along {}{more}", ids.join(" "))
        }
    }
}
