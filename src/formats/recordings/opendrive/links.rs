//! Which lanes touch which at their ends, and what does not fit together in roads.

use std::collections::{BTreeSet, HashMap, HashSet};

use nearmiss_base::geometry::Point;

use super::road::{End, Lane, Road, RoadLink, contact};
use super::tree::Node;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::Report;

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

/// Ends that are farther apart, metres, are a gap.
const GAP: f64 = 0.1;

/// Says what does not fit together, and how it is read.
pub fn report(roads: &[Road], report: &Report) {
    let known: HashSet<&str> = roads.iter().map(|r| r.id.as_str()).collect();
    for road in roads {
        let at = report.at(format!("road {}", road.id));
        for gap in gaps(road) {
            at.warn(gap);
        }
        if let Some(words) = length(road) {
            at.warn(words);
        }
        let links = road.links.iter().flatten();
        let names = links.filter_map(|link| match link {
            RoadLink::Road(id, _) => Some(id.as_str()),
            RoadLink::Junction(_) => None,
        });
        for id in names.filter(|id| !known.contains(id)) {
            at.warn(format!(
                "is linked to road {id}, which is not in the file; it ends there"
            ));
        }
        let inside = |s: f64| road.sections.iter().all(|x| (x.from - s).abs() > GAP);
        for kind in road.types.iter().skip(1).filter(|t| inside(t.from)) {
            at.warn(format!(
                "its type changes at s={} m within a lane section; the lanes there keep the one before",
                kind.from
            ));
        }
    }
}

/// Places where its reference line does not go on where it ended.
fn gaps(road: &Road) -> Vec<String> {
    let mut all = Vec::new();
    if let Some(first) = road.pieces.first().filter(|p| p.s > GAP) {
        all.push(format!("its reference line begins at s={} m only", first.s));
    }
    for pair in road.pieces.windows(2) {
        let end = pair[0].at((pair[1].s - pair[0].s).clamp(0.0, pair[0].length));
        let metres = (pair[1].start().position - end.position).norm();
        if metres > GAP {
            let s = pair[1].s;
            all.push(format!(
                "its reference line jumps by {metres:.1} m at s={s} m"
            ));
        }
    }
    all
}

/// Where its length is not that of its reference line.
fn length(road: &Road) -> Option<String> {
    let last = road.pieces.last()?;
    let drawn = last.s + last.length;
    let missing = road.length - drawn;
    if missing.abs() <= GAP {
        return None;
    }
    let does = if missing > 0.0 {
        "the last piece goes on to its end"
    } else {
        "what is behind its end is left out"
    };
    let length = road.length;
    Some(format!(
        "it is {length} m long, its reference line {drawn} m; {does}"
    ))
}
