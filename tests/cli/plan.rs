//! `plan`: outcomes as table and JSON, what is written and never overwritten, and settings of the planner.

use nearmiss::formats::commonroad::{TrajectoryKind, read, read_solution};
use nearmiss::formats::{Entry, read_ego};
use nearmiss::scenario::{EgoSource, VehicleType};
use nearmiss::{evaluation, planner, simulation};
use serde_json::Value;

use super::support::drives;
use super::support::program::{Ended, Home};
use super::{BUNDLED, CUT_IN, bundled_ego, bundled_xml};

const TURN: &str = "ZAM_RightTurn-1_1_T-1";

/// A road without anything to plan.
pub const NO_PROBLEM: &str = r#"<commonRoad timeStepSize="0.1" commonRoadVersion="2020a" benchmarkID="ZAM_None-1_1_T-1" date="2026-01-31">
  <lanelet id="1">
    <leftBound><point><x>0</x><y>3</y></point><point><x>50</x><y>3</y></point></leftBound>
    <rightBound><point><x>0</x><y>0</y></point><point><x>50</x><y>0</y></point></rightBound>
  </lanelet>
</commonRoad>"#;

pub fn lines(ended: &Ended) -> Vec<Value> {
    let lines = ended.stdout.lines();
    lines.map(|l| serde_json::from_str(l).unwrap()).collect()
}

/// The same without what a clock measured.
fn timeless(mut line: Value) -> Value {
    let object = line.as_object_mut().unwrap();
    for key in ["median_cycle_ms", "longest_cycle_ms", "ms"] {
        object.remove(key);
    }
    line
}

#[test]
fn one_scenario_as_json_and_its_ego_as_csv() {
    let home = Home::new();
    let told = [
        "plan",
        CUT_IN,
        "--set=prediction=recorded",
        "--set=replan=3",
    ];
    let arguments = [&told[..], &["--format=json", "-o"]].concat();
    let ended = home.run(&[&arguments[..], &["ego.csv"]].concat()).status(0);
    assert_eq!(ended.stderr, "");
    let said = ended.json();
    let keys: Vec<&str> = said
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    assert_eq!(
        keys[..5],
        ["schema_version", "scenario", "file", "hash", "planner"]
    );
    assert_eq!(said["outcome"], "goal");
    assert!(said["collision_with"].is_null() && said["goal"] == 0);
    assert!(said["median_cycle_ms"].as_f64().unwrap() > 0.0);
    assert_eq!(
        (&said["prediction"], &said["vehicle"], &said["scenario"]),
        (&"recorded".into(), &2.into(), &CUT_IN.into())
    );
    let count = |key: &str| said[key].as_u64().unwrap();
    assert_eq!(count("cycles"), count("steps").div_ceil(3));

    // What was written is what the library drives.
    let scenario = Entry::of_argument(CUT_IN.as_ref()).read().unwrap();
    let settings = simulation::Settings {
        forecast: planner::Forecast::Recorded,
        replan: 3,
        ..evaluation::default_planning()
    };
    let problem = &scenario.planning_problems[0];
    let drive = drives::drive(&scenario, problem, &settings).unwrap();
    let text = std::fs::read_to_string(home.files().join("ego.csv")).unwrap();
    assert!(
        text.starts_with(
            "ego_id,timestep,x_position,y_position,orientation,velocity,acceleration\n"
        )
    );
    let ego = read_ego(text.as_bytes(), "ego.csv", &scenario, None).unwrap();
    assert_eq!(ego.id, problem.id);
    let track = drive.track();
    let (driven, back): (Vec<_>, Vec<_>) = (track.iter().collect(), ego.track.iter().collect());
    assert_eq!(driven.len(), back.len());
    assert_eq!(said["steps"], driven.len() - 1);
    for ((step, motion), (step_back, motion_back)) in driven.iter().zip(&back) {
        assert_eq!(step, step_back);
        assert_eq!(motion, motion_back, "step {step}");
    }

    // The same again gives the same, but never over a file that is there.
    let refused = home.run(&[&arguments[..], &["ego.csv"]].concat()).status(2);
    assert!(refused.says(&["ego.csv", "--overwrite"]).stdout.is_empty());
    let again = home
        .run(&[&arguments[..], &["again.csv"]].concat())
        .status(0);
    assert_eq!(timeless(again.json()), timeless(said));
    let again = std::fs::read_to_string(home.files().join("again.csv")).unwrap();
    assert_eq!(again, text);
    // `-` is standard output, where then nothing else is.
    let out = home.run(&[&told[..], &["-o", "-"]].concat()).status(0);
    assert_eq!(out.stdout, text);
    home.run(&["plan", CUT_IN, "--format=json", "-o", "-"])
        .status(2);
}

#[test]
fn a_folder_is_written_so_that_it_is_found_again() {
    let home = Home::new();
    std::fs::create_dir(home.files().join("out")).unwrap();
    let ended = home
        .run(&[
            "plan",
            TURN,
            CUT_IN,
            "-o",
            "out",
            "--with-scenario",
            "--solution",
            "out",
            "--log",
            "log.jsonl",
        ])
        .status(0);
    let table: Vec<&str> = ended.stdout.lines().collect();
    assert_eq!(table.len(), 4, "{}", ended.stdout);
    assert!(table[0].starts_with("scenario ") && table[0].contains(" outcome "));
    assert!(table[1].starts_with(TURN) && table[2].starts_with(CUT_IN));
    assert!(table[3].starts_with("2 scenarios: "), "{}", table[3]);

    for name in [TURN, CUT_IN] {
        let copy = home.files().join(format!("out/{name}/{name}.xml"));
        assert_eq!(std::fs::read_to_string(&copy).unwrap(), bundled_xml(name));
        // The scenario is opened with the planned ego.
        let entry = Entry::of_file(&copy);
        let scenario = entry.read().unwrap();
        let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
        assert!(
            matches!(&ego.source, EgoSource::Recording(file) if file.ends_with("ego_trajectory.csv")),
            "{}",
            ego.source
        );
        // The solution says the same of the centre.
        let file = format!("out/solution_KS2_SM1_{name}_2020a.xml");
        let bytes = std::fs::read(home.files().join(&file)).unwrap();
        let solution = read_solution(&bytes, &file).unwrap();
        assert_eq!(solution.benchmark_id(), format!("KS2:SM1:{name}:2020a"));
        let trajectory = &solution.problems[0].trajectory;
        assert_eq!(trajectory.kind(), TrajectoryKind::Ks);
        let states = trajectory.states();
        assert_eq!(states.len(), ego.track.iter().count());
        for (state, (step, motion)) in states.iter().zip(ego.track.iter()) {
            assert_eq!(state.step, step);
            let at = motion.pose.position;
            assert!((state.values[0] - at.x).hypot(state.values[1] - at.y) < 1e-9);
            assert!((state.values[3] - motion.velocity).abs() < 1e-9);
        }
    }
    // A line a cycle: nothing is counted twice or forgotten.
    let log = std::fs::read_to_string(home.files().join("log.jsonl")).unwrap();
    let cycles: Vec<Value> = log
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    let driven = cycles.iter().filter(|c| c["scenario"] == TURN).count();
    let row: Vec<&str> = table[1].split_whitespace().collect();
    assert_eq!(row[5], driven.to_string(), "{row:?}");
    for cycle in &cycles {
        let rejected = cycle["rejected"].as_object().unwrap().values();
        let rejected: u64 = rejected.map(|n| n.as_u64().unwrap()).sum();
        let count = |key: &str| cycle[key].as_u64().unwrap();
        assert_eq!(count("candidates"), count("feasible") + rejected);
        assert_eq!(cycle["cost"].is_null(), cycle["emergency"] == "braking");
        let states = cycle["states"].as_array().unwrap();
        assert!(states.len() > 1 && states.iter().all(|s| s["velocity"].is_number()));
    }
}

#[test]
fn nothing_is_written_over_a_scenario_or_twice() {
    let home = Home::new();
    let xml = bundled_xml(TURN);
    home.write("a.xml", &xml);
    home.write("b/a.xml", &xml);
    std::fs::create_dir(home.files().join("b/c")).unwrap();
    for (arguments, said) in [
        (
            &["a.xml", "-o", "a.xml", "--overwrite"][..],
            "not overwritten",
        ),
        (
            &["a.xml", "--log", "a.xml", "--overwrite"],
            "not overwritten",
        ),
        (&["a.xml", "-o", "x", "--solution", "x"], "two outputs"),
        (&["a.xml", TURN, "-o", "x.csv"], "-o FOLDER"),
        (&["a.xml", "b", "-o", "b"], "both called a"),
        (
            &["a.xml", "-o", "x.csv", "--with-scenario"],
            "needs an existing folder",
        ),
        // Copies would be second scenarios where the first ones are found.
        (
            &["b", "-o", "b", "--with-scenario"],
            "egos are found beside their scenarios",
        ),
        (
            &["b/a.xml", "-o", "b", "--with-scenario", "--overwrite"],
            "a second scenario of the same name",
        ),
        (
            &["b", "-o", "b/c", "--with-scenario"],
            "read from b, so each copy",
        ),
        (
            &["a.xml", "-o", "none/"],
            "-o none/: no such folder; create it first",
        ),
        (
            &["a.xml", "-o", "none/x.csv"],
            "no folder none; create it first",
        ),
        (
            &["a.xml", "--solution", "a.xml/x.xml"],
            "--solution a.xml/x.xml",
        ),
        (
            &["a.xml", TURN, "-o", "none"],
            "none is not one; create it first",
        ),
        (&["a.xml", "--log", "-"], "name a file"),
    ] {
        let ended = home.run(&[&["plan"], arguments].concat()).status(2);
        assert!(ended.says(&[said]).stdout.is_empty(), "{arguments:?}");
    }
    assert_eq!(
        std::fs::read_to_string(home.files().join("a.xml")).unwrap(),
        xml
    );
    assert_eq!(super::metrics::names(&home.files()), ["a.xml", "b"]);
    assert_eq!(
        super::metrics::names(&home.files().join("b")),
        ["a.xml", "c"]
    );
}

#[test]
fn what_cannot_be_planned_is_named_and_counted() {
    let home = Home::new();
    home.write("all/none.xml", NO_PROBLEM);
    home.write("all/turn.xml", bundled_xml(TURN));
    home.write(
        "all/broken.xml",
        "<commonRoad timeStepSize=\"0.1\"><lanelet id=\"x\"",
    );
    let ended = home.run(&["plan", "all"]).status(1).says(&[
        "none.xml: no planning problem",
        "broken.xml",
        "2 of 3 scenarios could not be planned",
    ]);
    assert!(ended.stdout.contains("3 scenarios: ") && ended.stdout.contains(", 2 not planned"));
    // A scenario that has none is a finding, a file that is none a mistake.
    let none = home.run(&["plan", "all/none.xml"]).status(1);
    none.says(&["no planning problem"]);
    home.run(&["plan", "all/broken.xml"]).status(2);
    // The ego starts at 34 m/s.
    let slow = home.run(&["plan", CUT_IN, "--set=vehicle=4"]).status(1);
    slow.says(&["truck reaches at most 22.22 m/s", "vehicle"]);
    let wrong = home.run(&["plan", "all/turn.xml", "--planning-problem", "77"]);
    wrong
        .status(2)
        .says(&["no planning problem 77; the only one is 1"]);
    let problem = read(bundled_xml(TURN).as_bytes(), "turn")
        .unwrap()
        .planning_problems[0]
        .id;
    let right = [
        "plan",
        "all/turn.xml",
        "--planning-problem",
        &problem.to_string(),
        "--format=json",
    ];
    assert_eq!(
        home.run(&right).status(0).json()["planning_problem"],
        problem
    );
}

/// The turn with an obstacle that stands where the ego starts.
fn standing_in_the_ego() -> String {
    let xml = bundled_xml(TURN);
    let scenario = read(xml.as_bytes(), "turn").unwrap();
    let start = scenario.planning_problems[0].initial.point().unwrap();
    let standing = format!(
        "<staticObstacle id=\"9999\"><type>parkedVehicle</type><shape><rectangle><length>4</length><width>2</width>\
         </rectangle></shape><initialState><position><point><x>{}</x><y>{}</y></point></position><orientation><exact>0\
         </exact></orientation><time><exact>0</exact></time></initialState></staticObstacle>\n  <planningProblem",
        start.x, start.y
    );
    xml.replacen("<planningProblem", &standing, 1)
}

#[test]
fn a_collision_is_a_finding() {
    let home = Home::new();
    home.write("stands.xml", standing_in_the_ego());
    let ended = home
        .run(&["plan", "stands.xml", "--format=json"])
        .status(1)
        .says(&["1 of 1 drive ended"]);
    let said = ended.json();
    assert_eq!(said["outcome"], "collision");
    assert_eq!(said["collision_with"], 9999);
    assert_eq!(said["collision_step"], said["first_step"]);
    assert!(said["ego_side"].is_string() && said["other_side"].is_string());
    assert_eq!((&said["steps"], &said["cycles"]), (&0.into(), &0.into()));
    assert!(said["median_cycle_ms"].is_null());
    assert_eq!(said["note"], "contact at the start");
    let table = home.run(&["plan", "stands.xml"]).status(1).stdout;
    let row = table.lines().nth(1).unwrap();
    assert!(row.ends_with("(contact at the start)"), "{row}");
}

#[test]
fn every_scenario_has_a_line_of_json() {
    let home = Home::new();
    home.write("all/a.xml", NO_PROBLEM);
    home.write("all/b.xml", standing_in_the_ego());
    home.write(
        "all/c.xml",
        "<commonRoad timeStepSize=\"0.1\"><lanelet id=\"x\"",
    );
    let said = lines(&home.run(&["plan", "all", "--format=json"]).status(1));
    assert_eq!(said.len(), 3);
    for (line, (name, why)) in said.iter().zip([
        ("a", "a.xml: no planning problem"),
        ("b", ""),
        ("c", "c.xml"),
    ]) {
        assert_eq!(line["scenario"], name);
        assert!(
            line["file"]
                .as_str()
                .unwrap()
                .ends_with(&format!("{name}.xml"))
        );
        assert_eq!(
            line["outcome"].is_null(),
            line["error"].is_string(),
            "{name}"
        );
        assert!(line["error"].as_str().unwrap_or_default().contains(why));
    }
    // The same status as with the table.
    let broken = home.run(&["plan", "all/c.xml", "--format=json"]).status(2);
    assert!(broken.json()["error"].is_string());
}

#[test]
fn drives_that_end_where_they_start_say_so() {
    let home = Home::new();
    // Without a place and from the start on, the goal holds at once.
    let xml = bundled_xml(TURN);
    let (before, goal) = xml.split_once("<goalState>").unwrap();
    let (_, after) = goal.split_once("</goalState>").unwrap();
    let at_once = "<goalState><time><intervalStart>0</intervalStart><intervalEnd>20</intervalEnd></time></goalState>";
    home.write("there.xml", format!("{before}{at_once}{after}"));
    let said = home
        .run(&["plan", "there.xml", "--format=json"])
        .status(0)
        .json();
    assert_eq!(
        (&said["outcome"], &said["steps"]),
        (&"goal".into(), &0.into())
    );
    assert_eq!(said["note"], "goal reached at the start");
    let table = home.run(&["plan", "there.xml"]).status(0).stdout;
    assert!(table.contains("(goal reached at the start)"));
}

#[test]
fn nothing_is_driven_beyond_the_horizon() {
    let home = Home::new();
    let told = ["plan", TURN, "--set=horizon=2"];
    let refused = home
        .run(&[&told[..], &["--set=replan=21"]].concat())
        .status(2);
    refused.says(&["horizon of 2 s has 20 steps of 0.1 s; use at most replan=20"]);
    let most = home
        .run(&[&told[..], &["--set=replan=20", "--format=json"]].concat())
        .json();
    assert_eq!(most["replan"], 20);
    assert!(most["note"].is_null());
}

#[test]
fn a_truck_is_a_truck_when_its_folder_is_opened_again() {
    let home = Home::new();
    let length = |folder: &str| {
        let copy = home.files().join(format!("{folder}/{TURN}/{TURN}.xml"));
        let entry = Entry::of_file(&copy);
        let scenario = entry.read().unwrap();
        let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
        let sizes = ego
            .diagnostics
            .iter()
            .filter(|d| d.message.contains("size"));
        assert_eq!(sizes.count(), 1);
        ego.footprint.shape().size().0
    };
    for folder in ["with", "without"] {
        std::fs::create_dir(home.files().join(folder)).unwrap();
        let mut told = vec!["plan", TURN, "--set=vehicle=4", "--set=replan=10"];
        told.extend(["-o", folder, "--with-scenario"]);
        if folder == "with" {
            told.extend(["--solution", folder]);
        }
        let ended = home.run(&told);
        assert_eq!(
            ended.stderr.contains("cannot hold the vehicle's size"),
            folder == "without",
            "{}",
            ended.stderr
        );
    }
    assert_eq!(length("with"), VehicleType::Truck.length());
    assert_eq!(length("without"), VehicleType::Bmw320i.length());
    // The solution of another motion says nothing about this one.
    let csv = home.files().join(format!("with/{TURN}/ego_trajectory.csv"));
    let text = std::fs::read_to_string(&csv).unwrap();
    let all_but_the_last = text.trim_end().rsplit_once('\n').unwrap().0;
    std::fs::write(&csv, all_but_the_last).unwrap();
    assert_eq!(length("with"), VehicleType::Bmw320i.length());
}

#[test]
fn the_configuration_holds_unless_the_arguments_say_otherwise() {
    let home = Home::new();
    let config = home.config().join("config.toml");
    home.write(
        &config,
        "[planner]\nhorizon = 2\nprediction = \"constant-velocity\"\n\n[planner.weights]\noffset = 7.5\n",
    );
    let of_file = home.run(&["plan", TURN, "--format=json"]).json();
    assert_eq!(
        (&of_file["horizon"], &of_file["prediction"]),
        (&2.0.into(), &"constant-velocity".into())
    );
    let said = home
        .run(&[
            "plan",
            TURN,
            "--format=json",
            "--set=horizon=3.5",
            "--set=replan=3",
            "--set=vehicle=3",
            "--set=prediction=lane",
        ])
        .json();
    assert_eq!(
        (&said["horizon"], &said["prediction"]),
        (&3.5.into(), &"lane".into())
    );
    assert_eq!((&said["replan"], &said["vehicle"]), (&3.into(), &3.into()));
    assert!(said["cycles"].as_u64() < said["steps"].as_u64());

    let printed = home.run(&["config", "print"]).status(0).stdout;
    let line = |start: &str| {
        let found = printed.lines().find(|line| line.starts_with(start));
        found
            .unwrap_or_else(|| panic!("no {start} in {printed}"))
            .to_string()
    };
    assert!(line("horizon = 2").ends_with("config.toml:2"), "{printed}");
    assert!(line("offset = 7.5").ends_with("config.toml:6"));
    assert!(line("replan = 1").ends_with("default"));
    let values: toml::Table = toml::from_str(&printed).unwrap();
    assert_eq!(
        values["planner"]["sampling"]["offsets"].as_integer(),
        Some(9)
    );

    home.write(
        &config,
        "[planner]\nhorizon = 0\nhorizn = 2\nsampling = { offsets = 4 }\n",
    );
    home.run(&["plan", TURN]).status(2).says(&[
        "config.toml:2: planner.horizon = 0: expected a number from 0.5 to 20",
        "config.toml:3: unknown key `planner.horizn`; did you mean `horizon`?",
        "config.toml:4: planner.sampling.offsets = 4: expected an odd number",
    ]);
}

#[test]
fn bad_values_are_refused_with_what_is_allowed() {
    let home = Home::new();
    for (flag, said) in [
        ("--set=horizon=0", "a number from 0.5 to 20"),
        ("--set=horizon=nan", "a number from 0.5 to 20"),
        ("--set=replan=0", "a whole number from 1 to 1000"),
        ("--set=replan=-3", "a whole number from 1 to 1000"),
        ("--set=vehicle=5", "a whole number from 1 to 4"),
        ("--set=prediction=oracle", "constant-velocity"),
        ("--solution-model=ST", "KS, PM"),
    ] {
        home.run(&["plan", TURN, flag]).status(2).says(&[said]);
    }
    home.run(&["plan"]).status(2);
    home.run(&["plan", "nobody.xml"])
        .status(2)
        .says(&["nobody.xml"]);
}

#[test]
fn an_interrupt_ends_with_the_part_that_is_done() {
    let home = Home::new();
    for i in 0..40 {
        home.write(format!("all/s{i:02}.xml"), bundled_xml(TURN));
    }
    std::fs::create_dir(home.files().join("out")).unwrap();
    let mut child = home.start(&["plan", "all", "-o", "out", "--set=replan=4"]);
    // The first line is there: something was driven.
    let mut first = [0; 8];
    std::io::Read::read_exact(child.stdout.as_mut().unwrap(), &mut first).unwrap();
    assert_eq!(&first, b"scenario");
    super::long_jobs::interrupt(&child);
    let ended = Ended::of(&child.wait_with_output().unwrap())
        .status(130)
        .says(&["interrupted after ", " of 40 scenarios"]);
    let rows = ended.stdout.lines().filter(|line| line.starts_with('s'));
    let rows: Vec<&str> = rows.filter_map(|l| l.split_whitespace().next()).collect();
    let rows: Vec<&str> = rows
        .into_iter()
        .filter(|name| *name != "scenario")
        .collect();
    assert!(rows.len() < 40, "{}", ended.stdout);
    assert!(
        ended
            .stdout
            .trim_end()
            .lines()
            .last()
            .unwrap()
            .contains(" scenario")
    );
    // Whole files of those in the table, and no others.
    let written = super::metrics::names(&home.files().join("out"));
    assert_eq!(written, rows);
}

#[test]
fn traffic_rules_are_reported_and_can_be_switched_off() {
    let home = Home::new();
    for (mode, more) in [("obey", &[][..]), ("off", &["--set=rules=off"][..])] {
        let ended = home.run(&[&["plan", TURN, "--format=json"][..], more].concat());
        let said = ended.json();
        assert_eq!(said["rule_mode"], mode);
        let rules = said["rules"].as_array().unwrap();
        assert_eq!(rules.len(), 8);
        for rule in rules {
            let broken = rule["status"] == "broken";
            assert_eq!(broken, rule["violations"][0].is_object(), "{rule}");
            let named = said["rules_broken"].as_array().unwrap();
            assert_eq!(broken, named.contains(&rule["rule"]), "{rule}");
        }
        assert!(said["recorded_rules_broken"].is_array(), "{said}");
        assert_eq!(said["recorded_rules"].as_array().unwrap().len(), 8);
    }
    let ended = home.run(&["plan", TURN, "--set=rules=some"]).status(2);
    assert!(ended.stderr.contains("obey"), "{}", ended.stderr);
}

#[test]
fn every_bundled_scenario_can_be_planned() {
    let home = Home::new();
    let names: Vec<&str> = BUNDLED.iter().map(|(name, _)| *name).collect();
    let ended = home.run(
        &[
            &[
                "plan",
                "--format=json",
                "--set=prediction=recorded",
                "--set=replan=4",
            ],
            &names[..],
        ]
        .concat(),
    );
    let said = lines(&ended.status(0));
    assert_eq!(said.len(), names.len());
    for (line, name) in said.iter().zip(names) {
        assert_eq!(line["scenario"], name);
        assert!(["goal", "timeout"].contains(&line["outcome"].as_str().unwrap()));
    }
}

#[test]
fn without_a_named_problem_the_one_of_the_recorded_ego_is_solved() {
    let home = Home::new();
    let xml = bundled_xml(CUT_IN);
    let start = xml.find("<planningProblem").unwrap();
    let end = xml.find("</planningProblem>").unwrap() + "</planningProblem>".len();
    let own = &xml[start..end];
    let id = own.split('"').nth(1).unwrap();
    // Another problem stands before its own.
    let other = own.replacen(&format!("\"{id}\""), "\"98765\"", 1);
    home.write("two.xml", xml.replacen(own, &format!("{other}{own}"), 1));
    let solved = |more: &[&str]| {
        let arguments = ["plan", "two.xml", "--format=json", "--set=horizon=2"];
        let said = home.run(&[&arguments[..], more].concat()).json();
        said["planning_problem"].to_string()
    };
    assert_eq!(solved(&[]), "98765", "no ego is recorded beside it");
    home.write("two.ego_trajectory.csv", bundled_ego(CUT_IN));
    assert_eq!(solved(&[]), id);
    assert_eq!(solved(&["--planning-problem", "98765"]), "98765");
}

#[test]
fn traffic_that_reacts_is_written_as_it_was_driven() {
    let home = Home::new();
    std::fs::create_dir(home.files().join("out")).unwrap();
    let told = ["plan", CUT_IN, "--set=traffic=reactive", "--format=json"];
    let written = [&told[..], &["-o", "out", "--with-scenario"]].concat();
    let said = home.run(&written).status(0).json();
    assert_eq!(said["traffic"], "reactive");
    let reactions = said["reactions"].as_array().unwrap();
    assert!(!reactions.is_empty(), "{said}");
    assert_eq!(said["reacted"], reactions.len());
    assert_eq!(said["first_reaction_step"], reactions[0]["step"]);
    let recorded = Entry::of_argument(CUT_IN.as_ref()).read().unwrap();
    let driven = home.files().join(format!("out/{CUT_IN}/{CUT_IN}.xml"));
    let driven = Entry::of_file(&driven).read().unwrap();
    for (old, new) in recorded.obstacles.iter().zip(&driven.obstacles) {
        let mut reactions = reactions.iter();
        let reaction = reactions.find(|r| r["obstacle"] == old.id);
        let from = reaction.and_then(|r| r["step"].as_i64());
        for (step, motion) in old
            .track()
            .iter()
            .take_while(|(s, _)| from.is_none_or(|f| *s <= f))
        {
            let there = new.motion_at(step).unwrap();
            let apart = (there.pose.position - motion.pose.position).norm();
            assert!(apart < 1e-6, "{} at step {step}", old.id);
        }
        let last = said["last_step"].as_i64().unwrap();
        let differs = old.motion_at(last) != new.motion_at(last);
        assert!(from.is_none() || differs, "{} is as recorded", old.id);
    }
    // Without it, nothing reacts.
    let said = home
        .run(&["plan", CUT_IN, "--format=json"])
        .status(0)
        .json();
    assert_eq!(
        (&said["traffic"], &said["reacted"]),
        (&"recorded".into(), &0.into())
    );
}
