//! Thresholds of the user's: from the configuration folder or a file, never in the convention of the paper.

use parquet::file::reader::{FileReader, SerializedFileReader};

use super::support::program::Home;
use super::{BUNDLED, CUT_IN};

/// Far more is dangerous than as shipped.
const WIDE: &str = "[[level]]\nscore = 4\ndistance = 80\ntime = 80\n";

fn column(text: &str, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let place = reader
        .headers()
        .unwrap()
        .iter()
        .position(|h| h == name)
        .unwrap_or_else(|| panic!("no column {name}"));
    reader
        .records()
        .map(|row| row.unwrap()[place].to_string())
        .collect()
}

fn without(text: &str, name: &str) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let place = reader.headers().unwrap().iter().position(|h| h == name);
    let rows = reader.records().map(|row| {
        let row = row.unwrap();
        let cells = row.iter().enumerate().filter(|(i, _)| Some(*i) != place);
        cells.map(|(_, cell)| cell.to_string()).collect()
    });
    rows.collect()
}

#[test]
fn the_file_in_the_configuration_folder_changes_the_risk_and_says_so() {
    let home = Home::new();
    let shipped = home.run(&["metrics", CUT_IN]).status(0);
    assert!(
        shipped
            .stderr
            .starts_with("nearmiss: Provenance: nearmiss ")
            && shipped.stderr.ends_with("; shipped thresholds.\n"),
        "{}",
        shipped.stderr
    );
    home.write(home.config().join("thresholds.toml"), WIDE);
    let own = home
        .run(&["metrics", CUT_IN])
        .status(0)
        .says(&["thresholds.toml", "; thresholds "]);
    let (before, after) = (column(&shipped.stdout, "risk"), column(&own.stdout, "risk"));
    assert_ne!(before, after);
    assert!(
        before.iter().zip(&after).all(|(b, a)| a <= b),
        "never safer"
    );
    assert_eq!(
        without(&shipped.stdout, "risk"),
        without(&own.stdout, "risk")
    );
    // A file that is named is taken instead of it, not beside it.
    let other = home.write("other.toml", "[[limit]]\nname = \"tau\"\nvalue = 9\n");
    let other = other.to_str().unwrap();
    let named = home
        .run(&["metrics", CUT_IN, "--thresholds", other])
        .status(0)
        .says(&["other.toml"])
        .stdout;
    assert_eq!(column(&named, "risk"), before);
    assert_ne!(column(&named, "tet"), column(&shipped.stdout, "tet"));
}

#[test]
fn the_convention_of_the_paper_is_never_affected() {
    let home = Home::new();
    let arguments = ["metrics", CUT_IN, "--convention", "paper"];
    let shipped = home.run(&arguments).status(0).stdout;
    let file = home.write(home.config().join("thresholds.toml"), WIDE);
    let own = home.run(&arguments).status(0);
    assert_eq!(own.stdout, shipped);
    assert!(!own.stderr.contains("thresholds"), "{}", own.stderr);
    // Not even read.
    home.write(&file, "nonsense");
    assert_eq!(home.run(&arguments).status(0).stdout, shipped);
    for option in [&["--thresholds", "t.toml"][..], &["--scene"]] {
        let ended = home.run(&[&arguments[..], option].concat()).status(2);
        assert!(ended.says(&[option[0], "paper"]).stdout.is_empty());
    }
}

#[test]
fn wrong_files_are_named_and_nothing_is_written() {
    let home = Home::new();
    let config = home.config().join("thresholds.toml");
    home.write(&config, "# mine\n[[limit]]\nname = \"taw\"\nvalue = 1\n");
    let words = ["thresholds.toml:3", "`taw`", "tau"];
    let ended = home.run(&["metrics", CUT_IN, "-o", "table.csv"]).status(2);
    assert!(ended.says(&words).stdout.is_empty());
    assert!(!home.files().join("table.csv").exists());
    for command in [&["prompt", "show", CUT_IN][..], &["ask", CUT_IN]] {
        home.run(command).status(2).says(&words);
    }
    std::fs::remove_file(config).unwrap();
    let bytes = home.write("bytes.toml", [0xff, 0xfe]);
    let bytes = bytes.to_str().unwrap();
    for (path, word) in [
        ("absent.toml", "absent.toml"),
        (".", "folder"),
        (bytes, "UTF-8"),
    ] {
        home.run(&["metrics", CUT_IN, "--thresholds", path])
            .status(2)
            .says(&["--thresholds", word]);
    }
}

#[test]
fn prompts_and_the_judge_score_alike() {
    let home = Home::new();
    let (prompt, ask) = (["prompt", "show", CUT_IN], ["ask", CUT_IN, "--format=json"]);
    let risk = |home: &Home| {
        home.run(&ask).status(0).json()["verdict"]["obstacles"][0]["risk_score"].clone()
    };
    let before = (home.run(&prompt).status(0).stdout, risk(&home));
    home.write(
        home.config().join("thresholds.toml"),
        "[[level]]\nscore = 1\ndistance = 0.05\ntime = 0.05\n[[level]]\nscore = 2\ndistance = 0.06\ntime = 0.06\n",
    );
    let after = (home.run(&prompt).status(0).stdout, risk(&home));
    assert!(
        !before.0.contains("| 0.06 m |") && after.0.contains("| 0.06 m |"),
        "{}",
        after.0
    );
    assert!(after.1.as_u64() > before.1.as_u64(), "{after:?}");
    let runs = home.runs();
    let parameters = |i: usize| runs[i]["parameters"].clone().unwrap();
    assert_eq!(parameters(0), "{}");
    assert!(
        parameters(1).contains("risk 1 distance 0.05 m"),
        "{}",
        parameters(1)
    );
}

#[test]
fn scenes_are_measured_a_row_a_step() {
    let home = Home::new();
    let paths: Vec<&str> = BUNDLED.iter().map(|(name, _)| *name).collect();
    let run = |options: &[&str]| {
        let arguments = [&["metrics", "--scene"], &paths[..], options].concat();
        home.run(&arguments).status(0).stdout
    };
    let text = run(&["--reasons"]);
    let head = "scenario,file,hash,ego,step,time,dce,ttc_star,ttb,ttk,tts,ttr,dce_reason,";
    assert!(text.starts_with(head), "{text:.200}");
    let (dce, star) = (column(&text, "dce"), column(&text, "ttc_star"));
    let why = column(&text, "ttc_star_reason");
    let scenario = column(&text, "scenario");
    for (name, collides) in BUNDLED {
        let rows: Vec<usize> = (0..scenario.len())
            .filter(|&i| scenario[i] == name)
            .collect();
        assert!(!rows.is_empty(), "{name}");
        assert_eq!(dce[rows[0]] == "0", collides, "{name}");
        assert_eq!(!star[rows[0]].is_empty(), collides, "{name}");
        for &i in &rows {
            assert_eq!(star[i].is_empty(), !why[i].is_empty(), "{name} {i}");
        }
    }
    // The least distance of all obstacles is that of the scene.
    let each = home.run(&["metrics", CUT_IN]).status(0).stdout;
    let (steps, of_each) = (column(&each, "step"), column(&each, "dce"));
    for i in (0..scenario.len()).filter(|&i| scenario[i] == CUT_IN) {
        let step = &column(&text, "step")[i];
        let here = steps.iter().zip(&of_each).filter(|(s, _)| *s == step);
        let least = here
            .map(|(_, d)| d.parse::<f64>().unwrap())
            .reduce(f64::min);
        assert_eq!(least, dce[i].parse().ok(), "step {step}");
    }
    let json = run(&["--format", "json"]);
    let first: serde_json::Value = serde_json::from_str(json.lines().next().unwrap()).unwrap();
    assert_eq!(first["scenario"], BUNDLED[0].0);
    assert!(first["ttb"].is_number() && first.get("obstacle").is_none());
    home.run(&["metrics", CUT_IN, "--scene", "--radius", "30"])
        .status(2)
        .says(&["--radius"]);
}

#[test]
fn parquet_holds_units_and_what_was_changed() {
    let home = Home::new();
    let wide = home.write("wide.toml", WIDE);
    let metadata = |options: &[&str]| {
        let arguments = [
            &["metrics", CUT_IN, "-o", "t.parquet", "--overwrite"],
            options,
        ]
        .concat();
        home.run(&arguments).status(0);
        let file = std::fs::File::open(home.files().join("t.parquet")).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let entries = reader
            .metadata()
            .file_metadata()
            .key_value_metadata()
            .unwrap();
        let entry = |key: &str| {
            let found = entries.iter().find(|e| e.key == format!("nearmiss.{key}"));
            found.and_then(|e| e.value.clone())
        };
        (entry("thresholds_changed"), entry("columns").unwrap())
    };
    assert_eq!(metadata(&[]).0.as_deref(), Some("[]"));
    let (changed, columns) = metadata(&["--scene", "--thresholds", wide.to_str().unwrap()]);
    assert_eq!(
        changed.as_deref(),
        Some(r#"["risk 4 distance 80 m","risk 4 time 80 s"]"#)
    );
    let columns: Vec<serde_json::Value> = serde_json::from_str(&columns).unwrap();
    let dce = columns.iter().find(|c| c["name"] == "dce").unwrap();
    assert_eq!(dce["unit"], "m");
    assert_eq!(metadata(&["--convention", "paper"]).0, None);
}
