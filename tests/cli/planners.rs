//! Planners that are processes: those that misbehave end a drive clearly and leave nothing running, and the one of the
//! manual drives.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::plan::lines;
use super::support::program::{Ended, Home};
use super::{BUNDLED, CUT_IN};

/// A planner for `sh`: it stands still, unless its first word says otherwise. It notes its id and that of a child which
/// outlives it unless the whole group is ended.
pub(super) const FAKE: &str = r#"
echo $$ >> ids
sleep 300 < /dev/null > /dev/null 2>&1 &
echo $! >> ids
ready='{"type":"ready","protocol":1,"name":"fake","version":"2","reusable":false}'
# The ego of a request, as a state; times make it last.
answer() {
  ego=${1#*\"ego\":\{}; ego=${ego%%\}*}
  step=${1#*\"step\":}; step=${step%%,*}
  states="{\"t\":0,$ego},{\"t\":10,$ego}"
}
count=0
while read -r line; do
  case "$line" in
    *'"type":"hello"'*)
      case "$1" in
        die_at_start) echo 'no map for this' >&2; exit 3 ;;
        hang_at_start) sleep 300 ;;
        wrong_version) echo '{"type":"ready","protocol":9,"name":"fake"}' ;;
        refuse) echo '{"type":"error","message":"cannot drive\u001b[31m here"}' ;;
        flood_at_start) yes ;;
        flood_without_end) exec cat /dev/zero ;;
        *) printf '%s\n' "$ready" ;;
      esac ;;
    *'"type":"plan"'*)
      count=$((count + 1))
      answer "$line"
      if [ "$count" -gt 3 ]; then
        case "$1" in
          die) echo 'boom' >&2; exit 7 ;;
          close) exec >&-; sleep 300 ;;
          hang) sleep 300 ;;
          nonsense) echo 'planning ...' ;;
          null) states="{$ego},{\"x\":null,\"y\":0,\"heading\":0,\"velocity\":0}" ;;
          nan) states="{\"x\":NaN,\"y\":0,\"heading\":0,\"velocity\":0}" ;;
          empty) states= ;;
          short) states="{$ego}" ;;
          elsewhere) states='{"x":1e6,"y":0,"heading":0,"velocity":0},{"x":1e6,"y":0,"heading":0,"velocity":0}' ;;
          backwards) states="{\"t\":0,$ego},{\"t\":-1,$ego}" ;;
          infeasible) echo '{"type":"error","message":"nothing left","infeasible":true}'; continue ;;
          twice) printf '{"type":"trajectory","step":%s,"states":[%s]}\n' "$step" "$states"; sleep 0.01 ;;
          yesterday) step=0 ;;
        esac
      fi
      case "$1" in
        late) sleep 0.25 ;;
        shouting) head -c 3000000 /dev/zero | tr '\0' 'x' >&2; echo >&2; echo 'last words' >&2 ;;
      esac
      printf '{"type":"trajectory","step":%s,"states":[%s],"ms":0.01}\n' "$step" "$states" ;;
    *) exit 0 ;;
  esac
done
"#;

fn home() -> Home {
    let home = Home::new();
    home.write("fake.sh", FAKE);
    home
}

/// Drives with the fake planner in a mode.
fn drive(home: &Home, mode: &str, more: &[&str]) -> Ended {
    let planner = format!("sh fake.sh {mode}");
    let told = ["plan", CUT_IN, "--planner", &planner, "--format=json"];
    home.run(&[&told[..], more].concat())
}

/// Whether none of the processes that a planner noted is running; a moment is given.
fn nothing_left(home: &Home) {
    let ids = std::fs::read_to_string(home.files().join("ids")).unwrap_or_default();
    let until = Instant::now() + Duration::from_secs(5);
    for id in ids.lines() {
        let runs = || {
            let mut kill = Command::new("sh");
            let kill = kill.args(["-c", "kill -0 \"$0\" 2> /dev/null", id]);
            let there = kill.stdin(Stdio::null()).status().unwrap().success();
            there && !is_zombie(id)
        };
        while runs() {
            assert!(Instant::now() < until, "process {id} is left running");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
    assert!(ids.lines().count() >= 2, "{ids}");
}

/// Ended, and waited for by nobody yet: an orphan in a container without an init.
fn is_zombie(id: &str) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    status
        .rsplit_once(") ")
        .is_some_and(|(_, rest)| rest.starts_with('Z'))
}

#[test]
fn each_misbehaviour_is_a_clear_outcome_and_leaves_nothing_running() {
    for (mode, error, words) in [
        ("die_at_start", "died", "exit status 3"),
        ("hang_at_start", "start_timeout", "0.5 s"),
        (
            "wrong_version",
            "wrong_version",
            "version 9; nearmiss speaks 1",
        ),
        ("refuse", "refused", "cannot drive"),
        (
            "flood_at_start",
            "nonsense",
            "logs belong on standard error",
        ),
        ("flood_without_end", "flood", "more than 8 MiB"),
        ("die", "died", "exit status 7"),
        ("close", "died", "closed its standard output"),
        ("hang", "cycle_timeout", "3 s"),
        ("nonsense", "nonsense", "planning ..."),
        ("nan", "not_finite", "NaN"),
        ("empty", "empty", ""),
        ("short", "too_short", "0 steps"),
        ("elsewhere", "wrong_start", "m away"),
        ("backwards", "wrong_times", "-1 s after 0 s"),
        ("twice", "flood", "asked"),
        ("yesterday", "flood", "it is for step 0, asked was step 3"),
    ] {
        let home = home();
        std::fs::write(
            home.config().join("config.toml"),
            format!("[planner.fake]\ncommand = \"sh fake.sh {mode}\"\nstart_timeout = 0.5\n[planner.slow]\ncommand = \"sh fake.sh {mode}\"\ntimeout = 3\n"),
        )
        .unwrap();
        // On a busy machine, times that are short end other drives, too.
        let name = match mode {
            "hang_at_start" => "fake".into(),
            "hang" => "slow".into(),
            mode => format!("sh fake.sh {mode}"),
        };
        let ended = home
            .run(&["plan", CUT_IN, "--planner", &name, "--format=json"])
            .status(1);
        let said = ended.json();
        let external = &said["external_planner"];
        assert_eq!(said["outcome"], "planner_error", "{mode}: {said}");
        assert_eq!(external["error"], error, "{mode}: {said}");
        let note = said["note"].as_str().unwrap();
        assert!(note.contains(words), "{mode}: {note}");
        assert!(!note.contains('\u{1b}'), "{mode}: {note}");
        let late = ["die", "close", "hang", "nonsense", "nan", "empty", "short"].contains(&mode);
        let at = if mode == "twice" {
            4
        } else {
            i64::from(late) * 3
        };
        if late || mode == "twice" {
            assert_eq!(external["error_step"], at, "{mode}: {said}");
        }
        let written = external["stderr"].to_string();
        assert!(mode != "die" || written.contains("boom"), "{written}");
        assert!(
            mode != "die_at_start" || written.contains("no map"),
            "{written}"
        );
        assert!(
            ended.stderr.contains("an error of the planner"),
            "{}",
            ended.stderr
        );
        nothing_left(&home);
    }
}

#[cfg(unix)]
#[test]
fn no_signal_leaves_a_planner_running() {
    for signal in super::interrupted::signals() {
        let home = home();
        let child = home.start(&["plan", CUT_IN, "--planner", "sh fake.sh hang"]);
        let noted = || std::fs::read_to_string(home.files().join("ids")).unwrap_or_default();
        let until = Instant::now() + Duration::from_secs(30);
        while noted().lines().count() < 2 && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(10));
        }
        let id = child.id().to_string();
        let sent = Command::new("kill").args([signal, &id]).status();
        assert!(sent.unwrap().success());
        let output = child.wait_with_output().unwrap();
        Ended::of(&output).status(130).says(&["interrupted"]);
        nothing_left(&home);
    }
}

#[test]
fn a_planner_that_stands_still_is_driven_to_the_end() {
    let home = home();
    let ended = drive(&home, "", &["--log", "log.jsonl"]);
    let said = ended.json();
    assert_eq!(said["planner"], "sh fake.sh ");
    assert_ne!(said["outcome"], "planner_error", "{said}");
    let external = &said["external_planner"];
    assert_eq!(
        (&external["name"], &external["version"]),
        (&"fake".into(), &"2".into())
    );
    assert!(external["predictions"].is_null() && external["error"].is_null());
    // It has a speed and does not move: no vehicle does that.
    assert!(
        said["beyond_vehicle"]["steps"].as_u64().unwrap() > 0,
        "{said}"
    );
    let overhead = external["median_overhead_ms"].as_f64().unwrap();
    assert!(overhead > 0.0 && overhead < 500.0, "{overhead}");
    nothing_left(&home);
    let log = std::fs::read_to_string(home.files().join("log.jsonl")).unwrap();
    assert_eq!(
        log.lines().count(),
        said["cycles"].as_u64().unwrap() as usize
    );
    let first = log.lines().next().unwrap();
    let first: Value = serde_json::from_str(first).unwrap();
    for unknown in ["candidates", "feasible", "rejected", "wanted_speed", "cost"] {
        assert!(first[unknown].is_null(), "{unknown}: {first}");
    }
    assert!(first["ms"].is_number() && first["states"][0].is_object());
    // In simulated time the drive is the same however long planning takes.
    let again = drive(&home, "", &[]).json();
    for key in [
        "outcome",
        "steps",
        "mean_jerk",
        "collision_with",
        "near_misses",
    ] {
        assert_eq!(again[key], said[key], "{key}");
    }
    let infeasible = drive(&home, "infeasible", &[]).status(1).json();
    assert_eq!(infeasible["outcome"], "infeasible");
    assert_eq!(infeasible["note"], "nothing left");
    assert!(infeasible["external_planner"]["error"].is_null());
}

#[test]
fn standard_error_is_kept_in_bounds_and_written_with_the_log() {
    let home = home();
    let said = drive(&home, "shouting", &["--log", "log.jsonl"]).json();
    assert!(said["external_planner"]["error"].is_null(), "{said}");
    let lines = said["external_planner"]["stderr"].as_array().unwrap();
    assert_eq!(lines.last().unwrap(), "last words");
    let log = std::fs::read_to_string(home.files().join("log.jsonl")).unwrap();
    let last = log.lines().last().unwrap();
    assert!(last.len() < 64 << 10, "{} bytes", last.len());
    let schema = ["help", "json", "--schema", "plan-log-stderr"];
    let schema: Value = serde_json::from_str(&home.run(&schema).status(0).stdout).unwrap();
    let line: Value = serde_json::from_str(last).unwrap();
    assert!(
        jsonschema::validator_for(&schema).unwrap().is_valid(&line),
        "{last}"
    );
    nothing_left(&home);
}

#[test]
fn in_real_time_answers_count_when_they_are_there() {
    let home = home();
    let told = ["--real-time", "--set=timeout=5"];
    let said = drive(&home, "late", &told).json();
    let external = &said["external_planner"];
    assert_eq!(external["clock"], "real");
    assert!(external["error"].is_null(), "{said}");
    assert!(external["late_steps"].as_u64().unwrap() >= 3, "{said}");
    let (cycles, steps) = (&said["cycles"], &said["steps"]);
    assert!(
        cycles.as_u64().unwrap() * 2 < steps.as_u64().unwrap(),
        "{said}"
    );
    // The same planner is waited for in simulated time: a cycle a step.
    let waited = drive(&home, "late", &["--set=replan=20"]).json();
    assert_eq!(waited["external_planner"]["late_steps"], 0);
}

#[test]
fn an_interrupted_drive_leaves_nothing_running() {
    let home = home();
    let mut command = home.command();
    command.args(["plan", CUT_IN, "--planner", "sh fake.sh hang"]);
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let until = Instant::now() + Duration::from_secs(30);
    while std::fs::read_to_string(home.files().join("ids"))
        .unwrap_or_default()
        .lines()
        .count()
        < 2
    {
        assert!(Instant::now() < until, "the planner does not start");
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(300));
    let id = child.id().to_string();
    let interrupted = Command::new("sh")
        .args(["-c", "kill -INT \"$0\"", &id])
        .status();
    assert!(interrupted.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    nothing_left(&home);
}

#[test]
fn what_is_asked_wrongly_is_refused() {
    let home = home();
    let plan = |more: &[&str]| home.run(&[&["plan", CUT_IN][..], more].concat()).status(2);
    plan(&["--planner", "nearmis"]).says(&["no planner of this name", "did you mean `nearmiss`"]);
    plan(&["--planner", "sh 'fake"]).says(&["quote"]);
    plan(&["--planner", "nearmiss", "--real-time"]).says(&["--real-time"]);
    plan(&["--real-time"]);
    let both = ["--planner", "nearmiss"].repeat(2);
    plan(&[&both[..], &["-o", "ego.csv"]].concat()).says(&["without files"]);
    let two = [
        "generate",
        CUT_IN,
        "--planner",
        "nearmiss",
        "--planner",
        "nearmiss",
    ];
    home.run(&two).status(2).says(&["only one"]);
}

/// The folder of planners in Python, and whether there is a Python to run them.
fn python() -> Option<PathBuf> {
    let there = Command::new("python3")
        .arg("--version")
        .stdout(Stdio::null())
        .status();
    if !there.is_ok_and(|status| status.success()) {
        crate::support::program::skipped("no python3");
        return None;
    }
    Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/planners"))
}

#[test]
fn the_planner_of_the_manual_drives_the_bundled_scenarios() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/planners");
    let text = std::fs::read_to_string(folder.join("minimal.py")).unwrap();
    assert!(text.lines().count() <= 40);
    let home = home();
    let manual = home.run(&["help", "planners"]).status(0).stdout;
    assert!(
        manual.contains(&format!("```python\n{text}```\n")),
        "the manual has another text"
    );
    let Some(folder) = python() else { return };
    let planner = format!("python3 '{}'", folder.join("minimal.py").display());
    let names = BUNDLED.map(|(name, _)| name);
    let told = [
        &["plan"],
        &names[..],
        &["--planner", &planner, "--format=json"],
    ]
    .concat();
    let ended = home.run(&told);
    let drives = lines(&ended);
    assert_eq!(drives.len(), BUNDLED.len(), "{}", ended.stderr);
    let arrived = drives
        .iter()
        .filter(|drive| drive["outcome"] == "goal")
        .count();
    for drive in &drives {
        assert!(
            ["goal", "timeout"].contains(&drive["outcome"].as_str().unwrap()),
            "{drive}"
        );
        assert_eq!(drive["external_planner"]["name"], "minimal");
    }
    assert!(arrived >= 3, "{arrived}");
}

#[test]
fn two_planners_are_compared_and_another_one_is_attacked() {
    let Some(folder) = python() else { return };
    let home = home();
    let planner = format!("python3 '{}'", folder.join("minimal.py").display());
    let told = [
        "plan",
        CUT_IN,
        "--planner",
        "nearmiss",
        "--planner",
        &planner,
    ];
    let table = home.run(&told).stdout;
    for part in [
        "nearmiss",
        "scenarios",
        "goal",
        "rear-ended",
        "95 % interval",
        "planner minimal",
    ] {
        assert!(table.contains(part), "{table}");
    }
    let made = [
        "generate",
        CUT_IN,
        "--planner",
        &planner,
        "--candidates",
        "40",
        "-o",
        "out",
        "--format=json",
    ];
    let ended = home.run(&made);
    let line = &lines(&ended)[0];
    assert_eq!(line["planner"], planner.as_str(), "{}", ended.stderr);
    assert!(line["driven"].as_u64().unwrap() > 0, "{line}");
    assert_eq!(line["baseline"], "goal");
    if let Some(variant) = line["variant"].as_str() {
        let manifest = home.files().join(Path::new(variant).with_extension("json"));
        let manifest = std::fs::read_to_string(manifest).unwrap();
        let manifest: Value = serde_json::from_str(&manifest).unwrap();
        assert_eq!(manifest["planning"]["planner"]["name"], "minimal");
    }
}
