//! Collision: do the real bodies of the ego and an obstacle touch, as recorded or soon, as predicted?

use nearmiss_base::geometry::{self, Pose, Vector};

use super::{Judgement, metres, moment, name, reasoning, risk, situation, touching, value};
use crate::metrics::{Contact, Context, Encounter, Thresholds};
use crate::scenario::prediction::{
    Model, Observed, ObservedHistory, PredictedPath, Prediction, Predictor, Trajectory,
};
use crate::scenario::{Obstacle, ObstacleType, Participant, Scene};
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
/// possible, and has no probability: how likely each place of its region is, is unknown.
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

    let how = format!(
        "Exact bodies of real size, {} to {}; the ego is {}.",
        moment(scene, scene.steps().start),
        moment(scene, scene.last_step()),
        scene.ego.source.short(),
    );
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
        (None, Some(nearest)) => {
            format!(
                "No body touches the ego's at any recorded step or between two; the smallest distance at a step is {} to {} at {}.",
                metres(nearest.nearest),
                name(&nearest.participant),
                moment(scene, nearest.nearest_step),
            ) + &uncertain(scene, nearest)
        }
        (None, None) => "No other road user is ever there.".to_string(),
    };
    let lines = histories.iter().map(|h| line(scene, h));
    Judgement {
        reasoning: reasoning(&justification, lines, &how),
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
        prospects: Vec::new(),
    }
}

/// Why bodies that come so near that evenly joined steps let them overlap have no contact.
fn uncertain(scene: &Scene, nearest: &History<'_>) -> String {
    let deepest = Contact::uncertain_overlap(scene, &nearest.participant, nearest.nearest_step);
    deepest.map_or(String::new(), |overlap| {
        format!(
            " Between the steps around it, straight ways would overlap by {}, less than the recording leaves uncertain there: no contact.",
            metres(overlap)
        )
    })
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
            "{who} touches the ego {}: {before}. Risk score {}. First touch at {:.2} s, closing speed {:.1} m/s.",
            touching(scene, &contact),
            risk(h.risk),
            // The velocities above are those of the step.
            contact.time,
            contact.impact.closing_speed
        ),
        None => format!(
            "{who}: nearest at {}: {before}. Worst risk score {}.",
            moment(scene, at),
            risk(h.risk)
        ),
    }
}

/// When a predicted contact is called critical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criterion {
    /// How motions are predicted.
    pub model: Model,
    /// How far ahead, seconds.
    pub horizon: f64,
    /// The least probability of contact within the horizon that is critical, 0 to 1.
    pub threshold: f64,
}

/// Predicted interaction of the ego and one obstacle.
#[derive(Debug, Clone, PartialEq)]
pub struct CollisionPrediction {
    /// The obstacle.
    pub id: i64,
    /// What it is.
    pub kind: Option<ObstacleType>,
    /// Probability of contact within the horizon, 0 to 1.
    pub probability: f64,
    /// Seconds to contact, if it comes to one: half of the probability lies before. Nothing where no predicted
    /// motions meet.
    pub time: Option<f64>,
    /// The likeliest ways of the ego and of the obstacle that meet.
    pub ways: Option<(PredictedPath, PredictedPath)>,
    /// Whether the contact is with regions of an occupancy set, which the obstacle may cover or not; the probability is
    /// that of reaching them.
    pub is_possible: bool,
}

/// Seconds between two moments of a predicted motion; in between it is a straight line.
const TICK: f64 = 0.1;

impl Criterion {
    /// That of the reference judge.
    ///
    /// Horizon and threshold were chosen on 60 published scenarios (`nearmiss help judge`: what they gain and cost).
    pub const REFERENCE: Self = Self {
        model: Model::AlongLanes,
        horizon: 2.0,
        threshold: 0.3,
    };

    /// Whether a prospect is critical.
    #[must_use]
    pub fn critical(&self, prospect: &CollisionPrediction) -> bool {
        prospect.probability >= self.threshold
    }

    /// The predicted contacts of all obstacles within `radius` metres of the ego now (centre to centre; `None` for
    /// all), most probable first. Empty without an ego at the end of the history.
    #[must_use]
    pub fn prospects(
        &self,
        past: &ObservedHistory<'_>,
        radius: Option<f64>,
    ) -> Vec<CollisionPrediction> {
        let Some(ego) = past.ego() else {
            return Vec::new();
        };
        let mut predictor = Predictor::new(past, self.model);
        // A horizon between two ticks ends inside the last one.
        let ticks = (self.horizon / TICK - 1e-9).ceil() as usize;
        let own = predictor.predict(ego, self.horizon);
        let mine = own.trajectories(TICK, ticks);
        let near = |other: &&Observed<'_>| {
            let between = (other.motion.pose.position - ego.motion.pose.position).norm();
            radius.is_none_or(|radius| between <= radius)
        };
        let prospect = |other: &Observed<'_>| {
            let theirs = predictor.predict(other, self.horizon);
            let sides = Sides {
                ego,
                own: &own,
                mine: &mine,
                other,
                theirs: &theirs,
            };
            sides.prospect(self.horizon, ticks)
        };
        let mut found: Vec<_> = past.others().iter().filter(near).map(prospect).collect();
        let sets = past
            .sets()
            .iter()
            .filter_map(|set| reached(set, ego, past.now(), &mine, self.horizon));
        found.extend(
            sets.filter(|(distance, _)| radius.is_none_or(|r| *distance <= r))
                .map(|(_, p)| p),
        );
        let time = |p: &CollisionPrediction| p.time.unwrap_or(f64::MAX);
        found.sort_by(|a, b| {
            b.probability
                .total_cmp(&a.probability)
                .then(time(a).total_cmp(&time(b)))
        });
        found
    }
}

/// Whether predicted motions of the ego reach the regions of an occupancy set, and the distance of the present one from
/// the ego, centre to centre; nothing where there is none now.
fn reached(
    set: &Obstacle,
    ego: &Observed<'_>,
    now: i64,
    mine: &[Trajectory],
    horizon: f64,
) -> Option<(f64, CollisionPrediction)> {
    let here = set.motion_at(now)?.pose.position;
    let steps = (horizon / ego.dt + 1e-9).floor() as i64;
    let first = |one: &Trajectory| {
        (0..=steps).find(|k| {
            let pose = one.pose_at(*k as f64 * ego.dt, TICK);
            let there = set.placed_at(now + k);
            there.is_some_and(|region| ego.footprint.at(pose).distance(&region) == 0.0)
        })
    };
    let contacts = mine.iter().filter_map(|one| {
        let step = first(one)?;
        Some((step as f64 * ego.dt, one.weight))
    });
    let contacts: Vec<(f64, f64)> = contacts.collect();
    let probability = contacts.iter().map(|(_, weight)| weight).sum::<f64>() + 0.0;
    let prediction = CollisionPrediction {
        id: set.id,
        kind: Some(set.kind),
        probability: probability.min(1.0),
        time: median(contacts),
        ways: None,
        is_possible: true,
    };
    Some(((here - ego.motion.pose.position).norm(), prediction))
}

/// The ego and one other, with what they may do.
struct Sides<'a> {
    ego: &'a Observed<'a>,
    own: &'a Prediction,
    mine: &'a [Trajectory],
    other: &'a Observed<'a>,
    theirs: &'a Prediction,
}

impl Sides<'_> {
    fn prospect(&self, horizon: f64, ticks: usize) -> CollisionPrediction {
        let mut contacts: Vec<(f64, f64)> = Vec::new();
        let mut likeliest: Option<(f64, usize, usize)> = None;
        let touch = self.ego.placed().distance(&self.other.placed()) == 0.0;
        if touch {
            // Whatever they do next.
            contacts.push((0.0, 1.0));
        } else if self.can_meet(horizon) {
            let courses = self.theirs.courses.len();
            let mut by_ways = vec![0.0; self.own.courses.len() * courses];
            for theirs in self.theirs.trajectories(TICK, ticks) {
                for mine in self.mine {
                    let time = self.contact(mine, &theirs);
                    if let Some(time) = time.filter(|time| *time <= horizon) {
                        let weight = mine.weight * theirs.weight;
                        contacts.push((time, weight));
                        by_ways[mine.course * courses + theirs.course] += weight;
                    }
                }
            }
            for (place, &weight) in by_ways.iter().enumerate() {
                if weight > likeliest.map_or(0.0, |(most, ..)| most) {
                    likeliest = Some((weight, place / courses, place % courses));
                }
            }
        }
        // The sum of an empty iterator is -0.
        let probability = contacts.iter().map(|(_, weight)| weight).sum::<f64>() + 0.0;
        CollisionPrediction {
            id: self.other.who.id,
            kind: self.other.who.kind,
            probability: probability.min(1.0),
            time: median(contacts),
            is_possible: false,
            ways: likeliest.map(|(_, mine, theirs)| {
                let way = |p: &Prediction, course: usize| p.courses[course].way.clone();
                (way(self.own, mine), way(self.theirs, theirs))
            }),
        }
    }

    /// Discs around both that cannot meet in time spare everything else.
    fn can_meet(&self, horizon: f64) -> bool {
        let between = self.other.motion.pose.position - self.ego.motion.pose.position;
        let bodies = self.ego.footprint.reach() + self.other.footprint.reach();
        between.norm() <= bodies + self.own.reach(horizon) + self.theirs.reach(horizon)
    }

    /// Seconds until the two bodies touch on these motions, swept from each tick to the next.
    fn contact(&self, mine: &Trajectory, theirs: &Trajectory) -> Option<f64> {
        let bodies = self.ego.footprint.reach() + self.other.footprint.reach();
        let (a, b) = (&mine.poses, &theirs.poses);
        let last = a.len().min(b.len()) - 1;
        let per_tick = (mine.fastest + theirs.fastest) * TICK;
        let mut k = 0;
        while k < last {
            let gap = (b[k].position - a[k].position).norm() - bodies;
            if gap > per_tick {
                if per_tick <= 0.0 {
                    return None;
                }
                // Nothing can happen until the discs around both are a tick apart.
                k += ((gap / per_tick) as usize).min(last - k);
                continue;
            }
            let velocity = |p: &[Pose]| -> Vector { (p[k + 1].position - p[k].position) / TICK };
            let (here, there) = (self.ego.footprint.at(a[k]), self.other.footprint.at(b[k]));
            match here.contact(&velocity(a), &there, &velocity(b), TICK) {
                geometry::Contact::Now => return Some(k as f64 * TICK),
                geometry::Contact::In(t) => return Some(k as f64 * TICK + t),
                geometry::Contact::NotWithinHorizon => k += 1,
            }
        }
        None
    }
}

/// The time before which half of the weight lies.
fn median(mut contacts: Vec<(f64, f64)>) -> Option<f64> {
    contacts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = contacts.iter().map(|(_, weight)| weight).sum::<f64>() / 2.0;
    let mut sum = 0.0;
    let found = contacts.iter().find(|(_, weight)| {
        sum += weight;
        sum >= half
    });
    found.map(|(time, _)| *time)
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn half_of_the_weight_lies_before_the_median() {
        assert_eq!(median(vec![]), None);
        let contacts = vec![(1.5, 0.2), (0.5, 0.1), (1.0, 0.1)];
        assert_eq!(median(contacts), Some(1.0));
        assert_eq!(median(vec![(0.3, 0.1), (0.9, 0.4)]), Some(0.9));
    }
}
