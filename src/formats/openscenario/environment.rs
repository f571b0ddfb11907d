//! Weather, time of day and lights, where they are known.

use super::storyboard::Clock;
use crate::commonroad::WriteError;
use crate::commonroad::xml_writer::{XmlWriter, number};
use crate::opendrive::date;
use nearmiss_scene::scenario::{Environment, Scenario, SignalColor, TrafficLight};

/// The action that sets time and weather; nothing where neither is known.
pub fn write(out: &mut XmlWriter, scenario: &Scenario) -> Result<(), WriteError> {
    let Some(environment) = scenario
        .location
        .as_ref()
        .and_then(|l| l.environment.as_ref())
    else {
        return Ok(());
    };
    let clock = clock(environment);
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
fn clock(environment: &Environment) -> Option<String> {
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
pub fn signals(out: &mut XmlWriter, scenario: &Scenario, clock: Clock) -> Result<(), WriteError> {
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
