//! What is told of planners that fail, that move as no vehicle can, and that are others than before.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use super::plan::lines;
use super::planners::FAKE;
use super::support::program::Home;
use super::{CUT_IN, bundled_xml};

const BRAKING: &str = "ZAM_HardBraking-1_1_T-1";

fn home() -> Home {
    let home = Home::new();
    home.write("fake.sh", FAKE);
    home
}

#[test]
fn a_failure_says_its_name_the_step_the_place_and_the_last_words() {
    let home = home();
    std::fs::write(
        home.config().join("config.toml"),
        "[planner.slow]\ncommand = \"sh fake.sh hang\"\ntimeout = 2\n[planner.never]\ncommand = \"sh fake.sh hang_at_start\"\nstart_timeout = 0.5\n",
    )
    .unwrap();
    for (planner, parts) in [
        (
            "sh fake.sh die",
            &["died at step 3", "exit status 7", "stderr: boom"][..],
        ),
        (
            "sh fake.sh die_at_start",
            &["died at step 0", "stderr: no map for this"],
        ),
        (
            "sh fake.sh null",
            &[
                "nonsense at step 3",
                "`states[1].x` is null, expected a number",
            ],
        ),
        (
            "sh fake.sh nan",
            &["not_finite at step 3", "`states[0].x` is NaN"],
        ),
        (
            "slow",
            &["cycle_timeout at step 3", "--set timeout", "`timeout`"],
        ),
        (
            "never",
            &[
                "start_timeout at step 0",
                "`start_timeout` of [planner.NAME]",
            ],
        ),
    ] {
        let table = home.run(&["plan", CUT_IN, "--planner", planner]).status(1);
        for part in parts {
            assert!(
                table.stdout.contains(part),
                "{planner}: {part}: {}",
                table.stdout
            );
        }
        assert!(!table.stdout.contains("f64"), "{}", table.stdout);
    }
    for command in ["plan", "generate"] {
        home.run(&[command, CUT_IN, "--planner", "no-such-program fake.py"])
            .status(2)
            .says(&["--planner no-such-program fake.py: no such program: no-such-program"]);
    }
    let attacked = ["generate", CUT_IN, "--planner", "sh fake.sh die"];
    let ended = home.run(&attacked).status(1);
    ended.says(&["died at step 3", "stderr: boom"]);
    let json = home.run(&[&attacked[..], &["--format=json", "--report", "report.json"]].concat());
    let line = &lines(&json)[0];
    assert_eq!(line["external_planner"]["error"], "died", "{line}");
    assert_eq!(line["external_planner"]["error_step"], 3);
    assert_eq!(line["external_planner"]["stderr"][0], "boom");
    let report = std::fs::read_to_string(home.files().join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    assert_eq!(
        (&report["planner_failed"], &report["not_driven"]),
        (&1.into(), &1.into())
    );
    let asked = ["inspect", CUT_IN, "--ego", "planner:sh fake.sh die"];
    home.run(&asked)
        .status(2)
        .says(&["died at step 3", "stderr: boom"]);
}

#[test]
fn steps_that_no_vehicle_can_do_are_remarked_and_not_judged() {
    let home = home();
    let told = ["plan", CUT_IN, "--planner", "sh fake.sh"];
    let table = home.run(&told).stdout;
    assert!(
        table.contains("beyond the vehicle, first: step 0, worst: displacement "),
        "{table}"
    );
    assert!(
        table.contains("drives with steps beyond the vehicle: 1;"),
        "{table}"
    );
    let said = home.run(&[&told[..], &["--format=json"]].concat()).json();
    let worst = &said["beyond_vehicle"]["worst"];
    assert_eq!(worst["bound"], "displacement", "{said}");
    assert!(worst["value"].as_f64() > worst["limit"].as_f64());
    for finding in said["rules"].as_array().unwrap() {
        assert_ne!(finding["status"], "broken", "{finding}");
    }
    let sound = home.run(&["plan", CUT_IN, "--planner", "nearmiss"]).stdout;
    assert!(!sound.contains("beyond the vehicle"), "{sound}");
}

#[test]
fn a_run_is_continued_with_its_table_by_the_same_planner_alone() {
    let home = home();
    for name in [CUT_IN, BRAKING] {
        home.write(format!("all/{name}.xml"), bundled_xml(name));
    }
    std::fs::create_dir(home.files().join("out")).unwrap();
    let plan = [
        "plan",
        "all",
        "-o",
        "out",
        "--set=replan=20",
        "--resume",
        "--table",
        "drives.csv",
        "--planner",
        "sh fake.sh",
    ];
    let run = |more: &[&str]| home.run(&[&plan[..], more].concat());
    let first = run(&[]);
    let csv = || std::fs::read_to_string(home.files().join("drives.csv")).unwrap();
    let before = csv();
    let header = before.lines().next().unwrap().to_string();
    for column in [
        "rules_broken",
        "rule_red_light",
        "beyond_vehicle.worst.bound",
        "external_planner.stderr",
        "external_planner.error_step",
    ] {
        assert!(
            header.split(',').any(|name| name == column),
            "{column}: {header}"
        );
    }
    let again = run(&[]);
    assert_eq!(again.status, first.status, "{}", again.stderr);
    // Drives of an earlier run stand in the table like new ones.
    assert_eq!(again.stdout, first.stdout);
    assert_eq!(csv(), before);
    // One scenario less was finished: the table is whole again.
    std::fs::remove_dir_all(home.files().join("out").join(BRAKING)).unwrap();
    let third = run(&[]).says(&["1 drive of an earlier run kept"]);
    assert_eq!(third.stdout.lines().count(), first.stdout.lines().count());
    home.run(&[&plan[..4], &["--resume", "--set=replan=5"], &plan[8..]].concat())
        .status(2)
        .says(&["replan 20, now 5"]);
    home.write("drives.csv", "mine");
    run(&[])
        .status(2)
        .says(&["drives.csv: exists, and is not the table of the run"]);
    assert_eq!(csv(), "mine");
    std::fs::remove_file(home.files().join("drives.csv")).unwrap();
    home.write(
        "fake.sh",
        FAKE.replace("\"version\":\"2\"", "\"version\":\"3\""),
    );
    run(&[])
        .status(2)
        .says(&["of planner fake 2, which is fake 3 now"]);
}

#[test]
fn a_planner_is_compared_with_the_recorded_ego_and_failed_drives_are_in_no_mean() {
    let home = home();
    home.write(format!("{CUT_IN}.xml"), bundled_xml(CUT_IN));
    home.write(
        format!("{CUT_IN}.ego_trajectory.csv"),
        super::bundled_ego(CUT_IN),
    );
    let file = format!("{CUT_IN}.xml");
    let told = [
        "plan",
        &file,
        "--planner",
        "nearmiss",
        "--planner",
        "recorded",
    ];
    let table = home.run(&told);
    assert!(
        table.stdout.contains("recorded"),
        "{} {}",
        table.stdout,
        table.stderr
    );
    let drives = lines(&home.run(&[&told[..], &["--format=json"]].concat()));
    assert_eq!(drives[1]["planner"], "recorded", "{}", drives[1]);
    assert_eq!(drives[1]["cycles"], 0);
    assert!(drives[1]["steps"].as_u64().unwrap() > 10);
    assert_eq!(
        drives[1]["rules_broken"],
        drives[1]["recorded_rules_broken"]
    );
    assert_eq!(drives[1]["rules"], drives[1]["recorded_rules"]);
    let differences = drives.last().unwrap()["differences"].as_array().unwrap();
    let beyond = differences
        .iter()
        .find(|one| one["figure"] == "undrivable_drives")
        .unwrap();
    // Recordings are not held to the limits of the vehicle, so there is nothing to compare.
    assert!(beyond["first"].is_number() && beyond["second"].is_null());
    assert_eq!(
        (&beyond["scenarios"], &beyond["difference"]),
        (&0.into(), &Value::Null)
    );
    let broken = [
        "plan",
        CUT_IN,
        "--planner",
        "nearmiss",
        "--planner",
        "sh fake.sh die",
        "--format=json",
    ];
    let drives = lines(&home.run(&broken));
    let differences = drives.last().unwrap()["differences"].as_array().unwrap();
    let of = |name: &str| {
        differences
            .iter()
            .find(|one| one["figure"] == name)
            .unwrap()
    };
    assert_eq!(of("mean_jerk")["scenarios"], 0);
    assert_eq!(of("planner_error")["scenarios"], 1);
    // Why a recorded ego cannot be read is said.
    let ego = super::bundled_ego(CUT_IN);
    let twice = format!("{ego}{}\n", ego.trim_end().lines().last().unwrap());
    home.write(format!("{CUT_IN}.ego_trajectory.csv"), twice);
    let unread = home.run(&told).status(2);
    unread.says(&["no recorded ego to compare with", "given twice"]);
    home.run(&["plan", CUT_IN, "--planner", "recorded"])
        .status(2)
        .says(&["no planner of this name"]);
}

/// Drives as the planner behind it, and ends with an error in every drive but the first.
const BREAKS: &str = r#"
import json, os, subprocess, sys
inner = subprocess.Popen([sys.executable, sys.argv[1]], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
plans = 0
for line in sys.stdin:
    kind = json.loads(line)["type"]
    if kind == "bye":
        open("drove", "w").close()
        break
    plans += kind == "plan"
    if plans > 3 and os.path.exists("drove"):
        sys.exit("broken under attack")
    inner.stdin.write(line)
    inner.stdin.flush()
    answer = inner.stdout.readline().replace('"reusable": true', '"reusable": false')
    print(answer, end="", flush=True)
"#;

fn minimal() -> Option<PathBuf> {
    let mut python = Command::new("python3");
    let there = python.arg("--version").stdout(Stdio::null()).status();
    if !there.is_ok_and(|status| status.success()) {
        crate::support::program::skipped("no python3");
        return None;
    }
    Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/planners/minimal.py"))
}

#[test]
fn an_attack_that_breaks_the_planner_is_an_outcome_of_its_own() {
    let Some(minimal) = minimal() else { return };
    let home = Home::new();
    home.write("breaks.py", BREAKS);
    home.write("original.xml", bundled_xml(CUT_IN));
    let planner = format!("python3 breaks.py '{}'", minimal.display());
    let made = [
        "generate",
        "original.xml",
        "--planner",
        &planner,
        "--candidates",
        "20",
        "-o",
        "out",
        "--format=json",
    ];
    let ended = home.run(&made).status(0);
    let line = &lines(&ended)[0];
    assert_eq!(line["outcome"], "planner_error", "{line}");
    assert_eq!(line["external_planner"]["error"], "died", "{line}");
    assert_eq!(line["external_planner"]["error_step"], 3);
    let stderr = line["external_planner"]["stderr"].to_string();
    assert!(stderr.contains("broken under attack"), "{stderr}");
    assert!(
        line["avoidable"].is_null() && line["good_driver"].is_null(),
        "{line}"
    );
    let variant = line["variant"].as_str().unwrap();
    let manifest = home.files().join(Path::new(variant).with_extension("json"));
    let manifest: Value =
        serde_json::from_str(&std::fs::read_to_string(manifest).unwrap()).unwrap();
    assert_eq!(manifest["planner_error"]["error"], "died");
    assert!(manifest["avoidable"].is_null());
    // It has passed the gate like any other, and names the planner.
    let check = home
        .run(&["generate", "original.xml", "--check", variant])
        .status(0);
    assert!(
        check.stdout.contains("attacked planner: minimal 1"),
        "{}",
        check.stdout
    );
    let resumed = home.run(&[&made[..8], &["--resume"]].concat()).status(0);
    for part in [
        "planner_error",
        "reused",
        "1 error of the planner",
        "attacked planner: minimal 1",
    ] {
        assert!(resumed.stdout.contains(part), "{part}: {}", resumed.stdout);
    }
}

#[test]
fn variants_of_another_version_of_the_planner_are_not_reused() {
    let Some(minimal) = minimal() else { return };
    let home = Home::new();
    let text = std::fs::read_to_string(minimal).unwrap();
    home.write("mine.py", &text);
    let made = [
        "generate",
        CUT_IN,
        "--planner",
        "python3 mine.py",
        "--candidates",
        "12",
        "-o",
        "out",
        "--format=json",
        "--resume",
    ];
    home.run(&made);
    let same = home.run(&made);
    assert_eq!(lines(&same)[0]["taken_over"], true, "{}", same.stderr);
    let other = text.replace("\"version\": \"1\"", "\"version\": \"2\"");
    assert_ne!(other, text);
    home.write("mine.py", other);
    let ended = home.run(&made).says(&["planner.version \"1\", now \"2\""]);
    assert_eq!(lines(&ended)[0]["taken_over"], false);
    let built_in = [&made[..2], &made[4..]].concat();
    home.run(&built_in)
        .says(&["planner `python3 mine.py`, now the built-in one"]);
}
