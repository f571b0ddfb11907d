//! `report --rows … --columns …`, `--against` and `--figure`.

use std::collections::BTreeMap;
use std::path::Path;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::Value;

use crate::answer_page::filled;
use crate::support::program::Home;

#[test]
fn a_table_over_axes_has_every_format() {
    let home = Home::new();
    filled(&home, 12);
    let report = |more: &[&str]| home.run(&[&["report", "--truth", "truth.csv"], more].concat());
    let axes = [
        "--rows",
        "model",
        "--columns",
        "techniques",
        "--measure",
        "accuracy",
    ];
    let markdown = report(&axes).status(0).stdout;
    let caption = "**Accuracy by model and techniques, collision task: 12 scenarios, n = 240; asked 2023-11-14; models as returned: small-2024 (lab/fast)";
    assert!(markdown.contains(caption), "{markdown}");
    assert!(
        markdown.contains("| Model ") && markdown.contains(", n = 12 |"),
        "{markdown}"
    );
    let json = report(&[&axes[..], &["--format=json"]].concat())
        .status(0)
        .stdout;
    let json: Value = serde_json::from_str(&json).unwrap();
    let cells = json["tables"][0]["cells"].as_array().unwrap();
    assert_eq!(
        (cells.len(), &json["rows"], &json["measure"]),
        (20, &"model".into(), &"accuracy".into())
    );
    let csv = report(&[&axes[..], &["--format", "csv"]].concat())
        .status(0)
        .stdout;
    assert_eq!(csv.lines().count(), 21);
    assert!(
        csv.starts_with("task,model,techniques,n,answered,scenarios,accuracy,"),
        "{csv}"
    );
    // Every cell is in CSV what it is in JSON.
    let of_json = cells[0]["value"].to_string();
    assert_eq!(
        csv.lines().nth(1).unwrap().split(',').nth(6),
        Some(of_json.as_str())
    );
    let latex = report(&[
        "--rows",
        "techniques",
        "--against",
        "base",
        "--columns",
        "model",
        "--format",
        "latex",
    ])
    .status(0)
    .stdout;
    for words in [
        "\\toprule",
        "\\label{tab:nearmiss-collision-right-of-all-techniques-model-against}",
        "p (Holm)",
        "$-$",
    ] {
        assert!(latex.contains(words), "{words}: {latex}");
    }
    let against = report(&["--rows", "model", "--against", "lab/large", "--format=json"])
        .status(0)
        .stdout;
    let against: Value = serde_json::from_str(&against).unwrap();
    let differences = against["tables"][0]["differences"].as_array().unwrap();
    assert_eq!(differences.len(), 4);
    for one in differences {
        assert!(one["p_holm"].as_f64() >= one["p"].as_f64(), "{one}");
    }
}

#[test]
fn wrong_axes_are_named() {
    let home = Home::new();
    filled(&home, 2);
    let report = |more: &[&str]| home.run(&[&["report", "--truth", "truth.csv"], more].concat());
    report(&["--rows", "modle"])
        .status(2)
        .says(&["did you mean `model`?"]);
    report(&["--columns", "model"])
        .status(2)
        .says(&["--columns needs --rows AXIS"]);
    report(&["--rows", "model", "--columns", "model"])
        .status(2)
        .says(&["choose another"]);
    report(&["--rows", "model", "--against", "lab/larg"])
        .status(2)
        .says(&["did you mean `lab/large`?"]);
    report(&["--rows", "model", "--measure", "f2"])
        .status(2)
        .says(&["unknown measure `f2`"]);
}

#[test]
fn figures_are_svg_or_png() {
    let home = Home::new();
    filled(&home, 12);
    let report = |more: &[&str]| home.run(&[&["report", "--truth", "truth.csv"], more].concat());
    for (figure, words) in [
        ("bars", "Right of all asked, intervals of 95 %"),
        ("reliability", "probability of a yes"),
    ] {
        let file = format!("{figure}.svg");
        report(&["--figure", figure, "-o", &file]).status(0);
        let svg = std::fs::read_to_string(home.files().join(&file)).unwrap();
        assert!(
            svg.contains(words) && svg.contains("lab/small") && !svg.contains("NaN"),
            "{svg}"
        );
        report(&["--figure", figure, "-o", &file])
            .status(2)
            .says(&["--overwrite"]);
    }
    report(&["--figure", "bars", "--measure", "recall", "-o", "bars.png"]).status(0);
    let png = std::fs::read(home.files().join("bars.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    report(&["--figure", "leads", "-o", "leads.svg"])
        .status(2)
        .says(&["leads=0.5,1,2"]);
    report(&["--figure", "cost", "-o", "cost.svg"])
        .status(2)
        .says(&["known cost"]);
    let axes = [
        "--rows",
        "model",
        "--columns",
        "techniques",
        "-o",
        "axes.svg",
    ];
    report(&[&["--figure", "bars"], &axes[..]].concat()).status(0);
    let svg = std::fs::read_to_string(home.files().join("axes.svg")).unwrap();
    assert!(
        svg.contains("lab/small · base") && svg.contains("n = 12"),
        "{svg}"
    );
    report(&[&["--figure", "cost"], &axes[..]].concat())
        .status(2)
        .says(&["only bars are drawn over axes"]);
    report(&["--figure", "bars", "-o", "bars.gif"])
        .status(2)
        .says(&[".svg and .png"]);
}

/// The rows of a Parquet file as CSV has them, its columns, and its metadata.
fn parquet(path: &Path) -> (Vec<Vec<String>>, Vec<String>, BTreeMap<String, String>) {
    let file = SerializedFileReader::new(std::fs::File::open(path).unwrap()).unwrap();
    let rows = file.get_row_iter(None).unwrap().map(|row| {
        let row = row.unwrap();
        let cells = row.get_column_iter().map(|(name, field)| match field {
            Field::Null => String::new(),
            Field::Str(text) => text.clone(),
            Field::Bool(truth) => truth.to_string(),
            Field::Long(number) => number.to_string(),
            Field::Double(number) => Value::from(*number).to_string(),
            other => panic!("{name} is {other:?}"),
        });
        cells.collect()
    });
    let about = file.metadata().file_metadata();
    let columns = about
        .schema_descr()
        .columns()
        .iter()
        .map(|column| format!("{} {}", column.name(), column.physical_type()));
    let entries = about
        .key_value_metadata()
        .unwrap()
        .iter()
        .map(|entry| (entry.key.clone(), entry.value.clone().unwrap()));
    (rows.collect(), columns.collect(), entries.collect())
}

#[test]
fn parquet_has_the_rows_of_csv_and_what_they_were_made_from() {
    let home = Home::new();
    filled(&home, 12);
    let report = |more: &[&str]| home.run(&[&["report", "--truth", "truth.csv"], more].concat());
    for (name, more) in [
        ("cells", &[][..]),
        ("axes", &["--rows", "model", "--columns", "techniques"]),
        ("against", &["--rows", "model", "--against", "lab/large"]),
    ] {
        let csv = report(&[more, &["--format", "csv"]].concat()).status(0);
        let file = format!("{name}.parquet");
        report(&[more, &["-o", &file]].concat()).status(0);
        let (rows, columns, metadata) = parquet(&home.files().join(&file));
        let mut reader = csv::Reader::from_reader(csv.stdout.as_bytes());
        let names: Vec<String> = reader.headers().unwrap().iter().map(Into::into).collect();
        let of_columns = columns
            .iter()
            .map(|column| column.split(' ').next().unwrap());
        assert!(of_columns.eq(names.iter()), "{columns:?}");
        let lines = reader.records().map(|line| {
            let line = line.unwrap();
            line.iter().map(String::from).collect::<Vec<_>>()
        });
        assert!(!rows.is_empty());
        // A whole number among others has a point in Parquet.
        for (row, line) in rows.iter().zip(lines.collect::<Vec<_>>()) {
            for ((ours, theirs), column) in row.iter().zip(&line).zip(&columns) {
                let same =
                    ours == theirs || ours.parse::<f64>().is_ok_and(|n| theirs.parse() == Ok(n));
                assert!(same, "{column}: {ours}, not {theirs}");
            }
        }
        let provenance: Value = serde_json::from_str(&metadata["nearmiss.provenance"]).unwrap();
        assert!(
            provenance["program"]
                .as_str()
                .unwrap()
                .starts_with("nearmiss ")
        );
        assert!(
            csv.stderr.contains("nearmiss: Provenance: "),
            "{}",
            csv.stderr
        );
        if name == "cells" {
            for column in [
                "label BYTE_ARRAY",
                "settings BYTE_ARRAY",
                "n INT64",
                "f1 DOUBLE",
            ] {
                assert!(
                    columns.iter().any(|one| one == column),
                    "{column}: {columns:?}"
                );
            }
        }
    }
    let piped = home.bytes(&["report", "--truth", "truth.csv", "--format", "parquet"]);
    assert!(piped.starts_with(b"PAR1"));
}
