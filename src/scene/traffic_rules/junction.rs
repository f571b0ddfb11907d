//! A way through an intersection, the lanes that cross or join it there, and where two are too close for two vehicles.

use nearmiss_base::geometry::{Polyline, ReferencePath};

use super::Rule;
use super::regulations::Stretch;
use super::right_of_way::{Party, SignRank, gives_way};
use crate::scenario::{Incoming, Intersection, Lane, Lanelet, LaneletNetwork};

/// Where a way turns to at an intersection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Turn {
    /// To the right.
    Right,
    /// Straight on.
    Straight,
    /// To the left.
    Left,
}

/// A way through an intersection.
#[derive(Debug, Clone, PartialEq)]
pub struct Passage {
    /// The intersection's id.
    pub intersection: i64,
    /// Arc length of the line before it, where one waits, metres.
    pub line: f64,
    /// Arc length of the end of the lanelets inside, metres.
    pub until: f64,
    /// Where the way turns to.
    pub turn: Turn,
    /// The lanelet that leads in; the first one inside where the way begins there.
    pub lanelet: i64,
    /// Whether lights hold on the way here.
    pub lights: bool,
    /// What its signs say.
    pub rank: SignRank,
    /// The lanes that cross or join the way.
    pub rivals: Vec<Rival>,
}

/// A lane that crosses or joins a way at an intersection.
#[derive(Debug, Clone, PartialEq)]
pub struct Rival {
    /// The lanelet inside the intersection.
    pub lanelet: i64,
    /// Its middle, from the road that leads in to the end of the lanelet.
    pub centre: Polyline,
    /// Where the lanelet inside begins along it, metres.
    pub inside: f64,
    /// Where both meet.
    pub conflict: Conflict,
    /// The rule by which the way has to give way, by signs and directions; `None` where the lane has to.
    pub rule: Option<Rule>,
    /// The same while lights hold on the way.
    pub rule_with_lights: Option<Rule>,
}

impl Rival {
    /// The rule by which the way has to give way while its lights show something, or nothing.
    #[must_use]
    pub fn rule(&self, lights: bool) -> Option<Rule> {
        if lights {
            self.rule_with_lights
        } else {
            self.rule
        }
    }
}

/// How far a rival's lane is followed back, metres.
const UPSTREAM: f64 = 100.0;

/// What is found of an incoming on a way: its lanelet there, if any, and the turn with the lanelets inside.
struct FoundLanelet<'n> {
    incoming: &'n Incoming,
    lanelet: Option<usize>,
    turn: Turn,
    inside: (usize, usize),
}

/// The passages of a way, in its order.
pub(super) fn passages(
    network: &LaneletNetwork,
    path: &ReferencePath,
    stretches: &[Stretch],
) -> Vec<Passage> {
    let mut found: Vec<Passage> = network
        .intersections
        .iter()
        .filter_map(|intersection| passage(network, path, stretches, intersection))
        .collect();
    found.sort_by(|a, b| a.line.total_cmp(&b.line));
    found
}

/// The lanelets to which an incoming leads, with the turn.
fn ways(incoming: &Incoming) -> impl Iterator<Item = (Turn, i64)> {
    let of = |turn: Turn, ids: &[i64]| -> Vec<(Turn, i64)> {
        ids.iter().map(|id| (turn, *id)).collect()
    };
    let all = [
        of(Turn::Right, &incoming.right),
        of(Turn::Straight, &incoming.straight),
        of(Turn::Left, &incoming.left),
    ];
    all.into_iter().flatten()
}

fn find<'n>(stretches: &[Stretch], intersection: &'n Intersection) -> Option<FoundLanelet<'n>> {
    intersection.incomings.iter().find_map(|incoming| {
        let inside = |stretch: &Stretch| {
            let mut ways = ways(incoming);
            ways.find(|(_, id)| stretch.along && *id == stretch.lanelet)
        };
        let first = stretches.iter().position(|s| inside(s).is_some())?;
        let (turn, _) = inside(&stretches[first])?;
        let last = stretches[first..]
            .iter()
            .take_while(|s| inside(s).is_some())
            .count();
        let before = first.checked_sub(1);
        let leads_in = |place: &usize| incoming.lanelets.contains(&stretches[*place].lanelet);
        Some(FoundLanelet {
            incoming,
            lanelet: before.filter(leads_in),
            turn,
            inside: (first, first + last - 1),
        })
    })
}

fn passage(
    network: &LaneletNetwork,
    path: &ReferencePath,
    stretches: &[Stretch],
    intersection: &Intersection,
) -> Option<Passage> {
    let found = find(stretches, intersection)?;
    let (first, last) = found.inside;
    let line = match found.lanelet {
        Some(place) => stretches[place].line,
        None => stretches[first].from,
    };
    let until = stretches[last].to;
    let lanelet = found.lanelet.unwrap_or(first);
    let own_lanelets = [lanelet, first].map(|place| stretches[place].lanelet);
    let own = Party {
        heading: path.at(stretches[first].from).heading,
        turn: found.turn,
        rank: SignRank::from_signs(
            network,
            own_lanelets.iter().filter_map(|id| network.lanelet(*id)),
        ),
    };
    let others = intersection
        .incomings
        .iter()
        .filter(|other| other.id != found.incoming.id);
    let on_way = |id: i64| stretches.iter().any(|s| s.lanelet == id);
    let rivals = others.flat_map(|incoming| {
        ways(incoming)
            .filter(|(_, id)| !on_way(*id))
            .filter_map(|(turn, id)| {
                let span = (stretches[first].from, until);
                rival(network, path, span, &own, incoming, turn, id)
            })
            .collect::<Vec<_>>()
    });
    Some(Passage {
        intersection: intersection.id,
        line,
        until,
        turn: found.turn,
        lanelet: stretches[lanelet].lanelet,
        lights: false,
        rank: own.rank,
        rivals: rivals.collect(),
    })
}

fn rival(
    network: &LaneletNetwork,
    path: &ReferencePath,
    span: (f64, f64),
    own: &Party,
    incoming: &Incoming,
    turn: Turn,
    id: i64,
) -> Option<Rival> {
    let inner = network.lanelet(id)?;
    let mut chain = vec![inner];
    let leads_in = inner.predecessors.iter();
    let leads_in = { leads_in }.find(|id| incoming.lanelets.contains(id));
    let mut next = leads_in.or(incoming.lanelets.first()).copied();
    let mut far = 0.0;
    while let Some(lanelet) = next.and_then(|id| network.lanelet(id)) {
        if chain.iter().any(|known| known.id == lanelet.id) || far > UPSTREAM {
            break;
        }
        far += Lane::from_lanelet(lanelet).map_or(0.0, |lane| lane.length());
        chain.push(lanelet);
        next = match &lanelet.predecessors[..] {
            [only] => Some(*only),
            _ => None,
        };
    }
    chain.reverse();
    let signed: Vec<&Lanelet> = chain.iter().rev().take(2).copied().collect();
    let lane = Lane::merged(chain)?;
    let inside = lane.length() - Lane::from_lanelet(inner)?.length();
    let centre = lane.centre().clone();
    let other = Party {
        heading: centre.pose_at(inside).heading,
        turn,
        rank: SignRank::from_signs(network, signed),
    };
    Some(Rival {
        lanelet: id,
        conflict: conflict(path, span, &centre, inside)?,
        inside,
        rule: gives_way(own, &other, false),
        rule_with_lights: gives_way(own, &other, true),
        centre,
    })
}

/// The parts of a way and of another lane on which vehicles would touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conflict {
    /// Arc lengths of the way, metres.
    pub own: (f64, f64),
    /// Distances along the other lane, metres.
    pub other: (f64, f64),
}

/// Two lanes whose middles are nearer than this have no room for two cars, metres: half the width of both and what they
/// keep beside them.
const WIDE: f64 = 2.2;

/// Between places that are looked at, metres.
const SPACING: f64 = 0.5;

/// The conflict on the part `span` (m) of a way with another lane from `inside` (m) on.
pub(super) fn conflict(
    path: &ReferencePath,
    span: (f64, f64),
    other: &Polyline,
    inside: f64,
) -> Option<Conflict> {
    let count = ((span.1 - span.0) / SPACING).clamp(0.0, MAX_PLACES).ceil() as usize;
    let mut found: Option<Conflict> = None;
    for n in 0..=count {
        let s = span.0 + n as f64 * SPACING;
        let on = other.project(&path.pose_at(s).position);
        if on.d.abs() >= WIDE || on.s < inside {
            continue;
        }
        let known = found.get_or_insert(Conflict {
            own: (s, s),
            other: (on.s, on.s),
        });
        known.own.1 = s;
        known.other = (known.other.0.min(on.s), known.other.1.max(on.s));
    }
    found
}

/// Places that are looked at, at most.
const MAX_PLACES: f64 = 1000.0;
