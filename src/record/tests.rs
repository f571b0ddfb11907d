//! One field added to a noun is seen in each of its faces.

use std::io::Write as _;

use schemars::JsonSchema;
use serde::Serialize;

use crate::table::Kind;
use crate::{
    CaptionedTable, Cell, Clock, Column, Format, Record, Table, TableWriter, columns, columns_of,
    json_line, row, rows, schema, text_table, titled,
};

/// A noun with every type of field.
#[derive(Serialize, JsonSchema)]
struct Drive {
    /// The scenario.
    #[schemars(title = "scenario")]
    scenario: String,
    /// How it ended.
    #[schemars(title = "ends")]
    outcome: Ending,
    steps: u32,
    /// Mean risk score with its interval.
    risk: f64,
    risk_ci: Option<(f64, f64)>,
    good_driver: Option<GoodDriver>,
    rules: Vec<&'static str>,
    /// The field that was added: this line is all that it needs.
    #[schemars(title = "brakes", extend("unit" = "m/s²", "decimals" = 1))]
    deceleration: Option<f64>,
}

#[derive(Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Ending {
    Goal,
    #[allow(dead_code, reason = "the schema lists it")]
    OffRoad,
}

#[derive(Serialize, JsonSchema)]
struct GoodDriver {
    /// Whether it survives.
    survives: bool,
    /// The reaction time of the ideal driver.
    #[schemars(title = "reacts", extend("unit" = "s"))]
    delay: f64,
}

impl Record for Drive {
    const NAME: &'static str = "drive";
    const TITLE: &'static str = "One drive a line";
}

fn drive(deceleration: Option<f64>) -> Drive {
    Drive {
        scenario: "A-1\u{1b}".into(),
        outcome: Ending::Goal,
        steps: 40,
        risk: 2.0,
        risk_ci: deceleration.map(|_| (1.5, 2.5)),
        good_driver: deceleration.map(|_| GoodDriver {
            survives: true,
            delay: 1.25,
        }),
        rules: vec!["R_G1", "R_G3"],
        deceleration,
    }
}

fn written(format: Format) -> Vec<u8> {
    let table = Table::new("drives", columns::<Drive>());
    let rows = rows([&drive(Some(3.25)), &drive(None)]).expect("plain keys");
    let mut writer = TableWriter::begin(Vec::new(), format, &table).expect("memory");
    writer.write(table.encode(format, rows)).expect("memory");
    writer.finish().expect("memory")
}

#[test]
fn columns_say_type_unit_and_meaning() {
    let all = columns::<Drive>();
    let names: Vec<&str> = all.iter().map(|c| &*c.name).collect();
    assert_eq!(
        names,
        [
            "scenario",
            "outcome",
            "steps",
            "risk",
            "risk_ci_low",
            "risk_ci_high",
            "good_driver.survives",
            "good_driver.delay",
            "rules",
            "deceleration"
        ]
    );
    let kinds: Vec<Kind> = all.iter().map(|c| c.kind).collect();
    use Kind::{Float, Integer, Text, Truth};
    assert_eq!(
        kinds,
        [
            Text, Text, Integer, Float, Float, Float, Truth, Float, Text, Float
        ]
    );
    let optional: Vec<bool> = all.iter().map(|c| c.optional).collect();
    assert_eq!(
        optional,
        [
            false, false, false, false, true, true, true, true, false, true
        ]
    );
    let added = all.last().expect("a column");
    assert_eq!((&*added.title, &*added.unit), ("brakes", "m/s²"));
    assert_eq!(
        added.source,
        "The field that was added: this line is all that it needs."
    );
}

#[test]
fn the_added_field_is_in_every_face() {
    let csv = String::from_utf8(written(Format::Csv)).expect("UTF-8");
    assert_eq!(
        csv,
        "scenario,outcome,steps,risk,risk_ci_low,risk_ci_high,good_driver.survives,good_driver.delay,rules,deceleration\n\
         A-1␛,goal,40,2.0,1.5,2.5,true,1.25,R_G1 R_G3,3.25\n\
         A-1␛,goal,40,2.0,,,,,R_G1 R_G3,\n"
    );
    let line = json_line(&drive(Some(3.25))).expect("plain keys");
    assert!(line.starts_with("{\"schema_version\":2,\"scenario\":\"A-1\\u001b\","));
    assert!(line.ends_with("\"deceleration\":3.25}\n"), "{line}");
    let (first, second) = (drive(Some(3.25)), drive(None));
    let rows = rows([&first, &second]).expect("plain keys");
    assert_eq!(
        text_table(&columns::<Drive>(), &rows),
        "scenario  ends  reacts s  brakes m/s²\n\
         A-1␛      goal      1.25          3.2\n\
         A-1␛      goal         -            -\n"
    );
    let panel = titled(&first).expect("plain keys");
    assert!(panel.contains(&("brakes".into(), "3.2 m/s²".into())));
    assert_eq!(titled(&second).expect("plain keys").len(), 2);
    let schema = schema::<Drive>();
    assert_eq!(
        schema["properties"]["deceleration"]["description"],
        "The field that was added: this line is all that it needs."
    );
    assert_eq!(row(&first).expect("plain keys").len(), 10);
}

#[test]
fn parquet_has_the_types_of_the_fields() {
    use ::parquet::file::reader::{FileReader, SerializedFileReader};
    let mut file = tempfile::tempfile().expect("a file");
    file.write_all(&written(Format::Parquet)).expect("room");
    let reader = SerializedFileReader::new(file).expect("a Parquet file");
    let schema = reader.metadata().file_metadata().schema_descr();
    let types: Vec<String> = schema
        .columns()
        .iter()
        .map(|c| format!("{} {}", c.name(), c.physical_type()))
        .collect();
    assert_eq!(types[2], "steps INT64");
    assert_eq!(types[9], "deceleration DOUBLE");
    let row = reader.get_row_iter(None).expect("rows").next();
    let row = row.expect("a row").expect("readable").to_string();
    assert!(row.contains("deceleration: 3.25"), "{row}");
}

#[test]
fn arrow_has_durations_units_and_gaps() {
    use arrow_array::Array;
    use arrow_array::cast::AsArray;
    use arrow_array::types::{DurationMicrosecondType, Float64Type};
    let mut table = Table::new(
        "measures",
        vec![
            Column::clock("time", "since step 0"),
            Column::new("ttc", Kind::Number, "s", "Hayward").optional(),
        ],
    )
    .with_reasons();
    table.metadata.push(("version", "1".into()));
    let rows = vec![
        vec![Cell::Number(1.2), Cell::Infinite("parallel")],
        vec![Cell::Number(1.3), Cell::None("no contact")],
    ];
    let encoded = table.encode(Format::Arrow, rows.clone());
    let mut writer = TableWriter::begin(Vec::new(), Format::Arrow, &table).expect("a stream");
    writer.write(encoded).expect("room");
    let bytes = writer.finish().expect("room");
    let mut reader = arrow_ipc::reader::StreamReader::try_new(&*bytes, None).expect("a stream");
    let schema = reader.schema();
    assert_eq!(
        schema
            .metadata()
            .get("nearmiss.version")
            .map(String::as_str),
        Some("1")
    );
    let ttc = schema.field(1);
    assert_eq!(ttc.metadata().get("unit").map(String::as_str), Some("s"));
    assert_eq!(
        ttc.metadata().get("description").map(String::as_str),
        Some("Hayward")
    );
    let batch = reader.next().expect("a batch").expect("readable");
    let times = batch.column(0).as_primitive::<DurationMicrosecondType>();
    assert_eq!(times.values(), &[1_200_000, 1_300_000]);
    let ttc = batch.column(1).as_primitive::<Float64Type>();
    assert!(ttc.value(0) == f64::INFINITY && ttc.is_null(1));
    assert_eq!(batch.column(2).as_string::<i32>().value(1), "no contact");
    assert!(reader.next().is_none());
    // Parquet has no durations.
    assert_eq!(
        table.arrow_schema(Clock::Seconds).field(0).data_type(),
        &arrow_schema::DataType::Float64
    );
    // A gap where none may be is an error, not a shorter column.
    let mut gap = rows;
    gap[0][0] = Cell::None("");
    assert!(
        table
            .arrow_batch(&table.arrow_schema(Clock::Durations), gap)
            .is_err()
    );
}

/// A noun that stands in several tables of a document.
#[derive(Serialize, JsonSchema)]
struct Result {
    #[schemars(title = "Model")]
    model: &'static str,
    #[schemars(title = "Recall", extend("decimals" = 2, "table" = "shares"))]
    recall: Option<f64>,
    recall_ci: Option<(f64, f64)>,
    #[schemars(title = "Not asked", extend("rare" = true, "table" = "shares"))]
    unasked: u32,
    #[schemars(title = "p", extend("decimals" = 3, "bounded" = true, "table" = "tests"))]
    p: f64,
}

impl Record for Result {
    const NAME: &'static str = "result";
    const TITLE: &'static str = "A result";
}

#[test]
fn a_table_of_a_document_has_its_columns_with_intervals_in_every_markup() {
    let results = |unasked| {
        [
            Result {
                model: "lab/a_b <i>",
                recall: Some(0.5),
                recall_ci: Some((0.25, 0.75)),
                unasked,
                p: 0.0001,
            },
            Result {
                model: "lab/c",
                recall: None,
                recall_ci: None,
                unasked: 0,
                p: 0.001,
            },
        ]
    };
    let table = |name: &str, unasked| {
        let rows = rows(&results(unasked)).expect("plain keys");
        CaptionedTable::new("Shares & p", "shares", &columns_of::<Result>(name), &rows)
    };
    let shares = table("shares", 0).with_notes(["Why: 5 %.".to_string()]);
    assert_eq!(
        shares.markdown(),
        "\n**Shares & p**\n\n\
         | Model        |            Recall |\n\
         |:------------ | -----------------:|\n\
         | lab/a_b \\<i> | 0.50 [0.25, 0.75] |\n\
         | lab/c        |                 – |\n"
    );
    let latex = shares.latex();
    for part in [
        "\\caption{Shares \\& p}",
        "  Model & Recall \\\\",
        "  lab/a\\_b $<$i$>$ & 0.50 [0.25, 0.75] \\\\",
        "\\emph{Notes.} Why: 5 \\%.",
    ] {
        assert!(latex.contains(part), "{part}: {latex}");
    }
    let html = shares.html();
    for part in [
        "<td>lab/a_b &lt;i&gt;</td><td class=\"n\">0.50 <span class=\"ci\">[0.25, 0.75]</span></td>",
        "aria-labelledby=\"shares\"",
    ] {
        assert!(html.contains(part), "{part}: {html}");
    }
    let titles = |table: &CaptionedTable| {
        let titles = table.columns.iter().map(|(title, _)| title.clone());
        titles.collect::<Vec<_>>()
    };
    assert_eq!(
        titles(&table("shares", 2)),
        ["Model", "Recall", "Not asked"]
    );
    let tests = table("tests", 0);
    assert_eq!(titles(&tests), ["Model", "p"]);
    assert_eq!(
        (&*tests.rows[0][1], &*tests.rows[1][1]),
        ("< 0.001", "0.001")
    );
}
