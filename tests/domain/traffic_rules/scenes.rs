//! A crossing of two roads, written by hand: the ego comes from the west along y = 0.
//!
//! Lanelets: 1 to 3 from west to east, 11 to 13 from south to north (from the ego's right), 21 to 23 from north to south,
//! 31 to 33 from east to west, 4 the ego's turn to the left. The square of the intersection is 12 m wide.

use std::fmt::Write;
use std::sync::Arc;

use nearmiss::formats::commonroad;
use nearmiss::geometry::{Footprint, Point, Shape};
use nearmiss::planner::{self, Forecast, RuleMode};
use nearmiss::scenario::{Ego, EgoSource, Sample, Scenario, Scene, Track};
use nearmiss::simulation::{Driver, Rollout, Settings, TrafficMode};
use nearmiss::traffic_rules::RuleReport;

/// Seconds between two steps.
pub const DT: f64 = 0.1;

/// A point or a motion by step, metres.
type Pair = (f64, f64);

/// A sign: number, value, lanelets.
type Sign = (&'static str, &'static str, Vec<i64>);

/// Steps and colours of a light.
type Phases = Vec<(i64, &'static str)>;

/// What is in the scene.
#[derive(Debug, Clone)]
pub struct Crossing {
    /// Signs on lanelets: number, value, lanelets.
    pub signs: Vec<Sign>,
    /// Phases (steps and colour) of a light on lanelet 1, and its offset.
    pub light: Option<(Phases, i64)>,
    /// Cars: id, where it is at step 0, metres along x and y a step.
    pub cars: Vec<(i64, Pair, Pair)>,
    /// Whether the map names the intersection.
    pub intersection: bool,
    /// The ego's speed at its start, m/s.
    pub speed: f64,
    /// Where it starts along x, metres.
    pub start: f64,
    /// The lanelet of its goal, and the last step.
    pub goal: (i64, i64),
}

impl Default for Crossing {
    fn default() -> Self {
        Self {
            signs: Vec::new(),
            light: None,
            cars: Vec::new(),
            intersection: true,
            speed: 10.0,
            start: -80.0,
            goal: (3, 300),
        }
    }
}

fn bound(out: &mut String, name: &str, points: &[(f64, f64)]) {
    write!(out, "<{name}>").unwrap();
    for (x, y) in points {
        write!(out, "<point><x>{x}</x><y>{y}</y></point>").unwrap();
    }
    write!(out, "</{name}>").unwrap();
}

/// A lanelet of 3.5 m along these points.
fn lanelet(
    out: &mut String,
    id: i64,
    points: &[(f64, f64)],
    (before, after): (&[i64], &[i64]),
    (signs, lights): (&[i64], &[i64]),
) {
    let side = |left: f64| -> Vec<(f64, f64)> {
        (0..points.len())
            .map(|i| {
                let (a, b) = (
                    points[i.saturating_sub(1)],
                    points[(i + 1).min(points.len() - 1)],
                );
                let (dx, dy) = (b.0 - a.0, b.1 - a.1);
                let length = dx.hypot(dy);
                let (x, y) = points[i];
                (x - left * dy / length, y + left * dx / length)
            })
            .collect()
    };
    write!(out, "<lanelet id=\"{id}\">").unwrap();
    bound(out, "leftBound", &side(1.75));
    bound(out, "rightBound", &side(-1.75));
    for id in before {
        write!(out, "<predecessor ref=\"{id}\"/>").unwrap();
    }
    for id in after {
        write!(out, "<successor ref=\"{id}\"/>").unwrap();
    }
    write!(out, "<laneletType>urban</laneletType>").unwrap();
    for id in signs {
        write!(out, "<trafficSignRef ref=\"{id}\"/>").unwrap();
    }
    for id in lights {
        write!(out, "<trafficLightRef ref=\"{id}\"/>").unwrap();
    }
    write!(out, "</lanelet>").unwrap();
}

fn line(from: (f64, f64), to: (f64, f64)) -> Vec<(f64, f64)> {
    let length = (to.0 - from.0).hypot(to.1 - from.1);
    let count = (length / 2.0).ceil().max(1.0);
    (0..=count as usize)
        .map(|i| {
            let t = i as f64 / count;
            (from.0 + (to.0 - from.0) * t, from.1 + (to.1 - from.1) * t)
        })
        .collect()
}

fn exact(name: &str, value: f64) -> String {
    format!("<{name}><exact>{value}</exact></{name}>")
}

fn state(tag: &str, step: i64, (x, y): (f64, f64), heading: f64, speed: f64) -> String {
    format!(
        "<{tag}><position><point><x>{x}</x><y>{y}</y></point></position>{}<time><exact>{step}</exact></time>{}{}{}</{tag}>",
        exact("orientation", heading),
        exact("velocity", speed),
        if tag == "initialState" {
            exact("yawRate", 0.0)
        } else {
            String::new()
        },
        if tag == "initialState" {
            exact("slipAngle", 0.0)
        } else {
            String::new()
        },
    )
}

impl Crossing {
    /// The scenario.
    pub fn scenario(&self) -> Arc<Scenario> {
        let xml = self.xml();
        Arc::new(commonroad::read(xml.as_bytes(), "crossing.xml").unwrap())
    }

    fn xml(&self) -> String {
        let mut out = String::from(
            "<?xml version=\"1.0\"?><commonRoad commonRoadVersion=\"2020a\" benchmarkID=\"ZAM_Rules-1_1_T-1\" date=\"2026-11-25\" author=\"t\" affiliation=\"t\" source=\"t\" timeStepSize=\"0.1\">",
        );
        let signs = |lanelet: i64| -> Vec<i64> {
            let of = self
                .signs
                .iter()
                .enumerate()
                .filter(|(_, (_, _, on))| on.contains(&lanelet));
            of.map(|(i, _)| 500 + i as i64).collect()
        };
        let roads: [(i64, Pair, Pair); 4] = [
            (1, (-150.0, 0.0), (150.0, 0.0)),
            (11, (1.75, -150.0), (1.75, 150.0)),
            (21, (-1.75, 150.0), (-1.75, -150.0)),
            (31, (150.0, 3.5), (-150.0, 3.5)),
        ];
        for (id, from, to) in roads {
            let along = |metres: f64| {
                let t = metres / 300.0;
                (from.0 + (to.0 - from.0) * t, from.1 + (to.1 - from.1) * t)
            };
            let lights: &[i64] = if id == 1 && self.light.is_some() {
                &[600]
            } else {
                &[]
            };
            let turns: &[i64] = if id == 1 { &[2, 4] } else { &[id + 1] };
            let ways = [
                (along(0.0), along(144.0)),
                (along(144.0), along(156.0)),
                (along(156.0), along(300.0)),
            ];
            let joins: &[i64] = if id == 11 { &[12, 4] } else { &[id + 1] };
            lanelet(
                &mut out,
                id,
                &line(ways[0].0, ways[0].1),
                (&[], turns),
                (&signs(id), lights),
            );
            lanelet(
                &mut out,
                id + 1,
                &line(ways[1].0, ways[1].1),
                (&[id], &[id + 2]),
                (&signs(id + 1), &[]),
            );
            lanelet(
                &mut out,
                id + 2,
                &line(ways[2].0, ways[2].1),
                (joins, &[]),
                (&signs(id + 2), &[]),
            );
        }
        // A quarter of an ellipse to the north.
        let turn: Vec<(f64, f64)> = (0..=12)
            .map(|i| {
                let (sin, cos) = (f64::from(i) * std::f64::consts::FRAC_PI_2 / 12.0).sin_cos();
                (-6.0 + 7.75 * sin, 6.0 - 6.0 * cos)
            })
            .collect();
        lanelet(&mut out, 4, &turn, (&[1], &[13]), (&[], &[]));
        for (i, (number, value, _)) in self.signs.iter().enumerate() {
            let value = match *value {
                "" => String::new(),
                value => format!("<additionalValue>{value}</additionalValue>"),
            };
            write!(out, "<trafficSign id=\"{}\"><trafficSignElement><trafficSignID>{number}</trafficSignID>{value}</trafficSignElement></trafficSign>", 500 + i).unwrap();
        }
        if let Some((phases, offset)) = &self.light {
            out += "<trafficLight id=\"600\"><cycle>";
            for (steps, color) in phases {
                write!(out, "<cycleElement><duration>{steps}</duration><color>{color}</color></cycleElement>").unwrap();
            }
            write!(out, "<timeOffset>{offset}</timeOffset></cycle><direction>all</direction><active>true</active></trafficLight>").unwrap();
        }
        if self.intersection {
            out += "<intersection id=\"700\">";
            for (i, (lanelet, straight)) in
                [(1, 2), (11, 12), (21, 22), (31, 32)].iter().enumerate()
            {
                let left = if *lanelet == 1 {
                    "<successorsLeft ref=\"4\"/>"
                } else {
                    ""
                };
                write!(out, "<incoming id=\"{}\"><incomingLanelet ref=\"{lanelet}\"/><successorsStraight ref=\"{straight}\"/>{left}</incoming>", 701 + i).unwrap();
            }
            out += "</intersection>";
        }
        for (id, from, (dx, dy)) in &self.cars {
            let (heading, speed) = (dy.atan2(*dx), dx.hypot(*dy) / DT);
            write!(out, "<dynamicObstacle id=\"{id}\"><type>car</type><shape><rectangle><length>4.5</length><width>1.8</width></rectangle></shape>").unwrap();
            out += &state("initialState", 0, *from, heading, speed);
            out += "<trajectory>";
            for step in 1..=self.goal.1 {
                let at = (from.0 + dx * step as f64, from.1 + dy * step as f64);
                out += &state("state", step, at, heading, speed);
            }
            out += "</trajectory></dynamicObstacle>";
        }
        out += "<planningProblem id=\"1\">";
        out += &state("initialState", 0, (self.start, 0.0), 0.0, self.speed);
        write!(out, "<goalState><time><intervalStart>0</intervalStart><intervalEnd>{}</intervalEnd></time><position><lanelet ref=\"{}\"/></position></goalState></planningProblem></commonRoad>", self.goal.1, self.goal.0).unwrap();
        out
    }

    /// The drive of the built-in planner, with its report.
    pub fn driven(&self, rules: RuleMode) -> (Rollout, RuleReport) {
        let settings = Settings {
            planner: planner::Settings {
                rules,
                ..planner::Settings::default()
            },
            forecast: Forecast::Lane,
            replan: 1,
            without: None,
            traffic: TrafficMode::Recorded,
            policy: None,
        };
        let scenario = self.scenario();
        let problem = &scenario.planning_problems[0];
        let driver = Driver::new(&scenario, problem, &settings).unwrap();
        let drive = driver.drive(&scenario, &driver.full_span());
        let report = drive.rules(&scenario, problem, &settings);
        (drive, report)
    }

    /// The report of an ego that drives along y = 0 with this speed (m/s) at each step.
    pub fn recorded(&self, speeds: impl IntoIterator<Item = f64>) -> RuleReport {
        let mut x = self.start;
        let mut samples = Vec::new();
        for (step, speed) in speeds.into_iter().enumerate() {
            samples.push(Sample {
                step: step as i64,
                position: Point::new(x, 0.0),
                heading: Some(0.0),
                velocity: Some(speed),
                acceleration: None,
            });
            x += speed * DT;
        }
        let ego = Ego {
            id: 1,
            source: EgoSource::Planned {
                planner: None,
                vehicle: "bmw".into(),
                forecast: "none".into(),
                planning_problem: 1,
            },
            footprint: Footprint::new(Shape::rectangle(4.5, 1.8)).unwrap(),
            track: Track::new(samples, DT, None),
            recorded: Vec::new(),
            diagnostics: Vec::new(),
        };
        RuleReport::from_scene(&Scene::new(self.scenario(), ego))
    }
}

/// Where the front of a drive's body is at each step, along x.
pub fn fronts(drive: &Rollout) -> Vec<(i64, f64, f64)> {
    let half = drive.limits.length / 2.0;
    let states = drive.states.iter();
    states
        .map(|(step, state)| {
            let centre = state.centre(&drive.limits);
            (*step, centre.pose.position.x + half, centre.velocity)
        })
        .collect()
}
