//! Storyboards of others: trajectories that end, acts that begin late, positions in any order, ghosts in recordings,
//! catalogs; what only a player works out; what a reader does not know.

use std::fmt::Write as _;

use super::made::{
    act, alone, at_x, document, folder, follow, on_road, place, road, said, says, seen, story,
    try_on_road, unused,
};
use super::*;
use nearmiss::system::files_opened_by;

#[test]
fn entities_wait_for_their_trajectory_and_stay_where_it_ends() {
    let init = at_x("Ego", 0.0) + &at_x("B", 20.0);
    let ego = act("Ego", 0.0, 0.0, &follow(&[(0.0, 0.0), (5.0, 50.0)]));
    let b = act("B", 0.0, 0.0, &follow(&[(1.0, 21.0), (2.0, 23.0)]));
    let read = on_road(&road("", "", ""), &init, &story(&[ego.clone(), b.clone()]));
    let other = &read.obstacles[0];
    let at = [0, 9, 10, 15, 20, 21, 50];
    let there = [20.0, 20.0, 21.0, 22.0, 23.0, 23.0, 23.0].map(Some);
    assert_eq!(seen(other, &at), there);
    assert_eq!(read.steps().end, 51);
    let speed = |step: i64| other.motion_at(step).unwrap().velocity;
    assert_eq!([5, 21, 50].map(speed), [0.0; 3]);
    assert!(says(&read, "`B` from 2 s"), "{:?}", said(&read));
    // The ego drives into it.
    let scene = Scene::new(Arc::new(read.clone()), read_ego(&read));
    let own = scene.ego_at(25).unwrap();
    assert!(
        scene
            .participants()
            .any(|p| p.placed_at(25).is_some_and(|o| own.distance(&o) <= 0.0))
    );
    // It is deleted: it is there no longer.
    let delete = r#"<GlobalAction><EntityAction entityRef="B"><DeleteEntityAction/></EntityAction></GlobalAction>"#;
    let gone = act("B", 0.0, 3.0, delete);
    let read = on_road(&road("", "", ""), &init, &story(&[ego.clone(), b, gone]));
    let there = [Some(23.0), Some(23.0), None, None];
    assert_eq!(seen(&read.obstacles[0], &[21, 30, 31, 50]), there);
    // Of one vertex it is there all the time.
    let stands = act("B", 0.0, 0.0, &follow(&[(0.0, 30.0)]));
    let read = on_road(&road("", "", ""), &init, &story(&[ego, stands]));
    assert_eq!(seen(&read.obstacles[0], &[0, 25, 50]), [Some(30.0); 3]);
    assert!(!says(&read, "trajectories end before"), "{:?}", said(&read));
}

fn read_ego(scenario: &Scenario) -> nearmiss::scenario::Ego {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.xosc");
    std::fs::write(&path, "").unwrap();
    Entry::of_file(&path)
        .recorded_ego(scenario)
        .unwrap()
        .unwrap()
}

#[test]
fn acts_begin_before_their_events_do() {
    let init = at_x("Ego", 0.0) + &at_x("B", 20.0);
    let late = act("B", 2.0, 0.0, &follow(&[(0.0, 20.0), (4.0, 60.0)]));
    let read = on_road(&road("", "", ""), &init, &story(&[late]));
    // It is on its trajectory from the beginning of its act on.
    assert_eq!(
        seen(&read.obstacles[0], &[0, 19, 20, 40]),
        [20.0, 20.0, 40.0, 60.0].map(Some)
    );
    let depends = act("B", 0.0, 0.0, &follow(&[(0.0, 20.0), (4.0, 60.0)]))
        .replacen(
            "<ByValueCondition>",
            "<ByEntityCondition/><ByValueConditions>",
            2,
        )
        .replace("</ByValueCondition>", "</ByValueConditions>");
    let error = try_on_road(&road("", "", ""), &init, &story(&[depends])).unwrap_err();
    assert!(error.contains("only a player works out"), "{error}");
}

#[test]
fn positions_may_be_told_from_entities_that_are_placed_later() {
    let relative =
        |of: &str| format!(r#"<RelativeObjectPosition entityRef="{of}" dx="-20" dy="0"/>"#);
    let b = place(
        "B",
        r#"<WorldPosition x="40" y="-1.75" h="${-pi / 2 + pi/2}"/>"#,
    );
    let read = on_road(&road("", "", ""), &(place("Ego", &relative("B")) + &b), "");
    let ego = &read.recorded_ego.as_ref().unwrap().obstacle;
    assert_eq!(seen(ego, &[0]), [Some(20.0)]);
    let circle = place("Ego", &relative("B")) + &place("B", &relative("Ego"));
    let error = try_on_road(&road("", "", ""), &circle, "").unwrap_err();
    assert!(error.contains("told from it in turn"), "{error}");
}

#[test]
fn places_beyond_a_road_and_times_that_fall_are_told() {
    let lane = r#"<LanePosition roadId="1" laneId="-1" s="170" offset="0"/>"#;
    let init = at_x("Ego", 0.0) + &place("B", lane);
    let read = on_road(&road("", "", ""), &init, "");
    assert_eq!(seen(&read.obstacles[0], &[0]), [Some(100.0)]);
    let words = "s=170 is not on road `1`, which is 100.00 m long; taken as its end";
    assert!(says(&read, words), "{:?}", said(&read));
    let init = at_x("Ego", 0.0) + &at_x("B", 20.0);
    let falls = follow(&[(0.0, 20.0), (4.0, 60.0), (3.0, 70.0)]);
    let error = try_on_road(
        &road("", "", ""),
        &init,
        &story(&[act("B", 0.0, 0.0, &falls)]),
    )
    .unwrap_err();
    assert!(
        error.contains("a vertex at 3 s after one at 4 s"),
        "{error}"
    );
}

#[test]
fn what_only_a_player_works_out_is_named_with_its_advice() {
    let init = at_x("Ego", 0.0) + &at_x("B", 20.0);
    let plain = follow(&[(0.0, 20.0), (4.0, 60.0)]);
    let controller = r#"<PrivateAction><ControllerAction><AssignControllerAction activateLateral="true" activateLongitudinal="true"><Controller name="c"/></AssignControllerAction></ControllerAction></PrivateAction>"#;
    let lane = r#"<RelativeLanePosition entityRef="Ego" dLane="0" ds="9"/>"#;
    let world = r#"<WorldPosition x="60" y="-1.75" h="0"/>"#;
    let relative = r#"<RelativeObjectPosition entityRef="Ego" dx="9" dy="0"/>"#;
    let drives = act("Ego", 0.0, 0.0, &follow(&[(0.0, 0.0), (5.0, 50.0)]));
    for (acts, words) in [
        (
            vec![act("B", 0.0, 0.0, &plain.replace(r#"time="4""#, ""))],
            "without times",
        ),
        (
            vec![act("B", 0.0, 0.0, &plain.replace(world, lane))],
            "through a <RelativeLanePosition>",
        ),
        (
            vec![act("B", 0.0, 0.0, controller)],
            "is moved by a controller",
        ),
        (
            vec![drives, act("B", 0.0, 1.0, &plain.replace(world, relative))],
            "moves from where `Ego` is then",
        ),
        (
            vec![act("B", 0.0, 0.0, &plain).replace(
                "<Maneuver",
                r#"<CatalogReference catalogName="c" entryName="e"/><Maneuver"#,
            )],
            "maneuver of a catalog",
        ),
    ] {
        let error = try_on_road(&road("", "", ""), &init, &story(&acts)).unwrap_err();
        assert!(error.contains(words), "{words}: {error}");
        assert!(error.contains("--csv_logger"), "{error}");
    }
    // With a trajectory, a controller is only said.
    let both = story(&[act("B", 0.0, 0.0, controller), act("B", 0.0, 0.0, &plain)]);
    let read = on_road(&road("", "", ""), &init, &both);
    assert!(says(&read, "controllers are not read"), "{:?}", said(&read));
}

#[test]
fn other_versions_say_so() {
    let old = document("", "").replace(
        r#"revMajor="1" revMinor="2""#,
        r#"revMajor="0" revMinor="9""#,
    );
    let error = alone("x.xosc", &old).unwrap_err();
    assert!(error.contains("OpenSCENARIO 0.9 is not read"), "{error}");
    let new = document("", "").replace(r#"revMinor="2""#, r#"revMinor="9""#);
    assert!(says(
        &alone("x.xosc", &new).unwrap(),
        "OpenSCENARIO 1.9 is read as 1.3"
    ));
}

#[test]
fn what_is_not_used_of_a_scenario_is_counted() {
    let init = at_x("Ego", 0.0).replace("<WorldPosition", r#"<WorldPosition z="3" planted="1""#);
    let init = init + "<GlobalAction><EnvironmentAction/></GlobalAction><planted/>";
    let plain = story(&[act("Ego", 0.0, 0.0, &follow(&[(0.0, 0.0), (5.0, 50.0)]))]);
    let (_folder, path) = folder(
        &road("<planted/>", "", ""),
        &init,
        &plain.replace("<Event ", r#"<Event planted="1" "#),
    );
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(
        &path,
        text.replace("<CatalogLocations/>", r#"<Planted deep="1"><A/></Planted>"#),
    )
    .unwrap();
    let read = Entry::of_file(&path).read().unwrap();
    let expected = [
        ("Actions/planted", 1),
        ("Event@planted", 1),
        ("GlobalAction/EnvironmentAction", 1),
        ("OpenSCENARIO/Planted", 1),
        ("WorldPosition@planted", 1),
        ("WorldPosition@z", 1),
        ("header/planted", 1),
    ]
    .map(|(kind, count)| (kind.to_string(), count));
    assert_eq!(unused(&read), expected);
}

#[test]
fn ghosts_of_a_recording_are_no_bodies() {
    let init = at_x("Ego", 0.0) + &at_x("B", 60.0);
    let speed = r#"<PrivateAction><LongitudinalAction><SpeedAction><SpeedActionTarget><AbsoluteTargetSpeed value="10"/></SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction>"#;
    let init = format!(r#"{init}<Private entityRef="Ego">{speed}</Private>"#);
    let (_folder, path) = folder(&road("", "", ""), &init, "");
    let mut log = String::from(
        "Index [-], TimeStamp [s], #1 Entity_Name [-], #1 Entity_ID [-], #1 Current_Speed [m/s], #1 bb_x [m], #1 bb_y [m], #1 bb_length [m], #1 bb_width [m], #1 World_Position_X [m], #1 World_Position_Y [m], #1 World_Heading_Angle [rad], #1 collision_ids, \n",
    );
    for i in -20..=20 {
        let (time, x) = (0.1 * f64::from(i), f64::from(i.max(0)));
        let entity = |name: &str, x: f64| {
            format!("{name}, 0, 10.0, 0.0, 0.0, 5.0, 2.0, {x:.6}, -1.75, 0.0, , ")
        };
        let all = [
            entity("Ego", x),
            entity("Ego_ghost", f64::from(i)),
            entity("B", 60.0),
        ]
        .concat();
        writeln!(log, "{i}, {time:.6}, {all}").unwrap();
    }
    std::fs::write(path.with_extension("csv"), log).unwrap();
    let read = Entry::of_file(&path).read().unwrap();
    assert_eq!(read.obstacles.len(), 1);
    assert_eq!((read.steps().start, read.steps().end), (0, 21));
    assert!(
        says(&read, "(Ego_ghost)") && says(&read, "states before time 0"),
        "{:?}",
        said(&read)
    );
}

#[test]
fn catalogs_are_read_once() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("cars")).unwrap();
    for catalog in 0..3 {
        let entries: String = (0..3).map(|i| format!(
            r#"<Vehicle name="e{i}" vehicleCategory="car" planted="1"><BoundingBox><Center x="0" y="0"/><Dimensions length="{}" width="2"/></BoundingBox></Vehicle>"#,
            4 + i
        )).collect();
        let text = format!(
            r#"<OpenSCENARIO><FileHeader/><Catalog name="c{catalog}">{entries}</Catalog></OpenSCENARIO>"#
        );
        std::fs::write(folder.path().join(format!("cars/c{catalog}.xosc")), text).unwrap();
    }
    let mut entities = String::new();
    let mut init = String::new();
    for i in 0..20 {
        let (catalog, entry) = (i % 4, i % 3);
        write!(entities, r#"<ScenarioObject name="v{i}"><CatalogReference catalogName="c{catalog}" entryName="e{entry}"/></ScenarioObject>"#).unwrap();
        init += &at_x(&format!("v{i}"), f64::from(i) * 9.0);
    }
    let text = format!(
        r#"<OpenSCENARIO><FileHeader revMajor="1" revMinor="2"/><CatalogLocations><VehicleCatalog><Directory path=".\cars"/></VehicleCatalog></CatalogLocations>
<RoadNetwork/><Entities>{entities}</Entities><Storyboard><Init><Actions>{init}</Actions></Init></Storyboard></OpenSCENARIO>"#
    );
    let path = folder.path().join("x.xosc");
    std::fs::write(&path, text).unwrap();
    let (read, opened) = files_opened_by(|| Entry::of_file(&path).read().unwrap());
    for catalog in 0..3 {
        let name = format!("c{catalog}.xosc");
        let times = opened.iter().filter(|f| f.ends_with(&name)).count();
        assert_eq!(times, 1, "{name}: {opened:?}");
    }
    let lengths: Vec<f64> = read.obstacles[..5]
        .iter()
        .map(|o| o.footprint.as_ref().unwrap().shape().size().0)
        .collect();
    assert_eq!(lengths, [5.0, 6.0, 4.6, 5.0, 6.0]);
    // A fourth catalog is nowhere; what is not used of an entry is counted once.
    assert!(
        says(
            &read,
            "`e0` of the catalog `c3` is in no catalog of the scenario"
        ),
        "{:?}",
        said(&read)
    );
    assert!(
        unused(&read).contains(&("Vehicle@planted".into(), 9)),
        "{:?}",
        unused(&read)
    );
}
