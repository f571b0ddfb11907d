//! Small road files and scenarios, and what was said of them.

use std::fmt::Write as _;

use super::*;

/// A road of 100 m along x with a lane to each side; what stands in its header, in its lanes, and behind them.
pub fn road(header: &str, right: &str, more: &str) -> String {
    format!(
        r#"<OpenDRIVE><header revMajor="1" revMinor="8">{header}</header>
<road id="1" length="100" junction="-1"><planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
<lanes><laneSection s="0"><left><lane id="1" type="driving"><width sOffset="0" a="3.5"/></lane></left>
<center><lane id="0" type="none"/></center>
<right><lane id="-1" type="driving" {right}><width sOffset="0" a="3.5"/></lane></right></laneSection></lanes>{more}</road></OpenDRIVE>"#
    )
}

/// The scenario of a file alone in a folder.
pub fn alone(name: &str, text: &str) -> Result<Scenario, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    let read = Entry::of_file(&path).read();
    read.map(|s| (*s).clone()).map_err(|e| e.to_string())
}

pub fn said(scenario: &Scenario) -> Vec<String> {
    scenario
        .diagnostics
        .iter()
        .map(ToString::to_string)
        .collect()
}

pub fn says(scenario: &Scenario, words: &str) -> bool {
    said(scenario).iter().any(|s| s.contains(words))
}

/// Kinds of what is not used, and how often.
pub fn unused(scenario: &Scenario) -> Vec<(String, usize)> {
    let all = scenario.diagnostics.iter();
    let unused = all.filter(|d| d.severity == nearmiss::scenario::Severity::Unused);
    let count = |words: &str| words.split(' ').next().unwrap().parse().unwrap();
    unused
        .map(|d| (d.element.clone(), count(&d.message)))
        .collect()
}

/// An entity at a place of the beginning.
pub fn place(name: &str, position: &str) -> String {
    format!(
        r#"<Private entityRef="{name}"><PrivateAction><TeleportAction><Position>{position}</Position></TeleportAction></PrivateAction></Private>"#
    )
}

/// A vehicle of 5 m and 2 m.
fn vehicle(name: &str) -> String {
    format!(
        r#"<ScenarioObject name="{name}"><Vehicle name="v" vehicleCategory="car"><BoundingBox><Center x="0" y="0" z="0"/>
<Dimensions length="5" width="2" height="0"/></BoundingBox></Vehicle></ScenarioObject>"#
    )
}

/// A scenario of `Ego` and `B` with a beginning and a story.
pub fn document(init: &str, story: &str) -> String {
    format!(
        r#"<OpenSCENARIO><FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="" author=""/>
<CatalogLocations/><RoadNetwork><LogicFile filepath="..\roads\a.xodr"/></RoadNetwork>
<Entities>{}{}</Entities><Storyboard><Init><Actions>{init}</Actions></Init>{story}</Storyboard></OpenSCENARIO>"#,
        vehicle("Ego"),
        vehicle("B"),
    )
}

/// A folder with a scenario and its roads, which it names as on Windows; and the scenario.
pub fn folder(roads: &str, init: &str, story: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for name in ["roads", "scenarios"] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
    }
    std::fs::write(folder.path().join("roads/a.xodr"), roads).unwrap();
    let path = folder.path().join("scenarios/x.xosc");
    std::fs::write(&path, document(init, story)).unwrap();
    (folder, path)
}

pub fn try_on_road(roads: &str, init: &str, story: &str) -> Result<Scenario, String> {
    let (_folder, path) = folder(roads, init, story);
    let read = Entry::of_file(&path).read();
    read.map(|s| (*s).clone()).map_err(|e| e.to_string())
}

pub fn on_road(roads: &str, init: &str, story: &str) -> Scenario {
    let read = try_on_road(roads, init, story).unwrap();
    assert_eq!(read.network.lanelets.len(), 2, "{:?}", said(&read));
    read
}

pub fn trigger(element: &str, at: f64) -> String {
    format!(
        r#"<{element}><ConditionGroup><Condition name="c" delay="0" conditionEdge="none"><ByValueCondition><SimulationTimeCondition value="{at}" rule="greaterOrEqual"/></ByValueCondition></Condition></ConditionGroup></{element}>"#
    )
}

/// A polyline through places on the x-axis at times.
pub fn follow(vertices: &[(f64, f64)]) -> String {
    let mut line = String::new();
    for (time, x) in vertices {
        write!(line, r#"<Vertex time="{time}"><Position><WorldPosition x="{x}" y="-1.75" h="0"/></Position></Vertex>"#).unwrap();
    }
    format!(
        r#"<PrivateAction><RoutingAction><FollowTrajectoryAction><TimeReference><Timing domainAbsoluteRelative="absolute" scale="1" offset="0"/></TimeReference>
<TrajectoryRef><Trajectory name="t" closed="false"><Shape><Polyline>{line}</Polyline></Shape></Trajectory></TrajectoryRef>
<TrajectoryFollowingMode followingMode="position"/></FollowTrajectoryAction></RoutingAction></PrivateAction>"#
    )
}

/// An act of an entity with an event at a moment.
pub fn act(actor: &str, begins: f64, at: f64, action: &str) -> String {
    format!(
        r#"<Act name="a"><ManeuverGroup name="g" maximumExecutionCount="1"><Actors selectTriggeringEntities="false"><EntityRef entityRef="{actor}"/></Actors>
<Maneuver name="m"><Event name="e" priority="overwrite"><Action name="x">{action}</Action>{}</Event></Maneuver></ManeuverGroup>{}</Act>"#,
        trigger("StartTrigger", at),
        trigger("StartTrigger", begins),
    )
}

pub fn story(acts: &[String]) -> String {
    format!(
        r#"<Story name="s">{}</Story>{}"#,
        acts.concat(),
        trigger("StopTrigger", 5.0)
    )
}

pub fn at_x(name: &str, x: f64) -> String {
    place(
        name,
        &format!(r#"<WorldPosition x="{x}" y="-1.75" h="0"/>"#),
    )
}

/// Where an obstacle is along x at steps of 0.1 s; nothing where it is not there.
pub fn seen(of: &nearmiss::scenario::Obstacle, steps: &[i64]) -> Vec<Option<f64>> {
    let at = |step: &i64| {
        of.motion_at(*step)
            .map(|m| (m.pose.position.x * 1e6).round() / 1e6)
    };
    steps.iter().map(at).collect()
}
