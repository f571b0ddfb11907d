//! Lanelets as they were before nearmiss exported them, from the user data beside the lanes.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::mem::{replace, take};

use super::TOLERANCE;
use super::lane::Lane;
use super::links::Key;
use super::road::Road;
use crate::opendrive::signals::{STOP_LINE, SignalKey};
use crate::opendrive::user_data::KeptLanelet;
use crate::recordings::assembly::Map;
use nearmiss_base::geometry::Polyline;
use nearmiss_scene::scenario::{Bound, Lanelet};

/// Lanes may be so much farther from their lanelets than was written, metres: what reading and rounding add.
const ROUNDING: f64 = 0.02;

/// What is cut off the beginning of a lane for a junction is not longer, metres.
const CUT: f64 = 3.0;

/// What the file of an export says of signs and lights, beside what it keeps of them.
pub struct KeptSigns {
    /// By the ids of lanelets.
    pub lanelets: HashMap<i64, LaneletSigns>,
    /// The signals beside its roads, without stop lines.
    pub signals: BTreeSet<SignalKey>,
}

/// The signs and lights of an exported lanelet, by id.
pub struct LaneletSigns {
    /// Signs and lights of the lanelet.
    pub own: [Vec<i64>; 2],
    /// Signs and lights of its stop line.
    pub stop_line: [Vec<i64>; 2],
    /// The speed limit of its lane, m/s.
    pub limit: Option<f64>,
}

/// Puts the lanelets that were exported in the place of those that lanes became, and tells their signs and lights as they
/// were. They themselves have those of the roads, for what they refer to is not in this file.
///
/// All of them or none: where a road was added or changed since, its lanes hold.
pub fn restore(roads: &[Road], places: &HashMap<Key, usize>, map: &mut Map) -> Option<KeptSigns> {
    let mut lanes: Vec<Option<&Lane>> = vec![None; map.lanelets.len()];
    for ((road, section, id), place) in places {
        let section = &roads[*road].sections[*section];
        lanes[*place] = section.lanes.iter().find(|l| l.id == *id);
    }
    let parts: HashSet<i64> = lanes.iter().flatten().filter_map(|l| l.part_of).collect();
    let kept = |lane: &Lane| lane.kept.as_ref().map(|k| k.lanelet.id);
    let known: HashSet<i64> = lanes.iter().flatten().filter_map(|l| kept(l)).collect();
    let holds = |(lanelet, lane): (&Lanelet, &Option<&Lane>)| match lane {
        Some(Lane {
            kept: Some(kept), ..
        }) => kept.lanelet.id == lanelet.id && is_near(kept, lanelet, parts.contains(&lanelet.id)),
        Some(Lane { part_of, .. }) => part_of.is_some_and(|of| known.contains(&of)),
        None => false,
    };
    if known.is_empty() || !map.lanelets.iter().zip(&lanes).all(holds) {
        return None;
    }
    let mut lanelets = HashMap::new();
    let mut restored = Vec::new();
    for (read, lane) in take(&mut map.lanelets).into_iter().zip(lanes) {
        let Some(kept) = lane.and_then(|l| l.kept.as_ref()) else {
            continue;
        };
        let mut lanelet = kept.lanelet.clone();
        let line = lanelet.stop_line.as_mut();
        let signs = LaneletSigns {
            own: [
                replace(&mut lanelet.signs, read.signs),
                replace(&mut lanelet.lights, read.lights),
            ],
            stop_line: line.map_or_else(Default::default, |line| {
                [take(&mut line.signs), take(&mut line.lights)]
            }),
            limit: lane.and_then(|l| l.limit),
        };
        lanelets.insert(lanelet.id, signs);
        lanelet.predecessors.retain(|id| known.contains(id));
        lanelet.successors.retain(|id| known.contains(id));
        for beside in [&mut lanelet.adjacent_left, &mut lanelet.adjacent_right] {
            *beside = beside.filter(|a| known.contains(&a.id));
        }
        restored.push((kept.place, lanelet));
    }
    restored.sort_by_key(|(place, _)| *place);
    map.lanelets = restored.into_iter().map(|(_, lanelet)| lanelet).collect();
    let signals = roads
        .iter()
        .flat_map(|r| &r.signals)
        .filter(|s| s.kind != STOP_LINE);
    Some(KeptSigns {
        lanelets,
        signals: signals
            .map(|s| SignalKey::new(&s.id, &s.kind, &s.subtype))
            .collect(),
    })
}

/// Whether the borders of a lane are still those of its lanelet.
fn is_near(kept: &KeptLanelet, read: &Lanelet, is_cut: bool) -> bool {
    let most = kept.deviation + TOLERANCE + ROUNDING;
    let near = |own: &Bound, read: &Bound| {
        let Some(line) = Polyline::new(own.points.iter().copied()) else {
            return false;
        };
        let ends = |b: &Bound| Some((*b.points.first()?, *b.points.last()?));
        let (Some((own_first, own_last)), Some((first, last))) = (ends(own), ends(read)) else {
            return false;
        };
        let begins = if is_cut { CUT } else { most };
        (own_first - first).norm() <= begins
            && (own_last - last).norm() <= most
            && read.points.iter().all(|p| line.project(p).d.abs() <= most)
    };
    near(&kept.lanelet.left, &read.left) && near(&kept.lanelet.right, &read.right)
}
