//! OpenDRIVE 1.7: writes the road network of a scenario as roads with lanes; such roads as lanelets.

mod curve;
mod graph;
mod links;
mod road;
pub(super) mod signals;
pub(super) mod user_data;

use std::collections::HashSet;

use nearmiss_scene::scenario::{Lanelet, LineMarking, Scenario};

use super::commonroad::WriteError;
use super::commonroad::writer::{Attributes, XmlWriter, number};
use curve::Profile;
use links::{Link, LinkedRoad, Roads};
use signals::Signal;
use user_data::{KeptLanelet, PART_OF};

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
        bytes: write_roads(scenario, &roads)?,
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

/// Attributes of an element whose names are known.
macro_rules! attributes {
    ($($name:literal = $value:expr),* $(,)?) => { [$(($name, $value.to_string())),*] };
}

/// The road network of a scenario as a file.
fn write_roads(scenario: &Scenario, roads: &Roads) -> Result<Vec<u8>, WriteError> {
    let mut out = XmlWriter::begun()?;
    let bounds = scenario.network.bounds();
    let edge =
        |of: fn(&nearmiss_base::geometry::Bounds) -> f64| number(bounds.as_ref().map_or(0.0, of));
    let header = attributes![
        "revMajor" = 1,
        "revMinor" = 7,
        "name" = scenario.header.benchmark_id,
        "version" = "1.00",
        "date" = date(scenario),
        "north" = edge(|b| b.max.y),
        "south" = edge(|b| b.min.y),
        "east" = edge(|b| b.max.x),
        "west" = edge(|b| b.min.x),
        "vendor" = "nearmiss",
    ];
    let country = country(scenario);
    out.element("OpenDRIVE", &[], |out| {
        out.element("header", &header, |out| match reference(scenario) {
            Some(reference) => out.leaf("geoReference", reference),
            None => Ok(()),
        })?;
        let mut written = HashSet::new();
        for road in &roads.roads {
            let signals = signals::of_road(&scenario.network, road, country, &mut written);
            self::road(out, scenario, road, &signals, country)?;
        }
        for junction in &roads.junctions {
            let attributes = attributes!["id" = junction.id, "name" = junction.name];
            out.element("junction", &attributes, |out| {
                let all = junction.connections.iter().enumerate();
                all.into_iter()
                    .try_for_each(|(i, (incoming, connecting, lanes))| {
                        let attributes = attributes![
                            "id" = i,
                            "incomingRoad" = incoming,
                            "connectingRoad" = connecting,
                            "contactPoint" = "start",
                        ];
                        out.element("connection", &attributes, |out| {
                            lanes.iter().try_for_each(|(from, to)| {
                                let link =
                                    attributes!["from" = lane_id(*from), "to" = lane_id(*to)];
                                out.empty("laneLink", &link)
                            })
                        })
                    })
            })?;
        }
        Ok(())
    })?;
    Ok(out.finished())
}

/// The date of a scenario, or a fixed one: the same scenario gives the same bytes.
pub(super) fn date(scenario: &Scenario) -> String {
    let date = scenario
        .header
        .attributes
        .get("date")
        .map_or("", String::as_str);
    let plain = date.len() == 10
        && date.bytes().enumerate().all(|(i, b)| match i {
            4 | 7 => b == b'-',
            _ => b.is_ascii_digit(),
        });
    let date = if plain { date } else { "1970-01-01" };
    format!("{date}T00:00:00")
}

/// The projection of the coordinates, where they are those of a projection.
fn reference(scenario: &Scenario) -> Option<&str> {
    let place = scenario.location.as_ref()?.transformation.as_ref()?;
    let shifted = [place.x, place.y, place.rotation];
    let moved = shifted.iter().any(|v| v.is_some_and(|v| v != 0.0));
    let scaled = place.scaling.is_some_and(|s| s != 1.0);
    let reference = place.reference.as_deref()?;
    (!moved && !scaled && reference.contains("+proj")).then_some(reference)
}

/// The country of signs, in two letters.
fn country(scenario: &Scenario) -> &'static str {
    let benchmark = &scenario.header.benchmark_id;
    let id = benchmark.strip_prefix("C-").unwrap_or(benchmark);
    let code = id.split('_').next().unwrap_or_default();
    let known = [
        ("USA", "US"),
        ("GBR", "GB"),
        ("FRA", "FR"),
        ("ESP", "ES"),
        ("ITA", "IT"),
        ("CHN", "CN"),
        ("BEL", "BE"),
        ("HRV", "HR"),
        ("ARG", "AR"),
        ("AUS", "AU"),
        ("GRC", "GR"),
        ("RUS", "RU"),
        ("SGP", "SG"),
        ("JPN", "JP"),
    ];
    // Signs of made-up places are those of Germany.
    known
        .iter()
        .find(|(three, _)| *three == code)
        .map_or("DE", |(_, two)| two)
}

/// The id of a lane, counted from the left: all lanes are to the right of the line in the middle.
fn lane_id(lane: usize) -> i64 {
    -(i64::try_from(lane).unwrap_or(i64::MAX - 1) + 1)
}

fn road(
    out: &mut XmlWriter,
    scenario: &Scenario,
    road: &LinkedRoad,
    signals: &[Signal],
    country: &str,
) -> Result<(), WriteError> {
    let network = &scenario.network;
    let places = road.road.lanelets.iter();
    let lanelets: Vec<&Lanelet> = places.map(|place| &network.lanelets[*place]).collect();
    let ids: Vec<String> = lanelets.iter().map(|l| l.id.to_string()).collect();
    let name = if road.is_cut {
        format!("into lanelet {}", ids.join(" "))
    } else {
        format!("lanelet {}", ids.join(" "))
    };
    let junction = road.junction.map_or("-1".into(), |id| id.to_string());
    let attributes = attributes![
        "name" = name,
        "length" = number(road.road.length()),
        "id" = road.id,
        "junction" = junction,
        "rule" = "RHT",
    ];
    out.element("road", &attributes, |out| {
        links(out, road)?;
        road_types(out, scenario, &lanelets, country)?;
        out.element("planView", &[], |out| {
            road.road.curve.pieces.iter().try_for_each(|piece| {
                let start = piece.start;
                let attributes = attributes![
                    "s" = number(piece.s),
                    "x" = number(start.position.x),
                    "y" = number(start.position.y),
                    "hdg" = number(start.heading),
                    "length" = number(piece.length),
                ];
                out.element("geometry", &attributes, |out| match piece.curvature {
                    0.0 => out.empty("line", &[]),
                    k => out.empty("arc", &attributes!["curvature" = number(k)]),
                })
            })
        })?;
        out.element("lanes", &[], |out| lanes(out, scenario, road, &lanelets))?;
        if signals.is_empty() {
            return Ok(());
        }
        out.element("signals", &[], |out| {
            signals
                .iter()
                .try_for_each(|s| signal(out, s, country, lanelets.len()))
        })
    })
}

fn links(out: &mut XmlWriter, road: &LinkedRoad) -> Result<(), WriteError> {
    if (road.predecessor, road.successor) == (Link::None, Link::None) {
        return out.empty("link", &[]);
    }
    out.element("link", &[], |out| {
        let ends = [
            ("predecessor", road.predecessor, "end"),
            ("successor", road.successor, "start"),
        ];
        ends.into_iter()
            .try_for_each(|(name, link, contact)| match link {
                Link::None => Ok(()),
                Link::Road(id) => out.empty(
                    name,
                    &attributes![
                        "elementType" = "road",
                        "elementId" = id,
                        "contactPoint" = contact
                    ],
                ),
                Link::Junction(id) => out.empty(
                    name,
                    &attributes!["elementType" = "junction", "elementId" = id],
                ),
            })
    })
}

fn road_types(
    out: &mut XmlWriter,
    scenario: &Scenario,
    lanelets: &[&Lanelet],
    country: &str,
) -> Result<(), WriteError> {
    let kind = signals::road_type(lanelets);
    let attributes = attributes!["s" = "0.0", "type" = kind, "country" = country];
    let limits = lanelets
        .iter()
        .filter_map(|l| signals::speed_limit(&scenario.network, l));
    match limits.max_by(f64::total_cmp) {
        Some(limit) => out.element("type", &attributes, |out| {
            out.empty("speed", &attributes!["max" = number(limit), "unit" = "m/s"])
        }),
        None => out.empty("type", &attributes),
    }
}

/// A function of the arc length as cubics with only the first two coefficients.
fn cubics(
    out: &mut XmlWriter,
    name: &str,
    at: &'static str,
    profile: &Profile,
) -> Result<(), WriteError> {
    let mut write = |s: f64, value: f64, slope: f64| {
        let cubic: &Attributes<'_> = &[
            (at, number(s)),
            ("a", number(value)),
            ("b", number(slope)),
            ("c", "0.0".into()),
            ("d", "0.0".into()),
        ];
        out.empty(name, cubic)
    };
    match &profile.0[..] {
        [] => write(0.0, 0.0, 0.0),
        [(s, only)] => write(*s, *only, 0.0),
        all => all.windows(2).try_for_each(|pair| {
            let ((s, value), (next, then)) = (pair[0], pair[1]);
            write(s, value, (then - value) / (next - s))
        }),
    }
}

fn lanes(
    out: &mut XmlWriter,
    scenario: &Scenario,
    road: &LinkedRoad,
    lanelets: &[&Lanelet],
) -> Result<(), WriteError> {
    cubics(out, "laneOffset", "s", &road.road.offset)?;
    out.element("laneSection", &attributes!["s" = "0.0"], |out| {
        let middle = attributes!["id" = 0, "type" = "none", "level" = "false"];
        out.element("center", &[], |out| {
            out.element("lane", &middle, |out| {
                let marking = lanelets.first().map(|l| l.left.marking);
                road_mark(out, marking.unwrap_or(LineMarking::Unknown))
            })
        })?;
        out.element("right", &[], |out| {
            let all = lanelets.iter().enumerate();
            all.into_iter()
                .try_for_each(|(i, l)| lane(out, scenario, road, i, l))
        })
    })
}

fn road_mark(out: &mut XmlWriter, marking: LineMarking) -> Result<(), WriteError> {
    let (kind, weight) = signals::road_mark(marking);
    let attributes = attributes![
        "sOffset" = "0.0",
        "type" = kind,
        "weight" = weight,
        "color" = "standard",
        "width" = if weight == "bold" { "0.25" } else { "0.12" },
    ];
    out.empty("roadMark", &attributes)
}

fn lane(
    out: &mut XmlWriter,
    scenario: &Scenario,
    road: &LinkedRoad,
    place: usize,
    lanelet: &Lanelet,
) -> Result<(), WriteError> {
    let attributes = attributes![
        "id" = lane_id(place),
        "type" = signals::lane_type(lanelet),
        "level" = "false"
    ];
    out.element("lane", &attributes, |out| {
        let ends = [
            ("predecessor", road.lanes_before[place]),
            ("successor", road.lanes_behind[place]),
        ];
        if ends.iter().any(|(_, lane)| lane.is_some()) {
            out.element("link", &[], |out| {
                ends.iter().try_for_each(|(name, lane)| match lane {
                    Some(lane) => out.empty(name, &attributes!["id" = lane_id(*lane)]),
                    None => Ok(()),
                })
            })?;
        }
        cubics(out, "width", "sOffset", &road.road.widths[place])?;
        road_mark(out, lanelet.right.marking)?;
        if let Some(limit) = signals::speed_limit(&scenario.network, lanelet) {
            let speed = attributes!["sOffset" = "0.0", "max" = number(limit), "unit" = "m/s"];
            out.empty("speed", &speed)?;
        }
        let kept = || KeptLanelet {
            lanelet: lanelet.clone(),
            place: road.road.lanelets[place],
            deviation: road.road.deviation,
        };
        let user_data = if road.is_cut {
            vec![(PART_OF, lanelet.id.to_string())]
        } else {
            kept().written()
        };
        user_data.into_iter().try_for_each(|(code, value)| {
            out.empty("userData", &attributes!["code" = code, "value" = value])
        })
    })
}

fn signal(
    out: &mut XmlWriter,
    signal: &Signal,
    country: &str,
    lanes: usize,
) -> Result<(), WriteError> {
    let (s, t) = signal.place;
    let mut attributes = attributes![
        "s" = number(s),
        "t" = number(t),
        "id" = signal.id,
        "name" = signal.name,
        "dynamic" = if signal.is_dynamic { "yes" } else { "no" },
        "orientation" = "+",
        "zOffset" = "0.0",
        "type" = signal.kind,
        "subtype" = signal.subtype,
    ]
    .to_vec();
    if let Some((value, unit)) = signal.value {
        attributes.push(("value", number(value)));
        attributes.push(("unit", unit.to_string()));
    }
    out.element("signal", &attributes, |out| {
        // Without a validity it holds for all lanes.
        if signal.lanes.len() < lanes {
            signal.lanes.iter().try_for_each(|lane| {
                let id = lane_id(*lane);
                out.empty("validity", &attributes!["fromLane" = id, "toLane" = id])
            })?;
        }
        // Not the attribute: players look for a file of signs of that country.
        out.empty(
            "userData",
            &attributes!["code" = "country", "value" = country],
        )
    })
}
