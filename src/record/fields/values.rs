//! Values of fields: how each type is read from TOML, JSON and words, written, and described.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::{Value as Json, json};
use toml::{Table, Value};

use super::Takes;
use nearmiss_base::system::unknown;

/// Members of a list that a person chooses, at most.
const MAX_CHOSEN: usize = 10_000;

/// A type that fields have.
pub trait FieldValue: Sized {
    /// Members of a list, at most: more are no choice of a person.
    const MAX_MEMBERS: usize = MAX_CHOSEN;

    /// What separates the members of a list on a command line.
    const SEPARATORS: &'static [char] = &[','];

    /// From a value.
    ///
    /// # Errors
    /// It is no such value, or not one that the field takes.
    fn read(value: &Value, takes: &Takes) -> Result<Self, Wrong>;

    /// The value; nothing where there is none.
    fn write(&self) -> Option<Value>;

    /// What is expected, as messages say it, and as JSON schema.
    fn describe(takes: &Takes) -> (String, Json);

    /// What the user typed, as a value; what cannot be one stays a text, which is no mistake yet.
    #[must_use]
    fn parse(text: &str) -> Value {
        typed(text)
    }
}

/// Why a field does not take a value: each mistake with the member of a list that it is about, and why; without a reason
/// it is of another kind than expected, or out of bounds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong(Vec<(Option<usize>, Option<String>)>);

impl Wrong {
    /// It is of another kind, or out of bounds.
    #[must_use]
    pub fn kind() -> Self {
        Self(vec![(None, None)])
    }

    /// It is wrong in itself.
    #[must_use]
    pub fn because(why: impl Into<String>) -> Self {
        Self(vec![(None, Some(why.into()))])
    }

    /// What is wrong about a value, to be said behind its key, each with the member that it is about.
    pub fn messages(
        &self,
        value: &Value,
        expected: &str,
    ) -> impl Iterator<Item = (Option<usize>, String)> {
        self.0.iter().map(move |(place, why)| {
            let member = place.and_then(|place| value.as_array()?.get(place));
            let words = match (why, member) {
                (Some(why), _) => format!(": {why}"),
                (None, None) => format!(" = {}: {expected}", shown(value)),
                (None, Some(member)) => format!(": {}: {expected}", shown(member)),
            };
            (*place, words)
        })
    }

    /// The first mistake, to be said behind its key.
    #[must_use]
    pub fn first(&self, value: &Value, expected: &str) -> String {
        let first = self.messages(value, expected).next();
        first.map_or(String::new(), |(_, words)| words)
    }
}

/// A value as a file has it.
fn shown(value: &Value) -> String {
    match value {
        Value::Array(_) => "a list".into(),
        Value::Table(_) => "a table".into(),
        other => other.to_string(),
    }
}

/// A value in words.
pub(super) fn text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => number.to_string(),
        Value::Boolean(on) => if *on { "on" } else { "off" }.into(),
        Value::Datetime(time) => time.to_string(),
        Value::Array(members) => {
            let members: Vec<String> = members.iter().map(text).collect();
            members.join(", ")
        }
        Value::Table(table) => {
            let entries = table.iter();
            let entries: Vec<String> = entries
                .map(|(key, value)| format!("{key} {}", text(value)))
                .collect();
            entries.join(", ")
        }
    }
}

/// A list or a table of TOML, else a text.
fn typed(text: &str) -> Value {
    let is_toml = text.starts_with(['[', '{']);
    let value = is_toml.then(|| toml_value(text)).flatten();
    value.unwrap_or_else(|| text.into())
}

/// A text as one value of TOML.
pub(super) fn toml_value(text: &str) -> Option<Value> {
    let mut table = toml::from_str::<Table>(&format!("value = {text}")).ok()?;
    let value = table.remove("value")?;
    table.is_empty().then_some(value)
}

/// A type whose values are words, often a few known ones.
pub trait Word: Sized + Clone + PartialEq {
    /// What separates several on a command line.
    const SEPARATORS: &'static [char] = &[','];

    /// All words, where they are few.
    #[must_use]
    fn known() -> Vec<&'static str> {
        Vec::new()
    }

    /// The value of a word.
    ///
    /// # Errors
    /// There is none: in words.
    fn of_word(word: &str) -> Result<Self, String>;

    /// Its word.
    fn word(&self) -> String;
}

/// Makes an enumeration with `ALL`, `name` and `parse` a type of fields: `word!(Effort, "effort")`.
#[macro_export]
macro_rules! word {
    ($type:ty, $what:literal) => {
        impl $crate::fields::Word for $type {
            fn known() -> Vec<&'static str> {
                Self::ALL.map(Self::name).to_vec()
            }

            fn of_word(word: &str) -> Result<Self, String> {
                Self::parse(word).ok_or_else(|| $crate::fields::unknown_word::<Self>($what, word))
            }

            fn word(&self) -> String {
                (*self).name().into()
            }
        }
    };
}

impl<T: Word> FieldValue for T {
    const SEPARATORS: &'static [char] = T::SEPARATORS;

    fn read(value: &Value, _: &Takes) -> Result<Self, Wrong> {
        let word = value.as_str().ok_or(Wrong::kind())?;
        Self::of_word(word).map_err(Wrong::because)
    }

    fn write(&self) -> Option<Value> {
        Some(self.word().into())
    }

    fn describe(takes: &Takes) -> (String, Json) {
        match T::known() {
            none if none.is_empty() => String::describe(takes),
            known => one_of(&known),
        }
    }
}

fn one_of(words: &[&str]) -> (String, Json) {
    (
        format!("one of {}", words.join(", ")),
        json!({ "enum": words }),
    )
}

impl FieldValue for String {
    fn read(value: &Value, takes: &Takes) -> Result<Self, Wrong> {
        let text = value.as_str().ok_or(Wrong::kind())?;
        match takes {
            Takes::Checked(check) => check(text).map_err(Wrong::because)?,
            Takes::OneOf(words) if !words.contains(&text) => return Err(Wrong::kind()),
            _ => {}
        }
        Ok(text.into())
    }

    fn write(&self) -> Option<Value> {
        Some(self.clone().into())
    }

    fn describe(takes: &Takes) -> (String, Json) {
        match takes {
            Takes::OneOf(words) => one_of(words),
            _ => ("a text".into(), json!({ "type": "string" })),
        }
    }

    fn parse(text: &str) -> Value {
        text.into()
    }
}

impl FieldValue for PathBuf {
    const MAX_MEMBERS: usize = usize::MAX;

    fn read(value: &Value, takes: &Takes) -> Result<Self, Wrong> {
        String::read(value, takes).map(Self::from)
    }

    fn write(&self) -> Option<Value> {
        Some(self.display().to_string().into())
    }

    fn describe(takes: &Takes) -> (String, Json) {
        String::describe(takes)
    }
}

impl FieldValue for bool {
    fn read(value: &Value, _: &Takes) -> Result<Self, Wrong> {
        value.as_bool().ok_or(Wrong::kind())
    }

    fn write(&self) -> Option<Value> {
        Some((*self).into())
    }

    fn describe(_: &Takes) -> (String, Json) {
        ("true or false".into(), json!({ "type": "boolean" }))
    }

    fn parse(text: &str) -> Value {
        match text {
            "on" | "yes" | "true" => true.into(),
            "off" | "no" | "false" => false.into(),
            other => other.into(),
        }
    }
}

fn bounds(takes: &Takes) -> (i64, i64) {
    match takes {
        Takes::Whole(least, most) | Takes::Odd(least, most) => (*least, *most),
        _ => (0, i64::MAX),
    }
}

macro_rules! whole {
    ($($type:ty),*) => { $(
        impl FieldValue for $type {
            fn read(value: &Value, takes: &Takes) -> Result<Self, Wrong> {
                let (least, most) = bounds(takes);
                let fits = |whole: &i64| (least..=most).contains(whole) && (*whole % 2 != 0 || !matches!(takes, Takes::Odd(..)));
                let whole = value.as_integer().filter(fits);
                whole.and_then(|whole| whole.try_into().ok()).ok_or(Wrong::kind())
            }

            fn write(&self) -> Option<Value> {
                Some(Value::Integer((*self).try_into().unwrap_or(i64::MAX)))
            }

            fn describe(takes: &Takes) -> (String, Json) {
                let (least, most) = bounds(takes);
                let words = match (takes, most) {
                    (Takes::Odd(..), _) => format!("an odd number from {least} to {most}"),
                    (_, i64::MAX) => format!("a whole number from {least}"),
                    _ => format!("a whole number from {least} to {most}"),
                };
                (words, json!({ "type": "integer", "minimum": least, "maximum": most }))
            }

            fn parse(text: &str) -> Value {
                text.parse::<i64>().map_or_else(|_| text.into(), Value::Integer)
            }
        }
    )* };
}
whole!(u32, u64, usize);

impl FieldValue for f64 {
    fn read(value: &Value, takes: &Takes) -> Result<Self, Wrong> {
        let number = value.as_integer().map(|whole| whole as Self);
        let number = number.or(value.as_float()).ok_or(Wrong::kind())?;
        let is_taken = match takes {
            Takes::Number(least, most) => (*least..=*most).contains(&number),
            Takes::Above(least, most) => number > *least && number <= *most,
            Takes::Between(least, most) => number > *least && number < *most,
            _ => number.is_finite(),
        };
        if is_taken {
            Ok(number)
        } else {
            Err(Wrong::kind())
        }
    }

    fn write(&self) -> Option<Value> {
        Some((*self).into())
    }

    fn describe(takes: &Takes) -> (String, Json) {
        let (words, least, most) = match takes {
            Takes::Number(least, most) => (
                format!("a number from {least} to {most}"),
                ("minimum", least),
                ("maximum", most),
            ),
            Takes::Above(least, most) => (
                format!("a number above {least}, at most {most}"),
                ("exclusiveMinimum", least),
                ("maximum", most),
            ),
            Takes::Between(least, most) => (
                format!("a number above {least} and below {most}"),
                ("exclusiveMinimum", least),
                ("exclusiveMaximum", most),
            ),
            _ => return ("a number".into(), json!({ "type": "number" })),
        };
        (
            words,
            json!({ "type": "number", (least.0): least.1, (most.0): most.1 }),
        )
    }

    fn parse(text: &str) -> Value {
        text.parse::<Self>()
            .map_or_else(|_| text.into(), Value::Float)
    }
}

impl<T: FieldValue> FieldValue for Option<T> {
    fn read(value: &Value, takes: &Takes) -> Result<Self, Wrong> {
        T::read(value, takes).map(Some)
    }

    fn write(&self) -> Option<Value> {
        self.as_ref()?.write()
    }

    fn describe(takes: &Takes) -> (String, Json) {
        T::describe(takes)
    }

    fn parse(text: &str) -> Value {
        T::parse(text)
    }
}

impl<T: FieldValue + PartialEq> FieldValue for Vec<T> {
    fn read(value: &Value, takes: &Takes) -> Result<Self, Wrong> {
        members(value.as_array().ok_or(Wrong::kind())?, takes)
    }

    fn write(&self) -> Option<Value> {
        let members: Vec<Value> = self.iter().filter_map(T::write).collect();
        (!members.is_empty()).then_some(Value::Array(members))
    }

    fn describe(takes: &Takes) -> (String, Json) {
        let (one, schema) = T::describe(takes);
        let words = match (one.strip_prefix("one of "), one.as_str()) {
            (Some(words), _) => format!("a list out of {words}"),
            (_, "a text") => "a list of texts".into(),
            _ => format!("a list, each {one}"),
        };
        (words, json!({ "type": "array", "items": schema }))
    }

    fn parse(text: &str) -> Value {
        if text.starts_with(['[', '{']) {
            return typed(text);
        }
        let members = text.split(T::SEPARATORS).map(str::trim);
        let members = members.filter(|member| !member.is_empty());
        Value::Array(members.map(T::parse).collect())
    }
}

/// Each member once.
fn members<T: FieldValue + PartialEq>(values: &[Value], takes: &Takes) -> Result<Vec<T>, Wrong> {
    if values.len() > T::MAX_MEMBERS {
        let (all, most) = (values.len(), T::MAX_MEMBERS);
        return Err(Wrong::because(format!("{all} values, at most {most}")));
    }
    let (mut read, mut wrong) = (Vec::with_capacity(values.len()), Vec::new());
    for (place, value) in values.iter().enumerate() {
        match T::read(value, takes) {
            // Scenarios may be many; what a person chooses is little, and each is wanted once.
            Ok(one) if values.len() > MAX_CHOSEN || !read.contains(&one) => read.push(one),
            Ok(_) => {}
            Err(Wrong(why)) => wrong.extend(why.into_iter().map(|(_, why)| (Some(place), why))),
        }
    }
    if wrong.is_empty() {
        Ok(read)
    } else {
        Err(Wrong(wrong))
    }
}

/// A value, or several of which each is tried; none where that is left open.
#[derive(Debug, Clone, PartialEq)]
pub struct OneOrMore<T>(Vec<T>);

impl<T> Default for OneOrMore<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Clone + PartialEq> OneOrMore<T> {
    /// The only value.
    #[must_use]
    pub fn one(&self) -> Option<T> {
        match self.0.as_slice() {
            [one] => Some(one.clone()),
            _ => None,
        }
    }

    /// Every value.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.0.iter()
    }

    /// Whether there are several values.
    #[must_use]
    pub fn is_axis(&self) -> bool {
        self.0.len() > 1
    }
}

impl<T> From<Option<T>> for OneOrMore<T> {
    fn from(one: Option<T>) -> Self {
        Self(one.into_iter().collect())
    }
}

impl<T: PartialEq> FromIterator<T> for OneOrMore<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        let mut once = Vec::new();
        for value in values {
            if !once.contains(&value) {
                once.push(value);
            }
        }
        Self(once)
    }
}

impl<T: FieldValue + PartialEq> FieldValue for OneOrMore<T> {
    fn read(value: &Value, takes: &Takes) -> Result<Self, Wrong> {
        match value {
            Value::Array(values) => members(values, takes).map(Self),
            one => Ok(Self(vec![T::read(one, takes)?])),
        }
    }

    fn write(&self) -> Option<Value> {
        match self.0.as_slice() {
            [one] => one.write(),
            _ => self.0.write(),
        }
    }

    fn describe(takes: &Takes) -> (String, Json) {
        let (words, one) = T::describe(takes);
        let several = json!({ "type": "array", "items": one, "minItems": 1, "uniqueItems": true });
        (
            format!("{words}, or a list of them"),
            json!({ "anyOf": [one, several] }),
        )
    }

    fn parse(text: &str) -> Value {
        match <Vec<T>>::parse(text) {
            Value::Array(mut one) if one.len() == 1 => one.remove(0),
            several => several,
        }
    }
}

/// Two different texts.
impl FieldValue for (String, String) {
    fn read(value: &Value, _: &Takes) -> Result<Self, Wrong> {
        let pair = match value.as_array().map(Vec::as_slice) {
            Some([a, b]) => a.as_str().zip(b.as_str()),
            _ => None,
        };
        let (a, b) = pair.filter(|(a, b)| a != b).ok_or(Wrong::kind())?;
        Ok((a.into(), b.into()))
    }

    fn write(&self) -> Option<Value> {
        Some(vec![self.0.clone(), self.1.clone()].into())
    }

    fn describe(takes: &Takes) -> (String, Json) {
        let (_, one) = String::describe(takes);
        (
            "a list of two different names".into(),
            json!({ "type": "array", "items": one, "minItems": 2, "maxItems": 2 }),
        )
    }

    fn parse(text: &str) -> Value {
        <Vec<String>>::parse(text)
    }
}

/// A table that others read.
impl FieldValue for Table {
    fn read(value: &Value, _: &Takes) -> Result<Self, Wrong> {
        value.as_table().cloned().ok_or(Wrong::kind())
    }

    fn write(&self) -> Option<Value> {
        Some(self.clone().into())
    }

    fn describe(_: &Takes) -> (String, Json) {
        ("a table".into(), Json::from_iter([("type", "object")]))
    }
}

impl<T: FieldValue> FieldValue for BTreeMap<String, T> {
    fn read(value: &Value, takes: &Takes) -> Result<Self, Wrong> {
        let table = value.as_table().ok_or(Wrong::kind())?;
        let entries = table.iter().map(|(name, value)| {
            let wrong = |wrong: Wrong| {
                let expected = format!("expected {}", T::describe(takes).0);
                Wrong::because(format!("{name}{}", wrong.first(value, &expected)))
            };
            Ok((name.clone(), T::read(value, takes).map_err(wrong)?))
        });
        entries.collect()
    }

    fn write(&self) -> Option<Value> {
        let entries = self.iter();
        let table: Table = entries
            .filter_map(|(name, value)| Some((name.clone(), value.write()?)))
            .collect();
        Some(table.into())
    }

    fn describe(takes: &Takes) -> (String, Json) {
        let (words, one) = T::describe(takes);
        (
            format!("a table, each value {words}"),
            json!({ "type": "object", "additionalProperties": one }),
        )
    }
}

/// What is wrong about a word of no value.
#[doc(hidden)]
#[must_use]
pub fn unknown_word<T: Word>(what: &str, word: &str) -> String {
    unknown(what, word, T::known())
}
