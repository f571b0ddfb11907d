//! What kind of CommonRoad file some bytes are, by their root element.

use std::io::Read;
use std::path::Path;

use super::xml::Xml;

/// What an XML file of CommonRoad holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Root {
    /// A scenario, `<commonRoad>`.
    Scenario,
    /// A solution, `<CommonRoadSolution>`.
    Solution,
    /// Something else, or no XML.
    Other,
}

/// A root further into the file than this many bytes is not looked for.
const HEAD: usize = 64 * 1024;

/// The kind of the file that begins with `bytes`, sound or not.
#[must_use]
pub fn root_of(bytes: &[u8]) -> Root {
    let head = &bytes[..bytes.len().min(HEAD)];
    // The head may end inside a character.
    let head = String::from_utf8_lossy(head);
    let name = Xml::new(head.as_bytes(), "")
        .ok()
        .and_then(|mut xml| Some(xml.next().ok()??.name));
    match name {
        Some("commonRoad") => Root::Scenario,
        Some("CommonRoadSolution") => Root::Solution,
        _ => Root::Other,
    }
}

/// The kind of a file; pipes and devices are not touched, and what cannot be read is something else.
#[must_use]
pub fn root_of_file(path: &Path) -> Root {
    let mut head = Vec::new();
    let regular = path.metadata().is_ok_and(|m| m.is_file());
    let read = regular
        .then(|| std::fs::File::open(path).ok())
        .flatten()
        .and_then(|file| file.take(HEAD as u64).read_to_end(&mut head).ok());
    read.map_or(Root::Other, |_| root_of(&head))
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
                Root::Other,
            ),
            (
                "<?xml version='1.0'?><!-- <commonRoad> --><CommonRoadSolution/>",
                Root::Solution,
            ),
            ("<CommonRoadSolution a='b'>", Root::Solution),
            ("<html><commonRoad/></html>", Root::Other),
            ("timestep,x_position", Root::Other),
            ("", Root::Other),
        ] {
            assert_eq!(root_of(text.as_bytes()), root, "{text}");
        }
        assert_eq!(root_of(b"\xff<commonRoad>"), Root::Scenario);
    }
}
