//! Collision: do the real bodies of the ego and an obstacle touch, at a recorded step or between two?

use std::fmt::Write;

use super::Judgement;
use super::reasoning::{metres, moment, name, risk, situation, touching, value};
use crate::metrics::{Contact, Context, Encounter, Thresholds};
use crate::scenario::{Participant, Scene};
use crate::verdict::{CriticalObstacle, ObstacleRisk, Task, Verdict};

/// What one obstacle did over the whole recording.
struct History<'a> {
    participant: Participant<'a>,
    nearest: f64,
    nearest_step: i64,
    contact: Option<Contact>,
    risk: u8,
}

/// Obstacles listed beside those in contact.
const MOST_LISTED: usize = 5;

/// Judges the collision task: whether bodies touch at any recorded step of the ego or between two.
///
/// A region of an occupancy set counts as a body: only who keeps out of all of it is safe. A contact with it is called
/// possible, and has no probability: how likely the obstacle is where in its region nobody says.
#[must_use]
pub fn judge(scene: &Scene, thresholds: &Thresholds) -> Judgement {
    let context = Context::under(scene, thresholds);
    let everyone = 0..context.participants().len();
    let mut histories: Vec<_> = everyone.filter_map(|p| history(&context, p)).collect();
    histories.sort_by(|a, b| {
        // Bodies that touch before regions that do.
        let key = |h: &History<'_>| {
            let time = h.contact.map_or(f64::INFINITY, |contact| contact.time);
            (h.contact.is_some_and(|contact| contact.is_possible), time)
        };
        let contact = a.contact.is_none().cmp(&b.contact.is_none());
        let ((a_possible, a_time), (b_possible, b_time)) = (key(a), key(b));
        contact
            .then(a_possible.cmp(&b_possible))
            .then(a_time.total_cmp(&b_time))
            .then(a.risk.cmp(&b.risk))
            .then(a.nearest.total_cmp(&b.nearest))
    });
    let contacts = histories.iter().filter(|h| h.contact.is_some()).count();
    histories.truncate(contacts.max(MOST_LISTED));
    let first = histories.first().and_then(|h| Some((h, h.contact?)));

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
        (Some((hit, contact)), _) if contact.is_possible => format!(
            "The predicted occupancy of {} touches the ego's body {}: a possible contact.",
            name(&hit.participant),
            touching(scene, &contact),
        ),
        (Some((hit, contact)), _) if contact.overlaps => format!(
            "The body of {} overlaps the ego's from {} on.",
            name(&hit.participant),
            moment(scene, contact.step),
        ),
        (Some((hit, contact)), _) => format!(
            "The body of {} touches the ego's {}.",
            name(&hit.participant),
            touching(scene, &contact),
        ),
        (None, Some(nearest)) => format!(
            "No body touches the ego's at any recorded step or between two; the smallest distance at a step is {} to {} at {}.",
            metres(nearest.nearest),
            name(&nearest.participant),
            moment(scene, nearest.nearest_step),
        ),
        (None, None) => "No other road user is ever there.".to_string(),
    };
    let _ = write!(reasoning, "\n{justification}");
    Judgement {
        decisive_step: first.map(|(_, contact)| contact.step),
        verdict: Verdict {
            task: Task::Collision,
            dangerous: first.is_some(),
            obstacles: histories.iter().map(|h| entry(scene, h)).collect(),
            justification,
            critical: Some(histories.iter().filter_map(critical).collect()),
            probability: match first {
                Some((_, contact)) => (!contact.is_possible).then_some(1.0),
                None => Some(0.0),
            },
            token_probability: None,
            unknown: Vec::new(),
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

fn history<'a>(context: &Context<'a>, place: usize) -> Option<History<'a>> {
    let mut found: Option<History<'a>> = None;
    for step in context.steps() {
        let Some(encounter) = context.encounter(place, step) else {
            continue;
        };
        let distance = encounter.distance();
        let risk = value("risk", &encounter).map_or(5, |r| r as u8);
        let h = found.get_or_insert(History {
            participant: context.participants()[place],
            nearest: distance,
            nearest_step: step,
            contact: context.contacts(place).first().copied(),
            risk,
        });
        if distance < h.nearest {
            (h.nearest, h.nearest_step) = (distance, step);
        }
        h.risk = h.risk.min(risk);
    }
    found
}

fn entry(scene: &Scene, h: &History<'_>) -> ObstacleRisk {
    ObstacleRisk {
        id: h.participant.obstacle.id,
        risk_score: h.risk,
        reason: match h.contact {
            Some(contact) if contact.is_possible => {
                format!("possible contact {}", touching(scene, &contact))
            }
            Some(contact) => format!("contact {}", touching(scene, &contact)),
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
    h.contact.map(|contact| CriticalObstacle {
        id: h.participant.obstacle.id,
        probability: (!contact.is_possible).then_some(1.0),
    })
}

fn line(scene: &Scene, h: &History<'_>) -> String {
    let who = name(&h.participant);
    let at = h.contact.map_or(h.nearest_step, |contact| contact.step);
    let mut before = Encounter::at(scene, &h.participant, at)
        .map(|e| situation(&e))
        .unwrap_or_default();
    if h.contact.is_some_and(|contact| !contact.overlaps) {
        before = format!("at step {at} {before}");
    }
    match h.contact {
        Some(contact) if contact.is_possible => format!(
            "{who}, possible contact {}: its predicted occupancy touches the ego, {before}.",
            touching(scene, &contact),
        ),
        Some(contact) => format!(
            "{who} touches the ego {}: {before}. Risk score {}.",
            touching(scene, &contact),
            risk(h.risk)
        ),
        None => format!(
            "{who}: nearest at {}: {before}. Worst risk score {}.",
            moment(scene, at),
            risk(h.risk)
        ),
    }
}
