//! A table of fields: key, meaning, bounds and default of each setting, once for files, command line, store and schema.
//!
//! ```
//! use nearmiss_record::fields::{Fields, Layers};
//!
//! nearmiss_record::fields! {
//!     /// How something is asked.
//!     pub struct Asking {
//!         "sampling" {
//!             /// Answers to each question.
//!             samples: u32 = 1, Takes::Whole(1, 1000);
//!             /// Obstacles within this distance are described.
//!             radius: Option<f64>, Takes::Above(0.0, 1e6), "m";
//!         }
//!     }
//! }
//!
//! let mut layers = Layers::<Asking>::default();
//! layers.file("lab.toml", "samples = 3\nradius = 0\n");
//! layers.word("--set radius", "radius", "20");
//! let asking = layers.read().unwrap();
//! assert_eq!((asking.samples, asking.text("radius")), (3, Some("20 m".into())));
//! ```

mod layers;
mod values;

use nearmiss_base::system::unknown;
use serde_json::Value as Json;
use toml::{Table, Value};

pub use layers::Layers;
pub use values::{FieldValue, OneOrMore, Word, Wrong, unknown_word};

/// What a field takes beyond what its type says.
#[derive(Debug, Clone, Copy)]
pub enum Takes {
    /// Everything.
    Any,
    /// Whole numbers between these.
    Whole(i64, i64),
    /// Numbers between these.
    Number(f64, f64),
    /// Numbers above the first, at most the second.
    Above(f64, f64),
    /// Numbers between these, without them.
    Between(f64, f64),
    /// Odd numbers between these.
    Odd(i64, i64),
    /// One of these texts.
    OneOf(&'static [&'static str]),
    /// Texts in which this finds nothing wrong.
    Checked(fn(&str) -> Result<(), String>),
}

/// A row of the table.
#[derive(Debug)]
pub struct Row {
    /// The key in files and on the command line.
    pub key: &'static str,
    /// What it is for, and what holds without it.
    doc: &'static str,
    /// The group it belongs to.
    pub section: &'static str,
    /// The unit of numbers, else nothing.
    pub unit: &'static str,
    flags: &'static [&'static str],
    takes: Takes,
    describe: fn(&Takes) -> (String, Json),
    parse: fn(&str) -> Value,
}

impl Row {
    /// What it is for, and what holds without it.
    #[must_use]
    pub fn doc(&self) -> &'static str {
        self.doc.trim()
    }

    /// Whether the table says this of it.
    #[must_use]
    pub fn is(&self, flag: &str) -> bool {
        self.flags.contains(&flag)
    }

    /// What it takes, as messages say it, with its unit.
    #[must_use]
    pub fn expected(&self) -> String {
        let (words, _) = (self.describe)(&self.takes);
        let unit = self.unit;
        format!("expected {words} {unit}").trim_end().into()
    }

    /// Reads a value from a command line.
    #[must_use]
    pub fn parse(&self, text: &str) -> Value {
        (self.parse)(text)
    }

    #[doc(hidden)]
    #[must_use]
    pub const fn new<T: FieldValue>(
        key: &'static str,
        doc: &'static str,
        section: &'static str,
        flags: &'static [&'static str],
    ) -> Self {
        Self {
            key,
            doc,
            section,
            unit: "",
            flags,
            takes: Takes::Any,
            describe: T::describe,
            parse: T::parse,
        }
    }

    #[doc(hidden)]
    #[must_use]
    pub const fn takes(self, takes: Takes) -> Self {
        Self { takes, ..self }
    }

    #[doc(hidden)]
    #[must_use]
    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    #[doc(hidden)]
    pub fn read<T: FieldValue>(&self, value: &Value) -> Result<T, Wrong> {
        T::read(value, &self.takes)
    }
}

/// A struct whose fields a table describes; [`fields!`](crate::fields!) makes one.
pub trait Fields: Sized + Clone + PartialEq + Default {
    /// The table, in the order in which files are written.
    fn rows() -> &'static [Row];

    /// The value of a field; nothing where there is none.
    fn value(&self, key: &str) -> Option<Value>;

    /// Sets a field.
    ///
    /// # Errors
    /// It does not take the value.
    fn set(&mut self, key: &str, value: &Value) -> Result<(), Wrong>;

    /// The value of a field; nothing where it is the default, unless it is required.
    fn get(&self, key: &str) -> Option<Value> {
        let (row, value) = (Self::row(key).ok()?, self.value(key)?);
        (row.is("required") || Self::default().value(key).as_ref() != Some(&value)).then_some(value)
    }

    /// A row by its key.
    ///
    /// # Errors
    /// There is none: with the one that was probably meant.
    fn row(key: &str) -> Result<&'static Row, String> {
        let row = Self::rows().iter().find(|row| row.key == key);
        row.ok_or_else(|| unknown("key", key, Self::rows().iter().map(|row| row.key)))
    }

    /// The fields that are not as by default, each with its row.
    fn given(&self) -> impl Iterator<Item = (&'static Row, Value)> {
        let rows = Self::rows().iter();
        rows.filter_map(|row| Some((row, self.get(row.key)?)))
    }

    /// A field in words, with its unit; nothing where it is the default.
    fn text(&self, key: &str) -> Option<String> {
        let row = Self::row(key).ok()?;
        let value = self.get(key)?;
        Some(match row.unit {
            "" => values::text(&value),
            unit => format!("{} {unit}", values::text(&value)),
        })
    }

    /// The members of a list in words, or the one value, each with its unit.
    fn texts(&self, key: &str) -> Vec<String> {
        let unit = Self::row(key).map_or("", |row| row.unit);
        let members = match self.get(key) {
            Some(Value::Array(members)) => members,
            one => one.into_iter().collect(),
        };
        let words = members.iter().map(|member| match unit {
            "" => values::text(member),
            unit => format!("{} {unit}", values::text(member)),
        });
        words.collect()
    }

    /// The keys of fields in which two differ.
    fn differences(&self, other: &Self) -> Vec<&'static str> {
        let rows = Self::rows().iter().map(|row| row.key);
        rows.filter(|key| self.get(key) != other.get(key)).collect()
    }

    /// The fields that are not as by default.
    fn to_table(&self) -> Table {
        let given = self.given();
        given
            .map(|(row, value)| (row.key.to_string(), value))
            .collect()
    }

    /// Reads a table.
    ///
    /// # Errors
    /// The first mistake, which begins with its key.
    fn from_table(table: &Table) -> Result<Self, String> {
        let mut read = Self::default();
        for (key, value) in table {
            let row = Self::row(key)?;
            if let Err(wrong) = read.set(key, value) {
                return Err(format!("{key}{}", wrong.first(value, &row.expected())));
            }
        }
        let mut required = Self::rows().iter().filter(|row| row.is("required"));
        match required.find(|row| !table.contains_key(row.key)) {
            Some(row) => Err(format!("{} is missing: {}", row.key, row.doc())),
            None => Ok(read),
        }
    }

    /// As a TOML file: plain values first, in the order of the table.
    fn to_toml(&self) -> String {
        let (mut plain, mut tables) = (String::new(), String::new());
        for (row, value) in self.given() {
            let entry = Table::from_iter([(row.key.to_string(), value)]).to_string();
            if entry.starts_with('[') {
                tables += &format!("\n{entry}");
            } else {
                plain += &entry;
            }
        }
        plain + &tables
    }

    /// As a JSON object, in the order of the table.
    fn to_json(&self) -> serde_json::Map<String, Json> {
        let given = self.given();
        given
            .map(|(row, value)| {
                // Values of TOML are values of JSON, too.
                let value = serde_json::to_value(value).unwrap_or_default();
                (row.key.to_string(), value)
            })
            .collect()
    }

    /// The JSON schema of one.
    fn json_schema() -> Json {
        let properties = Self::rows().iter().map(|row| {
            let (_, mut property) = (row.describe)(&row.takes);
            if let Some(property) = property.as_object_mut() {
                property.insert("description".into(), row.doc().into());
            }
            (row.key.to_string(), property)
        });
        let properties: serde_json::Map<_, _> = properties.collect();
        let required = Self::rows().iter().filter(|row| row.is("required"));
        let required: Vec<&str> = required.map(|row| row.key).collect();
        serde_json::json!({
            "type": "object",
            "properties": properties,
            "required": required,
            "additionalProperties": false,
        })
    }
}

/// Declares a struct with its table: `key [flags]: Type = default, Takes, "unit";` in sections, each with its meaning as
/// documentation. Fields without a default have that of their type; `required` fields have to be in a file.
#[macro_export]
macro_rules! fields {
    (
        $(#[$meta:meta])*
        pub struct $name:ident { $(
            $section:literal { $(
                $(#[doc = $doc:literal])+
                $key:ident $([$($flag:ident),*])? : $type:ty $(= $default:expr)? $(, $takes:expr $(, $unit:literal)?)?;
            )* }
        )* }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $name { $($(
            $(#[doc = $doc])+
            pub $key: $type,
        )*)* }

        impl Default for $name {
            fn default() -> Self {
                Self { $($(
                    $key: $crate::fields!(@default $($default)?),
                )*)* }
            }
        }

        impl $crate::fields::Fields for $name {
            fn rows() -> &'static [$crate::fields::Row] {
                #[allow(unused_imports)]
                use $crate::fields::Takes;
                const ROWS: &[$crate::fields::Row] = &[$($(
                    $crate::fields::Row::new::<$type>(
                        stringify!($key),
                        concat!($($doc),+),
                        $section,
                        &[$($(stringify!($flag)),*)?],
                    )$(.takes($takes)$(.unit($unit))?)?,
                )*)*];
                ROWS
            }

            fn value(&self, key: &str) -> Option<$crate::fields::Toml> {
                match key {
                    $($(stringify!($key) => $crate::fields::FieldValue::write(&self.$key),)*)*
                    _ => None,
                }
            }

            fn set(&mut self, key: &str, value: &$crate::fields::Toml) -> Result<(), $crate::fields::Wrong> {
                let row = Self::row(key).map_err($crate::fields::Wrong::because)?;
                match key {
                    $($(stringify!($key) => self.$key = row.read::<$type>(value)?,)*)*
                    _ => {}
                }
                Ok(())
            }
        }

        impl $crate::fields::Serialize for $name {
            fn serialize<S: $crate::fields::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_map(<Self as $crate::fields::Fields>::to_json(self))
            }
        }

        impl<'de> $crate::fields::Deserialize<'de> for $name {
            fn deserialize<D: $crate::fields::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let table = $crate::fields::Deserialize::deserialize(deserializer)?;
                <Self as $crate::fields::Fields>::from_table(&table).map_err($crate::fields::DeError::custom)
            }
        }

        impl $crate::fields::FieldValue for $name {
            fn read(
                value: &$crate::fields::Toml,
                _takes: &$crate::fields::Takes,
            ) -> Result<Self, $crate::fields::Wrong> {
                let table = value.as_table().ok_or($crate::fields::Wrong::kind())?;
                <Self as $crate::fields::Fields>::from_table(table).map_err($crate::fields::Wrong::because)
            }

            fn write(&self) -> Option<$crate::fields::Toml> {
                Some(<Self as $crate::fields::Fields>::to_table(self).into())
            }

            fn describe(_takes: &$crate::fields::Takes) -> (String, $crate::fields::JsonSchema) {
                let rows = <Self as $crate::fields::Fields>::rows().iter();
                let keys: Vec<&str> = rows.map(|row| row.key).collect();
                let schema = <Self as $crate::fields::Fields>::json_schema();
                (format!("a table of {}", keys.join(", ")), schema)
            }
        }
    };
    (@default) => { Default::default() };
    (@default $default:expr) => { $default };
}

#[doc(hidden)]
pub use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as DeError};
#[doc(hidden)]
pub use serde_json::Value as JsonSchema;
#[doc(hidden)]
pub use toml::Value as Toml;

#[cfg(test)]
mod tests;
