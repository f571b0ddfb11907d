//! The road as text: all lanelets with neighbours, widths and centre lines, or those near the ego with their borders.

use std::collections::BTreeSet;

use nearmiss_base::geometry::{Point, distance_to_segment};

use super::options::{Form, Options};
use super::parts::lanelet_ids;
use super::writer::{Subject, Writer};
use crate::scenario::{Adjacent, Lane, Lanelet, LaneletNetwork, Scene};

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

/// A simplified line leaves the true one by no more than this, metres, unless it had too many points.
const TOLERANCE: f64 = 0.1;

/// Points of one line; where the tolerance needs more, it is doubled.
const MOST_NEARBY_POINTS: usize = 12;

/// Lanelets that are described, nearest first.
const MOST_NEARBY_LANELETS: usize = 30;

/// A lanelet near the ego with its simplified lines: centre, left and right.
struct Near<'n> {
    lanelet: &'n Lanelet,
    distance: f64,
    lines: [Vec<Point>; 3],
}

/// What the three lines are called.
const LINES: [&str; 3] = ["centre line", "left border", "right border"];

/// Describes the lanelets of which a part lies within the radius of the ego at one of `steps`.
pub(super) fn describe_nearby(w: &mut Writer, scene: &Scene, steps: &[i64], options: &Options) {
    let places = steps.iter().filter_map(|step| scene.ego.track.at(*step));
    let places: Vec<Point> = places.map(|ego| ego.pose.position).collect();
    let (mut near, mut tolerance) = (Vec::new(), TOLERANCE);
    for lanelet in &scene.scenario.network.lanelets {
        near.extend(within(lanelet, &places, options.radius, &mut tolerance));
    }
    w.about(Subject::Scene, None).text("\n");
    if near.is_empty() {
        w.text("No lanelet lies within ")
            .number("radius", options.radius)
            .text(" m of the ego.\n");
        return;
    }
    near.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let left_out = near.len().saturating_sub(MOST_NEARBY_LANELETS);
    near.truncate(MOST_NEARBY_LANELETS);
    w.text("Road: the lanelets within ")
        .number("radius", options.radius)
        .text(" m of the ego, nearest first");
    if left_out > 0 {
        w.text(" (")
            .integer("lanelets", i64::try_from(left_out).unwrap_or(i64::MAX))
            .text(" more are left out)");
    }
    w.text(". Their lines are (x, y) in metres, in driving direction, simplified to within ")
        .number("tolerance", tolerance)
        .text(" m.\n");
    if options.form == Form::Compact {
        w.text("lanelet,kind,comes from,leads to,left neighbour,right neighbour");
        for line in LINES {
            w.text(",").text(line).text(" [m]");
        }
        w.text("\n");
    }
    for one in &near {
        w.about(Subject::Lanelet(one.lanelet.id), None);
        match options.form {
            Form::Prose => prose(w, one),
            Form::Compact => compact(w, one),
        }
    }
}

fn within<'n>(
    lanelet: &'n Lanelet,
    places: &[Point],
    radius: f64,
    tolerance: &mut f64,
) -> Option<Near<'n>> {
    let lane = Lane::from_lanelet(lanelet)?;
    let lines = [lane.centre().points(), &lane.left, &lane.right];
    let distance = |line: &[Point]| {
        let segments = line.windows(2);
        let all = segments.map(|pair| to_segment(places, pair));
        all.fold(f64::INFINITY, f64::min)
    };
    let distance = lines
        .map(distance)
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    if distance > radius {
        return None;
    }
    let lines = lines.map(|line| {
        let line = clipped(line, places, radius);
        let mut wanted = TOLERANCE;
        let mut kept = simplified(line, wanted);
        while kept.len() > MOST_NEARBY_POINTS {
            wanted *= 2.0;
            kept = simplified(line, wanted);
        }
        *tolerance = tolerance.max(wanted);
        kept
    });
    Some(Near {
        lanelet,
        distance,
        lines,
    })
}

/// Metres from the nearest of `places` to a segment.
fn to_segment(places: &[Point], pair: &[Point]) -> f64 {
    let all = places
        .iter()
        .map(|place| distance_to_segment(place, &pair[0], &pair[1]));
    all.fold(f64::INFINITY, f64::min)
}

/// The part of a line from its first segment near one of `places` to its last.
fn clipped<'l>(line: &'l [Point], places: &[Point], radius: f64) -> &'l [Point] {
    let near = |pair: &[Point]| to_segment(places, pair) <= radius;
    let first = line.windows(2).position(near);
    let last = line.windows(2).rposition(near);
    match first.zip(last) {
        Some((first, last)) => &line[first..=last + 1],
        None => &[],
    }
}

/// The points of a line that keep every other one within `tolerance` metres of it: the algorithm of Ramer, Douglas and
/// Peucker (Cartographica 10, 1973).
fn simplified(line: &[Point], tolerance: f64) -> Vec<Point> {
    let mut kept = vec![false; line.len()];
    let mut spans = Vec::new();
    if let Some(end) = line.len().checked_sub(1) {
        (kept[0], kept[end]) = (true, true);
        spans.push((0, end));
    }
    while let Some((from, to)) = spans.pop() {
        let between = (from + 1..to).map(|at| {
            let off = distance_to_segment(&line[at], &line[from], &line[to]);
            (off, at)
        });
        let farthest = between.max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, at)) = farthest.filter(|(off, _)| *off > tolerance) {
            kept[at] = true;
            spans.extend([(from, at), (at, to)]);
        }
    }
    let points = line.iter().zip(kept);
    points.filter(|(_, kept)| *kept).map(|(p, _)| *p).collect()
}

fn prose(w: &mut Writer, near: &Near<'_>) {
    let lanelet = near.lanelet;
    w.text("  lanelet ").integer("lanelet", lanelet.id);
    w.text(" (").text(&kinds(lanelet, ", ")).text(")");
    for (words, ids) in [
        (", comes from ", &lanelet.predecessors),
        (", leads to ", &lanelet.successors),
    ] {
        if !ids.is_empty() {
            lanelet_ids(w.text(words), ids, " and ");
        }
    }
    for (words, beside) in [
        (", on its left ", lanelet.adjacent_left),
        (", on its right ", lanelet.adjacent_right),
    ] {
        if let Some(beside) = beside {
            w.text(words).integer("lanelet", beside.id);
            w.text(direction(beside));
        }
    }
    for (name, line) in LINES.iter().zip(&near.lines) {
        w.text("; ").text(name);
        if line.is_empty() {
            w.text(" farther away");
        }
        for p in line {
            w.text(" (").number("x", p.x).text(", ");
            w.number("y", p.y).text(")");
        }
    }
    w.text("\n");
}

fn compact(w: &mut Writer, near: &Near<'_>) {
    let lanelet = near.lanelet;
    w.integer("lanelet", lanelet.id);
    w.text(",").text(&kinds(lanelet, "+"));
    for ids in [&lanelet.predecessors, &lanelet.successors] {
        w.text(if ids.is_empty() { ",-" } else { "," });
        lanelet_ids(w, ids, "+");
    }
    for beside in [lanelet.adjacent_left, lanelet.adjacent_right] {
        match beside {
            Some(beside) => {
                w.text(",").integer("lanelet", beside.id);
                w.text(direction(beside));
            }
            None => {
                w.text(",-");
            }
        }
    }
    for line in &near.lines {
        w.text(if line.is_empty() { ",-" } else { "," });
        for (place, p) in line.iter().enumerate() {
            w.text(if place > 0 { " (" } else { "(" });
            w.number("x", p.x).text(" ").number("y", p.y).text(")");
        }
    }
    w.text("\n");
}

/// The words for the direction of a neighbour.
fn direction(beside: Adjacent) -> &'static str {
    if beside.same_direction {
        " in the same direction"
    } else {
        " in the opposite direction"
    }
}

/// The kinds of road that a lanelet is part of, `unknown` for none.
fn kinds(lanelet: &Lanelet, between: &str) -> String {
    let names: Vec<&str> = lanelet.types.iter().map(|kind| kind.name()).collect();
    if names.is_empty() {
        "unknown".into()
    } else {
        names.join(between)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simplified_line_keeps_its_ends_and_bends() {
        let at = |x: f64, y: f64| Point::new(x, y);
        let line = [at(0.0, 0.0), at(1.0, 0.05), at(2.0, 0.0), at(3.0, 1.0)];
        let kept = simplified(&line, TOLERANCE);
        assert_eq!(kept, [at(0.0, 0.0), at(2.0, 0.0), at(3.0, 1.0)]);
        assert_eq!(simplified(&line, 0.01).len(), 4);
        assert!(simplified(&[], 0.1).is_empty());
        let near = clipped(&line, &[at(0.5, 0.0)], 0.2);
        assert_eq!(near, &line[..2]);
    }
}
