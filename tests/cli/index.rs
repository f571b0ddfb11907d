//! `index` and `sample`: the table of a corpus, draws that cover it, and what other programs read.

use std::collections::BTreeSet;
use std::process::Command;

use super::support::program::Home;
use super::{BUNDLED, CUT_IN};

pub fn indexed(home: &Home) {
    let names = BUNDLED.iter().map(|(name, _)| *name);
    let run: Vec<&str> = ["corpus", "index", "-o", "index"]
        .into_iter()
        .chain(names)
        .collect();
    home.run(&run)
        .status(0)
        .says(&["windows of", "windows a second"]);
}

#[test]
fn the_table_of_an_index_and_a_sample_that_covers_it() {
    let home = Home::new();
    indexed(&home);
    let table = home
        .run(&["corpus", "show", "index", "-o", "map.svg"])
        .status(0)
        .stdout;
    let show = home
        .run(&["corpus", "show", "index", "--format=json"])
        .status(0)
        .json();
    let coverage = show["coverage"].as_array().unwrap();
    for manoeuvre in ["cut_in", "following", "crossing", "oncoming"] {
        assert!(table.contains(manoeuvre), "{manoeuvre}: {table}");
        assert!(coverage.iter().any(|row| row["manoeuvre"] == manoeuvre));
    }
    assert!(table.starts_with("manoeuvre") && table.contains("near miss"));
    let svg = std::fs::read_to_string(home.files().join("map.svg")).unwrap();
    assert!(svg.contains("<svg") && svg.contains("cut_in"));
    let sum: u64 = coverage
        .iter()
        .flat_map(|row| row["counts"].as_array().unwrap())
        .map(|n| n.as_u64().unwrap())
        .sum();
    assert_eq!(show["windows"], sum);
    // A sample of as many windows as there are manoeuvres has each of them.
    let known: BTreeSet<&str> = coverage
        .iter()
        .map(|r| r["manoeuvre"].as_str().unwrap())
        .collect();
    let count = known.len().to_string();
    let sample = |more: &[&str]| {
        let run = [
            "corpus",
            "sample",
            "index",
            "--by",
            "manoeuvre",
            "-n",
            &count,
            "--seed",
            "7",
        ];
        home.run(&[&run[..], more].concat()).status(0).stdout
    };
    let lines = sample(&["--format=json"]);
    let drawn: BTreeSet<String> = lines
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap())
        .map(|line| line["manoeuvre"].as_str().unwrap().to_string())
        .collect();
    assert!(drawn.iter().map(String::as_str).eq(known.iter().copied()));
    assert_eq!(
        lines,
        sample(&["--format=json"]),
        "the same seed draws the same"
    );
    assert!(sample(&[]).contains(" in cut_in"));
    // As an experiment, it is checked like one that was written by hand.
    home.run(&[
        "corpus", "sample", "index", "-n", "3", "--format", "toml", "-o", "e.toml",
    ])
    .status(0);
    let text = std::fs::read_to_string(home.files().join("e.toml")).unwrap();
    home.write(
        "e.toml",
        format!("models = [\"reference/geometry\"]\n{text}"),
    );
    home.run(&["evaluate", "e.toml", "--dry-run"]).status(0);
    let paths = home
        .run(&["corpus", "sample", "index", "-n", "3", "--format", "paths"])
        .status(0)
        .stdout;
    assert!(paths.lines().count() <= 3 && !paths.contains("bundled"));
}

/// As those of before severity was graded, whose scores were others.
#[test]
fn an_index_with_other_severities_is_refused() {
    let home = Home::new();
    indexed(&home);
    let mut parts = std::fs::read_dir(home.files().join("index/shard=1-of-1")).unwrap();
    let part = parts.next().unwrap().unwrap().path();
    let mut bytes = std::fs::read(&part).unwrap();
    let key = b"nearmiss.severities";
    let at = bytes.windows(key.len()).position(|part| part == key);
    bytes[at.unwrap() + key.len() - 1] = b'x';
    std::fs::write(&part, bytes).unwrap();
    for command in [
        &["corpus", "find", "severity:contact", "--index", "index"][..],
        &["corpus", "show", "index"],
        &["corpus", "sample", "index", "-n", "1"],
    ] {
        home.run(command)
            .status(2)
            .says(&["of another scale than contact, conflict", "--overwrite"]);
    }
}

#[test]
fn rates_of_shards_add_up_and_are_narrowed_by_terms() {
    let home = Home::new();
    indexed(&home);
    let names: Vec<&str> = BUNDLED.iter().map(|(name, _)| *name).collect();
    for shard in ["1/2", "2/2"] {
        let run = ["corpus", "index", "-o", "halves", "--shard", shard];
        home.run(&[&run[..], &names].concat()).status(0);
    }
    let rates = |more: &[&str]| {
        let run = home.run(&[&["corpus", "rate"], more, &["--format=json"]].concat());
        let lines = run.status(0).stdout;
        let rows = lines
            .lines()
            .map(|line| serde_json::from_str(line).unwrap());
        rows.collect::<Vec<serde_json::Value>>()
    };
    let all = rates(&["index"]);
    assert_eq!(all.len(), 8, "four manoeuvres, two kinds of egos");
    for (whole, halves) in all.iter().zip(rates(&["halves"])) {
        for key in ["manoeuvre", "ego_source", "egos", "events", "recordings"] {
            assert_eq!(whole[key], halves[key], "{key}");
        }
        let near = |key: &str| {
            let [a, b] = [whole, &halves].map(|row| row[key].as_f64().unwrap());
            (a - b).abs() < 1e-9
        };
        assert!(near("hours") && near("kilometres") && near("per_hour"));
    }
    let recorded = &all[0];
    assert_eq!(recorded["events"], 1, "{recorded}");
    let hours = recorded["hours"].as_f64().unwrap();
    let high = recorded["per_hour_ci"][1].as_f64().unwrap();
    assert!((high * hours - 5.571_643).abs() < 1e-3, "that of one event");
    // The cut-in is as extreme as itself, and a little more is none.
    let like = rates(&["index", "--like", CUT_IN]);
    assert_eq!(like.len(), 2);
    assert_eq!(
        (&like[0]["events"], &like[1]["events"]),
        (&1.into(), &0.into())
    );
    let events = home.run(&[
        "corpus",
        "rate",
        "index",
        "manoeuvre:cut_in",
        "--events",
        "--format=json",
    ]);
    let event = events.status(0).json();
    let gap = format!("gap<{}", event["gap"]);
    assert_eq!(rates(&["index", "manoeuvre:cut_in", &gap])[0]["events"], 0);
    home.run(&["corpus", "rate", "index", "-o", "rates.svg"])
        .status(0)
        .says(&["8 recordings", "independent", "wrote rates.svg"]);
    let svg = std::fs::read_to_string(home.files().join("rates.svg")).unwrap();
    assert!(svg.contains("cut_in, recorded egos"));
    for (terms, says) in [
        ("manoeuvre:following", "cut_in, merging, cut_out, braking"),
        ("gap<", "has no value"),
        ("gpa<3", "gap"),
        ("tag:x", "no term of events"),
    ] {
        home.run(&["corpus", "rate", "index", terms])
            .status(2)
            .says(&[says]);
    }
    home.run(&["corpus", "rate", "index", "gap<80"])
        .status(0)
        .says(&["farther than 50 m"]);
    // A copy of every file changes nothing.
    let part = |name: &str| home.files().join("index/shard=1-of-1").join(name);
    std::fs::copy(part("part-00000.parquet"), part("part-00001.parquet")).unwrap();
    assert_eq!(rates(&["index"]), all);
    home.run(&["corpus", "rate", "index"])
        .status(0)
        .says(&["files left out: copies of others"]);
}

/// As those of before events were measured.
#[test]
fn an_index_without_events_is_shown_and_has_no_rates() {
    let home = Home::new();
    indexed(&home);
    let part = home.files().join("index/shard=1-of-1/part-00000.parquet");
    let mut bytes = std::fs::read(&part).unwrap();
    let key = b"nearmiss.driven";
    let at = bytes.windows(key.len()).rposition(|part| part == key);
    bytes[at.unwrap() + key.len() - 1] = b'x';
    std::fs::write(&part, bytes).unwrap();
    home.run(&["corpus", "show", "index"]).status(0);
    home.run(&["corpus", "rate", "index"])
        .status(2)
        .says(&["no events and no hours driven", "--overwrite"]);
}

#[test]
fn mistakes_are_named() {
    let home = Home::new();
    home.run(&["corpus", "index", CUT_IN])
        .status(2)
        .says(&["--output"]);
    home.run(&["corpus", "index", CUT_IN, "-o", "x", "--measure", "tcc"])
        .status(2)
        .says(&["ttc"]);
    home.run(&["corpus", "index", CUT_IN, "-o", "x", "--length", "0"])
        .status(2)
        .says(&["positive"]);
    home.run(&["corpus", "sample", ".", "--by", "rode"])
        .status(2)
        .says(&["road"]);
    home.run(&["corpus", "sample", "."])
        .status(2)
        .says(&["no index here"]);
    home.run(&["corpus", "show", "nowhere"])
        .status(2)
        .says(&["nowhere"]);
    let broken = home.write("broken/shard=1-of-1/part-00000.parquet", "PAR1");
    assert!(broken.is_file());
    home.run(&["corpus", "show", "broken"])
        .status(2)
        .says(&["part-00000.parquet"]);
}

/// Counts rows of a data set as the documentation says.
const COUNT: &str = "
import sys
import duckdb, polars
folder = sys.argv[1]
pattern = folder + '/**/*.parquet'
a = duckdb.sql(f\"SELECT count(*), count(DISTINCT shard), count(DISTINCT scenario) FROM '{pattern}'\").fetchall()[0]
t = polars.scan_parquet(folder + '/*/*.parquet', hive_partitioning=True)
b = t.select(polars.len(), polars.col('shard').n_unique(), polars.col('scenario').n_unique()).collect().row(0)
assert tuple(a) == tuple(b), (a, b)
print(*a)
";

#[test]
fn duckdb_and_polars_read_the_parts_as_one_table() {
    let python = std::env::var("NEARMISS_PYTHON").unwrap_or("python3".into());
    let there = Command::new(&python)
        .args(["-c", "import duckdb, polars"])
        .output();
    if !there.is_ok_and(|ended| ended.status.success()) {
        crate::support::program::skipped(&format!(
            "{python} has no duckdb and polars (NEARMISS_PYTHON)"
        ));
        return;
    }
    let home = Home::new();
    let names: Vec<&str> = BUNDLED.iter().map(|(name, _)| *name).collect();
    let form = ["-o", "out", "--format", "parquet", "--shard"];
    for shard in ["1/2", "2/2"] {
        home.run(&[&["metrics"], &names[..], &form, &[shard]].concat())
            .status(0);
    }
    let whole = home
        .run(&[&["metrics"], &names[..]].concat())
        .status(0)
        .stdout;
    let count = Command::new(&python)
        .args(["-c", COUNT, "out"])
        .current_dir(home.files())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&count.stderr);
    let expected = format!("{} 2 {}", whole.lines().count() - 1, names.len());
    assert_eq!(
        String::from_utf8_lossy(&count.stdout).trim(),
        expected,
        "{said}"
    );
}
