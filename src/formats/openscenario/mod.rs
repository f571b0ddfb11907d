//! OpenSCENARIO XML: a scenario for simulators, with its road network as OpenDRIVE, weather, time of day and lights.

mod actor;
pub(super) mod entities;
mod formula;
mod storyboard;
mod varied;

pub use actor::ExportedEgo;
pub(super) use actor::{Actor, Notes, SINGLE_STATES, actors};
pub use formula::Formula;
pub use varied::{VariedMotion, VariedParameter, VariedVertex};

use std::collections::BTreeMap;
use std::sync::Arc;

use nearmiss_scene::scenario::{
    Ego, Environment, LaneletNetwork, Scenario, Scene, SignalColor, TrafficLight, driven_way,
};

use super::commonroad::writer::{XmlWriter, number};
use super::commonroad::{WriteError, write};
use super::opendrive::{date, write_opendrive};
use storyboard::Clock;

/// A scenario as it is exported.
#[derive(Debug, Clone, Copy)]
pub struct Export<'a> {
    /// The scenario.
    pub scenario: &'a Scenario,
    /// Its ego.
    pub ego: ExportedEgo<'a>,
    /// The name of the file with the roads, beside the scenario's.
    pub road_file: &'a str,
    /// More that is known of obstacles, by id: names and values.
    pub properties: &'a BTreeMap<i64, Vec<(String, String)>>,
    /// More that is known of the scenario: names and values.
    pub about: &'a [(String, String)],
    /// An obstacle whose motion follows from parameters.
    pub varied: Option<&'a VariedMotion>,
}

/// The two files of an export.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// OpenSCENARIO XML 1.2, in UTF-8.
    pub scenario: Vec<u8>,
    /// OpenDRIVE 1.7, in UTF-8.
    pub roads: Vec<u8>,
    /// What the formats cannot say, or say differently, one sentence each.
    pub notes: Vec<String>,
    /// How far borders of lanes are at most from those of the lanelets, metres.
    pub deviation: f64,
}

/// Writes a scenario as OpenSCENARIO XML 1.2 with OpenDRIVE 1.7. The same scenario gives the same bytes.
///
/// Entities are called as their obstacles, the ego `ego`. The position of an entity is that of CommonRoad: the middle of
/// its body. Time 0 is time step 0, or the first one if that is earlier.
///
/// # Errors
/// None in practice: writing goes to memory.
pub fn write_openscenario(export: &Export<'_>) -> Result<Exported, WriteError> {
    let scenario = export.scenario;
    let mut notes = Notes::default();
    let mut all = actors(scenario, export.ego, &mut notes);
    for actor in &mut all {
        let id: Option<i64> = match actor.name.as_str() {
            "ego" => None,
            name => name.parse().ok(),
        };
        let more = id.and_then(|id| export.properties.get(&id));
        actor.properties.extend(more.into_iter().flatten().cloned());
        let varied = export.varied.filter(|varied| Some(varied.obstacle) == id);
        if let Some(varied) = varied {
            actor.vary(&varied.vertices);
        }
    }
    let mut clock = clock(scenario, &all);
    if let ExportedEgo::Follows(ego) = export.ego
        && let Some(last) = contact_at_end(scenario, ego).filter(|last| *last < clock.last)
    {
        // Players report an error where an entity vanishes that touches another one.
        clock.last = last.max(clock.origin + 1);
        notes.ended = true;
    }
    let roads = write_opendrive(scenario)?;
    let mut sentences = roads.notes.clone();
    sentences.extend(notes.sentences());
    if clock.origin < 0 {
        sentences.push(format!("time 0 is step {}", clock.origin));
    }
    if matches!(export.ego, ExportedEgo::Missing) {
        sentences
            .push("no ego: none is recorded beside it; --ego ID or --ego planner adds one".into());
    }
    if !scenario.network.areas.is_empty() {
        sentences.push("drivable areas are left out".into());
    }
    if !scenario.planning_problems.is_empty() {
        sentences.push("goals of planning problems are properties".into());
    }
    Ok(Exported {
        scenario: bytes(export, &all, clock)?,
        roads: roads.bytes,
        notes: sentences,
        deviation: roads.deviation,
    })
}

/// The last step of an ego that touches an obstacle then, or on the way there.
fn contact_at_end(scenario: &Scenario, ego: &Ego) -> Option<i64> {
    let last = ego.track.steps().end - 1;
    let scene = Scene::new(Arc::new(scenario.clone()), ego.clone());
    let own = scene.ego_at(last)?;
    let touches = |p: nearmiss_scene::scenario::Participant<'_>| {
        let at_last = |other| own.distance(&other) <= CONTACT;
        let on_the_way = || {
            let (before, dt) = (last - 1, scenario.dt());
            let own = driven_way(scene.ego_at(before)?, own, dt)?;
            let other = driven_way(p.placed_at(before)?, p.placed_at(last)?, dt)?;
            own.first_touch(&other)
        };
        p.placed_at(last).is_some_and(at_last) || on_the_way().is_some()
    };
    scene.participants().any(touches).then_some(last)
}

/// Bodies as near as this may touch in a player, metres.
const CONTACT: f64 = 0.01;

fn clock(scenario: &Scenario, actors: &[Actor]) -> Clock {
    let moving = actors.iter().filter(|a| !a.stands && !a.is_free);
    let steps = moving.flat_map(|a| a.stretches.iter().flatten().map(|(step, _)| *step));
    let (first, last) = steps.fold((0, 0), |(low, high), s| (low.min(s), high.max(s)));
    // A free ego drives at least until its goal's time is over.
    let free = actors.iter().any(|a| a.is_free);
    let goals = scenario.planning_problems.iter().flat_map(|p| &p.goals);
    let goal = goals.map(|g| g.time.to).max().filter(|_| free && last == 0);
    Clock {
        dt: scenario.dt(),
        origin: first,
        last: goal
            .unwrap_or(last)
            .clamp(last, last + 10_000)
            .max(first + 1),
    }
}

fn bytes(export: &Export<'_>, actors: &[Actor], clock: Clock) -> Result<Vec<u8>, WriteError> {
    let scenario = export.scenario;
    let mut out = XmlWriter::begun()?;
    out.comment(" Written by nearmiss. Positions of entities are the middle of their bodies. ")?;
    let header = &scenario.header;
    let of = |name: &str| header.attributes.get(name).cloned().unwrap_or_default();
    let attributes = [
        ("revMajor", "1".into()),
        ("revMinor", "2".into()),
        ("date", date(scenario)),
        ("description", header.benchmark_id.clone()),
        ("author", of("author")),
    ];
    out.element("OpenSCENARIO", &[], |out| {
        out.element("FileHeader", &attributes, |out| {
            out.element("Properties", &[], |out| {
                let kept = (DOCUMENT.to_string(), document(scenario)?);
                let mut all = about(export, clock).into_iter().chain([kept]);
                all.try_for_each(|(name, value)| {
                    out.empty("Property", &[("name", name), ("value", value)])
                })
            })
        })?;
        if let Some(varied) = export.varied {
            varied.declare(out)?;
        }
        out.empty("CatalogLocations", &[])?;
        out.element("RoadNetwork", &[], |out| {
            out.empty("LogicFile", &[("filepath", export.road_file.to_string())])?;
            write_signals(out, scenario, clock)
        })?;
        out.element("Entities", &[], |out| {
            actors.iter().try_for_each(|a| entities::entity(out, a))
        })?;
        storyboard::storyboard(out, scenario, actors, clock)
    })?;
    Ok(out.finished())
}

/// The property with a CommonRoad document of what has no place elsewhere.
pub(super) const DOCUMENT: &str = "commonroad_document";

/// A CommonRoad document without lanelets and obstacles: planning problems, signs, lights, intersections, place and
/// authors.
fn document(scenario: &Scenario) -> Result<String, WriteError> {
    let roads = &scenario.network;
    let rest = Scenario {
        header: scenario.header.clone(),
        location: scenario.location.clone(),
        tags: scenario.tags.clone(),
        network: LaneletNetwork::new(
            Vec::new(),
            roads.signs.clone(),
            roads.lights.clone(),
            roads.intersections.clone(),
        ),
        obstacles: Vec::new(),
        planning_problems: scenario.planning_problems.clone(),
        recorded_ego: None,
        diagnostics: Vec::new(),
        hash: scenario.hash,
    };
    let text = String::from_utf8_lossy(&write(&rest)?).into_owned();
    // Lines and indents have no meaning in it.
    Ok(text.lines().map(str::trim).collect())
}

/// What is known of the scenario as a whole.
fn about(export: &Export<'_>, clock: Clock) -> Vec<(String, String)> {
    let scenario = export.scenario;
    let mut all = vec![
        (
            "commonroad_benchmark_id".to_string(),
            scenario.header.benchmark_id.clone(),
        ),
        (
            "commonroad_time_step".to_string(),
            scenario.dt().to_string(),
        ),
    ];
    if clock.origin != 0 {
        let first = clock.origin.to_string();
        all.push(("commonroad_first_step".to_string(), first));
    }
    for name in ["affiliation", "source"] {
        let value = scenario
            .header
            .attributes
            .get(name)
            .filter(|v| !v.is_empty());
        all.extend(value.map(|v| (format!("commonroad_{name}"), v.clone())));
    }
    if !scenario.tags.is_empty() {
        all.push(("commonroad_tags".to_string(), scenario.tags.join(" ")));
    }
    for problem in &scenario.planning_problems {
        for (i, goal) in problem.goals.iter().enumerate() {
            let positions = serde_json::to_string(&goal.positions).unwrap_or_default();
            all.push((
                format!("commonroad_goal_{}_{i}", problem.id),
                format!("steps {} to {}, {positions}", goal.time.from, goal.time.to),
            ));
        }
    }
    all.extend(export.about.iter().cloned());
    all
}

/// The action that sets time and weather; nothing where neither is known.
fn write_environment(out: &mut XmlWriter, scenario: &Scenario) -> Result<(), WriteError> {
    let Some(environment) = scenario
        .location
        .as_ref()
        .and_then(|l| l.environment.as_ref())
    else {
        return Ok(());
    };
    let clock = time_of_day(environment);
    let weather = weather(environment.weather.as_deref());
    let wet = matches!(
        environment.underground.as_deref(),
        Some("wet" | "ice" | "snow")
    );
    if clock.is_none() && weather.is_none() && !wet {
        return Ok(());
    }
    let name = [("name", "environment".to_string())];
    out.element("GlobalAction", &[], |out| {
        out.element("EnvironmentAction", &[], |out| {
            out.element("Environment", &name, |out| {
                if let Some(clock) = &clock {
                    let date = date(scenario);
                    let day = date.split('T').next().unwrap_or_default();
                    let time = [
                        ("animation", "false".into()),
                        ("dateTime", format!("{day}T{clock}")),
                    ];
                    out.empty("TimeOfDay", &time)?;
                }
                if let Some(weather) = weather {
                    let clouds = [("fractionalCloudCover", weather.clouds.to_string())];
                    out.element("Weather", &clouds, |out| {
                        if let Some(range) = weather.visual_range {
                            out.empty("Fog", &[("visualRange", number(range))])?;
                        }
                        let falling = [
                            ("precipitationIntensity", number(weather.intensity)),
                            ("precipitationType", weather.falling.to_string()),
                        ];
                        out.empty("Precipitation", &falling)
                    })?;
                }
                if !wet {
                    return Ok(());
                }
                out.element(
                    "RoadCondition",
                    &[("frictionScaleFactor", "1.0".into())],
                    |out| {
                        let word = environment.underground.clone().unwrap_or_default();
                        let property = [("name", "underground".into()), ("value", word)];
                        out.element("Properties", &[], |out| out.empty("Property", &property))
                    },
                )
            })
        })
    })
}

/// The time of day, `hh:mm:ss`: the clock's, or noon and midnight for day and night.
fn time_of_day(environment: &Environment) -> Option<String> {
    let written = environment.time.as_deref().filter(|t| {
        let parts: Vec<&str> = t.split(':').collect();
        let below =
            |text: &str, most: u32| text.len() == 2 && text.parse::<u32>().is_ok_and(|n| n < most);
        matches!(parts[..], [h, m, s] if below(h, 24) && below(m, 60) && below(s, 60))
    });
    match (written, environment.time_of_day.as_deref()) {
        // Files write midnight where they know nothing.
        (Some("00:00:00") | None, Some("day" | "noon")) => Some("12:00:00".into()),
        (_, Some("night")) if written.is_none() => Some("00:00:00".into()),
        (Some(time), Some(word)) if word != "unknown" => Some(time.into()),
        (Some(time), _) if time != "00:00:00" => Some(time.into()),
        _ => None,
    }
}

struct Weather {
    clouds: &'static str,
    falling: &'static str,
    /// mm/h.
    intensity: f64,
    /// Metres.
    visual_range: Option<f64>,
}

fn weather(word: Option<&str>) -> Option<Weather> {
    let (clouds, falling, intensity, visual_range) = match word? {
        "sunny" | "clear" => ("zeroOktas", "dry", 0.0, None),
        "light_rain" => ("sixOktas", "rain", 1.0, None),
        "mid_rain" => ("sevenOktas", "rain", 5.0, None),
        "heavy_rain" => ("eightOktas", "rain", 10.0, None),
        "fog" => ("eightOktas", "dry", 0.0, Some(100.0)),
        "snow" => ("eightOktas", "snow", 2.0, None),
        // There is no hail in the format.
        "hail" => ("eightOktas", "snow", 10.0, None),
        _ => return None,
    };
    Some(Weather {
        clouds,
        falling,
        intensity,
        visual_range,
    })
}

/// The controllers of traffic lights, one for each: their phases from time 0 on.
fn write_signals(out: &mut XmlWriter, scenario: &Scenario, clock: Clock) -> Result<(), WriteError> {
    let lanelets = &scenario.network.lanelets;
    let placed = |light: &&TrafficLight| lanelets.iter().any(|l| l.lights.contains(&light.id));
    let lights: Vec<&TrafficLight> = scenario.network.lights.iter().filter(placed).collect();
    if lights.is_empty() {
        return Ok(());
    }
    out.element("TrafficSignals", &[], |out| {
        lights.iter().try_for_each(|light| {
            let name = [("name", format!("light {}", light.id))];
            out.element("TrafficSignalController", &name, |out| {
                let phases = phases(light, clock.origin);
                let all = phases.iter().enumerate();
                all.into_iter().try_for_each(|(i, (steps, color))| {
                    let phase = [
                        ("name", format!("{} {i}", color.name())),
                        ("duration", number(*steps as f64 * clock.dt)),
                    ];
                    let state = [
                        ("trafficSignalId", light.id.to_string()),
                        ("state", lamps(*color).to_string()),
                    ];
                    out.element("Phase", &phase, |out| {
                        out.empty("TrafficSignalState", &state)
                    })
                })
            })
        })
    })
}

/// Red, yellow and green lamp.
fn lamps(color: SignalColor) -> &'static str {
    match color {
        SignalColor::Red => "on;off;off",
        SignalColor::RedYellow => "on;on;off",
        SignalColor::Yellow => "off;on;off",
        SignalColor::Green => "off;off;on",
        SignalColor::Inactive => "off;off;off",
    }
}

/// The phases of a light from a step on: as long as its cycle, and the one that runs then cut in two.
fn phases(light: &TrafficLight, from: i64) -> Vec<(i64, SignalColor)> {
    let cycle: Vec<(i64, SignalColor)> = light
        .cycle
        .iter()
        .filter(|p| p.duration > 0)
        .map(|p| (p.duration, p.color))
        .collect();
    let whole: i128 = cycle.iter().map(|(d, _)| i128::from(*d)).sum();
    if !light.active || whole == 0 {
        return vec![(1, SignalColor::Inactive)];
    }
    let mut gone = (i128::from(from) - i128::from(light.offset)).rem_euclid(whole);
    let mut rotated: Vec<(i64, SignalColor)> = Vec::new();
    let mut before = Vec::new();
    for (duration, color) in cycle {
        let past = gone.min(i128::from(duration));
        gone -= past;
        let past = i64::try_from(past).unwrap_or(0);
        if past > 0 {
            before.push((past, color));
        }
        if duration > past {
            rotated.push((duration - past, color));
        }
    }
    rotated.extend(before);
    rotated
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_scene::scenario::LightPhase;

    #[test]
    fn phases_from_time_0_show_what_the_light_shows() {
        let phase = |duration, color| LightPhase { duration, color };
        let light = TrafficLight {
            id: 1,
            position: None,
            active: true,
            direction: None,
            offset: 3,
            cycle: vec![phase(4, SignalColor::Red), phase(6, SignalColor::Green)],
        };
        let mut step = 0;
        for (duration, color) in phases(&light, 0).iter().cycle().take(9) {
            for _ in 0..*duration {
                assert_eq!(light.color_at(step), *color, "step {step}");
                step += 1;
            }
        }
    }
}
