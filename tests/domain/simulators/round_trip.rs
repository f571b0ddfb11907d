//! Exported and opened again: lanelets, problems, bodies and ids are those of before, unless a road was changed since.

use nearmiss::formats::commonroad;
use nearmiss::scenario::{Lanelet, ObstacleRole, SignalColor};

use super::*;

#[path = "../../hostile/mutated/small.rs"]
#[allow(dead_code)]
mod small;

/// Lanelets without what roads say of signs and lights.
fn plain(scenario: &Scenario) -> Vec<Lanelet> {
    let mut all = scenario.network.lanelets.clone();
    for lanelet in &mut all {
        (lanelet.signs, lanelet.lights) = (Vec::new(), Vec::new());
        for bound in [&mut lanelet.left, &mut lanelet.right] {
            bound.heights.clear();
        }
        if let Some(line) = &mut lanelet.stop_line {
            (line.signs, line.lights) = (Vec::new(), Vec::new());
        }
    }
    all
}

/// A document exported without an ego and opened again, with its roads changed by `change`.
fn again(xml: &str, change: impl Fn(String) -> String) -> (Scenario, Arc<Scenario>) {
    again_with(xml, change, |scenario| scenario)
}

/// The same, with the scenario file changed, too.
fn again_with(
    xml: &str,
    change_roads: impl Fn(String) -> String,
    change_scenario: impl Fn(String) -> String,
) -> (Scenario, Arc<Scenario>) {
    let scenario = commonroad::read(xml.as_bytes(), "small").unwrap();
    let mut written = write_openscenario(&Export {
        scenario: &scenario,
        ego: ExportedEgo::Missing,
        road_file: "small.xodr",
        properties: &BTreeMap::new(),
        about: &[],
        varied: None,
    })
    .unwrap();
    written.roads = change_roads(String::from_utf8(written.roads).unwrap()).into_bytes();
    written.scenario = change_scenario(String::from_utf8(written.scenario).unwrap()).into_bytes();
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "small", &written);
    (scenario, Entry::of_file(&path).read().unwrap())
}

#[test]
fn lanelets_and_problems_are_those_of_before() {
    let folder = tempfile::tempdir().unwrap();
    for entry in bundled() {
        let (scene, written) = exported(&entry, &format!("{}.xodr", entry.name));
        let path = write(folder.path(), &entry.name, &written);
        let back = Entry::of_file(&path).read().unwrap();
        let before = &scene.scenario;
        assert_eq!(plain(&back), plain(before), "{}", entry.name);
        assert_eq!(back.planning_problems, before.planning_problems);
        assert_eq!(back.network.intersections, before.network.intersections);
        assert_eq!(back.location, before.location);
    }
}

#[test]
fn a_fork_that_was_cut_is_whole_again() {
    // Two lanelets begin where the first one ends; the second one of them ends somewhere else.
    let lanelet = |id: i64, points: &[(f64, f64)], links: &str| {
        let bound = |name: &str, y: f64| {
            let points = points
                .iter()
                .map(|(x, at)| format!("<point><x>{x}</x><y>{}</y></point>", at + y));
            format!("<{name}>{}</{name}>", points.collect::<String>())
        };
        let (left, right) = (bound("leftBound", 1.75), bound("rightBound", -1.75));
        format!("<lanelet id=\"{id}\">{left}{right}{links}</lanelet>")
    };
    let bend: Vec<(f64, f64)> = (0..=10)
        .map(|i| (50.0 + 3.0 * f64::from(i), 0.08 * f64::from(i * i)))
        .collect();
    let xml = format!(
        r#"<commonRoad commonRoadVersion="2020a" benchmarkID="ZAM_Fork-1_1_T-1" timeStepSize="0.1">{}{}{}</commonRoad>"#,
        lanelet(
            1,
            &[(0.0, 0.0), (50.0, 0.0)],
            r#"<successor ref="2"/><successor ref="3"/>"#
        ),
        lanelet(2, &[(50.0, 0.0), (80.0, 0.0)], r#"<predecessor ref="1"/>"#),
        lanelet(3, &bend, r#"<predecessor ref="1"/>"#),
    );
    let (before, back) = again(&xml, |roads| {
        assert!(roads.contains("commonroad_part_of"), "{roads}");
        roads
    });
    assert_eq!(plain(&back), plain(&before));
    // Without what was kept the pieces for the junction are lanelets, too.
    let (_, back) = again(&xml, |roads| roads.replace("commonroad_left", "other"));
    assert!(back.network.lanelets.len() > 3);
}

#[test]
fn signs_are_those_of_before_unless_the_road_file_tells_others() {
    let sign = |id: i64, number: &str, value: &str| {
        format!(
            r#"<trafficSign id="{id}"><trafficSignElement><trafficSignID>{number}</trafficSignID>{value}</trafficSignElement><position><point><x>9.5</x><y>-4.25</y></point></position><virtual>true</virtual></trafficSign>"#
        )
    };
    let limit = "<additionalValue>13.9</additionalValue>";
    let bounds = r"<leftBound><point><x>0</x><y>2</y></point><point><x>50</x><y>2</y></point></leftBound><rightBound><point><x>0</x><y>-2</y></point><point><x>50</x><y>-2</y></point></rightBound>";
    // The ids are those that lanes would be numbered with.
    let xml = format!(
        r#"<commonRoad commonRoadVersion="2020a" benchmarkID="ZAM_Signs-1_1_T-1" timeStepSize="0.1"><lanelet id="9">{bounds}<trafficSignRef ref="1"/><trafficSignRef ref="2"/></lanelet>{}{}{}</commonRoad>"#,
        sign(1, "206", ""),
        sign(2, "274", limit),
        sign(3, "205", ""),
    );
    let (before, back) = again(&xml, |roads| roads);
    assert_eq!(before.network.signs.len(), 3);
    assert_eq!(back.network.signs, before.network.signs);
    assert_eq!(back.network.lanelets[0].signs, [1, 2]);

    let numbers = |s: &Scenario| -> Vec<String> {
        let signs = s.network.signs.iter();
        let mut all: Vec<_> = signs.map(|s| s.elements[0].id.clone()).collect();
        all.sort();
        all
    };
    let (_, back) = again(&xml, |roads| {
        assert!(roads.contains(r#"type="206""#), "{roads}");
        roads.replace(r#"type="206""#, r#"type="250""#)
    });
    assert_eq!(numbers(&back), ["250", "274"]);
    let (_, back) = again(&xml, |roads| {
        assert!(roads.contains(r#"max="13.9""#), "{roads}");
        roads.replace(r#"max="13.9""#, r#"max="8.5""#)
    });
    let limit = back
        .network
        .signs
        .iter()
        .find(|s| s.elements[0].id == "274");
    assert_eq!(limit.unwrap().elements[0].values, ["8.5"]);
    assert_eq!(numbers(&back), ["206", "274"]);
}

#[test]
fn a_road_that_was_changed_holds() {
    let xml = small::scenario();
    let (before, back) = again(&xml, |roads| roads);
    assert_eq!(plain(&back), plain(&before));
    let (_, back) = again(&xml, |roads| {
        let at = roads.find("<width").unwrap();
        let (head, tail) = roads.split_at(at);
        let wider = tail.replacen("a=\"3.5", "a=\"4.5", 1);
        assert_ne!(wider, tail);
        format!("{head}{wider}")
    });
    assert_ne!(plain(&back), plain(&before));
    let widest = |s: &Scenario| {
        let width = |l: &Lanelet| (l.left.points[0] - l.right.points[0]).norm();
        s.network.lanelets.iter().map(width).fold(0.0, f64::max)
    };
    assert!((widest(&back) - 4.5).abs() < 0.02, "{}", widest(&back));
}

#[test]
fn states_before_and_after_which_an_obstacle_is_away_are_kept() {
    let state = |step: i64, x: f64| {
        format!(
            "<position><point><x>{x}</x><y>1.5</y></point></position><orientation><exact>0.25</exact></orientation><time><exact>{step}</exact></time><velocity><exact>{}</exact></velocity>",
            x / 7.0
        )
    };
    let later = [(3, 30.0), (4, 40.0), (7, 70.0)]
        .map(|(step, x)| format!("<state>{}</state>", state(step, x)))
        .concat();
    let xml = format!(
        r#"<commonRoad commonRoadVersion="2020a" benchmarkID="ZAM_Gaps-1_1_T-1" timeStepSize="0.1"><dynamicObstacle id="5"><type>car</type><shape><rectangle><length>4</length><width>2</width></rectangle></shape><initialState>{}</initialState><trajectory>{later}</trajectory></dynamicObstacle></commonRoad>"#,
        state(0, 5_000_000.0 / 1e3)
    );
    let (before, back) = again(&xml, |roads| roads);
    let [old, new] = [&before, &*back].map(|s| s.obstacle(5).unwrap());
    assert_eq!(old.track().iter().count(), 4);
    for (step, motion) in old.track().iter() {
        let there = new.motion_at(step).unwrap_or_else(|| panic!("{step}"));
        let away = (there.pose.position - motion.pose.position).norm();
        assert!(away < 1e-3, "{step}: {away}");
        assert_eq!(there.velocity, motion.velocity, "{step}");
    }
    assert_eq!(new.track().iter().count(), 4);
    // Velocities that cannot be told apart any more are computed, and that is said.
    let (_, cut) = again_with(
        &xml,
        |roads| roads,
        |scenario| {
            let name = "name=\"commonroad_velocity\" value=\"";
            assert!(scenario.contains(name), "{scenario}");
            scenario.replace(name, &format!("{name}1 "))
        },
    );
    let warned = cut
        .diagnostics
        .iter()
        .filter(|d| d.message.contains("has 5 numbers for 4 states"));
    assert_eq!(warned.count(), 1, "{:?}", cut.diagnostics);
}

#[test]
fn lights_are_those_of_before_unless_the_controllers_tell_others() {
    let bounds = r"<leftBound><point><x>0</x><y>2</y></point><point><x>50</x><y>2</y></point></leftBound><rightBound><point><x>0</x><y>-2</y></point><point><x>50</x><y>-2</y></point></rightBound>";
    let phase = |steps: i64, color: &str| {
        format!("<cycleElement><duration>{steps}</duration><color>{color}</color></cycleElement>")
    };
    let xml = format!(
        r#"<commonRoad commonRoadVersion="2020a" benchmarkID="ZAM_Lights-1_1_T-1" timeStepSize="0.1"><lanelet id="9">{bounds}<trafficLightRef ref="4"/></lanelet><trafficLight id="4"><cycle>{}{}<timeOffset>3</timeOffset></cycle><position><point><x>49.5</x><y>-4.25</y></point></position><direction>straight</direction></trafficLight></commonRoad>"#,
        phase(4, "red"),
        phase(6, "green")
    );
    let (before, back) = again(&xml, |roads| roads);
    assert_eq!(before.network.lights.len(), 1);
    assert_eq!(back.network.lights, before.network.lights);
    let (_, changed) = again_with(
        &xml,
        |roads| roads,
        |scenario| {
            assert!(scenario.contains("off;off;on"), "{scenario}");
            scenario.replace("off;off;on", "off;on;off")
        },
    );
    let shown = |s: &Scenario, step| s.network.lights[0].color_at(step);
    assert_eq!(shown(&before, 7), SignalColor::Green);
    assert_eq!(shown(&changed, 7), SignalColor::Yellow);
}

#[test]
fn bodies_roles_and_ids_are_those_of_before() {
    let xml = small::scenario().replace("dynamicObstacle id=\"20\"", "dynamicObstacle id=\"0\"");
    let (before, back) = again(&xml, |roads| roads);
    let mut seen = 0;
    for obstacle in &before.obstacles {
        let solid = matches!(obstacle.role, ObstacleRole::Static | ObstacleRole::Dynamic);
        let Some(footprint) = obstacle.footprint.as_ref().filter(|_| solid) else {
            continue;
        };
        if obstacle.track().iter().next().is_none() {
            continue;
        }
        let id = obstacle.id;
        let same = back.obstacle(id).unwrap_or_else(|| panic!("{id} is gone"));
        assert_eq!(same.role, obstacle.role, "{id}");
        assert_eq!(same.kind, obstacle.kind, "{id}");
        let shape = same.footprint.as_ref().unwrap().shape();
        assert_eq!(shape, footprint.shape(), "{id}");
        for (step, motion) in obstacle.track().iter() {
            let there = same.motion_at(step).unwrap();
            let away = (there.pose.position - motion.pose.position).norm();
            assert!(away < 1e-3, "{id} at {step}: {away}");
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen}");
    assert!(before.obstacle(0).is_some());
}
