//! Commands over many files in parts: their union is the whole, and a run that is killed at any moment continues.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use parquet::file::reader::{FileReader, SerializedFileReader};

use super::support::program::Home;
use super::{BUNDLED, CUT_IN, bundled_ego, bundled_xml};

/// A folder of scenarios with their egos.
fn corpus(home: &Home, copies: usize) {
    for (name, _) in BUNDLED {
        for copy in 0..copies {
            home.write(format!("all/{name}-{copy}.xml"), bundled_xml(name));
            let ego = format!("all/{name}-{copy}.ego_trajectory.csv");
            home.write(ego, bundled_ego(name));
        }
    }
}

/// A car ahead of another one that is faster, for a second.
fn pair() -> String {
    let state = |tag: &str, step: i32, x: f64, speed: f64| {
        format!(
            "<{tag}><position><point><x>{x}</x><y>0</y></point></position><orientation><exact>0</exact></orientation>\
             <time><exact>{step}</exact></time><velocity><exact>{speed}</exact></velocity></{tag}>"
        )
    };
    let car = |id: i32, x: f64, speed: f64| {
        let at = |step: i32| x + speed * 0.1 * f64::from(step);
        let later: String = (1..12)
            .map(|step| state("state", step, at(step), speed))
            .collect();
        format!(
            "<dynamicObstacle id=\"{id}\"><type>car</type><shape><rectangle><length>4.5</length><width>1.8</width>\
             </rectangle></shape>{}<trajectory>{later}</trajectory></dynamicObstacle>",
            state("initialState", 0, x, speed)
        )
    };
    let border = |tag: &str, y: i32| {
        let point = |x: i32| format!("<point><x>{x}</x><y>{y}</y></point>");
        format!("<{tag}>{}{}</{tag}>", point(-50), point(150))
    };
    format!(
        "<commonRoad timeStepSize=\"0.1\" commonRoadVersion=\"2020a\" benchmarkID=\"ZAM_Pair-1_1_T-1\" author=\"\" \
         affiliation=\"\" source=\"\" date=\"2024-01-01\"><lanelet id=\"1\">{}{}</lanelet>{}{}</commonRoad>\n",
        border("leftBound", 2),
        border("rightBound", -2),
        car(10, 0.0, 10.0),
        car(11, 20.0, 6.0)
    )
}

/// A folder of many small scenarios.
fn pairs(home: &Home, count: usize) {
    let xml = pair();
    for i in 0..count {
        home.write(format!("all/s{i:04}.xml"), &xml);
    }
}

/// The files below a folder, by their paths in it.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// The parts of a data set, without its journals.
fn parts(home: &Home, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let mut all = files(&home.files().join(folder));
    all.retain(|name, _| name.ends_with(".parquet"));
    all
}

/// Every row of a data set, sorted.
fn rows(home: &Home, folder: &str) -> Vec<String> {
    let mut rows = Vec::new();
    for name in parts(home, folder).keys() {
        let file = std::fs::File::open(home.files().join(folder).join(name)).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        rows.extend(
            reader
                .get_row_iter(None)
                .unwrap()
                .map(|row| row.unwrap().to_string()),
        );
    }
    rows.sort();
    rows
}

#[test]
fn the_union_of_shards_is_the_whole() {
    let home = Home::new();
    corpus(&home, 2);
    for (command, words) in [("metrics", METRICS), ("index", INDEX)] {
        let whole = format!("{command}-whole");
        let run = ["all", "-o", &whole];
        let form: &[&str] = match command {
            "metrics" => &["--format", "parquet"],
            _ => &["--measure", "ttc", "--stride", "2"],
        };
        home.run(&[words, &run, form].concat()).status(0);
        let shards = format!("{command}-shards");
        for shard in ["1/3", "2/3", "3/3"] {
            let run = ["all", "-o", &shards, "--shard", shard];
            home.run(&[words, &run, form].concat()).status(0);
        }
        assert!(!rows(&home, &whole).is_empty());
        assert_eq!(rows(&home, &whole), rows(&home, &shards), "{command}");
        let names: Vec<String> = parts(&home, &shards).into_keys().collect();
        assert_eq!(names[0], "shard=1-of-3/part-00000.parquet");
        // Another division, other settings, or the same again without saying so would mix two tables.
        let again =
            |more: &[&str]| home.run(&[words, &["all", "-o", &shards], form, more].concat());
        again(&["--shard", "1/2"])
            .status(2)
            .says(&["divided otherwise"]);
        again(&["--shard", "1/3"])
            .status(2)
            .says(&["--resume", "--overwrite"]);
        again(&["--shard", "1/3", "--resume", "--radius", "20"])
            .status(2)
            .says(&["other settings"]);
    }
}

const METRICS: &[&str] = &["metrics"];
const INDEX: &[&str] = &["corpus", "index"];

#[test]
fn a_changed_scenario_is_measured_again_and_the_others_are_kept() {
    let home = Home::new();
    pairs(&home, 72);
    let run = [
        "metrics", "all", "--ego", "10", "--format", "parquet", "-o", "out", "--resume",
    ];
    home.run(&run).status(0);
    let before = parts(&home, "out");
    assert_eq!(before.len(), 2, "64 scenarios a part");
    let time = |name: &str| {
        let path = home.files().join("out").join(name);
        path.metadata().unwrap().modified().unwrap()
    };
    let names: Vec<String> = before.keys().cloned().collect();
    let (first, last) = (time(&names[0]), time(&names[1]));
    home.run(&run).status(0);
    assert_eq!((time(&names[0]), time(&names[1])), (first, last));
    // One of the last part is broken now: its rows go, and the command says so each time.
    home.write("all/s0071.xml", "<commonRoad commonRoadVersion=\"2020a\">");
    for _ in 0..2 {
        home.run(&run).status(1).says(&["1 of 72 scenarios"]);
    }
    assert_eq!(time(&names[0]), first);
    let after = parts(&home, "out");
    assert_eq!(before[&names[0]], after[&names[0]]);
    assert!(before[&names[1]] != after[&names[1]]);
    // A damaged part is made again.
    std::fs::write(home.files().join("out").join(&names[0]), "PAR1").unwrap();
    home.run(&run).status(1);
    assert_eq!(parts(&home, "out"), after);
}

/// Runs a command, kills it after random times, and continues until it ends by itself; how often it was killed.
fn until_done(home: &Home, arguments: &[&str], kills: u32, seed: u64) -> u32 {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut killed = 0;
    loop {
        let mut child = home.start(arguments);
        if killed < kills {
            std::thread::sleep(Duration::from_millis(random.u64(5..400)));
            child.kill().unwrap();
        }
        let ended = child.wait_with_output().unwrap();
        match ended.status.code() {
            None => killed += 1,
            Some(status) => {
                let said = String::from_utf8_lossy(&ended.stderr);
                assert_eq!(status, 0, "{said}");
                return killed;
            }
        }
    }
}

#[test]
fn a_killed_run_continues_to_the_same_files() {
    let home = Home::new();
    pairs(&home, 200);
    let kills = std::env::var("NEARMISS_KILLS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(2);
    for (command, words, form) in [
        (
            "metrics",
            METRICS,
            &["--ego", "10", "--format", "parquet"][..],
        ),
        ("index", INDEX, &[][..]),
    ] {
        for shards in [&[][..], &["--shard", "2/3"][..]] {
            let seed = shards.len() as u64 + 7;
            let folder = |kind: &str| format!("{command}-{kind}-{}", shards.len());
            let (whole, torn) = (folder("whole"), folder("torn"));
            let run = |folder: &str| -> Vec<String> {
                let all = ["all", "-o", folder, "--resume"];
                let all = words.iter().chain(&all).chain(form).chain(shards);
                all.map(ToString::to_string).collect()
            };
            let words = run(&whole);
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            home.run(&words).status(0);
            let words = run(&torn);
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            let killed = until_done(&home, &words, kills, seed);
            println!("{command} {shards:?}: killed {killed} times");
            let (whole, torn) = (parts(&home, &whole), parts(&home, &torn));
            assert!(!whole.is_empty());
            assert!(whole == torn, "{command} {shards:?}");
        }
    }
}

#[test]
fn converted_and_drawn_files_are_kept_and_never_taken_from_others() {
    let home = Home::new();
    corpus(&home, 1);
    std::fs::create_dir(home.files().join("out")).unwrap();
    std::fs::create_dir(home.files().join("whole")).unwrap();
    for (command, more) in [("convert", &[][..]), ("render", &["--format", "svg"][..])] {
        let run = |folder: &str, extra: &[&str]| {
            home.run(&[&[command, "all", "-o", folder], more, extra].concat())
        };
        run("whole", &[]).status(0);
        run("out", &["--shard", "1/2", "--resume"]).status(0);
        let half = files(&home.files().join("out")).len();
        run("out", &["--shard", "2/2", "--resume"]).status(0);
        assert!(half < files(&home.files().join("out")).len());
        run("out", &["--shard", "2/2", "--resume"]).status(0);
    }
    let mut made = files(&home.files().join("out"));
    let journals = made.len();
    made.retain(|name, _| !name.starts_with("_nearmiss"));
    assert_eq!(journals - made.len(), 4);
    assert_eq!(made, files(&home.files().join("whole")));
    // What was written last before a kill is there without a line in the journal.
    let journal = home.files().join("out/_nearmiss/convert-1-of-2.jsonl");
    let lines = std::fs::read_to_string(&journal).unwrap();
    let header = lines.lines().next().unwrap();
    std::fs::write(&journal, format!("{header}\n")).unwrap();
    let again = ["convert", "all", "-o", "out", "--shard", "1/2", "--resume"];
    home.run(&again).status(0);
    // What somebody else has written there stays.
    let name = made.keys().find(|n| n.ends_with(".xml")).unwrap().clone();
    std::fs::write(home.files().join("out").join(&name), "mine").unwrap();
    for shard in ["1/2", "2/2"] {
        home.run(&["convert", "all", "-o", "out", "--shard", shard, "--resume"]);
    }
    assert_eq!(
        std::fs::read(home.files().join("out").join(&name)).unwrap(),
        b"mine"
    );
    home.run(&["convert", CUT_IN, "--resume"])
        .status(2)
        .says(&["--output"]);
}

#[test]
fn drives_are_kept_with_their_outcomes() {
    let home = Home::new();
    for name in [CUT_IN, "ZAM_HardBraking-1_1_T-1"] {
        home.write(format!("all/{name}.xml"), bundled_xml(name));
    }
    std::fs::create_dir(home.files().join("out")).unwrap();
    let run = |more: &[&str]| {
        let plan = [
            "plan",
            "all",
            "-o",
            "out",
            "--set=replan=20",
            "--format=json",
            "--resume",
        ];
        home.run(&[&plan[..], more].concat())
    };
    let first = run(&[]);
    let before = files(&home.files().join("out"));
    let again = run(&[]).says(&["2 drives of an earlier run kept"]);
    assert_eq!(again.status, first.status);
    assert_eq!(again.stdout, first.stdout);
    assert_eq!(files(&home.files().join("out")), before);
    run(&["--log", "log.json"]).status(2).says(&["--log"]);
    run(&["--set=horizon=3"])
        .status(2)
        .says(&["other settings"]);
}

/// The first line of a journal of the first layout: a hash of its settings, and of drives words for them.
fn first_layout(home: &Home, command: &str, named: &str) {
    let path = home.files().join(format!("out/_nearmiss/{command}.jsonl"));
    let lines = std::fs::read_to_string(&path).unwrap();
    let units = lines.split_once('\n').unwrap().1;
    let version = env!("CARGO_PKG_VERSION");
    let header = format!(
        r#"{{"command":"{command}","shard":null,"settings":"a6456b6299ae44","version":"{version}"{named}}}"#
    );
    std::fs::write(path, format!("{header}\n{units}")).unwrap();
}

/// The settings of drives with a horizon of 2.5 s, as the first layout had them.
const FIRST_LAYOUT: &str = r#","named":{"braking":"6.0","horizon":"2.5","low_speed":"4.0","margin":"0.1","planner":"nearmiss","prediction":"lane","reaction":"0.5","replan":"1","rules":"obey","sampling.changes":"2","sampling.durations":"4","sampling.offsets":"9","sampling.refinements":"2","sampling.speeds":"9","sampling.widest":"3.5","share":"0.95","solution":"out","solution-model":"KS","traffic":"recorded","vehicle":"2","weights.acceleration":"0.1","weights.clearance":"40.0","weights.following":"60.0","weights.lateral_jerk":"0.05","weights.longitudinal_jerk":"0.02","weights.offset":"2.0","weights.risk":"1.0","weights.speed":"1.0"}"#;

#[test]
fn runs_of_the_first_layout_of_journals_are_continued_or_refused_and_lose_nothing() {
    let home = Home::new();
    home.write("all/one.xml", bundled_xml(CUT_IN));
    std::fs::create_dir(home.files().join("out")).unwrap();
    let plan = [
        "plan",
        "all",
        "-o",
        "out",
        "--solution",
        "out",
        "--set=horizon=2.5",
        "--resume",
    ];
    let first = home.run(&plan);
    first_layout(&home, "plan", FIRST_LAYOUT);
    let before = files(&home.files().join("out"));
    let again = home.run(&plan).says(&["1 drive of an earlier run kept"]);
    assert_eq!(again.status, first.status);
    home.run(&[&plan[..], &["--set=horizon=3"]].concat())
        .status(2)
        .says(&["other settings", "horizon 2.5, now 3.0"]);
    home.run(&[&plan[..], &["--monitor", "reference/geometry"]].concat())
        .status(2)
        .says(&["monitor not given, now \"reference/geometry\""]);
    assert_eq!(files(&home.files().join("out")), before);

    // What says nothing of its settings is refused.
    std::fs::remove_dir_all(home.files().join("out")).unwrap();
    std::fs::create_dir(home.files().join("out")).unwrap();
    let convert = ["convert", "all", "-o", "out"];
    home.run(&[&convert[..], &["--resume"]].concat()).status(0);
    first_layout(&home, "convert", "");
    let before = files(&home.files().join("out"));
    home.run(&[&convert[..], &["--resume"]].concat())
        .status(2)
        .says(&["does not say with which settings", "--overwrite"]);
    assert_eq!(files(&home.files().join("out")), before);
    home.run(&[&convert[..], &["--overwrite"]].concat())
        .status(0);
}
