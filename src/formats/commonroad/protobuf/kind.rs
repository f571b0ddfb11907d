//! Detects which CommonRoad protobuf message a file holds, from its first bytes.

use super::wire::{Fields, Value, first};

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
