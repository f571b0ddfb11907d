//! Which lanes touch which at their ends.

use std::collections::{BTreeSet, HashMap};

use super::lane::Lane;
use super::road::{End, Road, RoadLink, contact};
use super::tree::Node;
use crate::commonroad::ReadError;
use crate::recordings::report::Report;
use nearmiss_base::geometry::Point;

/// A lane: the place of its road, of its section, and its id.
pub type Key = (usize, usize, i64);

/// A lane and one of its ends, along its road.
pub type At = (Key, End);

/// The links of a lane to one side.
type Links = fn(&Lane) -> &Vec<i64>;

/// A connection of a junction.
pub struct Connection {
    junction: String,
    incoming: String,
    /// The connecting road, or in direct junctions the road that it goes on to, and the end there.
    road: String,
    end: End,
    /// Lanes of the first and of the second road.
    lanes: Vec<(i64, i64)>,
}

/// The connections of all junctions.
pub fn connections(root: &Node, report: &Report) -> Result<Vec<Connection>, ReadError> {
    let mut all = Vec::new();
    let mut others = 0;
    for junction in root.all("junction") {
        // Virtual junctions lie amid a road, crossings have no lanes.
        if matches!(junction.text("type"), Some("virtual" | "crossing")) {
            others += 1;
            continue;
        }
        for node in junction.all("connection") {
            // Others refer to it by that.
            node.skip_attributes(&["id"]);
            let road = node.text("connectingRoad").or(node.text("linkedRoad"));
            let (Some(incoming), Some(road)) = (node.text("incomingRoad"), road) else {
                continue;
            };
            let mut lanes = Vec::new();
            for lane in node.all("laneLink") {
                let id = |name: &str| Ok::<i64, ReadError>(lane.or_zero(name)? as i64);
                lanes.push((id("from")?, id("to")?));
            }
            all.push(Connection {
                junction: junction.text("id").unwrap_or_default().to_string(),
                incoming: incoming.to_string(),
                road: road.to_string(),
                end: contact(node),
                lanes,
            });
        }
    }
    report.note_count(others, |n| {
        format!("virtual junctions and crossings: {n}; their connections are not read")
    });
    Ok(all)
}

/// The section at an end of a road.
fn section_at(road: &Road, end: End) -> usize {
    match end {
        End::Start => 0,
        End::End => road.sections.len() - 1,
    }
}

/// Where the reference line of a road ends.
fn place_of(road: &Road, end: End) -> Point {
    let s = match end {
        End::Start => 0.0,
        End::End => road.length,
    };
    road.pose(s).position
}

/// Pairs of ends of lanes that touch, each once.
pub fn contacts(roads: &[Road], connections: &[Connection]) -> BTreeSet<(At, At)> {
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
            let own = section_at(road, end);
            let theirs = section_at(&roads[other], *contact);
            for lane in &road.sections[own].lanes {
                for id in links(lane) {
                    touch(((r, own, lane.id), end), ((other, theirs, *id), *contact));
                }
            }
        }
    }
    for connection in connections {
        let place = |id: &str| places.get(id).copied();
        let (Some(r), Some(other)) = (place(&connection.incoming), place(&connection.road)) else {
            continue;
        };
        let meets = place_of(&roads[other], connection.end);
        let away = |end: &End| (place_of(&roads[r], *end) - meets).norm();
        // A road may begin and end at one junction.
        let ends = [(0, End::Start), (1, End::End)].into_iter().filter(|(side, _)| {
            matches!(&roads[r].links[*side], Some(RoadLink::Junction(id)) if *id == connection.junction)
        });
        let nearest = ends
            .map(|(_, end)| end)
            .min_by(|a, b| away(a).total_cmp(&away(b)));
        let Some(end) = nearest else {
            continue;
        };
        let own = section_at(&roads[r], end);
        let theirs = section_at(&roads[other], connection.end);
        for (from, to) in &connection.lanes {
            touch(
                ((r, own, *from), end),
                ((other, theirs, *to), connection.end),
            );
        }
    }
    all
}
