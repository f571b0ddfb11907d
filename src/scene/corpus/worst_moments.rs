//! The moment of a recording that is most severe for each road user.

use std::cmp::Ordering;
use std::sync::Arc;

use rayon::prelude::*;

use crate::metrics::{Context, CriticalMoment, Grade, Moments, Thresholds};
use crate::scenario::{Scenario, Scene};

/// The most severe moment of a road user.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstMoment {
    /// The road user, as the ego.
    pub ego: i64,
    /// Who endangers it, when and how.
    pub moment: CriticalMoment,
    /// Whether the other one is ahead of the ego at it.
    other_is_ahead: bool,
}

/// What is slower stands, m/s.
const STANDING: f64 = 0.5;

/// Moments of the same two nearer to each other than this are one, seconds.
const SAME: f64 = 10.0;

/// The most severe moment of each of these road users that moves, the most severe first; each pair is there once, with
/// the one behind as the ego. Pairs whose centres are farther apart than `radius` metres are not measured.
///
/// Moments of nothing but nearness are left out if there are others.
#[must_use]
pub fn worst_moments(
    scenario: &Arc<Scenario>,
    egos: &[i64],
    radius: f64,
    thresholds: &Thresholds,
) -> Vec<WorstMoment> {
    let worst = egos.par_iter().filter_map(|id| {
        let scene = Scene::with_obstacle_as_ego(Arc::clone(scenario), *id).ok()?;
        let mut moving = scene.ego.track.iter();
        if !moving.any(|(_, motion)| motion.velocity.abs() >= STANDING) {
            return None;
        }
        worst_of(&Context::under(&scene, thresholds), radius)
    });
    let mut all: Vec<WorstMoment> = worst.collect();
    let is_any = |worst: &WorstMoment| worst.moment.grade <= Grade::LaterCourse;
    if all.iter().any(is_any) {
        all.retain(is_any);
    }
    all.sort_by(|a, b| a.compare(b).then(a.ego.cmp(&b.ego)));
    once_each(all, (SAME / scenario.dt()) as i64)
}

/// Each pair once at a time, with the one behind as the ego.
fn once_each(all: Vec<WorstMoment>, near: i64) -> Vec<WorstMoment> {
    let mut taken: Vec<WorstMoment> = Vec::with_capacity(all.len());
    for one in all {
        let pair = |w: &WorstMoment| (w.ego, w.moment.obstacle);
        let twin = taken.iter_mut().find(|t| {
            let apart = (t.moment.step - one.moment.step).abs();
            pair(t) == (one.moment.obstacle, one.ego) && apart < near
        });
        match twin {
            Some(twin) if one.other_is_ahead && !twin.other_is_ahead => *twin = one,
            Some(_) => {}
            None => taken.push(one),
        }
    }
    taken
}

impl WorstMoment {
    fn compare(&self, other: &Self) -> Ordering {
        self.moment.compare_across(&other.moment)
    }
}

fn worst_of(context: &Context<'_>, radius: f64) -> Option<WorstMoment> {
    let moments = Moments::new(context);
    let participants = 0..context.participants().len();
    let all = participants.filter_map(|participant| {
        let near = |step: &i64| apart(context, participant, *step).is_some_and(|d| d <= radius);
        // Most are never near: nothing of theirs is computed.
        context.steps().find(near)?;
        let pair = moments.with(participant);
        let moment = pair.worst(context.steps().filter(near))?;
        let encounter = context.encounter(participant, moment.step)?;
        let ego = encounter.ego.pose;
        let there = encounter.other.pose.position - ego.position;
        Some(WorstMoment {
            ego: context.scene().ego.id,
            moment,
            other_is_ahead: there.dot(&ego.forward()) >= 0.0,
        })
    });
    all.min_by(|a, b| a.moment.compare(&b.moment))
}

/// How far the centres are apart, where both are there, metres.
fn apart(context: &Context<'_>, participant: usize, step: i64) -> Option<f64> {
    let ego = context.scene().ego.track.at(step)?;
    let other = context.participants()[participant].at(step)?;
    Some((other.pose.position - ego.pose.position).norm())
}
