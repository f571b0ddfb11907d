//! Detects the kind of a CommonRoad file by its root element.

use std::io::Read;
use std::path::Path;

use quick_xml::Reader;
use quick_xml::events::Event;

use super::encoding::{BYTE_ORDER_MARK, beginning, foreign_to_xml};

/// Contents of a CommonRoad XML file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Root {
    /// A scenario, `<commonRoad>`.
    Scenario,
    /// A solution, `<CommonRoadSolution>`.
    Solution,
    /// Something else, or no XML.
    Other,
}

/// Why the type of a file named like a scenario cannot be determined.
#[derive(Debug, thiserror::Error)]
pub enum Unrecognised {
    /// It has no bytes.
    #[error("empty")]
    Empty,
    /// It has to be unpacked or saved anew first.
    #[error("{0}")]
    Foreign(&'static str),
    /// XML was expected.
    #[error("no XML element in its first {} KiB", HEAD / 1024)]
    NoElement,
    /// Protobuf was expected.
    #[error("not a CommonRoad message, or damaged at its beginning")]
    NoMessage,
    /// It is a pipe, a device or the like, which is not touched.
    #[error("not a regular file")]
    Irregular,
    /// It cannot be opened or read.
    #[error("{}", nearmiss_base::system::words(.0))]
    Io(#[from] std::io::Error),
}

/// A root further into the file than this many bytes is not looked for.
const HEAD: usize = 64 * 1024;

/// Most roots are within this many bytes.
const FIRST: usize = 2048;

/// The kind of the file that begins with `bytes`, sound or not.
#[must_use]
pub fn root_of(bytes: &[u8]) -> Root {
    let head = beginning(&bytes[..bytes.len().min(HEAD)]);
    match first_element(&head) {
        Some("commonRoad") => Root::Scenario,
        Some("CommonRoadSolution") => Root::Solution,
        _ => Root::Other,
    }
}

/// The kind of a file; pipes and devices are not touched, and what cannot be read is something else.
#[must_use]
pub fn root_of_file(path: &Path) -> Root {
    beginning_of_file(path, HEAD).map_or(Root::Other, |head| root_of(&head))
}

/// Whether an XML file is a scenario, or something else.
///
/// # Errors
/// It is neither, or cannot be read: why.
pub(crate) fn is_scenario(path: &Path) -> Result<bool, Unrecognised> {
    let mut head = beginning_of_file(path, FIRST)?;
    let mut known = root_name(&head);
    if known.is_none() && head.len() == FIRST {
        head = beginning_of_file(path, HEAD)?;
        known = root_name(&head);
    }
    match (known, foreign_to_xml(&head)) {
        // Another encoding is reported only if the file could be a scenario.
        (Some(false), _) => Ok(false),
        (_, Some(what)) => Err(Unrecognised::Foreign(what)),
        (Some(true), None) => Ok(true),
        (None, None) => Err(Unrecognised::NoElement),
    }
}

/// The name of the root of XML that begins so; nothing if none is to be seen.
pub(crate) fn root_name_of(head: &[u8]) -> Option<String> {
    first_element(&beginning(head)).map(str::to_string)
}

/// Whether the first element is a scenario's; nothing if none is to be seen.
fn root_name(head: &[u8]) -> Option<bool> {
    first_element(&beginning(head)).map(|name| name == "commonRoad")
}

/// At most so many bytes of a file, and at least one.
pub(crate) fn beginning_of_file(path: &Path, most: usize) -> Result<Vec<u8>, Unrecognised> {
    if !path.metadata()?.is_file() {
        return Err(Unrecognised::Irregular);
    }
    let mut head = Vec::with_capacity(FIRST);
    let file = nearmiss_base::system::open_file(path)?;
    file.take(most as u64).read_to_end(&mut head)?;
    if head.is_empty() {
        return Err(Unrecognised::Empty);
    }
    Ok(head)
}

/// The name of the first element, also where `head` ends within its tag.
fn first_element(head: &str) -> Option<&str> {
    // All of them: the reader takes one away by itself and does not count its bytes.
    let head = head.trim_start_matches(BYTE_ORDER_MARK);
    let mut reader = Reader::from_str(head);
    let at = loop {
        let at = usize::try_from(reader.buffer_position()).ok()?;
        match reader.read_event() {
            Ok(Event::Start(_) | Event::Empty(_)) | Err(_) => break at,
            Ok(Event::Eof) => return None,
            Ok(_) => {}
        }
    };
    let tag = head.get(at..)?.strip_prefix('<')?;
    let end = tag.find(|c: char| c.is_whitespace() || matches!(c, '/' | '>'))?;
    let name = &tag[..end];
    name.starts_with(|c: char| c.is_alphabetic() || c == '_')
        .then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_element_decides() {
        for (text, root) in [
            ("<commonRoad>", Root::Scenario),
            (
                "\u{feff}<?xml version='1.0'?>\n<!-- <commonRoad> -->\n<CommonRoadSolution x='",
                Root::Solution,
            ),
            (
                "<?xml version='1.0'?><!-- <commonRoad> --><CommonRoadSolution/>",
                Root::Solution,
            ),
            ("<CommonRoadSolution a='b'>", Root::Solution),
            (
                "<!DOCTYPE a [<!ENTITY b 'c'>]>\n<commonRoad\tx",
                Root::Scenario,
            ),
            ("\u{feff}\u{feff}<commonRoad x='1'>", Root::Scenario),
            (
                "\u{feff}\u{feff}\u{feff}<CommonRoadSolution>",
                Root::Solution,
            ),
            ("<commonRoadMap>", Root::Other),
            // Cut off before the name is known.
            ("<commonRoad", Root::Other),
            ("<!-- <commonRoad>", Root::Other),
            ("words, and then a <commonRoad>", Root::Scenario),
            ("<html><commonRoad/></html>", Root::Other),
            ("timestep,x_position", Root::Other),
            ("", Root::Other),
        ] {
            assert_eq!(root_of(text.as_bytes()), root, "{text}");
        }
        assert_eq!(root_of(b"\xff<commonRoad>"), Root::Scenario);
        let wide: Vec<u8> = "\u{feff}<commonRoad >"
            .encode_utf16()
            .flat_map(u16::to_be_bytes)
            .collect();
        assert_eq!(root_of(&wide), Root::Scenario);
    }
}
