//! Scans the fields of a message before its type is known, tells which one it is, and finds where it is truncated.

use prost::encoding::{WireType, decode_key, decode_varint};

/// A field as encoded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Field<'a> {
    /// Its number in the schema.
    pub number: u32,
    /// Its offset, bytes from 0.
    pub offset: usize,
    pub value: Value<'a>,
    /// How many bytes of it lie beyond the end; 0 for a whole field.
    pub missing: u64,
}

/// Value of a field, as far as the encoding tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Value<'a> {
    Varint(u64),
    Fixed64(f64),
    Fixed32,
    /// Text, bytes or a message.
    Bytes(&'a [u8]),
}

/// Bytes that are no field, and where.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NoField {
    pub offset: usize,
    /// Whether they are the beginning of one that the end cuts off.
    pub cut: bool,
}

/// The fields of a message. Ends after what is no field, and after a field that is cut off.
#[derive(Clone)]
pub(crate) struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Fields<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    fn field(&mut self) -> Result<Field<'a>, NoField> {
        let offset = self.at;
        let mut rest = &self.bytes[offset..];
        let end = self.bytes.len();
        let fault = |rest: &[u8]| NoField {
            offset,
            // A number ends with the first byte below 128.
            cut: rest.iter().all(|b| *b >= 128),
        };
        let whole = rest;
        let (number, wire) = decode_key(&mut rest).map_err(|_| fault(whole))?;
        let mut missing = 0;
        let value = match wire {
            WireType::Varint => {
                let digits = rest;
                Value::Varint(decode_varint(&mut rest).map_err(|_| fault(digits))?)
            }
            WireType::SixtyFourBit => {
                let (eight, after) = rest
                    .split_first_chunk()
                    .ok_or(NoField { offset, cut: true })?;
                rest = after;
                Value::Fixed64(f64::from_le_bytes(*eight))
            }
            WireType::ThirtyTwoBit => {
                let (_, after) = rest
                    .split_at_checked(4)
                    .ok_or(NoField { offset, cut: true })?;
                rest = after;
                Value::Fixed32
            }
            WireType::LengthDelimited => {
                let digits = rest;
                let length = decode_varint(&mut rest).map_err(|_| fault(digits))?;
                let there = usize::try_from(length).map_or(rest.len(), |l| l.min(rest.len()));
                missing = length - there as u64;
                let (value, after) = rest.split_at(there);
                rest = after;
                Value::Bytes(value)
            }
            // Groups are in no schema of CommonRoad.
            WireType::StartGroup | WireType::EndGroup => {
                return Err(NoField { offset, cut: false });
            }
        };
        self.at = end - rest.len();
        Ok(Field {
            number,
            offset,
            value,
            missing,
        })
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = Result<Field<'a>, NoField>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.at >= self.bytes.len() {
            return None;
        }
        let field = self.field();
        if field.is_err() {
            self.at = self.bytes.len();
        }
        Some(field)
    }
}

/// The first field with a number, as far as the bytes are fields.
pub(crate) fn first<'a>(bytes: &'a [u8], number: u32) -> Option<Value<'a>> {
    let mut fields = Fields::new(bytes).map_while(Result::ok);
    fields.find(|f| f.number == number).map(|f| f.value)
}

impl<'a> Value<'a> {
    /// The bytes of text, bytes or a message.
    pub fn bytes(self) -> Option<&'a [u8]> {
        match self {
            Self::Bytes(bytes) => Some(bytes),
            _ => None,
        }
    }

    pub fn text(self) -> Option<&'a str> {
        self.bytes().and_then(|b| std::str::from_utf8(b).ok())
    }

    pub fn varint(self) -> Option<u64> {
        match self {
            Self::Varint(value) => Some(value),
            _ => None,
        }
    }
}

/// The messages that are files of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum MessageKind {
    /// Everything in one, 2020a.
    Single,
    /// The road, 2024.
    Map,
    /// The traffic on it, 2024.
    Dynamic,
    /// The planning problems, and which map and which traffic they are for, 2024.
    Scenario,
}

/// Information from the beginning of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct FileHeader {
    pub kind: MessageKind,
    /// Its own id: of the benchmark, or of a map the map's.
    pub id: String,
    /// The id of the map it needs.
    pub map: Option<String>,
    /// The id of the dynamic file it needs.
    pub dynamic: Option<String>,
}

impl FileHeader {
    /// Looks at the beginning of a file; nothing if it is none of the messages. The rest may be missing.
    ///
    /// The first field of each is its information, and the first field of that tells them apart: a version as text
    /// (2020a), the id of a map (map), or the id of a scenario. A dynamic file has an environment as field 2, which
    /// a scenario file has not; a scenario file has the ids of the other two as fields 3 and 4.
    pub fn detect(bytes: &[u8]) -> Option<Self> {
        let whole = Fields::new(bytes).map_while(Result::ok);
        let information = whole
            .clone()
            .next()
            .filter(|f| f.number == 1)?
            .value
            .bytes()?;
        let opening = first(information, 1)?.bytes()?;
        if let Some(id) = map_id(opening) {
            return Some(Self {
                kind: MessageKind::Map,
                id,
                map: None,
                dynamic: None,
            });
        }
        if let Some((id, map)) = scenario_id(opening) {
            let text = |number| Some(first(bytes, number)?.text()?.to_string());
            if whole.clone().any(|f| f.number == 2) {
                return Some(Self {
                    kind: MessageKind::Dynamic,
                    id,
                    map: Some(map),
                    dynamic: None,
                });
            }
            return Some(Self {
                kind: MessageKind::Scenario,
                id,
                map: Some(text(3).unwrap_or(map)),
                dynamic: text(4),
            });
        }
        let version = std::str::from_utf8(opening).ok()?;
        let id = first(information, 2)?.text()?;
        let has_step = matches!(first(information, 7), Some(Value::Fixed64(_)));
        (has_step || version.starts_with("20")).then(|| Self {
            kind: MessageKind::Single,
            id: id.to_string(),
            map: None,
            dynamic: None,
        })
    }
}

/// `COUNTRY_Name-1` of a map's id.
fn map_id(bytes: &[u8]) -> Option<String> {
    let country = first(bytes, 1)?.text()?;
    let name = first(bytes, 2)?.text()?;
    let number = first(bytes, 3)?.varint()?;
    Some(map_name(country, name, number))
}

pub(super) fn map_name(country: &str, name: &str, number: u64) -> String {
    format!("{country}_{name}-{number}")
}

/// The benchmark id of a scenario's id, and its map's id.
fn scenario_id(bytes: &[u8]) -> Option<(String, String)> {
    let cooperative = first(bytes, 1)?.varint()? != 0;
    let map = map_id(first(bytes, 2)?.bytes()?)?;
    let configuration = first(bytes, 3).and_then(Value::varint);
    let behavior = first(bytes, 4).and_then(Value::text);
    let prediction = first(bytes, 5).and_then(Value::varint);
    let id = benchmark_id(cooperative, &map, configuration, behavior, prediction);
    Some((id, map))
}

/// `(C-)?MAP(_1(_T-1)?)?`.
pub(super) fn benchmark_id(
    cooperative: bool,
    map: &str,
    configuration: Option<u64>,
    behavior: Option<&str>,
    prediction: Option<u64>,
) -> String {
    let mut id = format!("{}{map}", if cooperative { "C-" } else { "" });
    if let Some(configuration) = configuration {
        id.push_str(&format!("_{configuration}"));
    }
    if let Some(behavior) = behavior {
        id.push_str(&format!("_{behavior}"));
        if let Some(prediction) = prediction {
            id.push_str(&format!("-{prediction}"));
        }
    }
    id
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn fields_with_their_places() {
        let bytes = [0x08, 0x96, 0x01, 0x12, 0x02, b'h', b'i'];
        let fields: Vec<_> = Fields::new(&bytes).map(Result::unwrap).collect();
        assert_eq!((fields[0].number, fields[0].offset), (1, 0));
        assert_eq!(fields[0].value, Value::Varint(150));
        assert_eq!((fields[1].number, fields[1].offset), (2, 3));
        assert_eq!(first(&bytes, 2).and_then(Value::text), Some("hi"));
    }

    #[test]
    fn ends_that_are_cut_off_and_bytes_that_are_no_field() {
        let cut = Fields::new(&[0x12, 0x05, b'h']).next().unwrap().unwrap();
        assert_eq!((cut.missing, cut.value), (4, Value::Bytes(b"h")));
        let broken = |bytes: &[u8]| Fields::new(bytes).next().unwrap().unwrap_err();
        assert!(broken(&[0x09, 1, 2]).cut, "a double needs eight bytes");
        assert!(broken(&[0x08, 0x80]).cut, "a number without its last byte");
        assert!(!broken(&[0x0b]).cut, "a group");
        assert!(!broken(&[0x07]).cut, "no such type");
        assert!(!broken(&[0x00]).cut, "field 0");
        let longest = [
            0x12, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01,
        ];
        let field = Fields::new(&longest).next().unwrap().unwrap();
        assert_eq!(field.missing, u64::MAX);
    }
}
