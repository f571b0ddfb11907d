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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::formats::commonroad::read;
    use crate::metrics::{MEASURES, NoValue, Reading};

    /// An ego at 10 m/s that comes to a region which obstacle 2 may cover from step 5 to 20, 13 m to 17 m ahead.
    fn scene() -> Scene {
        let state = |name: &str, step: i64, x: f64, v: f64| {
            format!(
                "<{name}><position><point><x>{x}</x><y>0</y></point></position><orientation><exact>0</exact></orientation>\
                 <time><exact>{step}</exact></time><velocity><exact>{v}</exact></velocity></{name}>"
            )
        };
        let later: String = (1..=20)
            .map(|step| state("state", step, step as f64, 10.0))
            .collect();
        let body = "<shape><rectangle><length>4</length><width>2</width></rectangle></shape>";
        let text = format!(
            "<commonRoad commonRoadVersion='2020a' benchmarkID='ZAM_A-1' timeStepSize='0.1'>\
             <dynamicObstacle id='1'><type>car</type>{body}{}<trajectory>{later}</trajectory></dynamicObstacle>\
             <dynamicObstacle id='2'><type>car</type>{body}{}<occupancySet><occupancy><shape><polygon>\
             <point><x>13</x><y>-1</y></point><point><x>17</x><y>-1</y></point><point><x>17</x><y>1</y></point>\
             <point><x>13</x><y>1</y></point></polygon></shape><time><intervalStart>5</intervalStart>\
             <intervalEnd>20</intervalEnd></time></occupancy></occupancySet></dynamicObstacle></commonRoad>",
            state("initialState", 0, 0.0, 10.0),
            state("initialState", 0, 40.0, 5.0),
        );
        let scenario = read(text.as_bytes(), "a.xml").unwrap();
        Scene::with_obstacle_as_ego(Arc::new(scenario), 1).unwrap()
    }

    #[test]
    fn a_contact_with_a_predicted_occupancy_is_possible() {
        let scene = scene();
        let judgement = judge(&scene, Thresholds::shipped());
        let verdict = &judgement.verdict;
        assert_eq!(judgement.decisive_step, Some(11));
        assert!(verdict.dangerous);
        assert_eq!(verdict.probability, None, "nobody says how likely");
        assert_eq!(verdict.critical.as_ref().unwrap()[0].probability, None);
        assert!(verdict.obstacles[0].reason.starts_with("possible contact"));
        for words in [&verdict.justification, &judgement.reasoning] {
            assert!(words.contains("predicted occupancy"), "{words}");
            assert!(words.contains("possible contact"), "{words}");
            assert!(!words.contains("velocity 0"), "{words}");
        }
    }

    #[test]
    fn a_region_has_a_place_and_no_velocity() {
        let scene = scene();
        let other = scene.participants().next().unwrap();
        let reading = |id: &str, step| {
            let encounter = Encounter::at(&scene, &other, step).unwrap();
            let measure = MEASURES.iter().find(|m| m.id == id).unwrap();
            measure.of(&encounter)
        };
        assert!(
            Encounter::at(&scene, &other, 3).is_none(),
            "a gap stays one"
        );
        assert!(
            reading("ttc", 0).value().is_some(),
            "its first state is known"
        );
        assert_eq!(reading("distance", 8), Reading::Value(3.0));
        assert_eq!(reading("distance", 12), Reading::Value(0.0));
        assert_eq!(reading("risk", 12), Reading::Value(0.0));
        for id in ["ttc", "risk", "v_rel_long", "wttc", "pet", "drac"] {
            assert_eq!(reading(id, 8), Reading::None(NoValue::Occupancy), "{id}");
        }
        let taken = Scene::with_obstacle_as_ego(Arc::clone(&scene.scenario), 2);
        assert!(taken.unwrap_err().to_string().contains("occupancy set"));
        assert_eq!(scene.scenario.possible_egos(), [1]);
    }

    #[test]
    fn what_the_ego_is_about_to_reach_is_a_possible_contact() {
        use crate::scenario::Window;

        let scene = scene();
        let window = Window::ending_at(&scene, 8, 8);
        let judgement = super::super::safety::judge(&scene, &window, Thresholds::shipped());
        assert!(judgement.verdict.dangerous, "{}", judgement.reasoning);
        assert!(
            judgement.reasoning.contains("possible contact"),
            "{}",
            judgement.reasoning
        );
        assert!(judgement.prospects[0].is_possible);
    }
}
