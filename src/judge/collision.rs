//! Collision: do the real bodies of the ego and an obstacle overlap at a recorded step?

use std::fmt::Write;

use super::Judgement;
use super::reasoning::{metres, moment, name, risk, situation, value};
use crate::metrics::{Encounter, Thresholds};
use crate::scenario::{Participant, Scene};
use crate::verdict::{CriticalObstacle, ObstacleRisk, Task, Verdict};

/// What one obstacle did over the whole recording.
struct History<'a> {
    participant: Participant<'a>,
    nearest: f64,
    nearest_step: i64,
    contact: Option<i64>,
    /// Whether what is touched then is a region that the obstacle may cover or not.
    is_possible: bool,
    risk: u8,
}

/// Obstacles listed beside those in contact.
const MOST_LISTED: usize = 5;

/// Judges the collision task: whether bodies touch at any recorded step of the ego.
///
/// A region of an occupancy set counts as a body: only who keeps out of all of it is safe. A contact with it is called
/// possible, and has no probability: how likely the obstacle is where in its region nobody says.
#[must_use]
pub fn judge(scene: &Scene, thresholds: &Thresholds) -> Judgement {
    let mut histories: Vec<_> = scene
        .participants()
        .filter_map(|p| history(scene, p, thresholds))
        .collect();
    histories.sort_by(|a, b| {
        // Bodies that touch before regions that do.
        let key = |h: &History<'_>| (h.is_possible, h.contact.unwrap_or(i64::MAX), h.risk);
        let key = |h: &History<'_>| (h.contact.is_none(), key(h));
        key(a).cmp(&key(b)).then(a.nearest.total_cmp(&b.nearest))
    });
    let contacts = histories.iter().filter(|h| h.contact.is_some()).count();
    histories.truncate(contacts.max(MOST_LISTED));
    let first = histories.first().filter(|h| h.contact.is_some());

    let mut reasoning = format!(
        "Exact bodies of real size, {} to {}; the ego is {}.\n\n",
        moment(scene, scene.steps().start),
        moment(scene, scene.last_step()),
        scene.ego.source.short(),
    );
    for h in &histories {
        let _ = writeln!(reasoning, "- {}", line(scene, h));
    }
    let justification = match (first, by_distance(&histories)) {
        (Some(hit), _) if hit.is_possible => format!(
            "The predicted occupancy of {} overlaps the ego's body from {} on: a possible contact.",
            name(&hit.participant),
            moment(scene, hit.contact.unwrap_or_default()),
        ),
        (Some(hit), _) => format!(
            "The body of {} overlaps the ego's from {} on.",
            name(&hit.participant),
            moment(scene, hit.contact.unwrap_or_default()),
        ),
        (None, Some(nearest)) => format!(
            "No body overlaps the ego's at any recorded step; the smallest distance is {} to {} at {}.",
            metres(nearest.nearest),
            name(&nearest.participant),
            moment(scene, nearest.nearest_step),
        ),
        (None, None) => "No other road user is ever there.".to_string(),
    };
    let _ = write!(reasoning, "\n{justification}");
    Judgement {
        decisive_step: first.and_then(|h| h.contact),
        verdict: Verdict {
            task: Task::Collision,
            dangerous: first.is_some(),
            obstacles: histories.iter().map(|h| entry(scene, h)).collect(),
            justification,
            critical: Some(histories.iter().filter_map(critical).collect()),
            probability: match first {
                Some(hit) => (!hit.is_possible).then_some(1.0),
                None => Some(0.0),
            },
            token_probability: None,
        },
        reasoning,
        prospects: Vec::new(),
    }
}

fn by_distance<'a, 'b>(histories: &'b [History<'a>]) -> Option<&'b History<'a>> {
    histories
        .iter()
        .min_by(|a, b| a.nearest.total_cmp(&b.nearest))
}

fn history<'a>(
    scene: &'a Scene,
    participant: Participant<'a>,
    thresholds: &Thresholds,
) -> Option<History<'a>> {
    let mut found: Option<History<'a>> = None;
    for step in scene.steps() {
        let Some(encounter) = Encounter::at(scene, &participant, step) else {
            continue;
        };
        let encounter = encounter.under(thresholds);
        let distance = encounter.distance();
        let risk = value("risk", &encounter).map_or(5, |r| r as u8);
        let h = found.get_or_insert(History {
            participant,
            nearest: distance,
            nearest_step: step,
            contact: None,
            is_possible: false,
            risk,
        });
        if distance < h.nearest {
            (h.nearest, h.nearest_step) = (distance, step);
        }
        h.risk = h.risk.min(risk);
        if distance == 0.0 && h.contact.is_none() {
            h.contact = Some(step);
            h.is_possible = encounter.is_with_occupancy();
        }
    }
    found
}

fn entry(scene: &Scene, h: &History<'_>) -> ObstacleRisk {
    ObstacleRisk {
        id: h.participant.obstacle.id,
        risk_score: h.risk,
        reason: match h.contact {
            Some(step) if h.is_possible => {
                format!("possible contact at {}", moment(scene, step))
            }
            Some(step) => format!("contact at {}", moment(scene, step)),
            None => format!(
                "nearest {} at {}",
                metres(h.nearest),
                moment(scene, h.nearest_step)
            ),
        },
        written_score: None,
    }
}

/// Bodies that touch the ego do so for certain: they are recorded.
fn critical(h: &History<'_>) -> Option<CriticalObstacle> {
    h.contact.map(|_| CriticalObstacle {
        id: h.participant.obstacle.id,
        probability: (!h.is_possible).then_some(1.0),
    })
}

fn line(scene: &Scene, h: &History<'_>) -> String {
    let who = name(&h.participant);
    let at = h.contact.unwrap_or(h.nearest_step);
    let before = Encounter::at(scene, &h.participant, at)
        .map(|e| situation(&e))
        .unwrap_or_default();
    match h.contact {
        Some(step) if h.is_possible => format!(
            "{who}, possible contact at {}: its predicted occupancy touches the ego, {before}.",
            moment(scene, step),
        ),
        Some(step) => format!(
            "{who} touches the ego at {}: {before}. Risk score {}.",
            moment(scene, step),
            risk(h.risk)
        ),
        None => format!(
            "{who}: nearest at {}: {before}. Worst risk score {}.",
            moment(scene, at),
            risk(h.risk)
        ),
    }
}
