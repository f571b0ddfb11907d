//! The road as text: lanelets with neighbours, widths and centre-line points.

use std::collections::BTreeSet;

use super::parts::lanelet_ids;
use super::writer::{Subject, Writer};
use crate::scenario::{Adjacent, Lane, Lanelet, LaneletNetwork, Scene};
use nearmiss_base::geometry::Point;

/// Between two points of a centre line, metres.
const SPACING: f64 = 10.0;

/// Points of one centre line; on a longer one they lie farther apart.
const MOST_POINTS: f64 = 200.0;

/// Lanelets that are described: more under one obstacle in one window is a mistake in the file.
const MOST_LANELETS: usize = 40;

/// Describes the lanelets `under` a participant, those that they lead to, and those beside them; of their centre
/// lines what lies within `radius` metres of any of `places`.
pub(super) fn describe(
    w: &mut Writer,
    scene: &Scene,
    under: &BTreeSet<i64>,
    places: &[Point],
    radius: f64,
) {
    let network = &scene.scenario.network;
    let lanelets = lanelets_around(network, under);
    if lanelets.is_empty() {
        w.words("\nThere is no road under them.\n");
        return;
    }
    w.words("\nRoad, centre lines in driving direction:\n");
    for lanelet in lanelets {
        one(w, lanelet, places, radius);
    }
}

fn lanelets_around<'n>(network: &'n LaneletNetwork, under: &BTreeSet<i64>) -> Vec<&'n Lanelet> {
    let mut ids: Vec<i64> = under.iter().copied().collect();
    for &id in under {
        if let Some(lanelet) = network.lanelet(id) {
            let beside = [lanelet.adjacent_left, lanelet.adjacent_right];
            ids.extend(&lanelet.successors);
            ids.extend(beside.into_iter().flatten().map(|a| a.id));
        }
    }
    let mut seen = BTreeSet::new();
    ids.retain(|id| seen.insert(*id));
    let known = ids.iter().filter_map(|id| network.lanelet(*id));
    known.take(MOST_LANELETS).collect()
}

fn one(w: &mut Writer, lanelet: &Lanelet, places: &[Point], radius: f64) {
    w.about(Subject::Lanelet(lanelet.id), None)
        .words("  lanelet ")
        .whole("lanelet", lanelet.id);
    let Some(lane) = Lane::from_lanelet(lanelet) else {
        w.words(" has no length\n");
        return;
    };
    w.words(", ")
        .number("width", lane.width_at(lane.length() / 2.0))
        .words(" m wide, ");
    if lanelet.successors.is_empty() {
        w.words("leads to none");
    } else {
        w.words("leads to ");
        lanelet_ids(w, &lanelet.successors, " and ");
    }
    write_neighbour(w, "left", lanelet.adjacent_left);
    write_neighbour(w, "right", lanelet.adjacent_right);
    let spacing = SPACING.max(lane.length() / MOST_POINTS);
    let count = (lane.length() / spacing).ceil().max(1.0) as usize;
    let at = |i: usize| {
        let s = lane.length() * i as f64 / count as f64;
        lane.centre().pose_at(s).position
    };
    let near = |p: &Point| places.iter().any(|place| (place - p).norm() <= radius);
    let points: Vec<Point> = (0..=count).map(at).filter(near).collect();
    if points.is_empty() {
        w.words("; its centre line is farther away\n");
        return;
    }
    w.words(":");
    for p in points {
        w.words(" (")
            .number("x", p.x)
            .words(", ")
            .number("y", p.y)
            .words(")");
    }
    w.words("\n");
}

fn write_neighbour(w: &mut Writer, side: &str, neighbour: Option<Adjacent>) {
    if let Some(neighbour) = neighbour {
        w.words(", on its ")
            .words(side)
            .words(" ")
            .whole("lanelet", neighbour.id)
            .words(if neighbour.same_direction {
                " in the same direction"
            } else {
                " in the opposite direction"
            });
    }
}
