//! What does not fit together in roads: gaps, lengths, links to nothing.

use std::collections::HashSet;

use super::road::{Road, RoadLink};
use crate::commonroad::builder::SourceLocation;
use crate::recordings::report::Report;

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
