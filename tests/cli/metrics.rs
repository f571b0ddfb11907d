//! `metrics`: conventions, formats, and files that are whole or not there.

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::Value;

use super::support::program::Home;
use super::{BUNDLED, CUT_IN, bundled_ego, bundled_xml};

/// The columns of the published `relative_metrics.csv`, but for its last.
const PUBLISHED: [&str; 13] = [
    "timestep",
    "obstacle_id",
    "relative_direction",
    "d_long",
    "d_lat",
    "adjusted_d_long",
    "adjusted_d_lat",
    "v_rel_long",
    "v_rel_lat",
    "a_rel_long",
    "a_rel_lat",
    "ttc_long",
    "ttc_lat",
];

type Rows = Vec<Vec<(String, String)>>;

/// Header and cells of a CSV table.
fn table(text: &str) -> Rows {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().unwrap().clone();
    let rows = reader.records().map(|row| {
        let row = row.unwrap();
        let cells = header.iter().zip(row.iter());
        cells.map(|(n, c)| (n.to_string(), c.to_string())).collect()
    });
    rows.collect()
}

fn cell<'a>(row: &'a [(String, String)], name: &str) -> &'a str {
    let found = row.iter().find(|(column, _)| column == name);
    &found.unwrap_or_else(|| panic!("no column {name}")).1
}

#[test]
fn the_convention_of_the_paper_begins_with_the_published_columns() {
    let home = Home::new();
    let text = home
        .run(&["metrics", CUT_IN, "--convention", "paper"])
        .status(0)
        .stdout;
    let header: Vec<_> = text.lines().next().unwrap().split(',').collect();
    assert_eq!(header[..13], PUBLISHED);
    let risk = [
        "wdominant",
        "long_dsc",
        "lat_dsc",
        "dsc",
        "long_tsc",
        "lat_tsc",
        "tsc",
        "risk_score",
    ];
    let at = header.iter().position(|h| *h == "wdominant").unwrap();
    assert_eq!(header[at..at + 8], risk);
    assert!(header.ends_with(&["distance", "scenario", "file", "hash", "ego"]));
    let rows = table(&text);
    assert!(rows.len() > 100);
    let infinite = |row: &&Vec<(String, String)>| cell(row, "ttc_long") == "inf";
    assert!(rows.iter().any(|row| infinite(&row)) && !rows.iter().all(|row| infinite(&row)));
    for row in &rows {
        assert!(row.iter().all(|(_, cell)| !cell.is_empty()), "{row:?}");
        let decimals = cell(row, "d_long")
            .split_once('.')
            .expect("a decimal point")
            .1;
        assert!(decimals.len() <= 2, "{row:?}");
        assert_eq!(cell(row, "scenario"), CUT_IN);
    }
    // The default is the other one, and both have the same columns whatever is asked for.
    let exact = home.run(&["metrics", CUT_IN]).status(0).stdout;
    assert_eq!(
        exact,
        home.run(&["metrics", CUT_IN, "--convention", "exact"])
            .stdout
    );
    assert!(exact.starts_with("scenario,file,hash,ego,step,time,"));
    let ended = home
        .run(&["metrics", CUT_IN, "--convention", "loose"])
        .status(2);
    let _ = ended.says(&["exact", "paper"]);
}

#[test]
fn a_radius_leaves_out_who_is_farther() {
    let home = Home::new();
    for convention in ["exact", "paper"] {
        let run = |radius: &[&str]| {
            let arguments = [&["metrics", CUT_IN, "--convention", convention], radius].concat();
            home.run(&arguments).status(0).stdout
        };
        let (all, near) = (run(&[]), run(&["--radius", "30"]));
        let (all, near) = (table(&all), table(&near));
        assert!(
            !near.is_empty() && near.len() < all.len(),
            "{convention}: {} of {}",
            near.len(),
            all.len()
        );
        assert!(near.iter().all(|row| all.contains(row)));
        if convention == "paper" {
            let close = all
                .iter()
                .filter(|row| cell(row, "distance").parse::<f64>().unwrap() <= 30.0);
            assert_eq!(close.count(), near.len());
        }
    }
    for wrong in ["0", "-3", "inf", "NaN", "near"] {
        home.run(&["metrics", CUT_IN, "--radius", wrong])
            .status(2)
            .says(&["--radius", "metres"]);
    }
}

#[test]
fn reasons_stand_in_columns_of_their_own() {
    let home = Home::new();
    for (convention, measure) in [("exact", "ttc"), ("paper", "ttc_long")] {
        let arguments = ["metrics", CUT_IN, "--convention", convention, "--reasons"];
        let text = home.run(&arguments).status(0).stdout;
        let plain = home.run(&arguments[..4]).status(0).stdout;
        let reason = format!("{measure}_reason");
        let (mut with, mut without) = (0, 0);
        for (row, plain) in table(&text).iter().zip(table(&plain)) {
            assert_eq!(row[..plain.len()], plain[..]);
            let value = cell(row, measure);
            let there = value.parse::<f64>().is_ok_and(f64::is_finite);
            assert_eq!(there, cell(row, &reason).is_empty(), "{row:?}");
            *(if there { &mut with } else { &mut without }) += 1;
        }
        assert!(
            with > 0 && without > 0,
            "{convention}: {with} and {without}"
        );
        let json = home
            .run(&[&arguments[..], &["--format", "json"]].concat())
            .status(0)
            .stdout;
        for (line, row) in json.lines().zip(table(&text)) {
            let object: Value = serde_json::from_str(line).unwrap();
            let object = object.as_object().unwrap();
            // Between the version and the names that all commands have in common.
            let columns = object.keys().skip(1).take(row.len());
            assert!(columns.eq(row.iter().map(|(name, _)| name)));
            assert_eq!(
                object[measure].is_null(),
                object[&reason].is_string(),
                "{line}"
            );
            assert_eq!(object[&reason].as_str().unwrap_or(""), cell(&row, &reason));
        }
    }
}

/// The cells of a Parquet file as CSV has them.
fn parquet_rows(path: &std::path::Path) -> Rows {
    let file = SerializedFileReader::new(std::fs::File::open(path).unwrap()).unwrap();
    let rows = file.get_row_iter(None).unwrap().map(|row| {
        let row = row.unwrap();
        let cells = row.get_column_iter().map(|(name, field)| {
            let text = match field {
                Field::Null => String::new(),
                Field::Str(text) => text.clone(),
                Field::Long(number) => number.to_string(),
                Field::Double(number) => number.to_string(),
                other => panic!("{name} is {other:?}"),
            };
            (name.clone(), text)
        });
        cells.collect()
    });
    rows.collect()
}

#[test]
fn parquet_reads_back_as_the_csv_table() {
    let home = Home::new();
    for convention in ["exact", "paper"] {
        let mut arguments = vec!["metrics", "--convention", convention, "--reasons"];
        arguments.extend(BUNDLED.iter().map(|(name, _)| *name));
        let csv = table(&home.run(&arguments).status(0).stdout);
        let name = format!("{convention}.parquet");
        arguments.extend(["-o", &name]);
        let ended = home.run(&arguments).status(0);
        assert_eq!((ended.stdout.as_str(), ended.stderr.as_str()), ("", ""));
        let path = home.files().join(&name);
        let parquet = parquet_rows(&path);
        assert_eq!(parquet.len(), csv.len());
        for (ours, theirs) in parquet.iter().zip(&csv) {
            for ((name, ours), (column, theirs)) in ours.iter().zip(theirs) {
                assert_eq!(name, column);
                let same =
                    ours == theirs || ours.parse::<f64>().is_ok_and(|n| theirs.parse() == Ok(n));
                assert!(same, "{name}: {ours}, not {theirs}");
            }
        }
        let file = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
        let entries = file
            .metadata()
            .file_metadata()
            .key_value_metadata()
            .unwrap();
        let entry = |key: &str| {
            let found = entries.iter().find(|e| e.key == key);
            found.unwrap().value.clone().unwrap()
        };
        assert_eq!(entry("nearmiss.version"), env!("CARGO_PKG_VERSION"));
        assert_eq!(entry("nearmiss.convention"), convention);
        let provenance: Value = serde_json::from_str(&entry("nearmiss.provenance")).unwrap();
        let json = [
            "metrics",
            CUT_IN,
            "--format=json",
            "--convention",
            convention,
        ];
        let json = home.run(&json).status(0).json_lines();
        assert!(!json.is_empty());
        for line in &json {
            for name in ["program", "commit", "thresholds", "thresholds_sha256"] {
                assert_eq!(line["provenance"][name], provenance[name], "{name}");
            }
        }
        let hash = &json[0]["provenance"]["thresholds_sha256"];
        assert_eq!(hash.is_string(), convention == "exact", "{hash}");
        let columns: Value = serde_json::from_str(&entry("nearmiss.columns")).unwrap();
        let ttc = columns
            .as_array()
            .unwrap()
            .iter()
            .find(|c| c["name"] == "ttc_long")
            .unwrap();
        assert_eq!(ttc["unit"], "s");
        assert!(!ttc["source"].as_str().unwrap().is_empty());
    }
}

#[test]
fn the_format_follows_the_name_of_the_file_unless_it_is_said() {
    let home = Home::new();
    let piped = home.bytes(&["metrics", CUT_IN, "--format", "parquet"]);
    assert!(piped.starts_with(b"PAR1"));
    let read = |name: &str| std::fs::read(home.files().join(name)).unwrap();
    for (name, format) in [("a.csv", "csv"), ("a.jsonl", "json"), ("a.JSON", "json")] {
        home.run(&["metrics", CUT_IN, "-o", name]).status(0);
        let said = home.run(&["metrics", CUT_IN, "--format", format]).status(0);
        assert_eq!(read(name), said.stdout.as_bytes(), "{name}");
    }
    home.run(&["metrics", CUT_IN, "-o", "a.parquet"]).status(0);
    assert!(read("a.parquet").starts_with(b"PAR1"));
    home.run(&["metrics", CUT_IN, "-o", "b.parquet", "--format", "csv"])
        .status(2)
        .says(&["--format csv contradicts the file name b.parquet"]);
    assert!(!home.files().join("b.parquet").exists());
    home.run(&["metrics", CUT_IN, "-o", "b.txt", "--format", "json"])
        .status(0);
    assert!(read("b.txt").starts_with(b"{"));
    for name in ["a.txt", "a", "a.xlsx"] {
        home.run(&["metrics", CUT_IN, "-o", name])
            .status(2)
            .says(&[name, ".parquet", "--format"]);
        assert!(!home.files().join(name).exists());
    }
    let piped = home.run(&["metrics", CUT_IN, "-o", "-"]).status(0).stdout;
    assert_eq!(piped.as_bytes(), read("a.csv"));
    let piped = home.bytes(&["metrics", CUT_IN, "-o", "-", "--format", "parquet"]);
    assert_eq!(piped, read("a.parquet"));
    assert!(!home.files().join("-").exists());
    home.write("folder/keep", "");
    home.run(&["metrics", CUT_IN, "-o", "folder", "--overwrite"])
        .status(2)
        .says(&["folder: is a folder; name a file in it"]);
}

#[test]
fn the_list_tells_what_the_columns_are() {
    let home = Home::new();
    let table = home.run(&["metrics", CUT_IN]).status(0).stdout;
    let columns: Vec<&str> = table.lines().next().unwrap().split(',').skip(8).collect();
    let list = home
        .run(&["metrics", "--list", "--format", "json"])
        .status(0)
        .json_lines();
    let ids: Vec<&str> = list
        .iter()
        .map(|m| m["measure"].as_str().unwrap())
        .collect();
    assert_eq!(ids, columns);
    let ttc = &list[1];
    assert_eq!(
        (&ttc["unit"], &ttc["dangerous"]),
        (&"s".into(), &"low".into())
    );
    assert_eq!(ttc["thresholds"][0]["value"], 1.5);
    assert!(ttc["source"].as_str().unwrap().contains("Hayward"));
    let csv = home
        .run(&["metrics", "--list", "--format", "csv"])
        .status(0)
        .stdout;
    assert_eq!(csv.lines().count(), 1 + columns.len());
    let shown = home.run(&["metrics", "--list"]).status(0).stdout;
    assert!(
        shown.contains("≤ 1.5 s: critical (van der Horst 1990)"),
        "{shown}"
    );
    assert!(shown.contains("< 0 m: dangerous"), "{shown}");
    let scene = home.run(&["metrics", "--list", "--scene"]).status(0).stdout;
    assert!(scene.contains("ttc_star") && !scene.contains("headway"));
    home.write(
        "own.toml",
        "[[threshold]]\nmeasure = \"ttc\"\nname = \"critical\"\nvalue = 0.7\n",
    );
    let own = home
        .run(&["metrics", "--list", "--thresholds", "own.toml"])
        .status(0)
        .stdout;
    assert!(own.contains("≤ 0.7 s: critical"), "{own}");
    for arguments in [
        &["metrics", "--list", CUT_IN][..],
        &["metrics", "--list", "--convention", "paper"],
        &["metrics", "--list", "--format", "parquet"],
        &["metrics"],
    ] {
        home.run(arguments).status(2);
    }
}

/// The files in a folder.
pub fn names(folder: &std::path::Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_file_is_replaced_only_when_asked_and_only_by_a_whole_one() {
    let home = Home::new();
    home.write("old.csv", "precious");
    let read = || std::fs::read(home.files().join("old.csv")).unwrap();
    let refused = ["metrics", CUT_IN, "-o", "old.csv"];
    let _ = home
        .run(&refused)
        .status(2)
        .says(&["old.csv", "--overwrite"]);
    assert_eq!(read(), b"precious");
    // Nothing could be measured: the old table stays.
    home.write("in/broken.xml", &bundled_xml(CUT_IN)[..5000]);
    home.run(&["metrics", "in", "-o", "old.csv", "--overwrite"])
        .status(2)
        .says(&["broken.xml", "truncated"]);
    assert_eq!(read(), b"precious");
    home.run(&["metrics", CUT_IN, "-o", "old.csv", "--overwrite"])
        .status(0);
    assert_eq!(read(), home.run(&["metrics", CUT_IN]).stdout.as_bytes());
    assert_eq!(names(&home.files()), ["in", "old.csv"]);
    home.run(&["metrics", CUT_IN, "--overwrite"])
        .status(2)
        .says(&["--output"]);
}

#[test]
fn many_files_are_one_table_in_their_order_and_a_broken_one_is_named() {
    let home = Home::new();
    let (xml, ego) = (bundled_xml(CUT_IN), bundled_ego(CUT_IN));
    for i in 0..40 {
        home.write(format!("all/s{i:02}.xml"), &xml);
        home.write(format!("all/s{i:02}.ego_trajectory.csv"), &ego);
    }
    home.write("all/s17.xml", &xml[..5000]);
    home.write(
        "all/s23.ego_trajectory.csv",
        "timestep,x_position,y_position\n0,here,0\n",
    );
    for convention in ["exact", "paper"] {
        let ended = home
            .run(&[
                "metrics",
                "all",
                "--convention",
                convention,
                "-o",
                "t.csv",
                "--overwrite",
            ])
            .status(1)
            .says(&[
                "s17.xml",
                "s23.ego_trajectory.csv",
                "line 2",
                "2 of 40 scenarios",
            ]);
        assert!(
            !ended.stderr.contains('\u{1b}'),
            "no bar in a pipe: {}",
            ended.stderr
        );
        let text = std::fs::read_to_string(home.files().join("t.csv")).unwrap();
        let mut order: Vec<_> = table(&text)
            .iter()
            .map(|r| cell(r, "scenario").to_string())
            .collect();
        order.dedup();
        let expected = (0..40).filter(|i| ![17, 23].contains(i));
        assert!(
            order
                .iter()
                .eq(&expected.map(|i| format!("s{i:02}")).collect::<Vec<_>>()),
            "{order:?}"
        );
        let alone = home
            .run(&["metrics", CUT_IN, "--convention", convention])
            .stdout;
        assert_eq!(table(&text).len(), 38 * table(&alone).len());
    }
}
