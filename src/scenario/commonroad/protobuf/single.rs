//! The single message of 2020a.

use super::messages::{Region, ScenarioTags};
use super::report::{At, Report};
use super::wire::{Field, Fields};
use super::words::{ENVIRONMENT_2020A, OBSTACLE_TYPES};
use super::{doubts, header, obstacles, place, planning, references, road, words};
use crate::scenario::commonroad::ReadError;
use crate::scenario::{
    ContentHash, Header, Intersection, Lanelet, LaneletNetwork, Location, Obstacle, ObstacleParts,
    PlanningProblem, Scenario, Sign, TrafficLight,
};

/// What was read so far.
#[derive(Default)]
struct Found {
    header: Option<Header>,
    tags: Option<Vec<String>>,
    location: Option<Location>,
    lanelets: Vec<Lanelet>,
    signs: Vec<Sign>,
    lights: Vec<TrafficLight>,
    intersections: Vec<Intersection>,
    fixed: Vec<ObstacleParts>,
    moving: Vec<ObstacleParts>,
    environment: Vec<ObstacleParts>,
    phantom: Vec<ObstacleParts>,
    problems: Vec<PlanningProblem>,
}

/// Reads the message. Elements are decoded one after the other, so that no more than one of them is in memory twice.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<Scenario, ReadError> {
    let mut report = Report::about(file);
    let root = At::root("");
    let mut found = Found::default();
    for field in Fields::of(bytes) {
        let field = report.whole(&root, field)?;
        found.add(&mut report, &root, &field)?;
    }
    let header = report.need(&root, "information", found.header)?;
    let tags = report.need(&root, "scenario_tags", found.tags)?;
    let location = report.need(&root, "location", found.location)?;
    let network = LaneletNetwork::new(
        found.lanelets,
        found.signs,
        found.lights,
        found.intersections,
    );
    references::check(&mut report, &network, &root, &found.problems, &root);
    let roles = [found.fixed, found.moving, found.environment, found.phantom];
    let parts = roles.into_iter().flatten();
    let obstacles = parts.map(|parts| Obstacle::new(parts, header.time_step_size));
    let mut scenario = Scenario {
        obstacles: obstacles.collect(),
        header,
        location: Some(location),
        tags,
        network,
        planning_problems: found.problems,
        diagnostics: Vec::new(),
        hash: ContentHash::of(bytes),
    };
    doubts::note(&mut report, &doubts::ONE, &scenario);
    scenario.diagnostics = report.into_diagnostics();
    Ok(scenario)
}

impl Found {
    fn add(&mut self, r: &mut Report, root: &At<'_>, field: &Field<'_>) -> Result<(), ReadError> {
        let at = |name| root.field(name);
        match field.number {
            1 => r.part(
                &at("information"),
                field,
                &mut self.header,
                header::of_2020a,
            ),
            2 => r.part(&at("scenario_tags"), field, &mut self.tags, tags),
            3 => r.part(&at("location"), field, &mut self.location, |r, at, m| {
                place::location(r, at, m, &ENVIRONMENT_2020A)
            }),
            4 => r.element(
                &at("lanelets"),
                field,
                &mut self.lanelets,
                road::lanelet,
                |l| l.id,
            ),
            5 => r.element(
                &at("traffic_signs"),
                field,
                &mut self.signs,
                road::sign,
                |s| s.id,
            ),
            6 => r.element(
                &at("traffic_lights"),
                field,
                &mut self.lights,
                road::light,
                |l| l.id,
            ),
            7 => {
                let (at, into) = (at("intersections"), &mut self.intersections);
                r.element(&at, field, into, road::intersection, |i| i.id)
            }
            8 => {
                let (at, into) = (at("static_obstacles"), &mut self.fixed);
                r.element(&at, field, into, obstacles::fixed::<Region>, |o| o.id)
            }
            9 => {
                let (at, into) = (at("dynamic_obstacles"), &mut self.moving);
                r.element(&at, field, into, obstacles::moving::<Region>, |o| o.id)
            }
            10 => {
                let (at, into) = (at("environment_obstacles"), &mut self.environment);
                let read = |r: &mut Report, at: &At<'_>, m: &_| {
                    obstacles::environment(r, at, m, OBSTACLE_TYPES)
                };
                r.element(&at, field, into, read, |o| o.id)
            }
            11 => {
                let (at, into) = (at("phantom_obstacles"), &mut self.phantom);
                r.element(&at, field, into, obstacles::phantom, |o| o.id)
            }
            12 => {
                let (at, into) = (at("planning_problems"), &mut self.problems);
                r.element(&at, field, into, planning::problem, |p| p.id)
            }
            _ => {
                r.unknown(root, field);
                Ok(())
            }
        }
    }
}

fn tags(r: &mut Report, at: &At<'_>, message: &ScenarioTags) -> Result<Vec<String>, ReadError> {
    Ok(words::tags(r, at, &message.tags))
}
