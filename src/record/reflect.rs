//! What a noun's type says of itself: its JSON schema, its columns, and a row of one of them.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde_json::Value;

use crate::table::{Cell, Column, Kind, Row};

/// A noun: a struct whose fields say with their documentation, `#[schemars(title = "took", extend("unit" = "s",
/// "decimals" = 1))]` and their types what every face of it shows.
pub trait Record: Serialize + JsonSchema {
    /// Its name in `nearmiss help json`.
    const NAME: &'static str;
    /// What it is, in one line.
    const TITLE: &'static str;
}

/// The JSON schema of what is written of a type, with everything in it.
pub fn schema<R: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().for_serialize().with(|s| {
        s.inline_subschemas = true;
        s.meta_schema = None;
    });
    settings
        .into_generator()
        .into_root_schema_for::<R>()
        .to_value()
}

/// The columns of a noun. A field of a field is `outer.inner`, a pair of numbers is `field_low` and `field_high`, one of
/// whole numbers `field_first` and `field_last`; lists of plain values and maps are text, lists of nouns have no column.
pub fn columns<R: JsonSchema>() -> Vec<Column> {
    let mut found = Vec::new();
    collect("", &schema::<R>(), (false, ""), &mut found);
    found
}

/// The row of one of them, below [`columns`] of its type.
///
/// # Errors
/// A map in it has keys that JSON does not allow.
pub fn row<R: Serialize + JsonSchema>(record: &R) -> serde_json::Result<Row> {
    row_of(&columns::<R>(), record)
}

/// The row of one of them, below these of its columns.
///
/// # Errors
/// A map in it has keys that JSON does not allow.
pub fn row_of(columns: &[Column], record: &impl Serialize) -> serde_json::Result<Row> {
    let value = serde_json::to_value(record)?;
    Ok(columns.iter().map(|c| cell(&value, &c.name)).collect())
}

/// The rows of many, below [`columns`] of their type.
///
/// # Errors
/// A map in one has keys that JSON does not allow.
pub fn rows<'r, R: Serialize + JsonSchema + 'r>(
    records: impl IntoIterator<Item = &'r R>,
) -> serde_json::Result<Vec<Row>> {
    let columns = columns::<R>();
    let row = |record| row_of(&columns, record);
    records.into_iter().map(row).collect()
}

/// The titles and values of one, for a panel, as far as its fields have titles and values.
///
/// # Errors
/// A map in it has keys that JSON does not allow.
pub fn titled<R: Serialize + JsonSchema>(record: &R) -> serde_json::Result<Vec<(String, String)>> {
    let cells = row(record)?;
    let titled = columns::<R>().into_iter().zip(cells);
    Ok(titled
        .filter(|(column, cell)| !column.title.is_empty() && !matches!(cell, Cell::None(_)))
        .map(|(column, cell)| {
            let words = format!("{} {}", cell.shown(&column), column.unit);
            (column.title.into_owned(), words.trim_end().to_string())
        })
        .collect())
}

/// The columns of a noun that one of its tables for people shows: those of this `table`, and those of every one.
pub fn columns_of<R: JsonSchema>(table: &str) -> Vec<Column> {
    let mut all = columns::<R>();
    for column in &mut all {
        if !column.table.is_empty() && column.table != table {
            column.title = "".into();
        }
    }
    all
}

/// Adds the columns of a value, which may be missing, and which stand in a `table` as the field says that it is of.
fn collect(name: &str, schema: &Value, (optional, table): (bool, &str), into: &mut Vec<Column>) {
    let (schema, null) = without_null(schema);
    let optional = optional || null;
    let own = schema.get("table").and_then(Value::as_str);
    let table = if table.is_empty() {
        own.unwrap_or_default()
    } else {
        table
    };
    if let Some(fields) = schema.get("properties").and_then(Value::as_object) {
        let required = schema.get("required").and_then(Value::as_array);
        for (key, field) in fields {
            let name = if name.is_empty() {
                key.clone()
            } else {
                format!("{name}.{key}")
            };
            let always = required.is_some_and(|all| all.iter().any(|one| one == key));
            collect(&name, field, (optional || !always, table), into);
        }
        return;
    }
    if is_list_of_objects(schema) {
        return;
    }
    let column = |name: &str, kind: Kind, optional: bool| Column {
        table: table.to_owned().into(),
        ..column(name, schema, kind, optional)
    };
    if let Some(of) = pair(schema) {
        let ends = if of == Kind::Float {
            ["low", "high"]
        } else {
            ["first", "last"]
        };
        for end in ends {
            into.push(column(&format!("{name}_{end}"), of, optional));
        }
        return;
    }
    // What may be anything may be nothing.
    let any = ["type", "enum", "const", "anyOf", "oneOf"];
    let any = !any.iter().any(|key| schema.get(key).is_some());
    into.push(column(name, kind(schema), optional || any));
}

/// A column as its field's schema describes it.
fn column(name: &str, schema: &Value, kind: Kind, optional: bool) -> Column {
    let text = |key: &str| {
        let found = schema.get(key).and_then(Value::as_str);
        found.unwrap_or_default().to_owned().into()
    };
    let decimals = schema.get("decimals").and_then(Value::as_u64);
    let is = |key: &str| schema.get(key) == Some(&Value::Bool(true));
    Column {
        name: name.to_owned().into(),
        kind,
        optional,
        unit: text("unit"),
        source: text("description"),
        title: text("title"),
        decimals: decimals.and_then(|digits| usize::try_from(digits).ok()),
        table: "".into(),
        rare: is("rare"),
        bounded: is("bounded"),
        on_clock: is("clock"),
    }
}

/// The schema of a value that is there, and whether it may be missing.
fn without_null(schema: &Value) -> (&Value, bool) {
    let is_null = |one: &Value| one.get("type").is_some_and(|kind| kind == "null");
    let any = schema.get("anyOf").and_then(Value::as_array);
    if let Some(any) = any.filter(|any| any.iter().any(is_null)) {
        let there = any.iter().find(|one| !is_null(one));
        // A field's own words stand beside the choice; those of a plain value in it are not needed.
        let nested = there.filter(|one| one.get("properties").is_some() || pair(one).is_some());
        return (nested.unwrap_or(schema), true);
    }
    (schema, types(schema).contains(&"null"))
}

fn types(schema: &Value) -> Vec<&str> {
    match schema.get("type") {
        Some(Value::String(one)) => vec![one],
        Some(Value::Array(all)) => all.iter().filter_map(Value::as_str).collect(),
        _ => Vec::new(),
    }
}

fn kind(schema: &Value) -> Kind {
    match types(schema).first() {
        Some(&"integer") => Kind::Integer,
        Some(&"number") => Kind::Float,
        Some(&"boolean") => Kind::Truth,
        _ => Kind::Text,
    }
}

/// Whether a value is a list of nouns, which no cell holds.
fn is_list_of_objects(schema: &Value) -> bool {
    let items = schema.get("items");
    items.is_some_and(|item| item.get("properties").is_some() || item.get("anyOf").is_some())
}

/// What a pair of numbers is of: the two ends of an interval, or first and last.
fn pair(schema: &Value) -> Option<Kind> {
    let [first, last] = schema.get("prefixItems")?.as_array()?.as_slice() else {
        return None;
    };
    let of = kind(first);
    (of == kind(last) && matches!(of, Kind::Float | Kind::Integer)).then_some(of)
}

/// The cell of a column.
fn cell(record: &Value, name: &str) -> Cell {
    let mut value = record;
    for part in name.split('.') {
        let end = [("_low", 0), ("_high", 1), ("_first", 0), ("_last", 1)];
        let found = value.get(part).or_else(|| {
            let ends = end.iter();
            let mut ends = ends.filter_map(|(end, place)| Some((part.strip_suffix(end)?, place)));
            ends.find_map(|(field, place)| value.get(field)?.get(*place))
        });
        match found {
            Some(found) => value = found,
            None => return Cell::None(""),
        }
    }
    match value {
        Value::Array(items) if !items.iter().any(|i| i.is_object() || i.is_array()) => {
            let words = items.iter().map(|item| match item {
                Value::String(text) => text.clone(),
                other => other.to_string(),
            });
            let words: Vec<String> = words.collect();
            // Lines stay lines.
            let between = if words.iter().any(|word| word.contains(' ')) {
                "\n"
            } else {
                " "
            };
            words.join(between).into()
        }
        plain => Cell::from_json(plain),
    }
}
