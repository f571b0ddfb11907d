//! OpenDRIVE: the road network of a scenario as roads with lanes, and such roads as lanelets.

mod curve;
mod graph;
mod links;
mod profile;
mod road;
pub(super) mod signals;
pub(super) mod user_data;
mod writer;

pub(super) use writer::date;

use crate::commonroad::WriteError;
use nearmiss_scene::scenario::{Lanelet, Scenario};

/// An OpenDRIVE file.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenDrive {
    /// The file, in UTF-8.
    pub bytes: Vec<u8>,
    /// What it cannot say, or says differently, one sentence each.
    pub notes: Vec<String>,
    /// How far borders of lanes are at most from those of the lanelets, metres.
    pub deviation: f64,
}

/// Borders that are farther from those of the lanelets are told, metres.
const REPORTED_DEVIATION: f64 = 0.05;

/// More lanelets are not named.
const MAX_LISTED: usize = 6;

/// The road network of a scenario as OpenDRIVE 1.7. The same scenario gives the same bytes.
///
/// Lanelets beside each other in the same direction with the same borders are the lanes of one road. Places where
/// several roads continue each other are junctions. Coordinates are those of the scenario.
///
/// # Errors
/// None in practice: writing goes to memory.
pub fn write_opendrive(scenario: &Scenario) -> Result<OpenDrive, WriteError> {
    let network = &scenario.network;
    let roads = links::link(network, road::roads(network));
    let mut notes = Vec::new();
    let mut note = |count: usize, words: &str, names: Vec<String>| {
        if count > 0 {
            let more = if names.len() < count { ", …" } else { "" };
            notes.push(format!("{count} {words}: {}{more}", names.join(", ")));
        }
    };
    let known: std::collections::HashSet<usize> = roads
        .roads
        .iter()
        .flat_map(|r| r.road.lanelets.iter().copied())
        .collect();
    let all = network.lanelets.iter().enumerate();
    let lost: Vec<String> = all
        .filter(|(place, _)| !known.contains(place))
        .map(|(_, l)| l.id.to_string())
        .collect();
    note(lost.len(), "lanelets without length left out", few(lost));
    let far = roads
        .roads
        .iter()
        .filter(|r| r.road.deviation > REPORTED_DEVIATION && !r.is_cut);
    let far: Vec<String> = far
        .map(|r| {
            let ids = r
                .road
                .lanelets
                .iter()
                .map(|p| network.lanelets[*p].id.to_string());
            let ids: Vec<String> = ids.collect();
            format!("lanelet {} by {:.2} m", ids.join("+"), r.road.deviation)
        })
        .collect();
    note(
        far.len(),
        "roads have borders off those of their lanelets",
        few(far),
    );
    let apart: Vec<String> = roads
        .apart
        .iter()
        .map(|(a, b, gap)| format!("{a} → {b} ({gap:.2} m apart)"))
        .collect();
    note(
        apart.len(),
        "lanelets do not meet their successors and are not linked",
        few(apart),
    );
    let high = |l: &&Lanelet| !l.left.heights.is_empty() || !l.right.heights.is_empty();
    let high = network.lanelets.iter().filter(high).count();
    note(high, "lanelets have heights, written as 0", Vec::new());
    let deviation = roads.roads.iter().map(|r| r.road.deviation);
    Ok(OpenDrive {
        bytes: writer::bytes(scenario, &roads)?,
        notes: notes
            .into_iter()
            .map(|n| n.trim_end_matches(": , …").to_string())
            .collect(),
        deviation: deviation.fold(0.0, f64::max),
    })
}

fn few(mut all: Vec<String>) -> Vec<String> {
    all.truncate(MAX_LISTED);
    all
}
