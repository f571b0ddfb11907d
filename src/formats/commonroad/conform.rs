//! Makes a scenario conform to the schema of version 2020a, and reports what that changed.
//!
//! Real files hold what the schema has no place for: intersections without roads, signs without meaning, dangling
//! references, states without a heading. A scenario is written as it is; callers that need a file a validator accepts
//! run this first.

use std::collections::HashSet;

use nearmiss_base::geometry::Shape;
use nearmiss_scene::scenario::{
    Goal, Intersection, Lanelet, LaneletNetwork, LaneletType, Location, Obstacle, ObstacleParts,
    ObstacleRole, ObstacleType, PlanningProblem, Position, Prediction, Quantity, Referable,
    Scenario, Sign, State, StateField, Steps, TrafficLight,
};

use crate::commonroad::road;

/// A scenario that fits the schema as far as it can.
#[derive(Debug, Clone, PartialEq)]
pub struct Conformed {
    /// The scenario, restricted to what the format can hold.
    pub scenario: Scenario,
    /// Omissions, defaults and replacements, one sentence each.
    pub changes: Vec<String>,
    /// Schema violations that only the author can fix, one sentence each.
    pub violations: Vec<String>,
}

/// The report in the making.
#[derive(Default)]
struct Report {
    changes: Vec<String>,
    violations: Vec<String>,
}

impl Report {
    fn change(&mut self, sentence: String) {
        self.changes.push(sentence);
    }

    fn violation(&mut self, sentence: String) {
        self.violations.push(sentence);
    }
}

/// The tags of the schema.
#[rustfmt::skip]
const TAGS: [&str; 28] = [
    "interstate", "highway", "urban", "comfort", "critical", "evasive", "cut_in", "illegal_cutin",
    "intersection", "lane_change", "lane_following", "merging_lanes", "multi_lane",
    "no_oncoming_traffic", "oncoming_traffic", "parallel_lanes", "race_track", "roundabout", "rural",
    "simulated", "single_lane", "slip_road", "speed_limit", "traffic_jam", "turn_left",
    "turn_right", "two_lane", "emergency_braking",
];

/// Whether the schema has this tag.
pub(super) fn is_tag(tag: &str) -> bool {
    TAGS.contains(&tag)
}

/// Fits a scenario to the published schema of version 2020a.
#[must_use]
pub fn conform(scenario: &Scenario) -> Conformed {
    let mut report = Report::default();
    let mut fitted = scenario.clone();
    header(&mut fitted, &mut report);
    let network = &scenario.network;
    fitted.network = conform_network(network, &mut report);
    fitted.obstacles = scenario
        .obstacles
        .iter()
        .map(|o| conform_obstacle(o, scenario.dt(), &mut report))
        .collect();
    let problems = &mut fitted.planning_problems;
    problems
        .iter_mut()
        .for_each(|p| conform_problem(p, &fitted.network, &mut report));
    if problems.is_empty() {
        report.violation("no planning problem, but the schema requires one".into());
    }
    if fitted.network.lanelets.is_empty() {
        report.violation("no lanelet, but the schema requires one".into());
    }
    ids(&fitted, &mut report);
    Conformed {
        scenario: fitted,
        changes: report.changes,
        violations: report.violations,
    }
}

fn header(scenario: &mut Scenario, report: &mut Report) {
    scenario.header.version = "2020a".into();
    let attributes = &mut scenario.header.attributes;
    attributes.retain(|name, _| {
        let known = ["date", "author", "affiliation", "source"].contains(&name.as_str());
        if !known {
            report.change(format!("the attribute `{name}` was left out"));
        }
        known
    });
    for name in ["author", "affiliation", "source"] {
        attributes.entry(name.into()).or_insert_with(|| {
            report.change(format!("no {name}; left empty"));
            String::new()
        });
    }
    let date = attributes.get("date").map(String::as_str);
    if !date.is_some_and(is_date) {
        report.violation(format!(
            "the date is `{}`; the schema requires one like 2026-01-31",
            date.unwrap_or_default()
        ));
    }
    let mut seen = HashSet::new();
    scenario.tags.retain(|tag| {
        let keep = is_tag(tag) && seen.insert(tag.clone());
        if !keep {
            report.change(format!("the tag `{tag}` was left out"));
        }
        keep
    });
    match &mut scenario.location {
        None => {
            report.change("no location; written as unknown".into());
            scenario.location = Some(Location::default());
        }
        Some(location) => place(location, report),
    }
}

fn is_date(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let digits =
        |text: &str, count: usize| text.len() == count && text.bytes().all(|b| b.is_ascii_digit());
    let within = |text: &str, most: u32| text.parse().is_ok_and(|n: u32| (1..=most).contains(&n));
    matches!(parts.as_slice(), [year, month, day]
        if digits(year, 4) && digits(month, 2) && digits(day, 2) && within(month, 12) && within(day, 31))
}

fn place(location: &mut Location, report: &mut Report) {
    if let Some(transformation) = &mut location.transformation {
        let whole = [
            transformation.x,
            transformation.y,
            transformation.rotation,
            transformation.scaling,
        ];
        if transformation.reference.is_none() || whole.contains(&None) {
            report.change("the geo transformation was completed with defaults".into());
            transformation.reference.get_or_insert_default();
            transformation.x.get_or_insert(0.0);
            transformation.y.get_or_insert(0.0);
            transformation.rotation.get_or_insert(0.0);
            transformation.scaling.get_or_insert(1.0);
        }
    }
    let fits = location.environment.as_ref().is_none_or(|environment| {
        let word = |word: &Option<String>, known: &[&str]| {
            word.as_deref().is_some_and(|w| known.contains(&w))
        };
        let clock = environment.time.as_deref().is_some_and(|t| t.len() == 8);
        let weather = ["sunny", "light_rain", "heavy_rain", "fog", "snow", "hail"];
        let underground = ["wet", "clean", "dirty", "damaged", "snow", "ice"];
        clock
            && word(&environment.time_of_day, &["unknown", "night", "day"])
            && word(&environment.weather, &weather)
            && word(&environment.underground, &underground)
    });
    if !fits {
        report.change("the environment (time, weather, underground) was left out".into());
        location.environment = None;
    }
}

/// Ids must be positive and unique, also among incomings.
fn ids(scenario: &Scenario, report: &mut Report) {
    let mut seen = HashSet::new();
    let network: &LaneletNetwork = &scenario.network;
    let road = network.lanelets.iter().map(|l| l.id);
    let signs = network.signs.iter().map(|s| s.id);
    let lights = network.lights.iter().map(|l| l.id);
    let intersections = network
        .intersections
        .iter()
        .flat_map(|i| std::iter::once(i.id).chain(i.incomings.iter().map(|r| r.id)));
    let obstacles = scenario.obstacles.iter().map(|o| o.id);
    let problems = scenario.planning_problems.iter().map(|p| p.id);
    let all = road.chain(signs).chain(lights).chain(intersections);
    for id in all.chain(obstacles).chain(problems) {
        if id < 1 {
            report.violation(format!("id {id} is not positive"));
        } else if !seen.insert(id) {
            report.violation(format!("id {id} is used twice"));
        }
    }
}

/// Quantities that states of the schema do not have.
const BEYOND_SCHEMA: [StateField; 9] = [
    StateField::SteeringAngleSpeed,
    StateField::AccelerationY,
    StateField::CurvatureRate,
    StateField::FrontWheelAngularSpeed,
    StateField::RearWheelAngularSpeed,
    StateField::LongitudinalPosition,
    StateField::LateralPosition,
    StateField::JerkDot,
    StateField::KappaDotDot,
];

fn conform_obstacle(obstacle: &Obstacle, dt: f64, report: &mut Report) -> Obstacle {
    let mut fitted = obstacle.parts();
    let name = format!("{} obstacle {}", obstacle.role, obstacle.id);
    if !may_be(fitted.role, fitted.kind) {
        report.change(format!("{name}: the type {} became unknown", fitted.kind));
        fitted.kind = ObstacleType::Unknown;
    }
    if let Some(initial) = &mut fitted.initial {
        state(initial, &name, report);
        // The schema has the hitch angle in states of a trajectory only.
        drop_fields(initial, &[StateField::HitchAngle], &name, report);
        if initial.time != Steps::exact(0) {
            report.violation(format!("{name}: its initial state is not at time step 0"));
        }
    }
    if let Prediction::Trajectory(states) = &mut fitted.prediction {
        let before = states.len();
        states.retain(|s| s.time.from > 0);
        if states.len() < before {
            report.change(format!("{name}: states before time step 1 were left out"));
        }
        states.iter_mut().for_each(|s| state(s, &name, report));
    }
    let signals_fit = fitted.role == ObstacleRole::Dynamic;
    if !signals_fit && !fitted.signals.is_empty() {
        report.change(format!("{name}: its signals were left out"));
        fitted.signals.clear();
    }
    check(&fitted, &name, report);
    Obstacle::new(fitted, dt)
}

fn may_be(role: ObstacleRole, kind: ObstacleType) -> bool {
    use ObstacleType as Type;
    match role {
        ObstacleRole::Static => matches!(
            kind,
            Type::Unknown | Type::ParkedVehicle | Type::ConstructionZone | Type::RoadBoundary
        ),
        ObstacleRole::Dynamic => !matches!(
            kind,
            Type::ParkedVehicle
                | Type::ConstructionZone
                | Type::RoadBoundary
                | Type::Building
                | Type::Pillar
                | Type::MedianStrip
        ),
        ObstacleRole::Environment => matches!(
            kind,
            Type::Unknown | Type::Building | Type::Pillar | Type::MedianStrip
        ),
        ObstacleRole::Phantom => true,
    }
}

/// The missing properties of the obstacle.
fn check(obstacle: &ObstacleParts, name: &str, report: &mut Report) {
    let mut lacks = |what: &str| report.violation(format!("{name} has no {what}"));
    if obstacle.role != ObstacleRole::Phantom && obstacle.footprint.is_none() {
        lacks("shape");
    }
    let bodily = matches!(obstacle.role, ObstacleRole::Static | ObstacleRole::Dynamic);
    if bodily && obstacle.initial.is_none() {
        lacks("initial state");
    }
    let empty = match &obstacle.prediction {
        Prediction::None => true,
        Prediction::Trajectory(states) => states.is_empty(),
        Prediction::Occupancies(occupancies) => occupancies.is_empty(),
    };
    if empty && matches!(obstacle.role, ObstacleRole::Dynamic | ObstacleRole::Phantom) {
        lacks("trajectory or occupancy set");
    }
}

fn state(state: &mut State, name: &str, report: &mut Report) {
    drop_fields(state, &BEYOND_SCHEMA, name, report);
    if state.orientation.is_none()
        && let Some(velocity) = state.point_mass_velocity()
    {
        report.change(format!(
            "{name}, step {}: the heading was filled in from the velocity",
            state.time.from
        ));
        let heading = velocity.y.atan2(velocity.x);
        state.orientation = Some(Quantity::Exact(heading));
        state.velocity = Some(Quantity::Exact(velocity.norm()));
        state
            .more
            .retain(|(field, _)| *field != StateField::VelocityY);
    }
    if state.position.is_none() || state.orientation.is_none() {
        report.violation(format!(
            "{name}, step {}: a state needs position and orientation",
            state.time.from
        ));
    }
}

fn drop_fields(state: &mut State, fields: &[StateField], name: &str, report: &mut Report) {
    let step = state.time.from;
    state.more.retain(|(field, _)| {
        let fits = !fields.contains(field);
        if !fits {
            report.change(format!("{name}, step {step}: {field} was left out"));
        }
        fits
    });
}

fn conform_problem(problem: &mut PlanningProblem, network: &LaneletNetwork, report: &mut Report) {
    let name = format!("planning problem {}", problem.id);
    let initial = &mut problem.initial;
    let fits = |field: StateField| matches!(field, StateField::YawRate | StateField::SlipAngle);
    initial.more.retain(|(field, _)| {
        if !fits(*field) {
            report.change(format!("{name}: {field} was left out"));
        }
        fits(*field)
    });
    for field in [StateField::YawRate, StateField::SlipAngle] {
        if initial.quantity(field).is_none() {
            report.change(format!("{name}: {field} was filled in as 0"));
            initial.more.push((field, Quantity::Exact(0.0)));
        }
    }
    for (quantity, what) in [
        (&mut initial.velocity, "velocity"),
        (&mut initial.orientation, "orientation"),
    ] {
        if quantity.is_none() {
            report.change(format!("{name}: {what} was filled in as 0"));
            *quantity = Some(Quantity::Exact(0.0));
        }
    }
    if initial.point().is_none() {
        report.violation(format!("{name}: its initial position is not a point"));
    }
    if initial.time != Steps::exact(0) {
        report.violation(format!("{name}: does not start at time step 0"));
    }
    if problem.goals.is_empty() {
        report.violation(format!("{name} has no goal"));
    }
    problem
        .goals
        .iter_mut()
        .for_each(|g| goal(g, network, &name, report));
}

fn goal(goal: &mut Goal, network: &LaneletNetwork, name: &str, report: &mut Report) {
    if goal.time.from < 0 || goal.time.to < 1 {
        report.violation(format!("{name}: a goal that ends before time step 1"));
    }
    for quantity in [&mut goal.orientation, &mut goal.velocity] {
        if let Some(Quantity::Exact(value)) = *quantity {
            *quantity = Some(Quantity::Interval(value, value));
        }
    }
    let mut lanelets = goal.lanelets();
    let count = lanelets.len();
    lanelets.retain(|id| network.lanelet(*id).is_some());
    if lanelets.len() < count {
        report.change(format!("{name}: missing goal lanelets were left out"));
    }
    let mut regions = Vec::new();
    for position in goal.positions.drain(..) {
        match position {
            Position::Region(Shape::Group(members)) => regions.extend(members),
            Position::Region(region) => regions.push(region),
            Position::Point(_) => {
                report.violation(format!("{name}: the goal is a point, not a region"));
            }
            Position::Lanelets(_) => {}
        }
    }
    // The schema has one position in a goal, of lanelets or of shapes of one kind.
    if !lanelets.is_empty() {
        if !regions.is_empty() {
            report.change(format!(
                "{name}: goal regions beside goal lanelets were left out"
            ));
        }
        goal.positions.push(Position::Lanelets(lanelets));
    } else if regions.len() == 1 {
        goal.positions.extend(regions.pop().map(Position::Region));
    } else if !regions.is_empty() {
        goal.positions.push(Position::Region(Shape::Group(regions)));
    }
}

fn conform_network(network: &LaneletNetwork, report: &mut Report) -> LaneletNetwork {
    let signs: Vec<Sign> = network
        .signs
        .iter()
        .filter_map(|s| sign(s, report))
        .collect();
    let lights: Vec<TrafficLight> = network
        .lights
        .iter()
        .filter_map(|l| light(l, report))
        .collect();
    let known = Referable::new(&network.lanelets, &signs, &lights);
    let lanelets = network
        .lanelets
        .iter()
        .map(|l| lanelet(l, &known, report))
        .collect();
    let intersections = network
        .intersections
        .iter()
        .filter_map(|i| intersection(i, &known, report))
        .collect();
    LaneletNetwork::new(lanelets, signs, lights, intersections)
}

fn lanelet(lanelet: &Lanelet, known: &Referable, report: &mut Report) -> Lanelet {
    let mut fitted = lanelet.clone();
    let name = format!("lanelet {}", lanelet.id);
    fitted.keep_references(known, &mut |gone| report.change(gone));
    if fitted.types.contains(&LaneletType::Tram) {
        report.change(format!("{name}: the type tram became unknown"));
        for kind in &mut fitted.types {
            if *kind == LaneletType::Tram {
                *kind = LaneletType::Unknown;
            }
        }
    }
    if fitted.types.is_empty() {
        report.change(format!("{name}: no type; written as unknown"));
        fitted.types.push(LaneletType::Unknown);
    }
    fitted
}

fn sign(sign: &Sign, report: &mut Report) -> Option<Sign> {
    let mut fitted = sign.clone();
    fitted.elements.retain(|element| {
        let known = road::in_schema(&element.id);
        if !known {
            let words = format!("sign {}: `{}` is not in the schema", sign.id, element.id);
            report.change(words + " and was left out");
        }
        known
    });
    if fitted.elements.is_empty() {
        report.change(format!("sign {} without elements was left out", sign.id));
        return None;
    }
    Some(fitted)
}

fn light(light: &TrafficLight, report: &mut Report) -> Option<TrafficLight> {
    let mut fitted = light.clone();
    fitted.cycle.retain(|phase| phase.duration > 0);
    if fitted.cycle.len() < light.cycle.len() {
        report.change(format!(
            "light {}: phases without duration were left out",
            light.id
        ));
    }
    if fitted.cycle.is_empty() {
        report.change(format!("light {} without a cycle was left out", light.id));
        return None;
    }
    if fitted.offset < 0 {
        // A cycle repeats for ever, so that a negative offset has a positive twin.
        let period: i64 = fitted.cycle.iter().map(|p| p.duration).sum();
        fitted.offset = fitted.offset.rem_euclid(period);
        report.change(format!("light {}: the offset was made positive", light.id));
    }
    Some(fitted)
}

fn intersection(
    intersection: &Intersection,
    known: &Referable,
    report: &mut Report,
) -> Option<Intersection> {
    let mut fitted = intersection.clone();
    fitted.keep_references(known, &mut |gone| report.change(gone));
    if fitted.incomings.is_empty() {
        report.change(format!(
            "intersection {} without incoming roads was left out",
            intersection.id
        ));
        return None;
    }
    Some(fitted)
}
