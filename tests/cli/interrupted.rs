//! An answer that is paid for is in the store, however the program ends.

use std::time::{Duration, Instant};

use nearmiss::store::{LEASE, RunId, RunState, Store};

use super::remote::delta;
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};
use super::{CUT_IN, bundled_ego, bundled_xml};

const SAID: [&str; 3] = ["The car in front ", "brakes — 車 — ", "and then"];

/// Starts a question whose answer stops half-way, and waits until all that was said is in the store.
async fn half_an_answer(home: &Home) -> (Server, std::process::Child) {
    let script = SAID
        .iter()
        .fold(Script::chunked_events(), |s, text| s.chunk(delta(text)));
    let server = Server::start(vec![script.await_close()]).await;
    let arguments = [
        "ask",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--base-url",
        server.base_url(),
        "--format=json",
    ];
    let child = home.start(&arguments);
    let begun = Instant::now();
    let kept = || {
        let rows = home.rows("SELECT text FROM pieces ORDER BY id");
        rows.iter()
            .filter_map(|row| row["text"].clone())
            .collect::<String>()
    };
    while kept() != SAID.concat() {
        assert!(
            begun.elapsed() < Duration::from_secs(20),
            "only `{}` is in the store",
            kept()
        );
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    (server, child)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_arrived_before_a_kill_is_in_the_store() {
    let home = Home::new();
    let (_server, mut child) = half_an_answer(&home).await;
    child.kill().unwrap();
    let status = tokio::task::block_in_place(|| child.wait()).unwrap();
    assert_eq!(status.code(), None, "killed");
    assert_eq!(home.runs()[0]["state"].as_deref(), Some("running"));
    let killed = || {
        let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
        store.run(RunId(1)).unwrap().expect("the run is there")
    };
    assert_eq!(killed().answer, SAID.concat());
    // Its claim is not renewed.
    let begun = Instant::now();
    while killed().ending.state != RunState::Interrupted {
        assert!(begun.elapsed() < LEASE + Duration::from_secs(20));
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    assert_eq!(killed().answer, SAID.concat());
    let shown = tokio::task::block_in_place(|| home.run(&["runs", "show", "1"]).status(0).stdout);
    assert!(
        shown.contains("interrupted") && shown.contains(&SAID.concat()),
        "{shown}"
    );
    // The next question is not disturbed by it.
    tokio::task::block_in_place(|| home.run(&["ask", CUT_IN]).status(0));
    assert_eq!(home.runs().len(), 2);
}

#[cfg(unix)]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_interrupt_closes_the_connection_and_is_written_down() {
    let home = Home::new();
    let (server, child) = half_an_answer(&home).await;
    let id = child.id().to_string();
    let sent = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status()
        .unwrap();
    assert!(sent.success());
    let output = tokio::task::block_in_place(|| child.wait_with_output()).unwrap();
    let ended = Ended::of(&output).status(130).says(&[
        "interrupted",
        "partial answer is stored",
        "runs show 1",
    ]);
    assert_eq!(ended.stdout, "");
    assert!(server.seen_close().await);
    let runs = home.runs();
    assert_eq!(runs[0]["state"].as_deref(), Some("cancelled"));
    assert_eq!(runs[0]["answer"], Some(SAID.concat()));
}

/// The signals that end a command: Ctrl-C, the end that a scheduler asks for, a terminal that is gone, Ctrl-\. The last
/// two go unheard where whoever runs the tests ignores them.
#[cfg(unix)]
pub(super) fn signals() -> impl Iterator<Item = &'static str> {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|l| l.strip_prefix("SigIgn:"));
    let mask = mask.map_or(0, |mask| u64::from_str_radix(mask.trim(), 16).unwrap());
    let heard = move |(signal, number): &(&str, u32)| {
        let heard = *number == 0 || mask >> (number - 1) & 1 == 0;
        if !heard {
            super::support::program::skipped(&format!("{signal} is ignored here"));
        }
        heard
    };
    let all = [("-INT", 0), ("-TERM", 0), ("-HUP", 1), ("-QUIT", 3)];
    all.into_iter().filter(heard).map(|(signal, _)| signal)
}

/// What a program that was interrupted said, and how long it went on.
#[cfg(unix)]
struct Interrupted {
    status: Option<i32>,
    stdout: String,
    stderr: String,
    took: Duration,
}

/// Sends a signal to a program once `ready`, while its output is read; nothing where it ended before that.
#[cfg(unix)]
fn interrupt(
    mut child: std::process::Child,
    signal: &str,
    ready: impl Fn() -> bool,
) -> Option<Interrupted> {
    use std::io::Read;
    let (mut out, mut err) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let stdout = std::thread::spawn(move || {
        let mut text = String::new();
        out.read_to_string(&mut text).map(|_| text)
    });
    let stderr = std::thread::spawn(move || {
        let mut text = String::new();
        err.read_to_string(&mut text).map(|_| text)
    });
    let begun = Instant::now();
    while !ready() && begun.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(5));
    }
    if child.try_wait().unwrap().is_some() {
        return None;
    }
    let sent = std::process::Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
    let begun = Instant::now();
    let status = child.wait().unwrap();
    Some(Interrupted {
        took: begun.elapsed(),
        status: status.code(),
        stdout: stdout.join().unwrap().unwrap(),
        stderr: stderr.join().unwrap().unwrap(),
    })
}

/// A second, and a little for a machine that is busy with other tests.
#[cfg(unix)]
const LATEST: Duration = Duration::from_millis(if cfg!(debug_assertions) { 4000 } else { 1500 });

/// A planner whose cycles take minutes.
#[cfg(unix)]
const SLOW: &str = "[planner]\nhorizon = 20\n[planner.sampling]\ndurations = 12\nspeeds = 30\n\
    offsets = 31\nchanges = 6\nrefinements = 3\n";

/// The cut-in with so many copies of all its obstacles.
#[cfg(unix)]
pub(super) fn crowded(copies: usize) -> String {
    let xml = bundled_xml(CUT_IN);
    let (open, close) = ("<dynamicObstacle id=\"", "</dynamicObstacle>");
    let (from, to) = (
        xml.find(open).unwrap(),
        xml.rfind(close).unwrap() + close.len(),
    );
    let mut all = xml[..to].to_owned();
    for copy in 1..=copies {
        let prefix = format!("{open}{}", 1000 + copy);
        all.push_str(&xml[from..to].replace(open, &prefix));
    }
    all + &xml[to..]
}

#[cfg(unix)]
#[test]
fn every_command_ends_within_a_second_of_a_signal() {
    let home = Home::new();
    std::fs::write(home.config().join("config.toml"), SLOW).unwrap();
    home.write("crowd.xml", crowded(400));
    home.write("crowd.ego_trajectory.csv", bundled_ego(CUT_IN));
    let before = super::metrics::names(&home.files());
    let commands: [&[&str]; 13] = [
        &["plan", CUT_IN],
        &["plan", CUT_IN, "--format=json", "--log", "log.jsonl"],
        &["generate", CUT_IN, "--candidates", "9000"],
        &["generate", CUT_IN, "-o", "made", "--report", "report.json"],
        &["metrics", "crowd.xml", CUT_IN],
        &["metrics", "crowd.xml", "-o", "t.csv"],
        &["metrics", "crowd.xml", "-o", "t.parquet"],
        &[
            "render",
            "crowd.xml",
            "--what",
            "both",
            "--format",
            "gif",
            "--all",
            "-o",
            "a.gif",
        ],
        &["render", "crowd.xml", "--what", "screen"],
        &["inspect", "crowd.xml"],
        &["prompt", "describe", "crowd.xml", "--frame", "metrics"],
        &["ask", "crowd.xml", "--task", "safety"],
        &["convert", "crowd.xml", "-o", "again.xml"],
    ];
    for signal in signals() {
        // All signals take the same way.
        let commands = match signal {
            "-INT" | "-TERM" => &commands[..],
            _ => &commands[..4],
        };
        let mut interrupted = 0;
        for &arguments in commands {
            let begun = Instant::now();
            let child = home.start(arguments);
            let running = || begun.elapsed() > Duration::from_millis(700);
            let Some(ended) = interrupt(child, signal, running) else {
                continue;
            };
            let Interrupted {
                stdout,
                stderr,
                took,
                ..
            } = &ended;
            assert!(*took < LATEST, "{arguments:?} {signal}: {took:?}");
            if ended.status != Some(130) {
                // It was done when the signal came.
                assert!(
                    matches!(ended.status, Some(0 | 1)),
                    "{arguments:?}: {stderr}"
                );
                continue;
            }
            interrupted += 1;
            assert!(stderr.contains("interrupted"), "{arguments:?}: {stderr}");
            assert!(!stderr.contains("panicked"), "{arguments:?}: {stderr}");
            assert!(
                stdout.is_empty() || stdout.ends_with('\n'),
                "{arguments:?}: half a line"
            );
        }
        assert!(
            2 * interrupted >= commands.len().min(12),
            "{signal}: only {interrupted} were slow enough"
        );
        let left = super::metrics::names(&home.files());
        let parts = left.iter().filter(|name| name.contains(".part"));
        assert_eq!(parts.count(), 0, "{left:?}");
        for name in ["log.jsonl", "report.json", "again.xml", "made"] {
            // What was finished, or the papers of a run that was interrupted.
            let path = home.files().join(name);
            if path.is_dir() {
                std::fs::remove_dir_all(path).unwrap();
            } else if path.exists() {
                std::fs::remove_file(path).unwrap();
            }
        }
    }
    assert!(super::metrics::names(&home.files()).len() >= before.len());
}

#[cfg(unix)]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_server_that_says_nothing_does_not_keep_a_command() {
    for signal in signals() {
        for command in ["ask", "evaluate"] {
            let script = || Script::chunked_events().chunk(delta("I ")).await_close();
            let server = Server::start(vec![script(), script()]).await;
            let home = super::batches::home(server.base_url());
            let arguments = [command, CUT_IN, "--model", "lab/tiny"];
            let child = home.start(&arguments);
            let asked = || home.rows("SELECT id FROM runs").len() == 1;
            let ended = tokio::task::block_in_place(|| interrupt(child, signal, asked))
                .unwrap_or_else(|| panic!("{command} ended by itself"));
            assert_eq!(ended.status, Some(130), "{command}: {}", ended.stderr);
            assert!(ended.took < LATEST, "{command} {signal}: {:?}", ended.took);
            assert!(ended.stderr.contains("interrupted"), "{}", ended.stderr);
            assert!(
                !home.runs().is_empty(),
                "{command}: what was begun is in the store"
            );
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_nohup_started_goes_on_when_its_terminal_closes() {
    let home = Home::new();
    std::fs::write(home.config().join("config.toml"), SLOW).unwrap();
    let program = home.command();
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", "trap '' HUP; exec \"$0\" plan \"$1\""]);
    shell.arg(program.get_program()).arg(CUT_IN);
    shell.current_dir(home.files());
    shell.envs(program.get_envs().filter_map(|(k, v)| Some((k, v?))));
    shell.stdout(std::process::Stdio::piped());
    let mut child = shell.stderr(std::process::Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(700));
    let id = child.id().to_string();
    let signal = |name: &str| {
        let sent = std::process::Command::new("kill")
            .args([name, &id])
            .status();
        assert!(sent.unwrap().success());
    };
    signal("-HUP");
    std::thread::sleep(LATEST + Duration::from_secs(1));
    assert_eq!(child.try_wait().unwrap(), None, "it goes on");
    signal("-TERM");
    let output = child.wait_with_output().unwrap();
    Ended::of(&output).status(130).says(&["interrupted"]);
}
