//! Scenarios as resources: their addresses, the list in pages, their texts.

use std::ops::Range;

use serde_json::{Value, json};

use super::lines::RpcError;
use super::places::Places;
use nearmiss_formats::{Entry, EntryLocation};

/// Resources of one page.
const PAGE: usize = 200;

/// How the addresses of scenarios begin.
const SCHEME: &str = "nearmiss://scenario/";

/// Largest scenario that is given as a resource, bytes.
const LONGEST: u64 = 8 << 20;

fn address(places: &Places, entry: &Entry) -> String {
    let name = places.name(entry);
    let escaped: String = { name.bytes() }
        .map(|byte| match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' | b'/' => {
                char::from(byte).to_string()
            }
            other => format!("%{other:02X}"),
        })
        .collect();
    format!("{SCHEME}{escaped}")
}

/// Whether a scenario has a text to read: recordings and protobuf files have none.
fn is_text(entry: &Entry) -> bool {
    match &entry.place {
        EntryLocation::Bundled(_) => true,
        EntryLocation::File(path) => {
            let end = path.extension();
            end.is_some_and(|end| end.eq_ignore_ascii_case("xml")) && !entry.is_recording()
        }
    }
}

/// The range of the page of a list of so many that a request wants, and the cursor of the next one.
///
/// # Errors
/// In words: its cursor is none that an answer gave.
pub fn page(
    parameters: &Value,
    length: usize,
    of: usize,
) -> Result<(Range<usize>, Option<String>), &'static str> {
    let from = match &parameters["cursor"] {
        Value::Null => 0,
        cursor => {
            let place = cursor.as_str().and_then(|cursor| cursor.parse().ok());
            let is_given = |place: &usize| (1..of).contains(place) && place.is_multiple_of(length);
            let given = place.filter(is_given);
            given.ok_or("`cursor` is none that this server gave; list without it")?
        }
    };
    let until = (from + length).min(of);
    Ok((from..until, (until < of).then(|| until.to_string())))
}

/// Checks that a list of one page is not asked for another one.
///
/// # Errors
/// The request has a cursor.
pub fn no_cursor(parameters: &Value) -> Result<(), RpcError> {
    if parameters["cursor"].is_null() {
        Ok(())
    } else {
        Err(RpcError::parameters(
            "`cursor`: this list has only one page",
        ))
    }
}

/// A page of the list.
///
/// # Errors
/// The cursor is none that was given.
pub fn list(places: &Places, parameters: &Value) -> Result<Value, RpcError> {
    let entries = places.entries();
    let (range, next) = page(parameters, PAGE, entries.len()).map_err(RpcError::parameters)?;
    let resources: Vec<Value> = { entries[range].iter() }
        .map(|entry| {
            let mut resource = json!({"uri": address(places, entry), "name": places.name(entry)});
            if is_text(entry) {
                resource["mimeType"] = "application/xml".into();
            }
            resource
        })
        .collect();
    let mut list = json!({"resources": resources});
    if let Some(next) = next {
        list["nextCursor"] = next.into();
    }
    Ok(list)
}

/// The text of one.
pub fn read(places: &Places, parameters: &Value) -> Result<Value, RpcError> {
    let uri = parameters["uri"].as_str().unwrap_or_default();
    let unknown = |why: String| RpcError {
        code: -32002,
        message: why,
    };
    let entries = places.entries();
    let entry = entries.iter().find(|entry| address(places, entry) == uri);
    let Some(entry) = entry else {
        return Err(unknown("no such resource; resources/list has all".into()));
    };
    let long = |bytes: u64| {
        unknown(format!(
            "the scenario has {bytes} bytes, more than {LONGEST}; ask tools about it"
        ))
    };
    let file = entry.file().and_then(|file| std::fs::metadata(file).ok());
    if let Some(meta) = file.filter(|meta| meta.len() > LONGEST) {
        return Err(long(meta.len()));
    }
    let text = entry.source().map_err(|why| unknown(places.told(&why)))?;
    // The file may have grown meanwhile.
    if text.len() as u64 > LONGEST {
        return Err(long(text.len() as u64));
    }
    let contents = json!({"uri": uri, "mimeType": "application/xml", "text": text});
    Ok(json!({"contents": [contents]}))
}
