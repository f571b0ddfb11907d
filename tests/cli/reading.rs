//! `inspect`, `metrics`, `describe`, what is generated, and the program without a terminal.

use serde_json::Value;

use super::support::program::Home;
use super::{BUNDLED, CUT_IN, bundled_ego, bundled_xml};

fn keys(value: &Value) -> Vec<&str> {
    value
        .as_object()
        .expect("an object")
        .keys()
        .map(String::as_str)
        .collect()
}

fn has(value: &Value, names: &[&str]) {
    for name in names {
        assert!(
            value.get(name).is_some(),
            "`{name}` is not among {:?}",
            keys(value)
        );
    }
}

#[test]
fn inspect_says_what_is_in_a_scenario() {
    let home = Home::new();
    for (name, _) in BUNDLED {
        let ended = home.run(&["inspect", name]).status(0);
        assert!(ended.stdout.starts_with(name), "{}", ended.stdout);
        for word in [
            "hash",
            "CommonRoad 2020a, 0.1 s per step",
            "lanelets",
            "obstacles",
            "recorded in",
        ] {
            assert!(ended.stdout.contains(word), "{word}: {}", ended.stdout);
        }
        let route = ended
            .stdout
            .lines()
            .find(|l| l.starts_with("  route"))
            .expect("a line for the planning problem");
        assert!(
            route.contains("lanelets ") && route.ends_with(" m"),
            "{route}"
        );
        assert_eq!(ended.stderr, "");
    }
    assert!(
        !home.data().join("runs.sqlite").exists(),
        "reading keeps nothing"
    );
}

#[test]
fn inspect_prints_everything_as_json() {
    let home = Home::new();
    for (name, _) in BUNDLED {
        let document = home
            .run(&["inspect", name, "--format=json"])
            .status(0)
            .json();
        assert_eq!(document["benchmark_id"], name);
        assert_eq!(document["time_step_size"], 0.1);
        has(
            &document,
            &[
                "lanelets",
                "traffic_signs",
                "traffic_lights",
                "intersections",
            ],
        );
        has(
            &document,
            &["obstacles", "planning_problems", "hash", "diagnostics"],
        );
        let lanelet = &document["lanelets"][0];
        has(
            lanelet,
            &[
                "id",
                "left_bound",
                "right_bound",
                "predecessors",
                "successors",
            ],
        );
        has(lanelet, &["adjacent_left", "adjacent_right", "types"]);
        assert_eq!(lanelet["left_bound"][0].as_array().map(Vec::len), Some(2));
        for obstacle in document["obstacles"].as_array().unwrap() {
            has(
                obstacle,
                &["id", "role", "type", "shape", "states", "occupancies"],
            );
            has(&obstacle["shape"], &["kind"]);
            has(
                &obstacle["states"][0],
                &["time_step", "x", "y", "orientation"],
            );
        }
        let route = &document["routes"][0];
        assert_eq!(
            route["planning_problem"],
            document["planning_problems"][0]["id"]
        );
        assert_eq!(route["destination"]["goal"], 0, "{route}");
        let (length, legs) = (route["length"].as_f64(), route["legs"].as_array());
        assert!(length.is_some_and(|l| l > 50.0) && legs.is_some_and(|l| !l.is_empty()));
        let problem = &document["planning_problems"][0];
        has(problem, &["id", "initial", "goals"]);
        has(
            &problem["initial"],
            &["x", "y", "orientation", "velocity", "time_step"],
        );
        has(&problem["goals"][0], &["time_step", "lanelets"]);
    }
}

#[test]
fn inspect_names_file_line_and_element_of_what_is_wrong() {
    let home = Home::new();
    let good = bundled_xml(CUT_IN);
    let line_of = |text: &str| 1 + good[..good.find(text).unwrap()].matches('\n').count();
    let x_line = format!("wrong.xml:{}", line_of("<x>"));
    let cut = good.len() / 3 + good[good.len() / 3..].find('\n').unwrap();
    // In Latin-1, where the file does not say that it is.
    let element = good.find("<type>").unwrap() + "<type>".len();
    let latin = [
        &good.as_bytes()[..element],
        b"caf\xe9",
        &good.as_bytes()[element..],
    ]
    .concat();
    let column = 1 + good[..element].lines().last().unwrap().len() + "caf".len();
    let latin_place = format!("latin.xml:{}:{column}: in <commonRoad/", line_of("<type>"));
    let author = good.find("author=\"").unwrap() + "author=\"".len();
    let attribute = [
        &good.as_bytes()[..author],
        b"M\xfcller",
        &good.as_bytes()[author..],
    ]
    .concat();
    let cases: [(&str, Vec<u8>, Vec<&str>); 13] = [
        (
            "other.xml",
            b"<?xml version=\"1.0\"?>\n<note/>".to_vec(),
            vec!["other.xml:2", "<note>", "commonRoad"],
        ),
        (
            "words.xml",
            b"these are words".to_vec(),
            vec!["words.xml: text, not a scenario", "help scenarios"],
        ),
        (
            "empty.xml",
            Vec::new(),
            vec!["empty.xml", "the file is empty"],
        ),
        (
            "cut.xml",
            good.as_bytes()[..cut].to_vec(),
            vec!["cut.xml:", "truncated", "commonRoad"],
        ),
        (
            "tag.xml",
            good.as_bytes()[..cut - 1].to_vec(),
            vec!["tag.xml:", "end of input", "commonRoad"],
        ),
        (
            "bytes.xml",
            vec![0xff, 0x00, 0xfe, 0x3c, 0x80],
            vec!["bytes.xml", "binary data"],
        ),
        (
            "latin.xml",
            latin,
            vec![
                &latin_place,
                "/type>: the byte 0xe9 is not UTF-8",
                "save the file",
            ],
        ),
        (
            "attribute.xml",
            attribute,
            vec!["attribute.xml:2:", "in <commonRoad>: the byte 0xfc"],
        ),
        (
            "packed.xml",
            vec![0x1f, 0x8b, 8, 0],
            vec!["packed.xml", "gzip", "unpack"],
        ),
        (
            "packed.pb",
            vec![0x1f, 0x8b, 8, 0],
            vec!["packed.pb", "gzip", "unpack"],
        ),
        (
            "wrong.xml",
            good.replacen("<x>", "<x>1.2.3 ", 1).into_bytes(),
            vec![&x_line, "1.2.3", "point/x"],
        ),
        (
            "step.xml",
            good.replacen("timeStepSize=\"0.1\"", "timeStepSize=\"-1\"", 1)
                .into_bytes(),
            vec!["step.xml:2", "timeStepSize"],
        ),
        (
            "nan.xml",
            good.replacen("<x>", "<x>NaN</x><x>", 1).into_bytes(),
            vec!["nan.xml:", "NaN"],
        ),
    ];
    for (name, bytes, words) in cases {
        home.write(name, bytes);
        for arguments in [&["inspect", name][..], &["inspect", "--format=json", name]] {
            let ended = home.run(arguments).status(2).says(&words);
            assert_eq!(ended.stdout, "", "{name}");
            assert_eq!(
                ended.stderr.matches('\n').count(),
                1,
                "{name}: {}",
                ended.stderr
            );
        }
    }
    let home = Home::new();
    home.run(&["inspect", "nowhere.xml"]).status(2).says(&[
        "nowhere.xml",
        "no such file",
        "ZAM_CutIn-1_1_T-1",
    ]);
    home.run(&["inspect", "."]).status(2);
}

#[test]
fn every_beginning_of_a_file_is_refused_without_a_panic() {
    let home = Home::new();
    let good = bundled_xml(CUT_IN);
    for part in 1..12 {
        let mut cut = good.len() * part / 12;
        while !good.is_char_boundary(cut) {
            cut -= 1;
        }
        home.write("part.xml", &good[..cut]);
        home.run(&["inspect", "part.xml"])
            .status(2)
            .says(&["part.xml"]);
    }
}

#[test]
fn metrics_are_a_table() {
    let home = Home::new();
    let ended = home.run(&["metrics", CUT_IN]).status(0);
    assert_eq!(
        ended.stderr.lines().count(),
        1,
        "provenance: {}",
        ended.stderr
    );
    let mut reader = csv::Reader::from_reader(ended.stdout.as_bytes());
    let header = reader.headers().unwrap().clone();
    let first: Vec<&str> = header.iter().take(10).collect();
    let expected = [
        "scenario",
        "file",
        "hash",
        "ego",
        "step",
        "time",
        "obstacle",
        "relative_direction",
        "distance",
        "ttc",
    ];
    assert_eq!(first, expected);
    let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
    assert!(rows.len() > 100);
    for row in &rows {
        assert_eq!(&row[0], CUT_IN);
        assert!(
            row[4].parse::<i64>().is_ok() && row[6].parse::<i64>().is_ok(),
            "{row:?}"
        );
        for cell in row.iter().skip(8).filter(|cell| !cell.is_empty()) {
            assert!(cell.parse::<f64>().is_ok_and(f64::is_finite), "{row:?}");
        }
    }
    let lines = home
        .run(&["metrics", CUT_IN, "--format", "json"])
        .status(0)
        .stdout;
    let objects: Vec<Value> = lines
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    assert_eq!(objects.len(), rows.len());
    for (object, row) in objects.iter().zip(&rows) {
        // Behind the version.
        assert_eq!(
            keys(object)[1..=header.len()],
            header.iter().collect::<Vec<_>>()
        );
        let same = |name: &str, cell: &str| match &object[name] {
            Value::Null => cell.is_empty(),
            value => cell.parse::<f64>().ok() == value.as_f64(),
        };
        assert!(
            same("ttc", &row[9]) && same("distance", &row[8]),
            "{object} {row:?}"
        );
    }
}

#[test]
fn metrics_never_overwrite_a_file() {
    let home = Home::new();
    home.run(&["metrics", CUT_IN, "-o", "new.csv"]).status(0);
    let written = std::fs::read_to_string(home.files().join("new.csv")).unwrap();
    assert_eq!(written, home.run(&["metrics", CUT_IN]).stdout);
    home.write("old.csv", "precious");
    home.run(&["metrics", CUT_IN, "-o", "old.csv"])
        .status(2)
        .says(&["old.csv", "already exists", "--overwrite"]);
    assert_eq!(
        std::fs::read(home.files().join("old.csv")).unwrap(),
        b"precious"
    );
    home.run(&["metrics", CUT_IN, "-o", "no/such/folder.csv"])
        .status(2)
        .says(&["folder.csv"]);
}

#[test]
fn metrics_of_a_folder_with_a_broken_file_are_those_of_the_others() {
    let home = Home::new();
    for (name, _) in &BUNDLED[..2] {
        home.write(format!("all/{name}.xml"), bundled_xml(name));
        home.write(format!("all/{name}.ego_trajectory.csv"), bundled_ego(name));
    }
    home.write("all/broken.xml", &bundled_xml(CUT_IN)[..5000]);
    home.write("all/something-else.xml", "<note/>");
    let ended = home
        .run(&["metrics", "all"])
        .status(1)
        .says(&["broken.xml", "1 of 3 scenarios"]);
    for (name, _) in &BUNDLED[..2] {
        let alone = format!("all/{name}.xml");
        let alone = home.run(&["metrics", &alone]).status(0).stdout;
        let rows = alone.split_once('\n').unwrap().1;
        assert!(ended.stdout.contains(rows), "{name}");
    }
    std::fs::create_dir(home.files().join("none")).unwrap();
    home.run(&["metrics", "none"])
        .status(2)
        .says(&["none", "no CommonRoad scenario"]);
    home.run(&["metrics", "all/broken.xml"])
        .status(2)
        .says(&["broken.xml"]);
    home.run(&["metrics"]).status(2);
}

#[test]
fn a_scenario_is_described_in_both_frames() {
    let home = Home::new();
    let ego = home
        .run(&["prompt", "describe", CUT_IN, "--frame", "ego"])
        .status(0)
        .stdout;
    let cartesian = home
        .run(&["prompt", "describe", CUT_IN, "--frame", "cartesian"])
        .status(0)
        .stdout;
    assert!(
        ego.contains("gap long [m]") && ego.contains("Front"),
        "{ego}"
    );
    assert_ne!(ego, cartesian);
    for text in [&ego, &cartesian] {
        assert!(
            text.contains("301") && text.contains("\n0.00,ego,"),
            "{text}"
        );
        assert!(!text.contains("NaN") && !text.contains("inf "), "{text}");
    }
    assert_eq!(ego.matches(",ego,").count(), 10);
    let mut short = vec!["prompt", "describe", CUT_IN, "--at", "40", "--history", "3"];
    let table = home.run(&short).status(0).stdout;
    assert_eq!(table.matches(",ego,").count(), 3);
    short.extend(["--set=form=prose"]);
    let prose = home.run(&short).status(0).stdout;
    assert_eq!(prose.matches("\nt = ").count(), 3);
    // Nothing tells where in the recording it is.
    assert!(prose.contains("t = -0.20 s:") && prose.contains("t = 0.00 s:"));
    assert!(!prose.contains("tep"), "{prose}");
}

#[test]
fn a_description_outside_the_recording_is_refused() {
    let home = Home::new();
    for at in ["91", "-1", "99999999999"] {
        home.run(&["prompt", "describe", CUT_IN, "--at", at])
            .status(2)
            .says(&["--at", at, "0 to 90"]);
    }
    home.run(&["prompt", "describe", CUT_IN, "--at", "soon"])
        .status(2);
    home.run(&["prompt", "describe", CUT_IN, "--set=radius=0"])
        .status(2)
        .says(&["radius"]);
    home.run(&["prompt", "describe", CUT_IN, "--set=radius=NaN"])
        .status(2)
        .says(&["radius"]);
    home.run(&["prompt", "describe", CUT_IN, "--frame", "upside-down"])
        .status(2)
        .says(&["ego, cartesian, metrics, trajectory"]);
    home.run(&["prompt", "describe", CUT_IN, "--ego", "999"])
        .status(2)
        .says(&["999", "301"]);
    home.run(&["prompt", "describe", CUT_IN, "--ego", "301"])
        .status(0);
}

#[test]
fn a_scenario_without_an_ego_says_what_to_do() {
    let home = Home::new();
    home.write("lonely.xml", bundled_xml(CUT_IN));
    home.run(&["inspect", "lonely.xml"]).status(0);
    home.run(&["prompt", "describe", "lonely.xml"])
        .status(0)
        .says(&[
            "the built-in planner drives",
            "NAME.ego_trajectory.csv",
            "--ego",
        ]);
    let (from, to) = ("<planningProblem", "</planningProblem>");
    let mut alone = bundled_xml(CUT_IN);
    let (start, end) = (alone.find(from).unwrap(), alone.rfind(to).unwrap());
    alone.replace_range(start..end + to.len(), "");
    home.write("pairs.xml", &alone);
    let described = home.run(&["prompt", "describe", "pairs.xml"]).status(0);
    described.says(&["the follower of the most dangerous pair", "--ego"]);
    let page = home.run(&["inspect", "pairs.xml"]).status(0).stdout;
    assert!(
        page.contains("taken as ego") && page.contains("the follower of"),
        "{page}"
    );
    let table = home.run(&["metrics", "pairs.xml"]).status(0).stdout;
    assert!(table.contains("taken as ego"), "{table}");
    // Nobody moves: there is nobody to choose.
    let still = alone.replace("dynamicObstacle", "staticObstacle");
    home.write("still.xml", still);
    home.run(&["prompt", "describe", "still.xml"])
        .status(2)
        .says(&[
            "still.xml: no recorded ego",
            "NAME.ego_trajectory.csv",
            "--ego ID",
        ]);
    home.write("lonely.ego_trajectory.csv", "timestep,x_position\n0,1\n");
    let ended = home.run(&["prompt", "describe", "lonely.xml"]).status(2);
    ended.says(&["lonely.ego_trajectory.csv", "line 1", "y_position"]);
    home.write(
        "lonely.ego_trajectory.csv",
        "timestep,x_position,y_position\n0,1,2\n1,x,2\n",
    );
    let ended = home.run(&["prompt", "describe", "lonely.xml"]).status(2);
    ended.says(&["lonely.ego_trajectory.csv", "line 3", "x_position"]);
}

#[test]
fn without_a_terminal_what_is_not_there_is_said_alone() {
    let ended = Home::new().run(&["/nope"]).status(2).says(&["/nope"]);
    assert_eq!(ended.stdout, "");
    assert!(!ended.stderr.contains("verdicts"), "{}", ended.stderr);
}

#[test]
fn without_a_terminal_the_built_in_judge_answers() {
    let home = Home::new();
    let ended = home
        .run(&[])
        .status(0)
        .says(&["no terminal", "reference/geometry"]);
    for command in ["inspect", "metrics", "prompt", "ask", "--help"] {
        assert!(
            ended.stderr.contains(command),
            "{command}: {}",
            ended.stderr
        );
    }
    let lines: Vec<&str> = ended.stdout.lines().collect();
    assert_eq!(lines.len(), BUNDLED.len());
    for (line, (name, collides)) in lines.iter().zip(BUNDLED) {
        assert!(line.starts_with(name), "{line}");
        assert_eq!(line.contains(" no collision "), !collides, "{line}");
    }
    home.run(&["nowhere"]).status(2).says(&["nowhere"]);
}

#[test]
fn usage_errors_have_status_2() {
    let home = Home::new();
    for arguments in [
        &["--no-such-option"][..],
        &["inspect"],
        &["inspect", CUT_IN, "--no-such-option"],
        &["metrics", CUT_IN, "--format", "xls"],
        &["ask", CUT_IN, "--task", "cooking"],
        &["ask", CUT_IN, "--techniques", "magic"],
        &["ask", CUT_IN, "--model", "nothing"],
        &["ask", CUT_IN, "--model", "nobody/nothing"],
        &["completions", "cobol"],
    ] {
        let ended = home.run(arguments).status(2);
        assert!(
            ended.stdout.is_empty() && !ended.stderr.is_empty(),
            "{arguments:?}"
        );
    }
    home.run(&["--version"]).status(0);
    home.run(&["--help"]).status(0);
}

#[test]
fn a_wrong_configuration_is_named_with_its_line() {
    let home = Home::new();
    home.write(
        home.config().join("config.toml"),
        "mouse = true\nradios = 3\n",
    );
    home.run(&["prompt", "describe", CUT_IN])
        .status(2)
        .says(&["config.toml:2", "radios"]);
}

#[test]
fn completions_and_the_manual_page_are_printed() {
    let home = Home::new();
    for shell in ["bash", "zsh", "fish"] {
        let ended = home.run(&["completions", shell]).status(0);
        assert!(
            ended.stdout.contains("nearmiss") && ended.stdout.contains("inspect"),
            "{shell}"
        );
    }
    let manual = home.run(&["completions", "man"]).status(0).stdout;
    assert!(
        manual.contains(".TH") && manual.contains("nearmiss"),
        "{manual}"
    );
}

#[test]
fn a_mistyped_name_means_the_nearest_scenario() {
    let home = Home::new();
    for command in ["inspect", "metrics"] {
        let near = home
            .run(&[command, "ZAM_Cutin-1_1_T1"])
            .status(2)
            .says(&["no such file", CUT_IN]);
        assert!(!near.stderr.contains("ZAM_Merge"), "{}", near.stderr);
        home.run(&[command, "nowhere.xml"])
            .status(2)
            .says(&["no such file", "ZAM_Merge-1_1_T-1"]);
    }
}

#[test]
fn a_file_that_is_cut_off_within_a_tag_is_called_so() {
    let home = Home::new();
    let good = bundled_xml(CUT_IN);
    let tag = good.rfind("<dynamicObstacle id").unwrap();
    for end in [tag + 5, tag + 20] {
        home.write("cut.xml", &good[..end]);
        home.run(&["inspect", "cut.xml"])
            .status(2)
            .says(&["cut.xml:", "truncated"]);
    }
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_refused_at_once() {
    let home = Home::new();
    let pipe = home.files().join("pipe.xml");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(
        made.is_ok_and(|status| status.success()),
        "mkfifo is needed"
    );
    std::fs::create_dir_all(home.config()).unwrap();
    for arguments in [
        &["inspect", "pipe.xml"][..],
        &["metrics", "pipe.xml"],
        &["convert", "pipe.xml"],
        &["prompt", "describe", CUT_IN, "--ego", "pipe.xml"],
        &["metrics", CUT_IN, "--thresholds", "pipe.xml"],
        &["evaluate", CUT_IN, "--truth", "pipe.xml"],
    ] {
        home.run(arguments).status(2).says(&["not a regular file"]);
    }
    std::fs::rename(pipe, home.config().join("config.toml")).unwrap();
    home.run(&["prompt", "describe", CUT_IN])
        .status(2)
        .says(&["not a regular file"]);
    std::fs::remove_file(home.config().join("config.toml")).unwrap();
    let huge = std::fs::File::create(home.files().join("huge.xml")).unwrap();
    huge.set_len(10 << 30).unwrap();
    home.run(&["inspect", "huge.xml"])
        .status(2)
        .says(&["huge.xml: the file is larger than 1024 MiB"]);
}

#[test]
fn an_ego_that_jumps_is_told() {
    let home = Home::new();
    let rows = bundled_ego(CUT_IN);
    let mut lines: Vec<String> = rows.lines().map(str::to_string).collect();
    let mut cells: Vec<&str> = lines[20].split(',').collect();
    let step = cells[1].to_string();
    cells[3] = "99999";
    lines[20] = cells.join(",");
    home.write("jump.csv", lines.join("\n"));
    let ended = home
        .run(&["metrics", CUT_IN, "--ego", "jump.csv"])
        .status(0);
    ended.says(&["jumps", &format!("to {step}"), "1 more jump"]);
    let ended = home.run(&["metrics", CUT_IN]).status(0);
    assert_eq!(
        ended.stderr.lines().count(),
        1,
        "provenance: {}",
        ended.stderr
    );
}

/// A body that nothing sees must not pass in silence: it may be the one that collides.
#[test]
fn an_obstacle_that_is_left_out_is_told_wherever_it_matters() {
    let home = Home::new();
    let xml = bundled_xml(CUT_IN);
    let at = xml.find("<dynamicObstacle id=\"301\"").unwrap();
    let length = at + xml[at..].find("<length>").unwrap() + "<length>".len();
    let changed = [&xml[..length], "-", &xml[length..]].concat();
    let file = home.write("lost.xml", changed);
    home.write("lost.ego_trajectory.csv", bundled_ego(CUT_IN));
    let file = file.to_str().unwrap();
    for command in [
        &["metrics"][..],
        &["prompt", "describe"],
        &["prompt", "show"],
        &["ask"],
    ] {
        let ended = home.run(&[command, &[file]].concat());
        ended.says(&[
            "1 of 10 obstacles ignored",
            "no usable shape: 301",
            "inspect",
        ]);
    }
}
