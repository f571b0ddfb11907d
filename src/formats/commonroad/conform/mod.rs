//! Makes a scenario conform to the schema of version 2020a, and reports what that changed.
//!
//! Real files hold what the schema has no place for: intersections without roads, signs without meaning, dangling
//! references, states without a heading. A scenario is written as it is; callers that need a file a validator accepts
//! run this first.

mod contents;

use std::collections::HashSet;

use nearmiss_scene::scenario::{LaneletNetwork, Location, Scenario};

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
    fitted.network = contents::network(network, &mut report);
    fitted.obstacles = scenario
        .obstacles
        .iter()
        .map(|o| contents::obstacle(o, scenario.dt(), &mut report))
        .collect();
    let problems = &mut fitted.planning_problems;
    problems
        .iter_mut()
        .for_each(|p| contents::problem(p, &fitted.network, &mut report));
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
