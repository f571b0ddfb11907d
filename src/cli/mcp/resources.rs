//! Scenarios as resources: their addresses, the list in pages, their texts.

use std::ops::Range;

use rmcp::ErrorData;
use rmcp::model::{
    ListResourcesResult, PaginatedRequestParams, ReadResourceResult, Resource, ResourceContents,
};

use super::places::Places;
use nearmiss_formats::{Entry, EntryLocation};

/// Resources of one page.
const PAGE: usize = 200;

/// How the addresses of scenarios begin.
const SCHEME: &str = "nearmiss://scenario/";

/// Largest scenario that is given as a resource, bytes.
const LONGEST: u64 = 8 << 20;

/// What kind of text they are.
const XML: &str = "application/xml";

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
    cursor: Option<&str>,
    length: usize,
    of: usize,
) -> Result<(Range<usize>, Option<String>), &'static str> {
    let is_given = |place: &usize| (1..of).contains(place) && place.is_multiple_of(length);
    let from = match cursor {
        None => 0,
        Some(cursor) => { cursor.parse().ok().filter(is_given) }
            .ok_or("`cursor` is none that this server gave; list without it")?,
    };
    let until = (from + length).min(of);
    Ok((from..until, (until < of).then(|| until.to_string())))
}

/// Checks that a list of one page is not asked for another one.
///
/// # Errors
/// The request has a cursor.
pub fn no_cursor(request: Option<PaginatedRequestParams>) -> Result<(), ErrorData> {
    match request.and_then(|request| request.cursor) {
        None => Ok(()),
        Some(_) => Err(ErrorData::invalid_params(
            "`cursor`: this list has only one page",
            None,
        )),
    }
}

/// A page of the list.
///
/// # Errors
/// The cursor is none that was given.
pub fn list(places: &Places, cursor: Option<&str>) -> Result<ListResourcesResult, ErrorData> {
    let entries = places.entries();
    let (range, next) =
        page(cursor, PAGE, entries.len()).map_err(|why| ErrorData::invalid_params(why, None))?;
    let resources = entries[range].iter().map(|entry| {
        let resource = Resource::new(address(places, entry), places.name(entry));
        if is_text(entry) {
            resource.with_mime_type(XML)
        } else {
            resource
        }
    });
    let mut list = ListResourcesResult::with_all_items(resources.collect());
    list.next_cursor = next;
    Ok(list)
}

/// The text of one.
///
/// # Errors
/// There is none at this address, or it is too long, or it cannot be read.
pub fn read(places: &Places, uri: &str) -> Result<ReadResourceResult, ErrorData> {
    let unknown = |why: String| ErrorData::resource_not_found(why, None);
    let entries = places.entries();
    let entry = { entries.iter() }
        .find(|entry| address(places, entry) == uri)
        .ok_or_else(|| unknown("no such resource; resources/list has all".into()))?;
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
    let contents = ResourceContents::text(text, uri).with_mime_type(XML);
    Ok(ReadResourceResult::new(vec![contents]))
}
