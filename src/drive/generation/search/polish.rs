//! The end of a search that found nothing: small changes of what came nearest.
//!
//! An evolution strategy with one parent, whose step follows its success (Rechenberg, Evolutionsstrategie, 1973): how near
//! an attacker comes depends smoothly on a manoeuvre's numbers, while what was drawn at large leaves wide gaps.

use super::{Effort, Progress, Search};
use crate::generation::manoeuvre_space::Numbers;

/// What came nearest by so many arms is changed, and so often.
const PARENTS: usize = 2;
const GENERATIONS: usize = 6;

/// Motions that are driven in a generation, of at most so many that are asked for: some do not pass the gate.
const CHILDREN: usize = 4;
const ASKED: usize = 12;

/// What costs more is too far off for small changes.
const NEAR: f64 = 2.0;

/// The first step, as a share of an arm's spread; what it becomes after a success and a failure.
const STEP: f64 = 0.3;
const LONGER: f64 = 1.3;
const SHORTER: f64 = 0.6;

impl Search<'_> {
    /// Changes what came nearest, until a good driver survives an attack or enough was done.
    pub(super) fn polish(
        &mut self,
        effort: &Effort,
        random: &mut fastrand::Rng,
        watch: &mut dyn FnMut(Progress) -> bool,
    ) {
        for mut parent in self.parents() {
            let mut step = STEP;
            for _ in 0..GENERATIONS {
                if self.is_survived() || self.found.work >= self.wanted.work {
                    return;
                }
                let left = effort.candidates.saturating_sub(self.found.candidates);
                let children = self.children(parent, step, left, random, watch);
                if !self.drive_all(children.clone(), watch) || (self.stop)() {
                    return;
                }
                self.look(effort.delay);
                let cost = |&i: &usize| self.tried[i].attack.cost();
                let best = children
                    .into_iter()
                    .min_by(|a, b| cost(a).total_cmp(&cost(b)));
                match best.filter(|best| cost(best) < cost(&parent)) {
                    Some(best) => (parent, step) = (best, step * LONGER),
                    None => step *= SHORTER,
                }
            }
        }
    }

    /// What came nearest without an effect, one of an arm.
    fn parents(&self) -> Vec<usize> {
        let tried = self.tried.iter().enumerate();
        let mut near: Vec<(usize, f64)> = tried
            .filter(|(_, t)| t.attack.effect.is_some() && !t.attack.has_effect())
            .map(|(i, t)| (i, t.attack.cost()))
            .filter(|(_, cost)| *cost <= NEAR)
            .collect();
        near.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut parents: Vec<usize> = Vec::new();
        for (i, _) in near {
            let arm = self.tried[i].arm;
            if parents.len() < PARENTS && parents.iter().all(|&p| self.tried[p].arm != arm) {
                parents.push(i);
            }
        }
        parents
    }

    /// Places of new motions a step from `parent`, for which no more than `left` are tried.
    fn children(
        &mut self,
        parent: usize,
        step: f64,
        left: usize,
        random: &mut fastrand::Rng,
        watch: &mut dyn FnMut(Progress) -> bool,
    ) -> Vec<usize> {
        let (arm, numbers) = (self.tried[parent].arm, self.tried[parent].numbers);
        let first = self.tried.len();
        for _ in 0..ASKED.min(left) / CHILDREN {
            let asked: Vec<(usize, Numbers)> = (0..CHILDREN)
                .map(|_| (arm, self.arms[arm].around(&numbers, step, random)))
                .collect();
            let goes_on = self.make_all(&asked, 0, watch);
            if !goes_on || self.tried.len() >= first + CHILDREN {
                break;
            }
        }
        (first..self.tried.len()).take(CHILDREN).collect()
    }
}
