//! `convert`: what is written, what is mended, what is never overwritten.

use nearmiss::formats::commonroad::read;

use super::support::program::Home;
use super::{BUNDLED, CUT_IN, bundled_xml};

/// A scenario with most of what the schema does not allow.
const UNFIT: &str = r#"<commonRoad timeStepSize="0.1" commonRoadVersion="2020a" benchmarkID="ZAM_Unfit-1_1_T-1" date="2026-01-31">
  <scenarioTags><urban/><haunted/></scenarioTags>
  <lanelet id="1">
    <leftBound><point><x>0</x><y>3</y></point><point><x>50</x><y>3</y></point></leftBound>
    <rightBound><point><x>0</x><y>0</y></point><point><x>50</x><y>0</y></point></rightBound>
    <successor ref="99"/><trafficSignRef ref="2"/>
  </lanelet>
  <trafficSign id="2"><position><point><x>1</x><y>1</y></point></position></trafficSign>
  <intersection id="3"/>
  <dynamicObstacle id="4">
    <type>building</type><shape><circle><radius>0.4</radius></circle></shape>
    <initialState><position><point><x>1</x><y>1</y></point></position><orientation><exact>0</exact></orientation><time><exact>0</exact></time></initialState>
    <trajectory><state><position><point><x>1</x><y>2</y></point></position><time><exact>1</exact></time>
      <velocity><exact>0</exact></velocity><velocityY><exact>10</exact></velocityY></state></trajectory>
  </dynamicObstacle>
  <planningProblem id="5">
    <initialState><position><point><x>20</x><y>1</y></point></position><time><exact>0</exact></time></initialState>
    <goalState><time><exact>9</exact></time><velocity><exact>3</exact></velocity></goalState>
  </planningProblem>
</commonRoad>"#;

#[test]
fn bundled_scenarios_fit_the_schema_and_are_written_the_same() {
    let home = Home::new();
    for (name, _) in BUNDLED {
        let ended = home.run(&["convert", name, "--schema"]).status(0);
        let ego =
            format!("{name}: the ego is left out; -o FILE.xml writes it beside the scenario\n");
        assert_eq!(ended.stderr, ego, "nothing to mend in {name}");
        assert_eq!(ended.stdout, bundled_xml(name));
    }
}

#[test]
fn what_does_not_fit_is_mended_and_named() {
    let home = Home::new();
    let file = home.write("unfit.xml", UNFIT.as_bytes());
    let file = file.to_str().unwrap();
    let kept = home.run(&["convert", file]).status(0);
    assert!(kept.stderr.contains("--schema"), "{}", kept.stderr);
    let kept = read(kept.stdout.as_bytes(), "kept").unwrap();
    assert_eq!(kept.tags, ["urban", "haunted"]);
    assert_eq!(kept.network.intersections.len(), 1);

    let ended = home.run(&["convert", file, "--schema"]).status(0);
    for words in [
        "the tag `haunted` was left out",
        "no location",
        "no author",
        "lanelet 1: the reference to 99 was left out",
        "lanelet 1: no type",
        "sign 2 without elements was left out",
        "intersection 3 without incoming roads",
        "obstacle 4: the type building became unknown",
        "step 1: the heading was filled in from the velocity",
        "planning problem 5: yawRate was filled in as 0",
    ] {
        assert!(ended.stderr.contains(words), "{words}: {}", ended.stderr);
    }
    let fitted = read(ended.stdout.as_bytes(), "fitted").unwrap();
    assert_eq!(fitted.tags, ["urban"]);
    assert!(fitted.network.intersections.is_empty() && fitted.network.signs.is_empty());
    let heading = fitted.obstacles[0].track().at(1).unwrap().pose.heading;
    assert!((heading - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    let again = home.write("fitted.xml", ended.stdout.as_bytes());
    let again = home
        .run(&["convert", again.to_str().unwrap(), "--schema"])
        .status(0);
    assert_eq!((again.stderr.as_str(), again.stdout), ("", ended.stdout));
}

#[test]
fn what_cannot_be_mended_is_a_finding() {
    let home = Home::new();
    let text = UNFIT
        .replace("planningProblem", "nothing")
        .replace("id=\"4\"", "id=\"0\"");
    let file = home.write("unfit.xml", text.as_bytes());
    let ended = home
        .run(&["convert", file.to_str().unwrap(), "--schema"])
        .status(1);
    assert!(
        ended.stderr.contains("no planning problem"),
        "{}",
        ended.stderr
    );
    assert!(
        ended.stderr.contains("id 0 is not positive"),
        "{}",
        ended.stderr
    );
    assert!(
        ended.stdout.contains("<commonRoad"),
        "it is written all the same"
    );
}

#[test]
fn nothing_is_overwritten_unasked() {
    let home = Home::new();
    let target = home.write("mine.xml", b"mine");
    let path = target.to_str().unwrap();
    let ended = home.run(&["convert", CUT_IN, "-o", path]).status(2);
    assert!(ended.stderr.contains("--overwrite"), "{}", ended.stderr);
    assert_eq!(std::fs::read(&target).unwrap(), b"mine");
    home.run(&["convert", CUT_IN, "-o", path, "--overwrite"])
        .status(0);
    assert_eq!(
        std::fs::read_to_string(&target).unwrap(),
        bundled_xml(CUT_IN)
    );
}

#[test]
fn the_ego_goes_with_its_scenario_and_stays_what_it_is() {
    let home = Home::new();
    home.run(&["convert", CUT_IN, "-o", "own.xml"]).status(0);
    let ego = |name: &str| std::fs::read(home.files().join(name)).unwrap();
    let before = ego("own.ego_trajectory.csv");
    home.run(&["convert", "own.xml", "-o", "copy.xml"])
        .status(0);
    assert_eq!(ego("copy.ego_trajectory.csv"), before);
    // In its place: the ego is there already.
    home.run(&[
        "convert",
        "own.xml",
        "-o",
        "own.xml",
        "--schema",
        "--overwrite",
    ])
    .status(0);
    assert_eq!(ego("own.ego_trajectory.csv"), before);
    home.write(
        "own.ego_trajectory.csv",
        "timestep,x_position,y_position\n0,?,1\n",
    );
    home.run(&["convert", "own.xml", "-o", "third.xml"])
        .status(0)
        .says(&["the ego is left out", "line 2"]);
    assert!(!home.files().join("third.ego_trajectory.csv").exists());
    home.run(&["convert", CUT_IN])
        .status(0)
        .says(&["the ego is left out; -o FILE.xml writes it beside"]);
}

#[test]
fn several_go_into_a_folder() {
    let home = Home::new();
    let first = home.write("a.xml", bundled_xml(CUT_IN).as_bytes());
    let second = home.write("b.xml", b"<commonRoad");
    let (first, second) = (first.to_str().unwrap(), second.to_str().unwrap());
    home.run(&["convert", first, second]).status(2);
    let folder = home.files().join("out");
    std::fs::create_dir(&folder).unwrap();
    let ended = home
        .run(&["convert", first, second, "-o", folder.to_str().unwrap()])
        .status(1);
    assert!(
        ended
            .stderr
            .contains("1 of 2 scenarios could not be converted"),
        "{}",
        ended.stderr
    );
    assert!(folder.join("a.xml").exists() && !folder.join("b.xml").exists());
}

#[test]
fn what_reading_left_out_is_said_and_names_do_not_clash() {
    let home = Home::new();
    let text = bundled_xml(CUT_IN).replacen("<type>", "<hue>red</hue><type>", 1);
    let first = home.write("a/s.xml", &text);
    let second = home.write("b/s.xml", bundled_xml(CUT_IN));
    let (first, second) = (first.to_str().unwrap(), second.to_str().unwrap());
    let ended = home.run(&["convert", first]).status(0);
    assert!(
        ended
            .stderr
            .contains("not used: 1 × commonRoad/dynamicObstacle/hue (line"),
        "{}",
        ended.stderr
    );
    let folder = home.files().join("out");
    std::fs::create_dir(&folder).unwrap();
    let folder = folder.to_str().unwrap();
    let ended = home
        .run(&["convert", first, second, "-o", folder, "--overwrite"])
        .status(2);
    assert!(
        ended.stderr.contains("would both become s.xml"),
        "{}",
        ended.stderr
    );
}

#[test]
fn tables_of_tracks_are_written_and_open_with_the_same_ego() {
    let home = Home::new();
    let ended = home.run(&["convert", CUT_IN, "-o", "a.csv"]).status(0);
    assert!(
        ended.stderr.contains("the road is left out"),
        "{}",
        ended.stderr
    );
    for file in ["a.parquet", "a.arrow"] {
        home.run(&["convert", CUT_IN, "-o", file]).status(0);
    }
    let printed = home
        .run(&["convert", CUT_IN, "--format", "tracks"])
        .status(0);
    let written = std::fs::read_to_string(home.files().join("a.csv")).unwrap();
    assert_eq!(printed.stdout, written);
    assert!(written.starts_with("time,id,x,y,heading,speed,acceleration,length,width,class,ego\n"));
    for file in ["a.csv", "a.parquet", "a.arrow"] {
        let said = home.run(&["inspect", file]).status(0).stdout;
        assert!(said.contains("tracks of nearmiss"), "{said}");
        home.run(&["convert", file, "-o", "again.csv", "--overwrite"])
            .status(0);
        let again = std::fs::read_to_string(home.files().join("again.csv")).unwrap();
        let sorted = |text: &str| {
            let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
            lines.sort();
            lines
        };
        assert_eq!(sorted(&again).len(), sorted(&written).len(), "{file}");
    }
    home.run(&["convert", CUT_IN, "-o", "b.csv", "--ego", "free"])
        .status(2)
        .says(&["--ego free applies to OpenSCENARIO"]);
    home.run(&["convert", CUT_IN, "-o", "b.txt"])
        .status(2)
        .says(&[".csv or .parquet"]);
}

#[test]
fn shapes_of_other_data_sets_are_written() {
    let home = Home::new();
    let ended = home
        .run(&["convert", CUT_IN, "--format", "interaction", "-o", "a.csv"])
        .status(0);
    assert!(ended.stderr.contains("FILE#track="), "{}", ended.stderr);
    let said = home.run(&["inspect", "a.csv"]).status(0).stdout;
    assert!(said.contains("INTERACTION"), "{said}");
    home.run(&["convert", CUT_IN, "--format", "highd"])
        .status(2)
        .says(&["-o 01_tracks.csv"]);
    home.run(&[
        "convert",
        CUT_IN,
        "--format",
        "highd",
        "-o",
        "01_tracks.csv",
    ])
    .status(0)
    .says(&["turned by"]);
    for name in ["01_tracks.csv", "01_tracksMeta.csv", "01_recordingMeta.csv"] {
        assert!(home.files().join(name).is_file(), "{name}");
    }
    let said = home.run(&["inspect", "01_tracks.csv"]).status(0).stdout;
    assert!(said.contains("highD"), "{said}");
}

#[test]
fn the_older_version_of_commonroad_keeps_traffic_and_ego() {
    let home = Home::new();
    let ended = home
        .run(&[
            "convert",
            CUT_IN,
            "--format",
            "commonroad-2018b",
            "-o",
            "a.xml",
        ])
        .status(0);
    assert!(
        ended.stderr.contains("2018b has no place for"),
        "{}",
        ended.stderr
    );
    let text = std::fs::read_to_string(home.files().join("a.xml")).unwrap();
    assert!(text.contains("commonRoadVersion=\"2018b\""));
    assert_eq!(
        read(text.as_bytes(), "a.xml").unwrap().obstacles.len(),
        read(bundled_xml(CUT_IN).as_bytes(), "b.xml")
            .unwrap()
            .obstacles
            .len()
    );
    assert!(home.files().join("a.ego_trajectory.csv").is_file());
    home.run(&[
        "convert",
        CUT_IN,
        "--format",
        "commonroad-2018b",
        "--schema",
    ])
    .status(2)
    .says(&["--schema applies to CommonRoad"]);
}
