//! `inspect --format json` with everything that a file says, `inspect --ego`, and the workbench's `--ego` without a terminal.

use nearmiss::scenario::VehicleModel;
use serde_json::{Value, json};

use super::egos::solution;
use super::rich::RICH;
use super::support::program::Home;
use super::{BUNDLED, CUT_IN, bundled_ego, bundled_xml};

/// The thing with this id in a list.
#[track_caller]
fn with_id(list: &Value, id: i64) -> &Value {
    let found = list.as_array().unwrap().iter().find(|v| v["id"] == id);
    found.expect("the id is there")
}

/// Fails unless `value` has all the entries of `expected`; it may have more.
#[track_caller]
fn holds(value: &Value, expected: Value) {
    for (key, wanted) in expected.as_object().unwrap() {
        assert_eq!(&value[key], wanted, "{key} of {value}");
    }
}

/// [`RICH`] with heights, references of a stop line, and one road to the left of another.
fn rich() -> String {
    let edits = [
        (
            "<point><x>0</x><y>4</y></point><point><x>50</x><y>5</y></point><lineMarking>broad_dashed",
            "<point><x>0</x><y>4</y><z>1.5</z></point><point><x>50</x><y>5</y><z>2</z></point><lineMarking>broad_dashed",
        ),
        (
            "<lineMarking>solid</lineMarking></stopLine>",
            "<lineMarking>solid</lineMarking><trafficSignRef ref=\"20\"/><trafficLightRef ref=\"30\"/></stopLine>",
        ),
        (
            "<successorsLeft ref=\"2\"/></incoming>",
            "<successorsLeft ref=\"2\"/><isLeftOf ref=\"42\"/></incoming>\
             <incoming id=\"42\"><incomingLanelet ref=\"3\"/></incoming>",
        ),
    ];
    edits.iter().fold(RICH.to_string(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

#[test]
fn the_road_is_printed_with_all_its_details() {
    let home = Home::new();
    home.write("rich.xml", rich());
    let document = home
        .run(&["inspect", "rich.xml", "--format=json"])
        .status(0)
        .json();
    let expected = json!({
        "geo_name_id": 2_867_714, "gps_latitude": 48.25, "gps_longitude": 11.5,
        "geo_transformation": {
            "geo_reference": "EPSG:3857", "x_translation": 1.5, "y_translation": -2.5, "z_rotation": 0.25, "scaling": 2.0,
        },
        "environment": {
            "time": "06:30:00", "time_of_day": "night", "weather": "light_rain", "underground": "ice",
        },
    });
    assert_eq!(document["location"], expected);
    let lanelet = with_id(&document["lanelets"], 1);
    let expected = json!({
        "left_line_marking": "broad_dashed", "right_line_marking": "curb",
        "left_heights": [1.5, 2.0],
        "stop_line": {
            "points": [[49.0, 1.0], [49.0, 5.0]], "line_marking": "solid", "traffic_signs": [20], "traffic_lights": [30],
        },
        "users_one_way": ["car"], "users_bidirectional": ["pedestrian"],
        "traffic_signs": [20], "traffic_lights": [30],
    });
    holds(lanelet, expected);
    assert!(lanelet.get("right_heights").is_none(), "{lanelet}");
    assert_eq!(with_id(&document["lanelets"], 2)["stop_line"], Value::Null);
    let intersection = with_id(&document["intersections"], 40);
    let expected = json!({
        "id": 40,
        "incomings": [
            {
                "id": 41, "lanelets": [1], "successors_right": [3], "successors_straight": [2], "successors_left": [2],
                "is_left_of": 42,
            },
            {
                "id": 42, "lanelets": [3], "successors_right": [], "successors_straight": [], "successors_left": [],
                "is_left_of": null,
            },
        ],
        "crossings": [3],
    });
    assert_eq!(intersection, &expected);
}

#[test]
fn signs_and_lights_are_printed_with_who_refers_to_them() {
    let home = Home::new();
    home.write("rich.xml", rich());
    let document = home
        .run(&["inspect", "rich.xml", "--format=json"])
        .status(0)
        .json();
    let sign = with_id(&document["traffic_signs"], 20);
    let expected = json!({
        "elements": [
            { "id": "274", "additional_values": ["13.89"] },
            { "id": "306", "additional_values": [] },
        ],
        "position": [3.0, -1.0], "virtual": true, "lanelets": [1], "stop_lines": [1],
    });
    holds(sign, expected);
    let light = with_id(&document["traffic_lights"], 30);
    let expected = json!({
        "position": [48.0, -1.0], "active": false, "direction": "leftStraight", "time_offset": 4,
        "lanelets": [1], "stop_lines": [1],
    });
    holds(light, expected);
    let phases = [("red", 7), ("redYellow", 2), ("green", 9), ("yellow", 1)]
        .map(|(color, duration)| json!({ "duration": duration, "color": color }));
    assert_eq!(light["cycle"], json!(phases));
}

#[test]
fn obstacles_and_goals_are_printed_with_their_regions() {
    let home = Home::new();
    home.write("rich.xml", rich());
    let document = home
        .run(&["inspect", "rich.xml", "--format=json"])
        .status(0)
        .json();
    let rectangle = json!({
        "kind": "rectangle", "length": 2.0, "width": 1.0, "center": [4.0, 4.0], "orientation": 0.5, "origin_x_shift": 0.0,
    });
    let pedestrian = with_id(&document["obstacles"], 102);
    assert_eq!(pedestrian["prediction"], "occupancy_set");
    let initial = &pedestrian["states"][0];
    assert_eq!(initial["position"], rectangle);
    assert_eq!(initial["not_said"], json!(["orientation", "velocity"]));
    assert!(initial.get("x").is_none(), "{initial}");
    let occupancies = pedestrian["occupancy_set"].as_array().unwrap();
    assert_eq!(pedestrian["occupancies"], occupancies.len());
    assert_eq!(occupancies[0]["shape"]["kind"], "group");
    assert_eq!(
        occupancies[0]["shape"]["shapes"][1],
        json!({ "kind": "circle", "radius": 2.0, "center": [5.0, 5.0] })
    );
    assert_eq!(
        occupancies[0]["time_step"].as_array().map(Vec::len),
        Some(2)
    );

    let priority = with_id(&document["obstacles"], 101);
    assert_eq!(priority["prediction"], "trajectory");
    let later = &priority["states"][2];
    assert_eq!(later["time_step"], 2);
    assert_eq!(later["time_interval"], json!([2, 3]));
    assert_eq!(
        later["position"],
        json!({ "kind": "circle", "radius": 1.5, "center": [3.0, 2.0] })
    );
    let signals = &priority["signal_series"];
    assert_eq!(
        signals[0],
        json!({ "time_step": [0, 0], "signals": { "horn": true, "flashingBlueLights": false } })
    );
    holds(
        &signals[1]["signals"],
        json!({ "indicatorLeft": true, "brakingLights": false }),
    );

    let goals = &with_id(&document["planning_problems"], 200)["goals"];
    assert_eq!(
        goals[0]["positions"][0],
        json!({ "kind": "lanelets", "lanelets": [2, 3] })
    );
    assert_eq!(goals[0]["lanelets"], json!([2, 3]));
    assert_eq!(goals[1]["positions"][0]["kind"], "rectangle");
}

#[test]
fn inspect_shows_the_chosen_ego() {
    let home = Home::new();
    home.write("mine.csv", bundled_ego(CUT_IN));
    home.write("two.xml", solution(VehicleModel::Ks, &[9000]));
    let own = home
        .run(&["inspect", CUT_IN, "--format=json"])
        .status(0)
        .json()["ego"]["id"]
        .to_string();
    let cases: [(&[&str], &str); 3] = [
        (&["--ego", "301"], "301, obstacle 301 taken as ego"),
        (&["--ego", "mine.csv"], "recorded in mine.csv"),
        (
            &["--ego", &format!("two.xml#{own}")],
            "solution KS2 of planning problem",
        ),
    ];
    for (ego, words) in cases {
        let mut arguments = vec!["inspect", CUT_IN];
        arguments.extend(ego);
        let shown = home.run(&arguments).status(0).stdout;
        let line = shown.lines().find(|l| l.starts_with("  ego ")).unwrap();
        assert!(
            line.contains(words) && line.contains("steps 0 to 90"),
            "{line}"
        );
        arguments.push("--format=json");
        let document = home.run(&arguments).status(0).json();
        let source = document["ego"]["source"].as_str().unwrap();
        assert!(line.contains(source), "{source}: {line}");
    }
    for (ego, words) in [
        ("5", "no obstacle 5"),
        ("nowhere.csv", "no such file"),
        ("-", "standard input is read for scenarios only"),
    ] {
        home.run(&["inspect", CUT_IN, "--ego", ego])
            .status(2)
            .says(&[words]);
    }
    // What can be shown is shown all the same.
    let ended = home
        .run(&["inspect", CUT_IN, "--ego", "5", "--format=json"])
        .status(2);
    let error = ended.json()["ego"]["error"].to_string();
    assert!(error.contains("no obstacle 5"), "{error}");
    home.run(&["inspect", "two.xml", "--ego", "301"])
        .status(2)
        .says(&["two.xml", "is a solution", "name its scenario"]);
}

#[test]
fn the_workbench_takes_an_ego_for_one_scenario() {
    let home = Home::new();
    home.write("mine.csv", bundled_ego(CUT_IN));
    let recorded = home.run(&[CUT_IN]).status(0).stdout;
    assert_eq!(
        home.run(&[CUT_IN, "--ego", "mine.csv"]).status(0).stdout,
        recorded
    );
    let other = home.run(&[CUT_IN, "--ego", "301"]).status(0).stdout;
    assert!(other.starts_with(CUT_IN) && other != recorded, "{other}");
    for paths in [&[][..], &[BUNDLED[0].0, BUNDLED[1].0]] {
        let mut arguments = paths.to_vec();
        arguments.extend(["--ego", "301"]);
        let ended = home.run(&arguments).status(2);
        assert_eq!(ended.stdout, "");
        ended.says(&["--ego", "one scenario"]);
    }
    for (name, _) in &BUNDLED[..2] {
        home.write(format!("all/{name}.xml"), bundled_xml(name));
    }
    home.run(&["all", "--ego", "301"])
        .status(2)
        .says(&["one scenario", "2"]);
    home.run(&[CUT_IN, "--ego", "5"])
        .status(2)
        .says(&["no obstacle 5"]);
    home.run(&[CUT_IN, "--ego", "#5"])
        .status(2)
        .says(&["planning problem 5"]);
    home.run(&["--ego", "301", "inspect", CUT_IN])
        .status(2)
        .says(&["nearmiss COMMAND FILE --ego"]);
}

#[test]
fn standard_input_is_a_scenario_or_a_table_of_tracks() {
    let home = Home::new();
    for arguments in [&["inspect", "-"][..], &["metrics", "-"], &["convert", "-"]] {
        home.run(arguments)
            .status(2)
            .says(&["standard input is empty"]);
    }
    let scenario = bundled_xml(CUT_IN);
    let ended = home
        .run_with_input(&["inspect", "-"], scenario.as_ref())
        .status(0);
    assert!(ended.stdout.contains("lanelets"), "{}", ended.stdout);
    let mut table = String::from("t,id,x,y\n");
    for step in 0..30 {
        let t = f64::from(step) * 0.1;
        table += &format!("{t:.1},1,{},0\n{t:.1},2,{},0\n", 10.0 * t, 20.0 + 8.0 * t);
    }
    let ended = home
        .run_with_input(&["inspect", "-"], table.as_bytes())
        .status(0);
    assert!(ended.stdout.contains("2 × dynamic car"), "{}", ended.stdout);
    home.write("-", scenario);
    home.run(&["inspect", "./-"]).status(0);
}

#[test]
fn what_the_system_says_is_said_in_plain_words() {
    let home = Home::new();
    home.write("a.csv", "no folder");
    home.write("a folder/keep", "");
    let mut cases: Vec<(&[&str], &str)> = vec![
        (&["inspect", "a.csv/b.xml"], "part of this path is a file"),
        (&["metrics", "nowhere.xml"], "no such file"),
        (&["nowhere.xml"], "no such file"),
        (
            &["prompt", "describe", CUT_IN, "--ego", "a folder"],
            "is a folder, not a file",
        ),
        (&["metrics", CUT_IN, "-o", "a.csv/b.csv"], "a.csv/b.csv: "),
        (&["convert", CUT_IN, "-o", "a.csv/b.xml"], "a.csv/b.xml: "),
        (
            &["evaluate", CUT_IN, "--truth", "a folder"],
            "is a folder, not a file",
        ),
    ];
    if cfg!(target_os = "linux") {
        cases.extend([
            (&["inspect", "/proc/self/mem"][..], "input/output error"),
            (
                &["metrics", CUT_IN, "-o", "/proc/self/a.csv"],
                "/proc/self/a.csv: ",
            ),
            (
                &["convert", CUT_IN, "-o", "/proc/self/a.xml"],
                "/proc/self/a.xml: ",
            ),
        ]);
    }
    for (arguments, words) in cases {
        let ended = home.run(arguments).status(2);
        assert!(
            !ended.stderr.contains("os error") && !ended.stderr.contains(".part"),
            "{arguments:?}: {}",
            ended.stderr
        );
        ended.says(&[words]);
    }
}

/// Floating car data of 40 s: one car behind another.
fn floating_cars() -> String {
    let steps = (0..40).map(|t| {
        let car = |id: &str, x: i64| {
            format!(
                "<vehicle id=\"{id}\" x=\"{x}\" y=\"0\" angle=\"90\" type=\"\" speed=\"10\" pos=\"0\" lane=\"\" slope=\"0\"/>"
            )
        };
        let both = [car("6", 10 * t), car("7", 30 + 10 * t)].concat();
        format!("<timestep time=\"{t}\">{both}</timestep>")
    });
    format!("<fcd-export>{}</fcd-export>", steps.collect::<String>())
}

#[test]
fn what_a_list_shows_can_be_typed() {
    let home = Home::new();
    home.write("cars/fcd.xml", floating_cars());
    let list = home.run(&["inspect", "cars"]).status(0).stdout;
    let shown = list
        .split_whitespace()
        .find(|word| word.contains('#'))
        .unwrap_or_else(|| panic!("{list}"));
    assert!(shown.starts_with("cars/fcd.xml#track="), "{shown}");
    home.run(&["inspect", shown]).status(0);
    let lines = home
        .run(&["inspect", "cars", "--format=json"])
        .status(0)
        .stdout;
    let first: Value = serde_json::from_str(lines.lines().next().unwrap()).unwrap();
    let name = format!("cars/{}", first["scenario"].as_str().unwrap());
    assert!(name.starts_with("cars/fcd-track-"), "{name}");
    home.run(&["inspect", &name]).status(0);
    let said = home.run(&["inspect", "cars/fcd-trick-6"]).status(2).stderr;
    assert!(said.contains("no such file"), "{said}");
}

#[test]
fn several_scenarios_are_rows_the_most_severe_first() {
    let home = Home::new();
    let names = [
        "ZAM_JamTail-1_1_T-1",
        "ZAM_CutIn-1_1_T-1",
        "ZAM_RightTurn-1_1_T-1",
    ];
    let inspect = |more: &[&str]| home.run(&[&["inspect"], &names[..], more].concat());
    let rows = |more: &[&str]| -> Vec<Value> {
        let lines = inspect(&[&["--format=json"], more].concat()).stdout;
        let lines = lines
            .lines()
            .map(|line| serde_json::from_str(line).unwrap());
        lines.collect()
    };
    let all = rows(&[]);
    let severities: Vec<i64> = all
        .iter()
        .map(|row| row["severity"].as_i64().unwrap())
        .collect();
    assert!(all.len() == 3 && severities.is_sorted(), "{severities:?}");
    assert_eq!(rows(&["--top", "1"]), all[..1]);
    let most = all[0]["ttc"].as_f64().unwrap();
    for terms in [format!("ttc<={most}"), format!("ttc <= {most}")] {
        let some = rows(&["--where", &terms]);
        assert!(some.iter().all(|row| row["ttc"].as_f64().unwrap() <= most));
        assert!(some.contains(&all[0]) && some.len() < 3, "{some:?}");
    }
    let manoeuvre = all[0]["manoeuvre"].as_str().unwrap();
    assert!(rows(&["--where", &format!("manoeuvre:{manoeuvre}")]).contains(&all[0]));
    let table = inspect(&[]).status(0).stdout;
    assert_eq!(table.lines().count(), 4, "{table}");
    assert!(
        table.contains("near miss") && table.contains("recorded in"),
        "{table}"
    );
    let csv = inspect(&["--format=csv"]).status(0).stdout;
    assert!(
        csv.starts_with("scenario,file,hash,severity,") && csv.lines().count() == 4,
        "{csv}"
    );
    inspect(&["-o", "rows.parquet"]).status(0);
    assert!(
        std::fs::read(home.files().join("rows.parquet"))
            .unwrap()
            .starts_with(b"PAR1")
    );
    inspect(&["--where", "tcc<1"])
        .status(2)
        .says(&["unknown number `tcc`"]);
    for joint in ["ttc<1.5 && obstacles>2", "ttc<1.5 and obstacles>2"] {
        inspect(&["--where", joint])
            .status(2)
            .says(&["terms stand side by side"]);
    }
    inspect(&["--where", "ttc < 1.5s"])
        .status(2)
        .says(&["`1.5s` is not a number"]);
    inspect(&["--top", "0"]).status(2).says(&["--top"]);
    let piped = home.bytes(&[&["inspect"], &names[..], &["--format=parquet"]].concat());
    assert!(piped.starts_with(b"PAR1"));
    // One is shown as a page, with its moment.
    let page = home.run(&["inspect", names[1]]).status(0).stdout;
    assert!(
        page.contains("  moment      ") && page.contains("(cut_in)"),
        "{page}"
    );
}

#[test]
fn a_story_tells_what_happened() {
    let home = Home::new();
    let told = home
        .run(&["prompt", "describe", "ZAM_CutIn-1_1_T-1", "--story"])
        .status(0)
        .stdout;
    assert!((1..=5).contains(&told.lines().count()), "{told}");
    assert!(
        told.starts_with("At ") && told.contains("the ego drives"),
        "{told}"
    );
    home.run(&[
        "prompt",
        "describe",
        "ZAM_CutIn-1_1_T-1",
        "--story",
        "--frame",
        "ego",
    ])
    .status(2);
}

#[test]
fn what_is_not_read_is_told_by_name() {
    let home = Home::new();
    home.write("cars/a.net.xml", "<net version=\"1.20\"></net>");
    // A map opens by its name, and is no scenario of a folder.
    let page = home.run(&["inspect", "cars/a.net.xml"]).status(0).stdout;
    assert!(page.contains("a map without traffic"), "{page}");
    let said = home.run(&["inspect", "cars"]).status(2).stderr;
    assert!(
        said.contains("a.net.xml (a road network of SUMO, not a scenario)"),
        "{said}"
    );
    home.write("cars/fcd.xml", floating_cars());
    let said = home.run(&["inspect", "cars"]).status(0).stderr;
    assert!(!said.contains("skipped"), "{said}");
    home.write("each/anna.csv", "time,x,y\n0,1,2\n");
    home.write("each/bert.csv", "time,x,y\n0,1,2\n");
    let said = home.run(&["inspect", "each"]).status(2).stderr;
    assert!(
        said.contains("2 files skipped") && said.contains("--columns id=file"),
        "{said}"
    );
}
