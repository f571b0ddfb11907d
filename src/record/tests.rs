//! One field added to a noun is seen in each of its faces.

use std::io::Write as _;

use schemars::JsonSchema;
use serde::Serialize;

use crate::table::Kind;
use crate::{
    Format, Record, Table, TableWriter, columns, json_line, row, rows, schema, text_table, titled,
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
    /// The reaction time of the good driver.
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
    assert!(line.starts_with("{\"schema_version\":1,\"scenario\":\"A-1\\u001b\","));
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
