//! One template: its front matter and its text.

use serde::Deserialize;
use toml::Spanned;

use super::Pack;
use super::defaults::Defaults;
use super::render::syntax;
use nearmiss_base::system::line_at;

/// Metadata of a template.
#[derive(Debug, Clone, PartialEq)]
pub struct FrontMatter {
    /// Its name.
    pub name: String,
    /// Its version, any text.
    pub version: String,
    /// The task it is for, which is also the name of the answer's schema.
    pub task: String,
    /// The frame it is for.
    pub frame: String,
    /// The pack that it belongs to.
    pub pack: Pack,
    /// One sentence about it.
    pub summary: String,
    /// What holds where the user does not say otherwise.
    pub defaults: Defaults,
}

/// As it is written; a key that is not here is an error.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: String,
    version: String,
    task: String,
    frame: String,
    #[serde(default)]
    summary: String,
    schema: Option<Spanned<String>>,
    #[serde(default)]
    pack: Pack,
    #[serde(default)]
    defaults: Defaults,
}

/// A template, read but not yet filled.
#[derive(Debug, Clone, PartialEq)]
pub struct Template {
    /// What it says about itself.
    pub front: FrontMatter,
    /// The whole file, front matter included.
    pub source: String,
}

/// Why a text is not a template.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TemplateError {
    /// The file does not begin with front matter.
    #[error(
        "line 1: a template starts with `+++`, a TOML table with name, version, task and frame, and `+++`"
    )]
    NoFrontMatter,
    /// Front matter or text is not what is needed.
    #[error("line {line}: {message}")]
    Wrong {
        /// Line in the file, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
}

impl TemplateError {
    /// The error with the name of its file: `FILE:LINE: …`.
    #[must_use]
    pub fn in_file(&self, file: &str) -> String {
        match self {
            Self::NoFrontMatter => format!("{file}: {self}"),
            Self::Wrong { line, message } => format!("{file}:{line}: {message}"),
        }
    }
}

const FENCE: &str = "+++";

impl Template {
    /// Reads a template file: its front matter, and whether its text can be understood.
    ///
    /// # Errors
    /// The front matter is missing or wrong, or the syntax of the text, with its line.
    pub fn read(source: &str) -> Result<Self, TemplateError> {
        let (front, _) = split(source).ok_or(TemplateError::NoFrontMatter)?;
        let line = |byte: usize| 1 + line_at(front, byte);
        let written: Written = toml::from_str(front).map_err(|error| TemplateError::Wrong {
            line: line(error.span().map_or(0, |span| span.start)),
            message: error.message().to_string(),
        })?;
        if let Some(schema) = &written.schema
            && *schema.get_ref() != written.task
        {
            return Err(TemplateError::Wrong {
                line: line(schema.span().start),
                message: format!(
                    "the answer to task {} needs the schema of that name, not {}",
                    written.task,
                    schema.get_ref()
                ),
            });
        }
        syntax(&body_in_place(source))?;
        Ok(Self {
            front: FrontMatter {
                name: written.name,
                version: written.version,
                task: written.task,
                frame: written.frame,
                pack: written.pack,
                summary: written.summary,
                defaults: written.defaults,
            },
            source: source.to_string(),
        })
    }

    /// The text after the front matter.
    #[must_use]
    pub fn body(&self) -> &str {
        Self::body_of(&self.source)
    }

    /// The text after the front matter, of a text that may have none.
    #[must_use]
    pub fn body_of(text: &str) -> &str {
        split(text).map_or(text, |(_, body)| body)
    }

    /// The source of a template with the same front matter and another text.
    #[must_use]
    pub fn with_body(&self, body: &str) -> String {
        let before = self.source.len() - self.body().len();
        format!("{}\n{}\n", &self.source[..before], body.trim())
    }
}

/// Front matter and body of a file.
pub(super) fn split(source: &str) -> Option<(&str, &str)> {
    let rest = source
        .strip_prefix(FENCE)?
        .strip_prefix("\r\n")
        .or_else(|| source.strip_prefix(FENCE)?.strip_prefix('\n'))?;
    // Also where nothing stands between the fences.
    let end = match rest.strip_prefix(FENCE) {
        Some(_) => 0,
        None => rest.find("\n+++")? + 1,
    };
    let body = &rest[end + FENCE.len()..];
    Some((&rest[..end], body.strip_prefix('\r').unwrap_or(body)))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prompts::{Techniques, Wording};

    const GOOD: &str = "+++\nname = \"a\"\nversion = \"1\"\ntask = \"t\"\nframe = \"f\"\nschema = \"t\"\n\n\
        [defaults]\nhistory = 20\nform = \"compact\"\ntechniques = \"cp,cot\"\n+++\nbody {{ x }}\n";

    fn wrong(from: &str, to: &str) -> (usize, String) {
        assert!(GOOD.contains(from));
        match Template::read(&GOOD.replace(from, to)) {
            Err(TemplateError::Wrong { line, message }) => (line, message),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn front_matter_and_lines() {
        let template = Template::read(GOOD).expect("a whole template");
        let front = &template.front;
        assert_eq!((front.task.as_str(), front.frame.as_str()), ("t", "f"));
        assert_eq!(front.defaults.history.map(usize::from), Some(20));
        assert_eq!(front.defaults.form, Some(Wording::Compact));
        let techniques = Techniques::parse("cp,cot").expect("techniques");
        assert_eq!(front.defaults.techniques, Some(techniques));
        assert_eq!(front.defaults.radius, None);
        assert_eq!(body_in_place(GOOD).lines().nth(12), Some("body {{ x }}"));
    }

    #[test]
    fn another_body_keeps_the_front_matter() {
        let template = Template::read(GOOD).expect("a whole template");
        assert_eq!(template.body(), "\nbody {{ x }}\n");
        assert_eq!(template.with_body(template.body()), GOOD);
        let other = template.with_body("  other {{ y }}");
        assert_eq!(other, GOOD.replace("body {{ x }}", "other {{ y }}"));
        assert_eq!(Template::body_of(&other), "\nother {{ y }}\n");
        assert_eq!(Template::body_of("plain"), "plain");
    }

    #[test]
    fn what_is_wrong_has_a_line() {
        assert_eq!(Template::read("hello"), Err(TemplateError::NoFrontMatter));
        assert_eq!(wrong("version = \"1\"", "version = ").0, 3);
        let (line, message) = wrong("frame = \"f\"", "frames = \"f\"");
        assert!(line == 5 && message.contains("frames"), "{line} {message}");
        let (line, message) = wrong("schema = \"t\"", "schema = \"other\"");
        assert!(line == 6 && message.contains("other"), "{line} {message}");
        let (line, message) = wrong("history = 20", "histroy = 20");
        assert!(line == 9 && message.contains("histroy"), "{line} {message}");
        let (line, message) = wrong("body {{ x }}", "{% if x %}\n{{ }}");
        assert_eq!(line, 14, "{message}");
    }

    #[test]
    fn front_matter_cannot_be_nested_without_end() {
        for (open, close) in [("[", "]"), ("{a = ", "}")] {
            let deep = format!("x = {}{}", open.repeat(100_000), close.repeat(100_000));
            assert_eq!(wrong("version = \"1\"", &deep).0, 3);
        }
        // The key is understood and unknown, or refused: either way it has a line.
        let dotted = format!("{}x = 1", "a.".repeat(100_000));
        let (line, message) = wrong("version = \"1\"", &dotted);
        assert!((2..=3).contains(&line), "{line} {message}");
        let (line, message) = wrong("body {{ x }}", &"{% if x %}".repeat(10_000));
        assert!(line == 13, "{line} {message}");
    }

    #[test]
    fn defaults_that_cannot_be_are_named() {
        for (line, message) in [
            wrong("history = 20", "history = 0"),
            wrong("history = 20", "radius = -1.0"),
            wrong("history = 20", "radius = nan"),
            wrong("history = 20", "precision = 10"),
            wrong("history = 20", "temperature = 2.5"),
            wrong("history = 20", "stride = 0"),
        ] {
            assert_eq!(line, 9, "{message}");
        }
        let (line, message) = wrong("cp,cot", "cp,cut");
        assert!(line == 11 && message.contains("cut"), "{line} {message}");
    }
}
