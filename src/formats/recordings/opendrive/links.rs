//! Which lanes touch which at their ends.

use std::collections::{BTreeSet, HashMap};

use super::road::{End, Lane, Road, RoadLink};

/// A lane: the place of its road, of its section, and its id.
pub type Key = (usize, usize, i64);

/// A lane and one of its ends, along its road.
pub type At = (Key, End);

/// The links of a lane to one side.
type Links = fn(&Lane) -> &Vec<i64>;

/// Pairs of ends of lanes that touch, each once.
pub fn contacts(roads: &[Road]) -> BTreeSet<(At, At)> {
    let places: HashMap<&str, usize> = roads.iter().map(|r| r.id.as_str()).zip(0..).collect();
    let mut all = BTreeSet::new();
    let mut touch = |a: At, b: At| {
        all.insert(if a <= b { (a, b) } else { (b, a) });
    };
    for (r, road) in roads.iter().enumerate() {
        for x in 1..road.sections.len() {
            let (before, behind) = (&road.sections[x - 1], &road.sections[x]);
            for lane in &before.lanes {
                for id in &lane.successors {
                    touch(((r, x - 1, lane.id), End::End), ((r, x, *id), End::Start));
                }
            }
            for lane in &behind.lanes {
                for id in &lane.predecessors {
                    touch(((r, x - 1, *id), End::End), ((r, x, lane.id), End::Start));
                }
            }
        }
        let ends: [(usize, End, Links); 2] = [
            (0, End::Start, |l| &l.predecessors),
            (1, End::End, |l| &l.successors),
        ];
        for (side, end, links) in ends {
            let Some(RoadLink::Road(id, contact)) = &road.links[side] else {
                continue;
            };
            let Some(other) = places.get(id.as_str()).copied() else {
                continue;
            };
            let own = if end == End::Start {
                0
            } else {
                road.sections.len() - 1
            };
            let theirs = match contact {
                End::Start => 0,
                End::End => roads[other].sections.len() - 1,
            };
            for lane in &road.sections[own].lanes {
                for id in links(lane) {
                    touch(((r, own, lane.id), end), ((other, theirs, *id), *contact));
                }
            }
        }
    }
    all
}
