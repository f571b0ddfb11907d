//! The participants of a scene at a step, and which of them a description means.

use nearmiss_scene::metrics::Encounter;
use nearmiss_scene::scenario::{LaneRelation, ObstacleType, Scene};

use super::references::{Described, Noun};
use super::truth::{crosses, is_at_side, opposes, stands};
use super::worded::lane_of;
use super::{Predicate, Side};

/// The participants of a scene at a step, for descriptions.
#[derive(Clone, Copy)]
pub(super) struct Cast<'a> {
    /// The scene; nothing is found by description without it.
    pub scene: Option<&'a Scene>,
    /// The step.
    pub step: i64,
}

/// What a description asks for.
#[derive(Default)]
pub(super) struct Description {
    pub(super) noun: Option<Noun>,
    pub(super) side: Option<Side>,
    pub(super) lane: Option<bool>,
    pub(super) is_in_lane: bool,
    pub(super) says: Vec<Described>,
    pub(super) is_nearest: bool,
    /// Where it comes from.
    pub(super) origin: Option<Side>,
}

impl Cast<'_> {
    /// What kind an obstacle is.
    pub(super) fn kind(&self, id: i64) -> Option<ObstacleType> {
        let mut all = self.scene?.participants();
        let who = all.find(|who| who.obstacle.id == id)?;
        Some(who.obstacle.kind)
    }

    /// The only participant that fits, or where several are ahead or behind in the ego's lane, the nearest of them; and all that fit,
    /// the nearest first.
    pub(super) fn find(&self, asked: &Description) -> (Option<i64>, Vec<i64>) {
        let Some(scene) = self.scene else {
            return (None, Vec::new());
        };
        let is_parked = asked.says.contains(&Described::Stands);
        let fits_type = |kind: ObstacleType| match asked.noun {
            // A parked one is called what it is, too.
            Some(Noun::Of(one, other)) => {
                kind == one
                    || kind == other
                    || is_parked
                        && kind == ObstacleType::ParkedVehicle
                        && matches!(one, ObstacleType::Car | ObstacleType::Truck)
            }
            _ => true,
        };
        let mut fitting: Vec<(i64, f64, bool)> = Vec::new();
        let mut ahead: Vec<i64> = Vec::new();
        for who in scene.participants() {
            let Some(encounter) = Encounter::at(scene, &who, self.step) else {
                continue;
            };
            let lane = lane_of(scene, &encounter);
            let in_lane = match lane {
                Some(LaneRelation::Same | LaneRelation::Ahead | LaneRelation::Behind) => true,
                None => encounter.relation().gap_lat == 0.0,
                Some(_) => false,
            };
            let is_left = matches!(lane, Some(LaneRelation::Left | LaneRelation::FurtherLeft));
            let is_right = matches!(lane, Some(LaneRelation::Right | LaneRelation::FurtherRight));
            let fits = fits_type(who.obstacle.kind)
                && asked.side.is_none_or(|side| is_at_side(side, &encounter))
                && asked
                    .origin
                    .is_none_or(|side| is_at_side(side, &encounter) || crosses(&encounter))
                && asked
                    .lane
                    .is_none_or(|left| if left { is_left } else { is_right })
                && (!asked.is_in_lane || in_lane)
                && asked.says.iter().all(|said| match said {
                    Described::Stands => stands(encounter.other),
                    Described::Is(Predicate::Oncoming) => opposes(&encounter),
                    Described::Is(Predicate::Crossing) => crosses(&encounter),
                    // Where no one is both, that is what is wrong.
                    _ => true,
                });
            if fits && encounter.relation().gap_long > 0.0 {
                ahead.push(who.obstacle.id);
            }
            if fits {
                fitting.push((who.obstacle.id, encounter.distance(), in_lane));
            }
        }
        let nearest = |all: &[(i64, f64, bool)]| {
            { all.iter() }
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .map(|one| one.0)
        };
        let along = asked
            .side
            .is_some_and(|side| side.front.is_some() && side.left.is_none());
        fitting.sort_by(|a, b| a.1.total_cmp(&b.1));
        let in_lane: Vec<_> = fitting.iter().copied().filter(|one| one.2).collect();
        // Of several the one that is plainly nearer than the others.
        let plainly = |all: &[(i64, f64, bool)]| {
            let id = nearest(all)?;
            let own = { all.iter() }.find(|one| one.0 == id)?.1;
            let is_plain = { all.iter() }.all(|one| one.0 == id || one.1 > 1.5 * own + 3.0);
            is_plain.then_some(id)
        };
        let found = match fitting.as_slice() {
            [] => None,
            [one] => Some(one.0),
            all if asked.is_nearest => nearest(all),
            _ if along && !in_lane.is_empty() => nearest(&in_lane),
            // "The car in my lane" is the one ahead.
            all if asked.is_in_lane => { all.iter() }
                .map(|one| one.0)
                .find(|id| ahead.contains(id)),
            all => plainly(all),
        };
        (found, fitting.iter().map(|one| one.0).collect())
    }
}
