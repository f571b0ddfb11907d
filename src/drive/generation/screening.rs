//! Open-loop screening of changed motions, and the surrogate that corrects its predictions by closed-loop drives.
//!
//! Screening only selects attacks for the closed loop; no reported figure comes from it.
//!
//! The surrogate: corrects open-loop predictions by the closed-loop drives of a search.
//!
//! The difference between a drive and its prediction is assumed to hold for nearby motions, less with distance: the
//! cheap model is corrected by the residuals of the expensive one, as in multi-fidelity optimisation (Kennedy and
//! O'Hagan, Predicting the Output from a Complex Computer Code When Fast Approximations Are Available, 2000).

use nearmiss_base::geometry::{Footprint, Placed, Pose};
use nearmiss_scene::scenario::{Motion, Obstacle};

use super::attack::Attack;
use super::manoeuvre::{ManoeuvreSpace, Numbers};
use super::{AttackContext, Change};

/// How a change looks beside an ego that only brakes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenLoopScreening {
    /// The smallest distance between the bodies while both are there, metres.
    pub distance: f64,
    /// The step of it: of contact, the first.
    pub step: i64,
    /// Seconds from the first changed state to that step.
    pub lead: f64,
    /// The ego's speed there, m/s.
    pub speed: f64,
    /// Whether the attacker is behind the ego there.
    pub behind: bool,
}

/// The ego looks ahead so far, seconds, in this many looks.
const LOOKAHEAD_SECONDS: f64 = 2.4;
const LOOKAHEAD_SAMPLES: usize = 8;

/// It brakes when the two would come nearer than this, metres.
const BRAKING_DISTANCE: f64 = 0.3;

/// How hard it brakes, and how it gets up to its old speed again, m/s².
const BRAKING: f64 = 9.0;
const RESUMING: f64 = 2.5;

/// An ideal driver needs so long to get away, seconds.
const CHANCE: f64 = 1.3;

/// An attack that takes longer than this is seen through, seconds.
const SEEN_THROUGH: f64 = 3.0;

/// Below this speed a contact is harmless, m/s.
const CRAWLING: f64 = 2.0;

/// The ego on its way.
struct Braking<'s> {
    stage: &'s AttackContext<'s>,
    s: f64,
    speed: f64,
}

impl OpenLoopScreening {
    /// Looks at a change; nothing where the two are never there together.
    #[must_use]
    pub fn evaluate(
        stage: &AttackContext<'_>,
        obstacle: &Obstacle,
        change: &Change,
    ) -> Option<Self> {
        let body = obstacle.footprint.as_ref()?;
        let from = change.from()?.max(*stage.steps.start());
        let first = stage.ego.at(from)?;
        let mut ego = Braking {
            stage,
            s: stage.line.project(&first.pose.position).s,
            speed: first.velocity,
        };
        let mut nearest: Option<Self> = None;
        for (step, motion) in change.motions.iter().filter(|(step, _)| *step > from) {
            if *step > *stage.steps.end() {
                break;
            }
            ego.go(*step, motion, body);
            let own = stage.footprint.at(ego.pose());
            let other = body.at(motion.pose);
            let least = nearest.map_or(f64::INFINITY, |n| n.distance);
            let Some(distance) = nearer(&own, &other, least) else {
                continue;
            };
            let ahead = own.pose.to_local(&other.pose.position).x;
            nearest = Some(Self {
                distance,
                step: *step,
                lead: (*step - from) as f64 * stage.dt(),
                speed: ego.speed,
                behind: ahead < -stage.footprint.shape().size().0 / 2.0,
            });
            if distance == 0.0 {
                break;
            }
        }
        nearest
    }

    /// How promising it is: the less, the better. Contact that an ideal driver could have avoided is best, from behind
    /// worst.
    #[must_use]
    pub fn cost(&self) -> f64 {
        let hasty = (CHANCE - self.lead).max(0.0);
        let slow = 0.2 * (self.lead - SEEN_THROUGH).max(0.0);
        let near = if self.distance > 0.0 {
            1.0 + self.distance.min(20.0)
        } else {
            0.0
        };
        let crawling = (CRAWLING - self.speed).max(0.0);
        near + hasty + slow.min(1.0) + crawling + if self.behind { 3.0 } else { 0.0 }
    }
}

/// The distance of two bodies where it is less than `least`, metres.
fn nearer(a: &Placed<'_>, b: &Placed<'_>, least: f64) -> Option<f64> {
    let reach = a.footprint.reach() + b.footprint.reach();
    if (a.pose.position - b.pose.position).norm() - reach >= least {
        return None;
    }
    Some(a.distance(b)).filter(|distance| *distance < least)
}

impl Braking<'_> {
    fn pose(&self) -> Pose {
        self.stage.line.pose_at(self.s)
    }

    /// To a step, at which the attacker moves like this.
    fn go(&mut self, step: i64, attacker: &Motion, body: &Footprint) {
        let dt = self.stage.dt();
        let usual = self.stage.ego_at(step).map_or(0.0, |m| m.velocity);
        let before = self.speed;
        self.speed = if self.has_to_brake(attacker, body) {
            (self.speed - BRAKING * dt).max(0.0)
        } else if self.speed > usual {
            (self.speed - RESUMING * dt).max(usual)
        } else {
            (self.speed + RESUMING * dt).min(usual)
        };
        self.s += f64::midpoint(before, self.speed) * dt;
    }

    /// Whether the two would meet if both went on as they do.
    fn has_to_brake(&self, attacker: &Motion, body: &Footprint) -> bool {
        (1..=LOOKAHEAD_SAMPLES).any(|look| {
            let t = LOOKAHEAD_SECONDS * look as f64 / LOOKAHEAD_SAMPLES as f64;
            let own = self.stage.line.pose_at(self.s + self.speed * t);
            let there = Pose {
                position: attacker.pose.position + attacker.velocity_vector() * t,
                ..attacker.pose
            };
            nearer(
                &self.stage.footprint.at(own),
                &body.at(there),
                BRAKING_DISTANCE,
            )
            .is_some()
        })
    }
}

/// An evaluated attack.
#[derive(Debug)]
pub(super) struct Trial {
    /// Which arm.
    pub arm: usize,
    /// Its numbers.
    pub numbers: Numbers,
    /// Its result.
    pub attack: Attack,
    /// Whether it is from [`between`], which is driven in any case.
    pub is_between: bool,
}

impl Trial {
    /// Whether it is another one of the same arm, nearer than `apart` spreads of that.
    fn is_within(&self, apart: f64, other: &Self, arms: &[ManoeuvreSpace]) -> bool {
        self.arm == other.arm && arms[self.arm].apart(&self.numbers, &other.numbers) < apart
    }
}

/// Motions that are so far apart, in spreads of their arm, teach little about each other.
const REACH: f64 = 0.5;

/// The costs of all of `tried`, in their order: of those that were driven what the drive showed, of others what is to
/// be expected.
fn expected(arms: &[ManoeuvreSpace], tried: &[Trial]) -> Vec<f64> {
    let driven = tried.iter().filter(|t| t.attack.effect.is_some());
    // How much worse each drive was than its rehearsal hoped.
    let lessons: Vec<(&Trial, f64)> = driven
        .map(|t| (t, t.attack.cost() - t.attack.hoped()))
        .collect();
    let expect = |t: &Trial| {
        if t.attack.effect.is_some() {
            return t.attack.cost();
        }
        let same = lessons.iter().filter(|(l, _)| l.arm == t.arm);
        let apart = |l: &Trial| arms[t.arm].apart(&l.numbers, &t.numbers);
        t.attack.hoped() + correction(same.map(|&(l, worse)| (apart(l), worse)))
    };
    tried.iter().map(expect).collect()
}

/// What to add, of lessons that are so many spreads apart and taught so much: their mean, and less of it without any
/// nearby.
fn correction(lessons: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut nearest, mut weights, mut sum) = (0.0_f64, 0.0, 0.0);
    for (apart, worse) in lessons {
        let weight = (-0.5 * (apart / REACH).powi(2)).exp();
        nearest = nearest.max(weight);
        weights += weight;
        sum += weight * worse;
    }
    if weights > f64::MIN_POSITIVE {
        nearest * sum / weights
    } else {
        0.0
    }
}

/// Motions that are nearer to each other than this, in spreads of their arm, end alike.
const SIMILARITY: f64 = 0.25;

/// After so many drives without an effect nothing more is expected of what is like them.
const MAX_FUTILE_DRIVES: usize = 2;

/// Which of `tried` are to be driven next, at most `count`: the most promising ones, not more than half of them by
/// one arm, and at least `apart` spreads from each other.
pub(super) fn promising(
    arms: &[ManoeuvreSpace],
    tried: &[Trial],
    count: usize,
    apart: f64,
) -> Vec<usize> {
    let costs = expected(arms, tried);
    let mut order: Vec<usize> = (0..tried.len()).collect();
    let futile = |t: &&Trial| t.attack.effect.is_some() && t.attack.cost() > 0.0;
    let futile: Vec<&Trial> = tried.iter().filter(futile).collect();
    let hopeless = |t: &Trial| {
        let alike = futile.iter().filter(|f| f.is_within(SIMILARITY, t, arms));
        alike.count() >= MAX_FUTILE_DRIVES
    };
    order.retain(|&i| tried[i].attack.effect.is_none() && !hopeless(&tried[i]));
    order.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
    let undriven = (0..tried.len()).filter(|&i| tried[i].attack.effect.is_none());
    let mut chosen: Vec<usize> = undriven.filter(|&i| tried[i].is_between).collect();
    for i in order {
        let same = chosen.iter().filter(|&&c| tried[c].arm == tried[i].arm);
        let near = |&c: &usize| tried[c].is_within(apart, &tried[i], arms);
        let crowded = same.count() >= count.div_ceil(2) || chosen.iter().any(near);
        if chosen.len() < count && !crowded {
            chosen.push(i);
        }
    }
    chosen
}

/// Number of trials to learn from; at most a third from one arm.
const ELITE: usize = 9;

/// The most promising of `tried` and those that did best, in order, each with its expected cost.
pub(super) fn elite<'t>(arms: &[ManoeuvreSpace], tried: &'t [Trial]) -> Vec<(f64, &'t Trial)> {
    let mut order: Vec<(f64, &Trial)> = expected(arms, tried).into_iter().zip(tried).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut elite: Vec<(f64, &Trial)> = Vec::new();
    for (cost, tried) in order {
        let same = elite.iter().filter(|(_, t)| t.arm == tried.arm).count();
        let alike = elite
            .iter()
            .any(|(_, t)| t.is_within(SIMILARITY, tried, arms));
        if elite.len() < ELITE && same < ELITE / 3 && !alike {
            elite.push((cost, tried));
        }
    }
    elite
}

/// Motions that are nearer to each other than this, in spreads of their arm, have none between them.
const NEXT: f64 = 0.05;

/// At most `count` motions halfway between one that cannot be survived and the nearest of the same arm that does nothing:
/// where one turns into the other the ego gets away narrowly, or does not although it could.
pub(super) fn between(
    arms: &[ManoeuvreSpace],
    tried: &[Trial],
    count: usize,
) -> Vec<(usize, Numbers)> {
    let is_hopeless = |t: &&Trial| t.attack.survivable == Some(false) && !t.attack.is_idle();
    let mut hopeless: Vec<&Trial> = tried.iter().filter(is_hopeless).collect();
    hopeless.sort_by(|a, b| a.attack.cost().total_cmp(&b.attack.cost()));
    let halfway = hopeless.into_iter().filter_map(|hard| {
        let driven = tried.iter().filter(|t| t.attack.effect.is_some());
        let soft = driven.filter(|t| t.arm == hard.arm && !t.attack.has_effect());
        let apart = soft.map(|t| (arms[hard.arm].apart(&hard.numbers, &t.numbers), t));
        let (apart, soft) = apart.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let middle = |i: usize| f64::midpoint(hard.numbers[i], soft.numbers[i]);
        (apart > NEXT).then(|| (hard.arm, std::array::from_fn(middle)))
    });
    halfway.take(count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_teaches_all_about_its_place_and_little_about_far_ones() {
        let taught = |lessons: &[(f64, f64)]| correction(lessons.iter().copied());
        assert_eq!(taught(&[]), 0.0);
        assert!((taught(&[(0.0, 2.0)]) - 2.0).abs() < 1e-12);
        assert!((taught(&[(0.0, 2.0), (0.0, 4.0)]) - 3.0).abs() < 1e-12);
        let (near, far) = (taught(&[(0.2, 2.0)]), taught(&[(2.0, 2.0)]));
        assert!(near > 1.8 && far < 0.01, "{near}, {far}");
        assert_eq!(taught(&[(1e9, 2.0)]), 0.0, "too far to be a number");
    }
}
