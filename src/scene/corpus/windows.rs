//! Measures every window of every pair of road users in a scenario: its most severe moment, its manoeuvre and its road.

use std::cell::{OnceCell, RefCell};
use std::cmp::Ordering;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use nearmiss_base::geometry::{Vector, angle_between};
use rayon::prelude::*;

use super::events::{Driven, Event};
use super::lanes::{Lanelets, LanesUnder};
use super::manoeuvre::{Manoeuvre, PairMotion, RoadType};
use super::{CellWindows, WindowPlace};
use crate::metrics::{Context, CriticalMoment, Grade, Measure, Moments, PairMoments, Thresholds};
use crate::scenario::{Ego, EgoSource, LaneRelation, Motion, ObstacleRole, Scenario, Scene, Track};
use crate::story::Braking;

/// How windows are cut and what is measured in them.
#[derive(Debug, Clone)]
pub struct IndexOptions {
    /// Length of a window, seconds.
    pub length: f64,
    /// From the start of a window to that of the next, seconds.
    pub stride: f64,
    /// Pairs whose centres are farther apart at all steps of a window are left out, metres.
    pub radius: f64,
    /// What is measured.
    pub measures: Vec<&'static Measure>,
}

/// Who is the ego of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindowEgo {
    /// The ego that was recorded beside the scenario.
    Recorded,
    /// An obstacle.
    Obstacle(i64),
}

/// A window of a pair.
#[derive(Debug, Clone, PartialEq)]
pub struct IndexedWindow {
    /// The ego.
    pub ego: WindowEgo,
    /// The other.
    pub obstacle: i64,
    /// Its type, in the word of the format.
    pub kind: &'static str,
    /// First and last step at which both are there.
    pub steps: (i64, i64),
    /// What they do.
    pub manoeuvre: Manoeuvre,
    /// The road under the ego at the last step.
    pub road: RoadType,
    /// The severity of its most severe step, 0 (contact) to 5 (none).
    pub severity: u8,
    /// That step.
    pub worst_step: i64,
    /// The most dangerous value of each measure of [`IndexOptions::measures`]; of a measure that only describes, the
    /// lowest.
    pub values: Vec<Option<f64>>,
}

/// Turns are looked for so long before and after a window, seconds.
const TURN_MARGIN: f64 = 2.0;

/// Measures the windows of a scenario, with each track in turn as the ego, and the recorded ego if there is one; what
/// happened to these egos, and how far they drove.
pub fn for_each_window(
    scenario: &Arc<Scenario>,
    recorded: Option<Ego>,
    options: &IndexOptions,
    thresholds: &Thresholds,
    take: &mut dyn FnMut(IndexedWindow),
) -> Driven {
    let shared = Shared::new(scenario);
    let mut driven = Driven::default();
    let recorded = recorded.map(|ego| (WindowEgo::Recorded, Scene::new(Arc::clone(scenario), ego)));
    let tracks = scenario.possible_egos().into_iter().filter_map(|id| {
        let scene = Scene::with_obstacle_as_ego(Arc::clone(scenario), id).ok()?;
        Some((WindowEgo::Obstacle(id), scene))
    });
    for (ego, scene) in recorded.into_iter().chain(tracks) {
        let context = Context::under(&scene, thresholds);
        let egos = EgoWindows::new(ego, &context, options, &shared);
        for place in 0..context.participants().len() {
            egos.of_pair(place, take);
        }
        driven.add(&egos);
    }
    driven
}

/// What happens to the ego of a scene, as an index has it; others farther than `radius` metres do not matter.
#[must_use]
pub fn events(scene: &Scene, radius: f64) -> Vec<Event> {
    let (shared, context) = (Shared::new(&scene.scenario), Context::new(scene));
    let options = IndexOptions {
        length: 2.0 * AROUND_MOMENT,
        stride: AROUND_MOMENT,
        radius,
        measures: Vec::new(),
    };
    EgoWindows::new(WindowEgo::of(scene), &context, &options, &shared).events()
}

/// A moment is seen with so many seconds before and after it.
const AROUND_MOMENT: f64 = 1.0;

/// What the other of a moment does around it, on which road, as an index has it of a window; nothing where one of the two
/// is not there.
#[must_use]
pub fn window_of_moment(context: &Context<'_>, moment: &CriticalMoment) -> Option<CellWindows> {
    let scene = context.scene();
    let (ego, shared) = (WindowEgo::of(scene), Shared::new(&scene.scenario));
    let options = IndexOptions {
        length: 2.0 * AROUND_MOMENT,
        stride: AROUND_MOMENT,
        radius: f64::INFINITY,
        measures: Vec::new(),
    };
    let egos = EgoWindows::new(ego, context, &options, &shared);
    let mut all = context.participants().iter();
    let place = all.position(|other| other.obstacle.id == moment.obstacle)?;
    let around = (AROUND_MOMENT / scene.scenario.dt()).round() as i64;
    let is_there = |step: &i64| context.encounter(place, *step).is_some();
    let first = (moment.step - around..=moment.step).find(is_there)?;
    let last = (moment.step..=moment.step + around).rfind(is_there)?;
    Some(CellWindows {
        manoeuvre: egos.manoeuvre(place, first, last)?,
        road: egos.road(last),
        severity: moment.grade.number(),
        actor: context.participants()[place].obstacle.kind,
        windows: 1,
        asked: 0,
        example: WindowPlace {
            ego,
            ego_id: scene.ego.id,
            obstacle: moment.obstacle,
            steps: (first, last),
            worst_step: moment.step,
        },
    })
}

/// How severe a step is, and its measures.
type Readings = Option<(CriticalMoment, Vec<Option<f64>>)>;

/// What the pairs of a scenario share.
pub(super) struct Shared<'s> {
    pub lanes: LanesUnder<'s>,
    pub brakings: RefCell<HashMap<i64, Rc<[Braking]>>>,
}

impl<'s> Shared<'s> {
    fn new(scenario: &'s Scenario) -> Self {
        Self {
            lanes: LanesUnder::new(&scenario.network),
            brakings: RefCell::default(),
        }
    }
}

impl WindowEgo {
    /// The ego of a scene.
    fn of(scene: &Scene) -> Self {
        match scene.ego.source {
            EgoSource::Obstacle(id) => Self::Obstacle(id),
            _ => Self::Recorded,
        }
    }
}

pub(super) struct EgoWindows<'c, 's, 'n> {
    pub ego: WindowEgo,
    pub scene: &'s Scene,
    pub context: &'c Context<'s>,
    moments: Moments<'c, 's>,
    pub options: &'c IndexOptions,
    pub shared: &'c Shared<'n>,
    /// By step of the ego.
    lanes: Vec<OnceCell<Option<Rc<Lanelets<'n>>>>>,
}

impl<'c, 's, 'n> EgoWindows<'c, 's, 'n> {
    fn new(
        ego: WindowEgo,
        context: &'c Context<'s>,
        options: &'c IndexOptions,
        shared: &'c Shared<'n>,
    ) -> Self {
        let scene = context.scene();
        Self {
            ego,
            scene,
            context,
            moments: Moments::new(context),
            options,
            shared,
            lanes: scene.steps().map(|_| OnceCell::new()).collect(),
        }
    }

    fn of_pair(&self, place: usize, take: &mut dyn FnMut(IndexedWindow)) {
        let steps = self.scene.steps();
        let count = |seconds: f64| ((seconds / self.scene.scenario.dt()).round() as i64).max(1);
        let (length, stride) = (count(self.options.length), count(self.options.stride));
        let all = usize::try_from(steps.end - steps.start).unwrap_or(0);
        let readings: Vec<OnceCell<Readings>> = vec![OnceCell::new(); all];
        let moments = self.moments.with(place);
        let mut first = steps.start;
        while first < steps.end {
            let end = (first + length).min(steps.end);
            if let Some(window) = self.window(place, first..end, &moments, &readings) {
                take(window);
            }
            // The rest of a recording is in the last window that reaches its end.
            if end == steps.end {
                break;
            }
            first += stride;
        }
    }

    fn window(
        &self,
        place: usize,
        steps: std::ops::Range<i64>,
        moments: &PairMoments<'_, '_>,
        readings: &[OnceCell<Readings>],
    ) -> Option<IndexedWindow> {
        let other = self.context.participants()[place];
        let mut both = steps
            .filter(|step| self.scene.ego.track.at(*step).is_some() && other.at(*step).is_some());
        let first = both.next()?;
        let last = both.next_back().unwrap_or(first);
        let start = self.scene.steps().start;
        let mut values: Vec<Option<f64>> = vec![None; self.options.measures.len()];
        let mut worst: Option<CriticalMoment> = None;
        for step in first..=last {
            let index = usize::try_from(step - start).ok()?;
            let read = || self.read(place, moments, step);
            let Some((moment, here)) = readings[index].get_or_init(read) else {
                continue;
            };
            if worst.is_none_or(|worst| moment.precedes(&worst)) {
                worst = Some(*moment);
            }
            for ((value, here), measure) in values.iter_mut().zip(here).zip(&self.options.measures)
            {
                let Some(here) = *here else { continue };
                let danger = measure.danger;
                if value.is_none_or(|before| danger.compare(here, before).is_lt()) {
                    *value = Some(here);
                }
            }
        }
        // No step within the radius.
        let worst = worst?;
        Some(IndexedWindow {
            ego: self.ego,
            obstacle: other.obstacle.id,
            kind: other.obstacle.kind.name(),
            steps: (first, last),
            manoeuvre: self.manoeuvre(place, first, last)?,
            road: self.road(last),
            severity: worst.grade.number(),
            worst_step: worst.step,
            values,
        })
    }

    /// The readings of a step; nothing beyond the radius.
    fn read(&self, place: usize, moments: &PairMoments<'_, '_>, step: i64) -> Readings {
        let encounter = self.context.encounter(place, step)?;
        let apart = encounter.other.pose.position - encounter.ego.pose.position;
        if apart.norm() > self.options.radius {
            return None;
        }
        let measures = self.options.measures.iter();
        let values = measures.map(|m| m.evaluate(&encounter).value()).collect();
        Some((moments.at(step)?, values))
    }

    /// The lanelets under the ego.
    pub fn lanes_at(&self, step: i64) -> Option<&Rc<Lanelets<'n>>> {
        let index = usize::try_from(step - self.scene.steps().start).ok()?;
        let lanes = self.lanes.get(index)?.get_or_init(|| {
            let ego = self.scene.ego.track.at(step)?;
            self.shared.lanes.at(&ego.pose)
        });
        lanes.as_ref()
    }

    pub fn road(&self, step: i64) -> RoadType {
        let under = self.lanes_at(step).map(|under| under.ids.as_slice());
        RoadType::classify(self.shared.lanes.network, under.unwrap_or_default())
    }

    /// The lane under a body, seen from the ego's at a step; the closest relation of several.
    pub fn relation(&self, at: i64, other: &Motion) -> Option<LaneRelation> {
        let ego = self.lanes_at(at)?;
        ego.relation_to(&self.shared.lanes.at(&other.pose)?.ids)
    }

    fn manoeuvre(&self, place: usize, first: i64, last: i64) -> Option<Manoeuvre> {
        self.motion(place, first, last)
            .map(|pair| Manoeuvre::classify(&pair))
    }

    /// Both at two steps.
    pub fn motion(&self, place: usize, first: i64, last: i64) -> Option<PairMotion<'_>> {
        let other = self.context.participants()[place];
        let track = &self.scene.ego.track;
        let (ego, theirs) = (
            [track.at(first)?, track.at(last)?],
            [other.at(first)?, other.at(last)?],
        );
        let stands = other.obstacle.role == ObstacleRole::Static;
        let around = (TURN_MARGIN / self.scene.scenario.dt()).round() as i64;
        let wide = |track: &Track, first: i64, last: i64| {
            let steps = track.steps();
            let from = (first - around).max(steps.start);
            let to = (last + around).min(steps.end - 1);
            let heading = |step: i64, near: i64| {
                let motion = track.at(step).or_else(|| track.at(near));
                motion.map_or(0.0, |motion| motion.pose.heading)
            };
            (heading(from, first), heading(to, last))
        };
        let own = wide(track, first, last);
        let their = if stands {
            (theirs[0].pose.heading, theirs[1].pose.heading)
        } else {
            wide(other.obstacle.track(), first, last)
        };
        let lanes = [
            self.relation(first, theirs[0]),
            self.relation(last, theirs[1]),
        ];
        let aside = |step| match lanes {
            [Some(_), Some(_)] => None,
            _ => self.aside(place, step),
        };
        Some(PairMotion {
            ego,
            other: theirs,
            lanes,
            aside: [aside(first), aside(last)],
            to_first_lane: self.relation(first, theirs[1]),
            along: [own, their]
                .map(|(from, to)| Vector::new(from.cos() + to.cos(), from.sin() + to.sin())),
            turns: [angle_between(own.0, own.1), angle_between(their.0, their.1)],
            angle_before: angle_between(own.0, their.0).abs(),
            stands,
        })
    }

    /// How far the other's centre is left of the ego's way, metres.
    pub fn aside(&self, place: usize, step: i64) -> Option<f64> {
        let [ego, other] = self.context.along_way(place, step)?;
        Some(other.at.d - ego.at.d)
    }
}

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
pub(super) const STANDING: f64 = 0.5;

/// Moments of the same two nearer to each other than this are one, seconds.
const SAME_MOMENT_SECONDS: f64 = 10.0;

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
    once_each(all, (SAME_MOMENT_SECONDS / scenario.dt()) as i64)
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

/// The ego of a scenario that has none: the follower of the pair with the most severe moment, and that moment, in which
/// the other of [`WorstMoment::ego`] may be the follower. It is who sees the other ahead without being ahead of it, else the
/// one of them that closes faster; an obstacle without a trajectory follows none. `None` where no two come within `radius` metres.
#[must_use]
pub fn dangerous_follower(
    scenario: &Arc<Scenario>,
    radius: f64,
    thresholds: &Thresholds,
) -> Option<(i64, WorstMoment)> {
    let possible = scenario.possible_egos();
    let worst = { worst_moments(scenario, &possible, radius, thresholds).into_iter() }.next()?;
    let (one, other) = (worst.ego, worst.moment.obstacle);
    if !possible.contains(&other) {
        return Some((one, worst));
    }
    let motion = |id| scenario.obstacle(id)?.motion_at(worst.moment.step);
    let (here, there) = (motion(one)?, motion(other)?);
    let sees = |from: &Motion, to: &Motion| {
        let between = to.pose.position - from.pose.position;
        (
            between.dot(&from.pose.forward()) >= 0.0,
            between.dot(&from.velocity_vector()),
        )
    };
    let ((sees_other, closing), (is_seen, other_closing)) = (sees(here, there), sees(there, here));
    let other_follows = if sees_other == is_seen {
        other_closing > closing
    } else {
        is_seen
    };
    Some((if other_follows { other } else { one }, worst))
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
        let near =
            |step: &i64| centre_distance(context, participant, *step).is_some_and(|d| d <= radius);
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
fn centre_distance(context: &Context<'_>, participant: usize, step: i64) -> Option<f64> {
    let ego = context.scene().ego.track.at(step)?;
    let other = context.participants()[participant].at(step)?;
    Some((other.pose.position - ego.pose.position).norm())
}
