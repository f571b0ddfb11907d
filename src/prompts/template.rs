//! One template: its front matter, its text, its hash.

use serde::Deserialize;
use sha2::{Digest, Sha256};

/// What a template says about itself.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct FrontMatter {
    /// Its name.
    pub name: String,
    /// Its version, any text.
    pub version: String,
    /// The task it is for.
    pub task: String,
    /// The frame it is for.
    pub frame: String,
    /// One sentence about it.
    #[serde(default)]
    pub summary: String,
}

/// A template, read but not yet filled.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Template {
    /// What it says about itself.
    pub front: FrontMatter,
    /// The whole file, front matter included.
    pub source: String,
    /// SHA-256 of the file, hexadecimal.
    pub hash: String,
}

/// Why a text is not a template.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TemplateError {
    /// The file does not begin with front matter.
    #[error(
        "line 1: a template begins with `+++`, a TOML table with name, version, task and frame, and `+++`"
    )]
    NoFrontMatter,
    /// The front matter is not what is needed.
    #[error("line {line}: {message}")]
    FrontMatter {
        /// Line in the file, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
}

const FENCE: &str = "+++";

impl Template {
    /// Reads a template file.
    ///
    /// # Errors
    /// The front matter is missing or wrong, with its line.
    pub fn read(source: &str) -> Result<Self, TemplateError> {
        let (front, _) = split(source).ok_or(TemplateError::NoFrontMatter)?;
        let front = toml::from_str(front).map_err(|error| {
            let before = error
                .span()
                .map_or("", |span| &front[..span.start.min(front.len())]);
            TemplateError::FrontMatter {
                line: 2 + before.matches('\n').count(),
                message: error.message().to_string(),
            }
        })?;
        Ok(Self {
            front,
            source: source.to_string(),
            hash: hash(source),
        })
    }
}

/// Front matter and body of a file.
pub(super) fn split(source: &str) -> Option<(&str, &str)> {
    let rest = source
        .strip_prefix(FENCE)?
        .strip_prefix("\r\n")
        .or_else(|| source.strip_prefix(FENCE)?.strip_prefix('\n'))?;
    let end = rest.find("\n+++")?;
    let body = &rest[end + 1 + FENCE.len()..];
    Some((&rest[..end + 1], body.strip_prefix('\r').unwrap_or(body)))
}

/// The body of a file in its own lines: the front matter is blank, so that errors name the file's lines.
pub(super) fn body_in_place(source: &str) -> String {
    match split(source) {
        Some((_, body)) => {
            let before = source.len() - body.len();
            let lines = source[..before].matches('\n').count();
            // The newline after the closing fence is part of the body.
            "\n".repeat(lines) + body
        }
        None => source.to_string(),
    }
}

/// SHA-256 of a template's text, hexadecimal.
#[must_use]
pub fn hash(source: &str) -> String {
    Sha256::digest(source.as_bytes())
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str =
        "+++\nname = \"a\"\nversion = \"1\"\ntask = \"t\"\nframe = \"f\"\n+++\nbody {{ x }}\n";

    #[test]
    fn front_matter_and_lines() {
        let template = Template::read(GOOD).expect("a whole template");
        assert_eq!(template.front.task, "t");
        assert_eq!(body_in_place(GOOD).lines().nth(6), Some("body {{ x }}"));
    }

    #[test]
    fn what_is_wrong_has_a_line() {
        assert_eq!(Template::read("hello"), Err(TemplateError::NoFrontMatter));
        let broken = GOOD.replace("version = \"1\"", "version = ");
        match Template::read(&broken) {
            Err(TemplateError::FrontMatter { line, .. }) => assert_eq!(line, 3),
            other => panic!("{other:?}"),
        }
    }
}
