//! Rows of the database as values, and values as rows: a field is the column of the same name.
//!
//! A field `window` is the columns `window_first` and `window_last`.

use rusqlite::types::{Type, Value, ValueRef};
use rusqlite::{Connection, Error, Row, ToSql, params_from_iter};
use serde::de::value::{Error as Mistake, SeqDeserializer};
use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, Error as _, MapAccess, Visitor};
use serde::de::{IntoDeserializer, value::MapAccessDeserializer};
use serde::{Serialize, forward_to_deserialize_any};

use super::{Run, RunId, StoreError};

/// A run with at most so much of its texts as people look at, as [`run`].
pub fn shown(row: &Row<'_>, most: usize) -> Result<Run, Error> {
    let mut shown = read_run(row, most)?;
    for (name, text) in [
        ("answer", &mut shown.answer),
        ("reasoning", &mut shown.reasoning),
    ] {
        let whole = row.get_ref(name)?.as_str()?.len();
        if whole > text.len() {
            text.push_str(&format!(
                "\n[nearmiss: shortened; {whole} bytes are in the store: nearmiss runs show {} --format json]",
                shown.id
            ));
        }
    }
    Ok(shown)
}

/// A run, without the pieces that have not been put together.
pub fn run(row: &Row<'_>) -> Result<Run, Error> {
    read_run(row, usize::MAX)
}

fn read_run(row: &Row<'_>, most: usize) -> Result<Run, Error> {
    read::<Run>(row, most).map(Run::with_verdict)
}

/// A value made of the columns of a row that it has fields for.
pub fn from_row<T: DeserializeOwned>(row: &Row<'_>) -> Result<T, Error> {
    read(row, usize::MAX)
}

/// The same with at most so much of an answer's text and reasoning.
fn read<T: DeserializeOwned>(row: &Row<'_>, most: usize) -> Result<T, Error> {
    let next = 0;
    let columns = RowColumns { row, most, next };
    T::deserialize(MapAccessDeserializer::new(columns))
        .map_err(|mistake| Error::FromSqlConversionFailure(0, Type::Text, mistake.into()))
}

/// A truth value as the database or JSON has them, for a part of a value that is read with [`from_row`].
pub fn truth<'de, D: Deserializer<'de>>(from: D) -> Result<Option<bool>, D::Error> {
    #[derive(serde::Deserialize)]
    #[serde(untagged)]
    enum Truth {
        Number(i64),
        Said(bool),
    }
    let found: Option<Truth> = serde::Deserialize::deserialize(from)?;
    Ok(found.map(|found| match found {
        Truth::Number(number) => number != 0,
        Truth::Said(truth) => truth,
    }))
}

/// A value that the database has as JSON, and exports as it is; nothing where an unknown version wrote it.
pub fn json<'de, D: Deserializer<'de>, T: DeserializeOwned>(
    from: D,
) -> Result<Option<T>, D::Error> {
    let value: Option<serde_json::Value> = serde::Deserialize::deserialize(from)?;
    Ok(value.and_then(|value| match value {
        serde_json::Value::String(text) => serde_json::from_str(&text).ok(),
        value => serde_json::from_value(value).ok(),
    }))
}

/// The columns of a row as the entries of a map.
struct RowColumns<'a, 'stmt> {
    row: &'a Row<'stmt>,
    most: usize,
    next: usize,
}

impl RowColumns<'_, '_> {
    fn name(&self, place: usize) -> Result<&str, Mistake> {
        let statement = self.row.as_ref();
        statement.column_name(place).map_err(Mistake::custom)
    }
}

impl<'de> MapAccess<'de> for RowColumns<'_, '_> {
    type Error = Mistake;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Mistake> {
        if self.next >= self.row.as_ref().column_count() {
            return Ok(None);
        }
        let name = match self.name(self.next)? {
            "window_first" => "window",
            name => name,
        };
        let key = seed.deserialize(IntoDeserializer::<Mistake>::into_deserializer(name))?;
        self.next += 1;
        Ok(Some(key))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Mistake> {
        let name = self.name(self.next - 1)?;
        let column = |name: &str| self.row.get_ref(name).map_err(Mistake::custom);
        let value = match (name, column(name)?) {
            ("window_first", ValueRef::Integer(first)) => match column("window_last")? {
                ValueRef::Integer(last) => Cell::Pair([first, last]),
                _ => Cell::Value(ValueRef::Null),
            },
            ("answer" | "reasoning", ValueRef::Text(text)) => {
                let text = std::str::from_utf8(text).map_err(Mistake::custom)?;
                Cell::Value(text[..text.floor_char_boundary(self.most)].into())
            }
            (_, value) => Cell::Value(value),
        };
        seed.deserialize(value)
    }
}

/// What is in a column.
enum Cell<'a> {
    Value(ValueRef<'a>),
    Pair([i64; 2]),
}

impl<'de> Deserializer<'de> for Cell<'_> {
    type Error = Mistake;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        match self {
            Self::Value(ValueRef::Null) => visitor.visit_none(),
            Self::Value(ValueRef::Integer(number)) => visitor.visit_i64(number),
            Self::Value(ValueRef::Real(number)) => visitor.visit_f64(number),
            Self::Value(ValueRef::Text(text)) => {
                visitor.visit_str(std::str::from_utf8(text).map_err(Mistake::custom)?)
            }
            Self::Value(ValueRef::Blob(bytes)) => visitor.visit_bytes(bytes),
            Self::Pair(pair) => visitor.visit_seq(SeqDeserializer::new(pair.into_iter())),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        match self {
            Self::Value(ValueRef::Null) => visitor.visit_none(),
            some => visitor.visit_some(some),
        }
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        match self {
            Self::Value(ValueRef::Integer(truth)) => visitor.visit_bool(truth != 0),
            other => other.deserialize_any(visitor),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Mistake> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Mistake> {
        let word: String = serde::Deserialize::deserialize(self)?;
        word.into_deserializer()
            .deserialize_enum(name, variants, visitor)
    }

    forward_to_deserialize_any! {
        i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct identifier ignored_any
    }
}

/// Values to write, by the names of their columns.
#[derive(Debug, Default)]
pub struct Columns(Vec<(String, Value)>);

impl Columns {
    /// The fields of a value. A count that SQLite cannot hold is not known: no number is worth losing an answer.
    ///
    /// # Errors
    /// The value has no fields.
    pub fn from_fields(value: &impl Serialize) -> Result<Self, StoreError> {
        use serde_json::Value as Json;
        let fields: serde_json::Map<String, Json> =
            serde_json::from_value(serde_json::to_value(value)?)?;
        let mut columns = Self::default();
        for (name, value) in fields {
            if name == "window" {
                columns = columns.with("window_first", value.get(0).and_then(Json::as_i64));
                columns = columns.with("window_last", value.get(1).and_then(Json::as_i64));
                continue;
            }
            let value = match value {
                Json::String(text) => Value::Text(text),
                Json::Bool(truth) => Value::from(truth),
                Json::Number(number) if number.is_f64() => Value::from(number.as_f64()),
                other => Value::from(other.as_i64()),
            };
            columns.0.push((name, value));
        }
        Ok(columns)
    }

    /// The same with this value, in the place of one of this name.
    pub fn with(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.0.retain(|(known, _)| known != name);
        self.0.push((name.into(), value.into()));
        self
    }

    /// The same without a column.
    pub fn without(mut self, name: &str) -> Self {
        self.0.retain(|(known, _)| known != name);
        self
    }

    /// Inserts them as a run.
    pub fn insert(self, connection: &Connection) -> Result<RunId, Error> {
        let names: Vec<&str> = self.0.iter().map(|(name, _)| name.as_str()).collect();
        let places = vec!["?"; names.len()].join(", ");
        let sql = format!("INSERT INTO runs ({}) VALUES ({places})", names.join(", "));
        let mut statement = connection.prepare_cached(&sql)?;
        statement.execute(params_from_iter(self.0.iter().map(|(_, value)| value)))?;
        Ok(RunId(connection.last_insert_rowid()))
    }

    /// Writes them into a run.
    pub fn update(self, connection: &Connection, run: RunId) -> Result<(), Error> {
        let names: Vec<String> = self
            .0
            .iter()
            .map(|(name, _)| format!("{name} = ?"))
            .collect();
        let sql = format!("UPDATE runs SET {} WHERE id = ?", names.join(", "));
        let values = self.0.iter().map(|(_, value)| value as &dyn ToSql);
        let mut statement = connection.prepare_cached(&sql)?;
        statement.execute(params_from_iter(values.chain([&run.0 as &dyn ToSql])))?;
        Ok(())
    }
}

/// The texts of the pieces that have not been put together: answer and reasoning.
pub fn pieces(connection: &Connection, run: RunId) -> Result<(String, String), Error> {
    let mut statement = connection
        .prepare_cached("SELECT reasoning, text FROM pieces WHERE run = ?1 ORDER BY id")?;
    let mut rows = statement.query([run.0])?;
    let (mut answer, mut reasoning) = (String::new(), String::new());
    while let Some(row) = rows.next()? {
        let text = row.get_ref(1)?.as_str()?;
        if row.get(0)? {
            &mut reasoning
        } else {
            &mut answer
        }
        .push_str(text);
    }
    Ok((answer, reasoning))
}

/// A run with the pieces that have arrived so far.
pub fn with_pieces(connection: &Connection, mut run: Run) -> Result<Run, StoreError> {
    let (answer, reasoning) = pieces(connection, run.id)?;
    run.answer.push_str(&answer);
    run.reasoning.push_str(&reasoning);
    Ok(run)
}
