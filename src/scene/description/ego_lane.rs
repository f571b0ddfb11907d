//! The ego-centric description from centre to centre: s and d of all participants along the ego's lane, and their lanes.

use std::cell::RefCell;
use std::rc::Rc;

use nearmiss_base::geometry::{Point, Pose, Vector};

use super::ego_centric::{OWN, describe_along_lane, own, turned};
use super::nearby::{self, VisibleObstacle, centre_distance};
use super::options::{EgoAxes, Form, Moment, Options, everyone};
use super::parts::{
    self, Cell, Column, NO_EGO, column, ego_moves, everyone_there, heading, name_and_place,
    no_obstacles,
};
use super::writer::{Subject, Writer};
use crate::metrics::Encounter;
use crate::scenario::{LaneGraph, LaneRelation, LaneRelations, Motion, Route, Scene, Window};

/// The relation of each obstacle to the ego.
const RELATION: &[Column] = &[
    column("direction", "direction"),
    column("distance [m]", "distance"),
    column("s [m]", "s"),
    column("d [m]", "d"),
    column("heading [°]", "heading_rel"),
    column("v rel s [m/s]", "v_rel_s"),
    column("v rel d [m/s]", "v_rel_d"),
];

/// The same without what says whether bodies touch.
const CENTRES: &[Column] = &[
    column("direction", "direction"),
    column("centre long [m]", "centre_long"),
    column("centre lat [m]", "centre_lat"),
    column("heading [°]", "heading_rel"),
    column("v rel long [m/s]", "v_rel_long"),
    column("v rel lat [m/s]", "v_rel_lat"),
];

/// What s and d are measured along at one step.
enum Axes {
    /// The centre line of the ego's lane and of those that it leads to, straight on where it forks.
    Lane(Box<Route>),
    /// The ego's heading: it is on no lane.
    Heading(Pose),
}

/// A place and a velocity along and across the axes: metres and m/s.
struct Along {
    s: f64,
    d: f64,
    velocity: Vector,
}

impl Axes {
    /// Those of the ego at a pose; the lane is looked at `reach` metres ahead.
    fn new(graph: &LaneGraph<'_>, ego: &Pose, reach: f64) -> Self {
        // Off the lanelets there is no lane, however near one is.
        let on_a_lane = !graph.network().lanelets_at(&ego.position).is_empty();
        match graph.road_ahead(ego, reach) {
            Ok(route) if on_a_lane => Self::Lane(Box::new(route)),
            _ => Self::Heading(*ego),
        }
    }

    /// Where a motion is; `None` where no part of the lane is beside it.
    ///
    /// The velocity is split along the direction of the lane beside the participant.
    fn along(&self, motion: &Motion) -> Option<Along> {
        let (sin, cos) = motion.pose.heading.sin_cos();
        let velocity = Vector::new(cos, sin) * motion.velocity;
        match self {
            Self::Lane(route) => {
                let place = route.path.project_point(&motion.pose.position);
                let (at, point) = place.ok()?;
                Some(Along {
                    s: at.s,
                    d: at.d,
                    velocity: Vector::new(
                        velocity.dot(&point.tangent()),
                        velocity.dot(&point.normal()),
                    ),
                })
            }
            Self::Heading(ego) => {
                let turned = |v: Vector| {
                    let (sin, cos) = ego.heading.sin_cos();
                    Vector::new(v.x * cos + v.y * sin, v.y * cos - v.x * sin)
                };
                let offset = |p: Point| turned(p - ego.position);
                let place = offset(motion.pose.position);
                Some(Along {
                    s: place.x,
                    d: place.y,
                    velocity: turned(velocity),
                })
            }
        }
    }
}

pub(super) fn describe(w: &mut Writer, scene: &Scene, window: &Window, options: &Options) {
    w.relative_to(window.last());
    let described = options.described(scene, window);
    let everyone = everyone(scene, window, options, &described);
    everyone_there(w, scene, window, &everyone);
    let graph = scene.scenario.network.lane_graph(None);
    let write = |w: &mut Writer, moments: Vec<Moment<'_>>| {
        let axes = moments.into_iter().map(|moment| {
            let ego = scene.ego.track.at(moment.step);
            let farthest = |ego| {
                moment
                    .near
                    .iter()
                    .map(move |(_, there)| centre_distance(ego, there))
            };
            let reach = |ego| farthest(ego).fold(options.radius, f64::max);
            let axes = ego.map(|ego| match options.axes {
                EgoAxes::Lane => Axes::new(&graph, &ego.pose, reach(ego)),
                _ => Axes::Heading(ego.pose),
            });
            (moment, ego.zip(axes))
        });
        let axes: Vec<_> = axes.collect();
        match options.form {
            Form::Prose => prose(w, scene, &axes, options),
            Form::Compact => compact(w, scene, &axes, options),
        }
    };
    write(w, described);
    if options.nearest && !everyone.is_empty() {
        nearby::heading(w, scene, window);
        write(w, nearby::nearest_moments(scene, window, &everyone));
    }
}

/// A described step with the ego and what is measured along.
type Described<'s> = (Moment<'s>, Option<(&'s Motion, Axes)>);

/// The words for a step without a lane.
const NO_LANE: &str = "The ego is on no lane: s and d are along and across its heading.";

fn prose(w: &mut Writer, scene: &Scene, described: &[Described<'_>], options: &Options) {
    let lanes = Lanes::new(scene);
    for (moment, there) in described {
        let step = moment.step;
        heading(w, scene, step);
        let Some((ego, axes)) = there else {
            w.text(NO_EGO);
            continue;
        };
        ego_moves(w, &lanes, ego, step);
        let own = axes.along(ego);
        let is_lane = options.axes == EgoAxes::Lane;
        match (axes, &own) {
            _ if !is_lane => {}
            (Axes::Heading(_), _) => {
                w.text("  ").text(NO_LANE).text("\n");
            }
            (Axes::Lane(_), Some(own)) => {
                w.text("  The ego: d ").number("d", own.d).text(" m.\n");
            }
            (Axes::Lane(_), None) => {}
        }
        if moment.near.is_empty() && !moment.left_out {
            no_obstacles(w, options.radius);
        }
        for (participant, motion) in &moment.near {
            let Some(encounter) = Encounter::at(scene, participant, step) else {
                continue;
            };
            let seen = VisibleObstacle::new(&encounter, options);
            name_and_place(w, participant, step, &seen, lanes.relation(ego, motion));
            if is_lane {
                w.text("distance ")
                    .number("distance", seen.distance)
                    .text(" m; ");
            }
            let mut moves = String::new();
            match own.as_ref().zip(axes.along(motion)) {
                Some((own, other)) if !is_lane => {
                    w.text("centre longitudinal ")
                        .number("centre_long", other.s - own.s)
                        .text(" m, lateral ")
                        .number("centre_lat", other.d - own.d)
                        .text(" m; relative velocity longitudinal ")
                        .number("v_rel_long", other.velocity.x - own.velocity.x)
                        .text(" m/s, lateral ")
                        .number("v_rel_lat", other.velocity.y - own.velocity.y)
                        .text(" m/s; ");
                }
                Some((own, other)) => {
                    // Of the numbers as they are written; both d are.
                    let place = [
                        w.written("s", other.s - own.s),
                        w.written("d", other.d) - w.written("d", own.d),
                    ];
                    let velocity = [
                        w.written("v_rel_s", other.velocity.x - own.velocity.x),
                        w.written("v_rel_d", other.velocity.y - own.velocity.y),
                    ];
                    moves = format!(" {}", describe_along_lane(place, velocity));
                    w.text("s ")
                        .number("s", other.s - own.s)
                        .text(" m, d ")
                        .number("d", other.d)
                        .text(" m; relative velocity along ")
                        .number("v_rel_s", other.velocity.x - own.velocity.x)
                        .text(" m/s, across ")
                        .number("v_rel_d", other.velocity.y - own.velocity.y)
                        .text(" m/s; ");
                }
                None => {
                    w.text("no s and d, since the lane is not beside it; ");
                }
            }
            turned(w, seen.heading);
            w.text(".").text(&moves).text("\n");
        }
    }
}

fn compact(w: &mut Writer, scene: &Scene, described: &[Described<'_>], options: &Options) {
    let lanes = Lanes::new(scene);
    let is_lane = options.axes == EgoAxes::Lane;
    for (moment, there) in described {
        if let Some((_, Axes::Heading(_))) = there
            && is_lane
        {
            w.about(Subject::Scene, Some(moment.step))
                .text("t = ")
                .time(moment.step, scene.scenario.dt())
                .text(" s: ")
                .text(NO_LANE)
                .text("\n");
        }
    }
    let columns = if is_lane { RELATION } else { CENTRES };
    parts::titles(w, &[OWN, columns]);
    for (moment, there) in described {
        let step = moment.step;
        parts::begin(w, scene, step, None);
        let Some((ego, axes)) = there else {
            parts::cells(w, OWN, &[]);
            parts::cells(w, columns, &[]);
            w.text("\n");
            continue;
        };
        let mine = axes.along(ego);
        parts::cells(w, OWN, &own(&lanes, ego));
        let d = Cell::number(mine.as_ref().map(|mine| mine.d));
        let own_place = [Cell::Nothing, Cell::Nothing, Cell::Nothing, d];
        parts::cells(w, columns, if is_lane { &own_place } else { &[] });
        w.text("\n");
        for (participant, motion) in &moment.near {
            let Some(encounter) = Encounter::at(scene, participant, step) else {
                continue;
            };
            let seen = VisibleObstacle::new(&encounter, options);
            parts::begin(w, scene, step, Some(participant));
            parts::cells(w, OWN, &[Cell::text(lanes.relation(ego, motion))]);
            let pair = mine.as_ref().zip(axes.along(motion));
            let both = pair.as_ref();
            let of = |value: fn(&Along, &Along) -> f64| {
                Cell::number(both.map(|(mine, other)| value(mine, other)))
            };
            let mut cells = vec![
                Cell::Words(seen.direction.name()),
                Cell::Real(seen.distance),
                of(|mine, other| other.s - mine.s),
                of(|_, other| other.d),
                Cell::Degrees(seen.heading),
                of(|mine, other| other.velocity.x - mine.velocity.x),
                of(|mine, other| other.velocity.y - mine.velocity.y),
            ];
            if !is_lane {
                cells.remove(1);
            }
            parts::cells(w, columns, &cells);
            w.text("\n");
        }
    }
}

/// Names the lanes of participants.
pub(super) struct Lanes<'s> {
    scene: &'s Scene,
    /// Of the ego where it was asked about last.
    last: RefCell<Option<Known<'s>>>,
}

/// The ego's pose, its lanelets, and what others are to them.
type Known<'s> = (Pose, Vec<i64>, Rc<LaneRelations<'s>>);

/// The words for a participant that is on no lanelet.
pub(super) const OFF_THE_ROAD: &str = "off the road";

impl<'s> Lanes<'s> {
    pub fn new(scene: &'s Scene) -> Self {
        Self {
            scene,
            last: RefCell::default(),
        }
    }

    /// Of the ego only that it is on no lane is worth a word; nothing where the map has no lanes.
    pub fn of_ego(&self, ego: &Motion) -> Option<&'static str> {
        let network = &self.scene.scenario.network;
        let off = network.lanelets_at(&ego.pose.position).is_empty();
        (off && !network.lanelets.is_empty()).then_some(OFF_THE_ROAD)
    }

    /// What the lane under `other` is to the ego's; nothing where the map has no lanes.
    pub fn relation(&self, ego: &Motion, other: &Motion) -> Option<&'static str> {
        let network = &self.scene.scenario.network;
        if network.lanelets.is_empty() {
            return None;
        }
        let theirs = network.lanelets_driven(&other.pose);
        if theirs.is_empty() {
            return Some(OFF_THE_ROAD);
        }
        match self.relations(ego) {
            Some(relations) => theirs
                .iter()
                .map(|id| relations.relation_to(*id))
                .min()
                .map(LaneRelation::text),
            None => Some("on the road"),
        }
    }

    /// Nothing where the ego is off the road. Those of one step have the same ego, those of steps in a row mostly the
    /// same lanelets.
    fn relations(&self, ego: &Motion) -> Option<Rc<LaneRelations<'s>>> {
        let network = &self.scene.scenario.network;
        let mut last = self.last.borrow_mut();
        let known = match last.take() {
            Some(known) if known.0 == ego.pose => known,
            before => {
                let ours = network.lanelets_driven(&ego.pose);
                let same = before.filter(|(_, lanelets, _)| *lanelets == ours);
                let relations = same
                    .map(|(.., relations)| relations)
                    .unwrap_or_else(|| Rc::new(network.lane_relations(&ours)));
                (ego.pose, ours, relations)
            }
        };
        let relations = (!known.1.is_empty()).then(|| known.2.clone());
        *last = Some(known);
        relations
    }
}
