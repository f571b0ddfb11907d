//! Safety: will bodies touch soon if everyone keeps the present velocity and heading?

use std::fmt::Write;

use super::Judgement;
use super::reasoning::{moment, name, risk, situation, value};
use crate::metrics::{Encounter, RISK_LEVELS};
use crate::scenario::{Scene, Window};
use crate::verdict::{ObstacleRisk, Task, Verdict};

/// A predicted contact within this time is safety-critical, seconds. With it, constant-velocity bodies reach
/// F1 0.97 on the paper's windows, 0.2 s before the collision; 1.0 s before, 0.80.
const HORIZON: f64 = 1.0;

/// Obstacles listed beside those that are predicted to touch.
const MOST_LISTED: usize = 5;

pub(super) fn judge(scene: &Scene, window: &Window) -> Judgement {
    let now = window.last();
    let mut found: Vec<(ObstacleRisk, Option<f64>, String)> = Vec::new();
    for participant in scene.participants() {
        let Some(encounter) = Encounter::at(scene, &participant, now) else {
            continue;
        };
        let who = name(&participant);
        let contact = value("ttc", &encounter);
        let critical = contact.filter(|t| *t <= HORIZON);
        let now_risk = value("risk", &encounter).map_or(5, |r| r as u8);
        let score = match critical {
            Some(time) => now_risk.min(RISK_LEVELS.of_time(Some(time))),
            // Contact is neither there nor predicted: never below "high".
            None => now_risk.max(2),
        };
        let when = match contact {
            Some(0.0) => "in contact".to_string(),
            Some(time) => format!("predicted contact in {time:.2} s"),
            None => "no contact predicted".to_string(),
        };
        let line = format!(
            "{who}: {when}; {}. Risk {}.",
            situation(&encounter),
            risk(score)
        );
        let entry = ObstacleRisk {
            id: participant.obstacle.id,
            risk_score: score,
            reason: when,
        };
        found.push((entry, contact, line));
    }
    found.sort_by(|a, b| {
        let time = |t: Option<f64>| t.unwrap_or(f64::MAX);
        a.0.risk_score
            .cmp(&b.0.risk_score)
            .then(time(a.1).total_cmp(&time(b.1)))
    });
    let critical: Vec<_> = found
        .iter()
        .filter(|f| f.1.is_some_and(|t| t <= HORIZON))
        .collect();
    let listed = critical.len().max(MOST_LISTED);
    let justification = match critical.first() {
        Some((entry, time, _)) => format!(
            "At {}, obstacle {} is {:.2} s from contact if both keep velocity and heading; the horizon is {HORIZON:.1} s.",
            moment(scene, now),
            entry.id,
            time.unwrap_or_default(),
        ),
        None => format!(
            "At {}, no contact is predicted within {HORIZON:.1} s if everyone keeps velocity and heading.",
            moment(scene, now),
        ),
    };
    let mut reasoning = format!(
        "Present: {}; the ego is {}. Prediction: constant velocity and heading, real bodies, horizon {HORIZON:.1} s. \
         Nothing after the present is used.\n\n",
        moment(scene, now),
        scene.ego.source.short(),
    );
    for (_, _, line) in found.iter().take(listed) {
        let _ = writeln!(reasoning, "- {line}");
    }
    let _ = write!(reasoning, "\n{justification}");
    let dangerous = !critical.is_empty();
    found.truncate(listed);
    Judgement {
        decisive_step: Some(now),
        verdict: Verdict {
            task: Task::Safety,
            dangerous,
            obstacles: found.into_iter().map(|f| f.0).collect(),
            justification,
        },
        reasoning,
    }
}
