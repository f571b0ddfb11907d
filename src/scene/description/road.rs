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
        w.text("\nThere is no road under them.\n");
        return;
    }
    w.text("\nRoad, centre lines in driving direction:\n");
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
        .text("  lanelet ")
        .integer("lanelet", lanelet.id);
    let Some(lane) = Lane::from_lanelet(lanelet) else {
        w.text(" has no length\n");
        return;
    };
    w.text(", ")
        .number("width", lane.width_at(lane.length() / 2.0))
        .text(" m wide, ");
    if lanelet.successors.is_empty() {
        w.text("leads to none");
    } else {
        w.text("leads to ");
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
        w.text("; its centre line is farther away\n");
        return;
    }
    w.text(":");
    for p in points {
        w.text(" (")
            .number("x", p.x)
            .text(", ")
            .number("y", p.y)
            .text(")");
    }
    w.text("\n");
}

fn write_neighbour(w: &mut Writer, side: &str, neighbour: Option<Adjacent>) {
    if let Some(neighbour) = neighbour {
        w.text(", on its ")
            .text(side)
            .text(" ")
            .integer("lanelet", neighbour.id)
            .text(if neighbour.same_direction {
                " in the same direction"
            } else {
                " in the opposite direction"
            });
    }
}
