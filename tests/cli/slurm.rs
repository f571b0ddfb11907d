//! `nearmiss slurm`: its scripts run parts that go on after a kill, and whose joined report is that of one run.
//!
//! Without Slurm the scripts are run by bash. With `NEARMISS_SLURM=FOLDER`, a folder that the nodes share, one test
//! submits them to the Slurm of this machine.

use std::collections::BTreeMap;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use super::batches::home as home_with;
use super::reports::half_of_them;
use super::support::program::{Ended, Home, skipped};
use super::support::server::Server;
use super::{BUNDLED, bundled_ego, bundled_xml};

/// A folder name as people have them.
const FOLDER: &str = "Ada's \"study\" $(x) #1";

/// An experiment about the bundled scenarios as files.
const STUDY: &str = "scenarios = [\"my rec\"]\nmodels = [\"lab/tiny\", \"reference/geometry\"]\n\
    tasks = [\"collision\", \"safety\"]\ntechniques = [\"base\", \"all\"]\nsamples = 2\ntruth = [\"auto\"]\n";

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

/// A home with the study in a folder of its own; the folder.
fn with_study(server: &Server) -> (Home, PathBuf) {
    let home = home_with(server.base_url());
    let folder = home.files().join(FOLDER);
    write_study(&folder);
    (home, folder)
}

fn write_study(folder: &Path) {
    let rec = folder.join("my rec");
    std::fs::create_dir_all(&rec).unwrap();
    for (name, _) in BUNDLED {
        std::fs::write(rec.join(format!("{name}.xml")), bundled_xml(name)).unwrap();
        let ego = rec.join(format!("{name}.ego_trajectory.csv"));
        std::fs::write(ego, bundled_ego(name)).unwrap();
    }
    std::fs::write(folder.join("my study.toml"), STUDY).unwrap();
}

/// A program that is killed the first time, as it would be where memory runs out, and then is nearmiss.
fn killed_once(folder: &Path) -> PathBuf {
    let path = folder.join("killed once");
    let text = format!(
        "#!/bin/sh\n[ \"$1\" = evaluate ] && mkdir \"$NEARMISS_DATA/killed\" 2>/dev/null && kill -9 $$\nexec '{}' \"$@\"\n",
        env!("CARGO_BIN_EXE_nearmiss")
    );
    std::fs::write(&path, text).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path
}

/// Runs a script as a task of a job array would.
fn bash(home: &Home, script: &Path, part: u32) -> Ended {
    let environment = home.command();
    let mut command = Command::new("bash");
    command.current_dir("/").arg(script);
    for (name, value) in environment.get_envs() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    command.env("SLURM_ARRAY_TASK_ID", part.to_string());
    Ended::of(&tokio::task::block_in_place(|| command.output().unwrap()))
}

fn is_sound(script: &Path) {
    let checked = Command::new("bash").arg("-n").arg(script).output().unwrap();
    assert!(checked.status.success(), "{checked:?}");
    match Command::new("shellcheck").arg(script).output() {
        Ok(checked) => assert!(checked.status.success(), "{checked:?}"),
        Err(_) => skipped("shellcheck is not installed"),
    }
}

/// The reports of the last batch in a store, in all formats, as if every answer had taken a second.
fn reports(home: &Home, data: &Path) -> BTreeMap<&'static str, String> {
    let store = rusqlite::Connection::open(data.join("runs.sqlite")).unwrap();
    let timeless = "UPDATE runs SET duration_ms = 1000, first_chunk_ms = 10";
    store.execute(timeless, []).unwrap();
    drop(store);
    let data = data.display().to_string();
    let report = |format: &'static str| {
        let words = ["report", "--batch", "last", "--format", format];
        let made = home.run_with(&words, &[("NEARMISS_DATA", &data)]).status(0);
        (format, made.stdout + &made.stderr)
    };
    ["md", "latex", "csv", "json"].map(report).into()
}

/// The reports of one run over all scenarios.
fn whole(home: &Home, folder: &Path) -> BTreeMap<&'static str, String> {
    let data = folder.join("whole");
    let study = folder.join("my study.toml").display().to_string();
    let mut command = home.command();
    command.current_dir(folder).args(["evaluate", &study]);
    let ended = tokio::task::block_in_place(|| command.env("NEARMISS_DATA", &data).output());
    Ended::of(&ended.unwrap()).status(0);
    tokio::task::block_in_place(|| reports(home, &data))
}

/// How often each question was asked.
fn asked(server: &Server) -> BTreeMap<Vec<u8>, usize> {
    let mut counts = BTreeMap::new();
    for request in server.requests() {
        *counts.entry(request.body).or_default() += 1;
    }
    counts
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn parts_that_were_killed_go_on_and_their_report_is_that_of_one_run() {
    let server = half_of_them().await;
    let (home, folder) = with_study(&server);
    let program = killed_once(&folder).display().to_string();
    let key = "sk-lab-4711";
    let env = home.write(folder.join("keys.env"), format!("LAB_KEY={key}\nB='a b'\n"));
    let env = env.display().to_string();
    let study = folder.join("my study.toml").display().to_string();
    let out = folder.join("out").display().to_string();
    let slurm = [
        "slurm",
        "--parts",
        "4",
        "-o",
        &out,
        "--program",
        &program,
        "--env-file",
        &env,
        "--time",
        "1-12:00:00",
        "--memory",
        "4G",
        "--partition",
        "short",
        "--account",
        "lab",
        "--cpus",
        "2",
        "--at-once",
        "2",
        "--",
        "evaluate",
        &study,
        "--concurrency",
        "2",
    ];
    let written = run(&home, &slurm).status(0);
    written.says(&["chmod 600", "/tmp"]);
    run(&home, &slurm).status(2).says(&["--overwrite"]);
    let (array, join) = (folder.join("out/array.sh"), folder.join("out/join.sh"));
    let text = std::fs::read_to_string(&array).unwrap();
    for line in [
        "#SBATCH --array=1-4%2\n",
        "#SBATCH --requeue\n",
        "#SBATCH --partition=short\n",
        "#SBATCH --account=lab\n",
        "#SBATCH --time=1-12:00:00\n",
        "#SBATCH --mem=4G\n",
        "#SBATCH --cpus-per-task=2\n",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    for script in [&array, &join] {
        is_sound(script);
        assert!(!std::fs::read_to_string(script).unwrap().contains(key));
    }
    // Each part is killed once; the second is run again, as a requeued one is.
    let mut empty = 0;
    for part in [1, 2, 3, 4, 2] {
        let ended = bash(&home, &array, part).status(0);
        empty += usize::from(ended.stderr.contains("has no scenarios"));
    }
    assert!(empty > 0, "a part without scenarios is a part, too");
    let joined = bash(&home, &join, 0).status(0);
    assert!(joined.stdout.contains("Batch b1: "), "{}", joined.stdout);
    assert!(!joined.stderr.contains("only part"), "{}", joined.stderr);
    assert!(folder.join("out/report.html").is_file());
    bash(&home, &join, 0).status(0);
    let counts = asked(&server);
    assert!(counts.len() > 10, "{}", counts.len());
    assert!(counts.values().all(|n| *n <= 2), "samples, each once");
    let of_parts = tokio::task::block_in_place(|| reports(&home, &folder.join("out/joined")));
    for (format, whole) in whole(&home, &folder) {
        assert_eq!(whole, of_parts[format], "{format}");
    }
    let twice = asked(&server);
    assert_eq!(twice.len(), counts.len());
    assert!(
        counts.iter().all(|(body, n)| twice[body] == 2 * n),
        "the whole asks as often"
    );
    // What is missing is said.
    std::fs::remove_dir_all(folder.join("out/joined")).unwrap();
    let two = ["1-of-4", "2-of-4"].map(|part| {
        let store = folder.join("out/parts").join(part).join("runs.sqlite");
        store.display().to_string()
    });
    run(&home, &["import", &two[0], &two[1]]).status(0);
    run(&home, &["report", "--batch", "last"])
        .status(0)
        .says(&["only part 1/4,2/4 of the batch is here"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn tables_in_parts_need_no_joining() {
    let home = Home::new();
    let folder = home.files().join(FOLDER);
    write_study(&folder);
    let (rec, out) = (folder.join("my rec"), folder.join("out"));
    let [rec, out, table, other] = [rec, out.clone(), folder.join("an index"), folder.join("b")]
        .map(|path| path.display().to_string());
    let index = ["index", &rec, "-o", &table, "--stride", "2"];
    let slurm = ["slurm", "--parts", "3", "-o", &out, "--"];
    let written = run(&home, &[&slurm[..], &index].concat()).status(0);
    assert!(written.stdout.starts_with("sbatch '"), "{}", written.stdout);
    let array = Path::new(&out).join("array.sh");
    assert!(!Path::new(&out).join("join.sh").exists());
    is_sound(&array);
    for part in [1, 2, 3, 1] {
        bash(&home, &array, part).status(0);
    }
    run(&home, &["index", &rec, "-o", &other, "--stride", "2"]).status(0);
    let shown = |folder: &str| {
        run(&home, &["index", "show", folder, "--json"])
            .status(0)
            .stdout
    };
    assert_eq!(shown(&table), shown(&other));
    // A file that every part would write has the number of the part in its name.
    let report = Path::new(&out)
        .join("it's {part}.json")
        .display()
        .to_string();
    let generate = ["generate", &rec, "-o", &table, "--report", &report];
    let again = ["slurm", "--parts", "3", "-o", &out, "--overwrite", "--"];
    run(&home, &[&again[..], &generate].concat()).status(0);
    let text = std::fs::read_to_string(&array).unwrap();
    assert!(text.contains("it'\\''s '\"$part\".json --shard"), "{text}");
    is_sound(&array);
}

#[test]
fn what_cannot_work_is_refused() {
    let home = Home::new();
    home.write("study.toml", STUDY.replace("my rec", "ZAM_CutIn-1_1_T-1"));
    home.write("wrong.toml", "models = 3\n");
    let refused = |options: &[&str], command: &[&str], words: &[&str]| {
        let all = [&["slurm"], options, &["--"], command].concat();
        home.run(&all).status(2).says(words);
        assert!(!home.files().join("out").exists(), "{all:?}");
    };
    let study = &["evaluate", "study.toml"][..];
    let parts = &["--parts", "2", "-o", "out"][..];
    refused(&["--parts", "0", "-o", "out"], study, &["--parts"]);
    refused(&["--parts", "2"], study, &["--output <DIR>"]);
    refused(
        &["--parts", "2", "-o", "o\nut"],
        study,
        &["control characters"],
    );
    refused(&["--parts", "2", "-o", "o\\ut"], study, &["backslash"]);
    for (option, wrong) in [
        ("--partition", "a b"),
        ("--account", "x\n#SBATCH --uid=0"),
        ("--time", "soon"),
        ("--memory", "0G"),
        ("--program", "none"),
        ("--env-file", "none.env"),
    ] {
        refused(
            &[parts, &[option, wrong]].concat(),
            study,
            &[wrong.lines().next().unwrap()],
        );
    }
    for (command, words) in [
        (
            &["report"][..],
            &["cannot be run in parts; evaluate, metrics"][..],
        ),
        (
            &["evaluate", "rec", "--model", "lab/x"],
            &["--write-experiment"],
        ),
        (&["evaluate", "study.toml", "--dry-run"], &["asks nothing"]),
        (
            &["evaluate", "study.toml", "--batch"],
            &["waits for the provider"],
        ),
        (&["evaluate", "none.toml"], &["none.toml"]),
        (&["evaluate", "wrong.toml"], &["wrong.toml:1"]),
        (
            &["evaluate", "study.toml", "--shard", "1/2"],
            &["leave out --shard"],
        ),
        (
            &["index", "rec", "-o", "i", "--resume"],
            &["leave out --resume"],
        ),
        (
            &["index", "rec", "-o", "i", "--overwrite"],
            &["leave out --overwrite"],
        ),
        (&["index", "rec"], &["--output"]),
        (&["index", "rec", "-o", "i", "--sride", "2"], &["--sride"]),
        (&["metrics", "rec", "-o", "m.csv"], &["Parquet parts"]),
        (
            &["generate", "rec", "-o", "g", "--report", "r.json"],
            &["r.json", "{part}"],
        ),
    ] {
        refused(parts, command, words);
    }
    let cheap = STUDY.replace("my rec", "ZAM_CutIn-1_1_T-1") + "budget = 2.5\n";
    home.write("cheap.toml", cheap);
    let all = [&["slurm"], parts, &["--", "evaluate", "cheap.toml"]].concat();
    home.run(&all).status(0).says(&["2.5 USD", "at most 5 USD"]);
}

/// Waits until no job is left.
fn until_done(jobs: &dyn Fn() -> String) {
    let begun = Instant::now();
    while !jobs().is_empty() {
        assert!(begun.elapsed() < Duration::from_secs(900), "{}", jobs());
        std::thread::sleep(Duration::from_secs(1));
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn on_a_slurm_cluster_a_killed_and_a_requeued_part_change_nothing() {
    let Some(shared) = std::env::var_os("NEARMISS_SLURM") else {
        return skipped("NEARMISS_SLURM names no folder that the nodes of a Slurm cluster share");
    };
    let server = half_of_them().await;
    let home = home_with(server.base_url());
    let shared = tempfile::tempdir_in(shared).unwrap();
    let folder = shared.path().join("a study");
    write_study(&folder);
    let config = format!("NEARMISS_CONFIG='{}'\n", home.config().display());
    let env = home
        .write(folder.join("test.env"), config)
        .display()
        .to_string();
    let program = killed_once(&folder).display().to_string();
    let study = folder.join("my study.toml").display().to_string();
    let out = folder.join("out").display().to_string();
    let slurm = [
        "slurm",
        "--parts",
        "4",
        "-o",
        &out,
        "--program",
        &program,
        "--env-file",
        &env,
    ];
    let written = run(&home, &[&slurm[..], &["--", "evaluate", &study]].concat()).status(0);
    let shell = |words: &str| {
        let ended = Command::new("sh").arg("-c").arg(words).output().unwrap();
        assert!(ended.status.success(), "{words}: {ended:?}");
        String::from_utf8(ended.stdout).unwrap().trim().to_string()
    };
    tokio::task::block_in_place(|| {
        let join = shell(&written.stdout);
        let join = join.rsplit(' ').next().unwrap().to_string();
        let tasks = || shell("squeue --me -h -r -t RUNNING -o %i -n nearmiss-evaluate");
        let begun = Instant::now();
        while tasks().is_empty() {
            assert!(begun.elapsed() < Duration::from_secs(300), "no task runs");
            std::thread::sleep(Duration::from_millis(200));
        }
        let one = tasks().lines().next().unwrap().to_string();
        shell(&format!("scontrol requeue {one}"));
        until_done(&|| {
            shell(&format!(
                "squeue --me -h -o %i -j {join} 2>/dev/null || true"
            ))
        });
    });
    let log = std::fs::read_to_string(folder.join("out/logs/join.log")).unwrap();
    assert!(log.contains("Batch b1: "), "{log}");
    let counts = asked(&server);
    assert!(counts.values().all(|n| *n <= 2), "samples, each once");
    let of_parts = tokio::task::block_in_place(|| reports(&home, &folder.join("out/joined")));
    for (format, whole) in whole(&home, &folder) {
        assert_eq!(whole, of_parts[format], "{format}");
    }
}
