//! Checks how lanelets follow and adjoin each other, and signs, lights and intersections.

use std::collections::{HashMap, HashSet};

use nearmiss_base::geometry::{Bounds, Point, Polyline, Vector};

use super::{ElementRef, Findings, beyond, gap};
use crate::scenario::{
    Adjacent, Intersection, Lanelet, LaneletNetwork, Scenario, Severity, Sign, SignMeaning,
    TrafficLight,
};

/// A lanelet begins where the one before it ends, within this, metres.
const JOINT: f64 = 2.0;

/// Neighbours lie no farther from each other, metres.
const NEIGHBOUR_DISTANCE: f64 = 5.0;

/// A lanelet farther from all others, metres, is on no road with them.
const ISOLATED_DISTANCE: f64 = 500.0;

/// A neighbour farther to the wrong side than this lies on that side, metres.
const WRONG_SIDE_OFFSET: f64 = 0.5;

pub(super) fn check_links(network: &LaneletNetwork, found: &mut Findings) {
    for (place, lanelet) in network.lanelets.iter().enumerate() {
        let about = ElementRef::Lanelet(place);
        let mut say = |message: String| {
            found.warn(about, format!("lanelet {}: {message}", lanelet.id));
        };
        check_self_links(lanelet, &mut say);
        check_joints(network, lanelet, &mut say);
        check_neighbours(network, place, &mut say);
    }
    check_isolated(network, found);
}

/// Links of a lanelet to itself, and repeated links.
fn check_self_links(lanelet: &Lanelet, say: &mut impl FnMut(String)) {
    let id = lanelet.id;
    for (what, ids) in [
        ("successor", &lanelet.successors),
        ("predecessor", &lanelet.predecessors),
    ] {
        if ids.contains(&id) {
            say(format!("is its own {what}"));
        }
        let mut seen = HashSet::new();
        if let Some(twice) = ids.iter().find(|id| !seen.insert(**id)) {
            say(format!("{twice} is listed twice as {what}"));
        }
    }
    let (left, right) = (lanelet.adjacent_left, lanelet.adjacent_right);
    for (side, neighbour) in [("left", left), ("right", right)] {
        let Some(neighbour) = neighbour else { continue };
        if neighbour.id == id {
            say(format!("is its own neighbour on the {side}"));
        } else if lanelet.successors.contains(&neighbour.id)
            || lanelet.predecessors.contains(&neighbour.id)
        {
            say(format!(
                "{} is both {side} neighbour and predecessor or successor",
                neighbour.id
            ));
        }
    }
    if let (Some(left), Some(right)) = (left, right)
        && left.id == right.id
    {
        say(format!("{} is both left and right neighbour", left.id));
    }
}

/// The lanelets that it leads to and comes from.
fn check_joints(network: &LaneletNetwork, lanelet: &Lanelet, say: &mut impl FnMut(String)) {
    let id = lanelet.id;
    let others = |ids: &[i64]| -> Vec<&Lanelet> {
        let others = ids.iter().filter(|other| **other != id);
        others.filter_map(|other| network.lanelet(*other)).collect()
    };
    for next in others(&lanelet.successors) {
        if !next.predecessors.contains(&id) {
            say(format!(
                "successor {} does not list it as predecessor",
                next.id
            ));
        }
        let (Some((_, end)), Some((begin, _))) = (ends(lanelet), ends(next)) else {
            continue;
        };
        let gap = (begin - end).norm();
        if gap > JOINT {
            say(format!(
                "successor {} starts {gap:.1} m from its end",
                next.id
            ));
        }
    }
    for before in others(&lanelet.predecessors) {
        if !before.successors.contains(&id) {
            say(format!(
                "predecessor {} does not list it as successor",
                before.id
            ));
        }
    }
}

/// The middle of where a lanelet begins and ends; `None` if its bounds run in opposite directions.
fn ends(lanelet: &Lanelet) -> Option<(Point, Point)> {
    let (left, right) = (&lanelet.left.points, &lanelet.right.points);
    let begin = nalgebra::center(left.first()?, right.first()?);
    let end = nalgebra::center(left.last()?, right.last()?);
    (!lanelet.borders_disagree()).then_some((begin, end))
}

/// The lanelets on its left and right.
fn check_neighbours(network: &LaneletNetwork, place: usize, say: &mut impl FnMut(String)) {
    let lanelet = &network.lanelets[place];
    for (side, neighbour) in [
        (Side::Left, lanelet.adjacent_left),
        (Side::Right, lanelet.adjacent_right),
    ] {
        let Some(adjacent) = neighbour.filter(|n| n.id != lanelet.id) else {
            continue;
        };
        let Some(other) = network.place(adjacent.id) else {
            continue;
        };
        let gap = gap(&network.bounds_of(place), &network.bounds_of(other));
        let other = &network.lanelets[other];
        let side_name = side.name();
        if gap > NEIGHBOUR_DISTANCE {
            say(format!(
                "{side_name} neighbour {} is {gap:.0} m away",
                other.id
            ));
        } else if let Some(message) = course(lanelet, other, side, adjacent) {
            say(message);
        }
        mutual(lanelet, other, side, adjacent, say);
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Left,
    Right,
}

impl Side {
    fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// That the neighbour has this lanelet on the fitting side.
fn mutual(
    lanelet: &Lanelet,
    other: &Lanelet,
    side: Side,
    adjacent: Adjacent,
    say: &mut impl FnMut(String),
) {
    // A left neighbour in the same direction must have this lanelet on its right.
    let back = match (side, adjacent.same_direction) {
        (Side::Left, true) | (Side::Right, false) => other.adjacent_right,
        (Side::Right, true) | (Side::Left, false) => other.adjacent_left,
    };
    let (side, id) = (side.name(), other.id);
    match back {
        Some(back) if back.id == lanelet.id && back.same_direction == adjacent.same_direction => {}
        Some(back) if back.id == lanelet.id => say(format!(
            "it and its {side} neighbour {id} disagree on the driving direction"
        )),
        _ => {
            let there = [other.adjacent_left, other.adjacent_right];
            if there.iter().flatten().any(|back| back.id == lanelet.id) {
                say(format!("{side} neighbour {id} lists it on the wrong side"));
            } else {
                say(format!(
                    "{side} neighbour {id} does not list it as neighbour"
                ));
            }
        }
    }
}

/// Contradictions between the geometry of two neighbours and their links; only for nearly straight lanelets.
fn course(lanelet: &Lanelet, other: &Lanelet, side: Side, adjacent: Adjacent) -> Option<String> {
    let (mine, theirs) = (straight(lanelet)?, straight(other)?);
    let along = mine.dot(&theirs);
    let id = other.id;
    if adjacent.same_direction && along < -0.5 {
        return Some(format!(
            "{id} is marked as same direction but runs in the opposite one"
        ));
    }
    if !adjacent.same_direction && along > 0.5 {
        return Some(format!(
            "{id} is marked as opposite direction but runs in the same one"
        ));
    }
    // For an oncoming neighbour left and right are swapped.
    let left = to_the_left(lanelet, other)? * along.signum();
    let wrong = match side {
        Side::Left => left < -WRONG_SIDE_OFFSET,
        Side::Right => left > WRONG_SIDE_OFFSET,
    };
    wrong.then(|| {
        format!(
            "neighbour {id} on the {} lies on the other side",
            side.name()
        )
    })
}

/// How far to the left of a lanelet another one lies that runs the same way, metres; negative to the right. The
/// median over the stretch on which they lie beside each other, as neighbours may be bent and of different lengths;
/// `None` if there is none. Of many points some are enough.
fn to_the_left(lanelet: &Lanelet, other: &Lanelet) -> Option<f64> {
    let theirs = Polyline::new(centre(other))?;
    let some = lanelet.left.points.len().div_ceil(SAMPLED).max(1);
    let offsets = centre(lanelet).step_by(some).filter_map(|p| {
        let there = theirs.project(&p);
        let inside = there.s > 0.0 && there.s < theirs.length();
        inside.then_some(-there.d)
    });
    let mut offsets: Vec<f64> = offsets.collect();
    offsets.sort_by(f64::total_cmp);
    offsets.get(offsets.len() / 2).copied()
}

fn centre(lanelet: &Lanelet) -> impl Iterator<Item = Point> {
    let pairs = lanelet.left.points.iter().zip(&lanelet.right.points);
    pairs.map(|(left, right)| nalgebra::center(left, right))
}

/// So many points along a lanelet tell on which side of another one it lies.
const SAMPLED: usize = 40;

/// The direction of a lanelet; `None` if it is bent.
fn straight(lanelet: &Lanelet) -> Option<Vector> {
    let (begin, end) = ends(lanelet)?;
    let chord = end - begin;
    let legs = lanelet.left.points.windows(2);
    let length: f64 = legs.map(|pair| (pair[1] - pair[0]).norm()).sum();
    let is_straight = chord.norm() > 1.0 && chord.norm() > 0.95 * length;
    is_straight.then(|| chord.normalize())
}

/// Lanelets far from all others.
fn check_isolated(network: &LaneletNetwork, found: &mut Findings) {
    let count = network.lanelets.len();
    let wide = network
        .bounds()
        .is_some_and(|b| (b.max - b.min).norm() > ISOLATED_DISTANCE);
    if count < 2 || !wide {
        return;
    }
    for (place, lanelet) in network.lanelets.iter().enumerate() {
        let own = network.bounds_of(place);
        let gap = |other: usize| gap(&own, &network.bounds_of(other));
        // Those before and behind it in the file are nearly always near.
        let mut near = (place.saturating_sub(8)..(place + 8).min(count))
            .chain(0..count)
            .filter(|other| *other != place);
        if near.any(|other| gap(other) <= ISOLATED_DISTANCE) {
            continue;
        }
        let nearest = (0..count)
            .filter(|o| *o != place)
            .map(gap)
            .fold(f64::MAX, f64::min);
        found.warn(
            ElementRef::Lanelet(place),
            format!(
                "lanelet {}: {nearest:.0} m from all other lanelets; is a coordinate wrong?",
                lanelet.id
            ),
        );
    }
}

/// Signs and lights stand no farther from the road, metres; maps that were cut out of larger ones keep distant ones.
const MAX_ROAD_DISTANCE: f64 = 5_000.0;

/// No limit is higher, m/s: 360 km/h, and 225 mph.
const HIGHEST_LIMIT: f64 = 100.0;

/// No light takes longer for its phases, seconds.
const LONGEST_CYCLE: f64 = 3_600.0;

pub(super) fn check_traffic(scenario: &Scenario, found: &mut Findings) {
    let network = &scenario.network;
    let around = network.bounds();
    for (i, one) in network.signs.iter().enumerate() {
        let about = ElementRef::Sign(i);
        sign(one, &mut |message| {
            found.warn(about, format!("sign {}: {message}", one.id));
        });
        if let Some(message) = misplaced(around.as_ref(), one.position) {
            found.warn(about, format!("sign {}: {message}", one.id));
        }
    }
    for (i, one) in network.lights.iter().enumerate() {
        let about = ElementRef::Light(i);
        light(one, scenario.dt(), about, found);
        if let Some(message) = misplaced(around.as_ref(), one.position) {
            found.warn(about, format!("light {}: {message}", one.id));
        }
    }
    for (i, one) in network.intersections.iter().enumerate() {
        intersection(one, network, &mut |severity, message| {
            found.push(
                severity,
                ElementRef::Intersection(i),
                format!("intersection {}: {message}", one.id),
            );
        });
    }
}

fn misplaced(around: Option<&Bounds>, position: Option<Point>) -> Option<String> {
    let off = beyond(around?, &position?);
    (off > MAX_ROAD_DISTANCE).then(|| format!("{off:.0} m from the road; is a coordinate wrong?"))
}

fn sign(sign: &Sign, say: &mut impl FnMut(String)) {
    for element in &sign.elements {
        let value = element.values.first().map_or("", String::as_str);
        match element.meaning() {
            Some(SignMeaning::SpeedLimit(limit) | SignMeaning::LeastSpeed(limit))
                if limit <= 0.0 || limit > HIGHEST_LIMIT =>
            {
                say(format!("a speed limit of {limit} m/s is implausible"));
            }
            Some(SignMeaning::Words("speed limit" | "minimum speed")) => {
                let value: String = value.chars().take(40).collect();
                say(format!("`{value}` is not a speed in m/s; ignored"));
            }
            _ => {}
        }
    }
}

fn light(light: &TrafficLight, dt: f64, about: ElementRef, found: &mut Findings) {
    let id = light.id;
    let bad = light.cycle.iter().filter(|phase| phase.duration <= 0);
    if let Some(first) = bad.clone().next() {
        let message = format!(
            "light {id}: a phase lasts {} time steps and is never shown",
            first.duration
        );
        found.warn(about, super::and_more(message, bad.count() - 1));
    }
    let whole: i128 = light
        .cycle
        .iter()
        .map(|p| i128::from(p.duration.max(0)))
        .sum();
    let seconds = whole as f64 * dt;
    if seconds > LONGEST_CYCLE {
        found.warn(about, format!("light {id}: its cycle takes {seconds:.0} s"));
    }
    if light.offset < 0 {
        found.note(
            about,
            format!("light {id}: a negative offset, {}", light.offset),
        );
    } else if light.offset as f64 * dt > 10.0 * LONGEST_CYCLE {
        found.warn(
            about,
            format!(
                "light {id}: its first phase begins at step {}",
                light.offset
            ),
        );
    }
}

fn intersection(
    one: &Intersection,
    network: &LaneletNetwork,
    say: &mut impl FnMut(Severity, String),
) {
    let mut leads_in: HashMap<i64, i64> = HashMap::new();
    for road in &one.incomings {
        if road.is_left_of == Some(road.id) {
            // Converters write this where there is no other road.
            say(
                Severity::Note,
                format!("incoming road {} is left of itself", road.id),
            );
        }
        for lanelet in &road.lanelets {
            let other = leads_in.insert(*lanelet, road.id);
            if let Some(other) = other.filter(|other| *other != road.id) {
                say(
                    Severity::Warning,
                    format!(
                        "lanelet {lanelet} is part of incoming roads {other} and {}",
                        road.id
                    ),
                );
            }
        }
        let lanelets = road.lanelets.iter().filter_map(|id| network.lanelet(*id));
        let next: HashSet<i64> = lanelets.flat_map(|l| &l.successors).copied().collect();
        let mut ways: HashMap<i64, &str> = HashMap::new();
        let all = [
            ("right", &road.right),
            ("straight on", &road.straight),
            ("left", &road.left),
        ];
        for (way, ids) in all {
            for id in ids {
                if let Some(other) = ways.insert(*id, way).filter(|other| *other != way) {
                    say(
                        Severity::Note,
                        format!(
                            "from road {}, lanelet {id} leads {other} and {way}",
                            road.id
                        ),
                    );
                }
                if network.lanelet(*id).is_some() && !next.contains(id) {
                    say(
                        Severity::Warning,
                        format!(
                            "lanelet {id}, which road {} reaches going {way}, is not a successor of its lanelets",
                            road.id
                        ),
                    );
                }
            }
        }
    }
}
