//! Recording: does any obstacle reach the risk score of high risk at a recorded step?

use std::collections::BTreeMap;
use std::fmt::Write;

use super::{Judgement, moment, name, risk, situation};
use crate::metrics::{Encounter, RiskConvention, ScoreAt, Thresholds};
use crate::scenario::Scene;
use crate::verdict::{CriticalObstacle, ObstacleRisk, Task, Verdict};

/// Obstacles listed beside those of high risk.
const MOST_LISTED: usize = 5;

/// The score of no influence; obstacles that never have a lower one are not listed.
const NEGLIGIBLE: u8 = 5;

/// Judges the recording task: whether the lowest risk score of all obstacles at all recorded steps of the ego is at
/// most [`Task::HIGH_RISK`].
#[must_use]
pub fn judge(scene: &Scene, thresholds: &Thresholds) -> Judgement {
    let scores = RiskConvention::exact_up_to(NEGLIGIBLE - 1, scene, thresholds);
    let mut worst: BTreeMap<i64, ScoreAt> = BTreeMap::new();
    for &at in &scores {
        let known = worst.entry(at.obstacle).or_insert(at);
        if at.score < known.score {
            *known = at;
        }
    }
    let mut worst: Vec<ScoreAt> = worst.into_values().collect();
    worst.sort_by_key(|at| (at.score, at.step, at.obstacle));
    let high = |at: &ScoreAt| at.score <= Task::HIGH_RISK;
    let critical = first_times(&scores);
    let many = critical.len();
    worst.truncate(many.max(MOST_LISTED));
    let dangerous = many > 0;

    let mut reasoning = format!(
        "Risk scores of real bodies at every step, {} to {}; the ego is {}. High risk: a score of at most {}.\n\n",
        moment(scene, scene.steps().start),
        moment(scene, scene.last_step()),
        scene.ego.source.short(),
        risk(Task::HIGH_RISK),
    );
    let lines = worst.iter().filter_map(|at| line(scene, *at));
    for line in lines {
        let _ = writeln!(reasoning, "- {line}");
    }
    let justification = match worst.first() {
        Some(at) if high(at) => format!(
            "The lowest risk score is {}, of obstacle {} at {}: high risk.",
            risk(at.score),
            at.obstacle,
            moment(scene, at.step),
        ),
        Some(at) => format!(
            "The lowest risk score is {}, of obstacle {} at {}: safe.",
            risk(at.score),
            at.obstacle,
            moment(scene, at.step),
        ),
        None => format!(
            "No obstacle ever has a risk score below {}: safe.",
            risk(NEGLIGIBLE)
        ),
    };
    let _ = write!(reasoning, "\n{justification}");
    Judgement {
        decisive_step: worst.first().filter(|at| high(at)).map(|at| at.step),
        verdict: Verdict {
            task: Task::Recording,
            dangerous,
            obstacles: worst.iter().map(|at| entry(scene, *at)).collect(),
            justification,
            critical: Some(critical),
            probability: Some(if dangerous { 1.0 } else { 0.0 }),
            token_probability: None,
            unknown: Vec::new(),
        },
        reasoning,
        prospects: Vec::new(),
    }
}

/// The obstacles of high risk, in the order in which they first are.
fn first_times(scores: &[ScoreAt]) -> Vec<CriticalObstacle> {
    let mut found: Vec<CriticalObstacle> = Vec::new();
    for at in scores.iter().filter(|at| at.score <= Task::HIGH_RISK) {
        if found.iter().all(|known| known.id != at.obstacle) {
            found.push(CriticalObstacle {
                id: at.obstacle,
                probability: Some(1.0),
            });
        }
    }
    found
}

fn entry(scene: &Scene, at: ScoreAt) -> ObstacleRisk {
    ObstacleRisk {
        id: at.obstacle,
        risk_score: at.score,
        reason: format!("lowest at {}", moment(scene, at.step)),
        written_score: None,
    }
}

fn line(scene: &Scene, at: ScoreAt) -> Option<String> {
    let who = scene
        .participants()
        .find(|other| other.obstacle.id == at.obstacle)?;
    let encounter = Encounter::at(scene, &who, at.step)?;
    Some(format!(
        "{}: lowest risk score {} at {}: {}.",
        name(&who),
        risk(at.score),
        moment(scene, at.step),
        situation(&encounter),
    ))
}
