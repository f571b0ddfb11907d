//! One template: its front matter with defaults, its text, the fragments it includes, its hash, and copies of it.

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;

use nearmiss_base::system::line_at;
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use sha2::{Digest, Sha256};
use toml::Spanned;

use super::render::syntax;
use super::{Pack, Techniques};

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
        Self::strip_front_matter(&self.source)
    }

    /// The text after the front matter, of a text that may have none.
    #[must_use]
    pub fn strip_front_matter(text: &str) -> &str {
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

/// Defaults of a template; what it does not say, the program decides.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Defaults {
    /// Steps in the window.
    pub history: Option<NonZeroUsize>,
    /// Every so many steps are described.
    pub stride: Option<NonZeroUsize>,
    /// At most so many times are described: in a longer window the stride grows.
    pub times: Option<NonZeroUsize>,
    /// Whether everyone is told that would be described at any step, and in the ego frame the nearest moment of each.
    pub nearest: Option<bool>,
    /// Obstacles within this distance of the ego are described, metres, and farther away those that can reach it soon.
    #[serde(deserialize_with = "radius")]
    pub radius: Option<f64>,
    /// Decimals of metres, m/s and m/s².
    #[serde(deserialize_with = "precision")]
    pub precision: Option<usize>,
    /// How the scene is written.
    pub form: Option<Wording>,
    /// Whether it is said that bodies touch.
    pub contact: Option<bool>,
    /// Whether the road near the ego is described too, in the Cartesian frame.
    pub road: Option<bool>,
    /// What the ego frame measures along and across.
    pub axes: Option<AxesOfEgo>,
    /// Ids of the measures of the metrics frame.
    pub measures: Option<Vec<String>>,
    /// Which techniques are on.
    #[serde(deserialize_with = "techniques")]
    pub techniques: Option<Techniques>,
    /// Sampling temperature, 0 to 2.
    #[serde(deserialize_with = "temperature")]
    pub temperature: Option<f64>,
}

/// Style of a description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wording {
    /// Sentences.
    Prose,
    /// A table.
    Compact,
}

/// The axes of the ego frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AxesOfEgo {
    /// Along and across the ego's heading.
    Heading,
    /// Along and across the ego's lane.
    Lane,
    /// Along and across the ego's heading, from centre to centre, without distances and gaps.
    Centre,
}

/// More decimals than any recording has.
pub const MAX_DECIMALS: usize = 9;

fn radius<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    let metres = f64::deserialize(from)?;
    if metres.is_finite() && metres > 0.0 {
        return Ok(Some(metres));
    }
    Err(D::Error::custom(
        "radius must be a positive number of metres",
    ))
}

fn precision<'de, D: Deserializer<'de>>(from: D) -> Result<Option<usize>, D::Error> {
    let decimals = i64::deserialize(from)?;
    let decimals = usize::try_from(decimals).ok();
    match decimals.filter(|d| *d <= MAX_DECIMALS) {
        Some(decimals) => Ok(Some(decimals)),
        None => Err(D::Error::custom(format!(
            "precision must be 0 to {MAX_DECIMALS} decimals"
        ))),
    }
}

fn techniques<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Techniques>, D::Error> {
    let words = String::deserialize(from)?;
    Techniques::parse(&words)
        .map(Some)
        .map_err(D::Error::custom)
}

fn temperature<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    let value = f64::deserialize(from)?;
    if (0.0..=2.0).contains(&value) {
        return Ok(Some(value));
    }
    Err(D::Error::custom("temperature must be from 0 to 2"))
}

/// The names of the fragments that `source` includes, and that those include.
///
/// A fragment counts as included where its name stands in quotes; [`super::render()`] offers no other, so that the
/// hash covers all that can be in a message.
pub(super) fn included<'f>(
    source: &str,
    fragments: &'f BTreeMap<String, String>,
) -> BTreeSet<&'f str> {
    let mut found = BTreeSet::new();
    let mut look = vec![source];
    while let Some(text) = look.pop() {
        for (name, fragment) in fragments {
            let named = [format!("\"{name}\""), format!("'{name}'")];
            if named.iter().any(|n| text.contains(n.as_str())) && found.insert(name.as_str()) {
                look.push(fragment);
            }
        }
    }
    found
}

impl super::Library {
    /// The names of the fragments that a text includes, and that those include.
    #[must_use]
    pub fn included(&self, source: &str) -> BTreeSet<&str> {
        included(source, self.fragments())
    }
}

/// SHA-256, hexadecimal, of a template and the fragments that it includes.
#[must_use]
pub fn hash(source: &str, fragments: &BTreeMap<String, String>) -> String {
    let mut digest = Sha256::new();
    let mut add = |text: &str| {
        // With its length, so that no two sets of texts are alike one after the other.
        digest.update((text.len() as u64).to_le_bytes());
        digest.update(text.as_bytes());
    };
    add(source);
    for name in included(source, fragments) {
        add(name);
        add(&fragments[name]);
    }
    digest
        .finalize()
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect()
}

/// The file that a name for a template means: `.md` may be left out.
///
/// # Errors
/// It is no name of a file that could be a template.
pub fn template_file(name: &str) -> Result<String, String> {
    let stem = name.trim().trim_end_matches(".md");
    let allowed = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    if stem.is_empty() || !stem.chars().all(allowed) {
        return Err(format!(
            "invalid template name `{}`; letters, digits, - and . are allowed",
            name.trim()
        ));
    }
    if stem.starts_with(['_', '.']) {
        return Err(format!(
            "invalid template name `{stem}`; it must start with a letter"
        ));
    }
    Ok(format!("{stem}.md"))
}

/// The text of a template with `name` in its front matter changed to that of its new file.
#[must_use]
pub fn renamed(source: &str, file: &str) -> String {
    let Some((front, _)) = split(source) else {
        return source.to_string();
    };
    let Ok(Template { front: said, .. }) = Template::read(source) else {
        return source.to_string();
    };
    let mut start = source.find(front).unwrap_or(0);
    for line in front.split_inclusive('\n') {
        let key = line.split('=').next().unwrap_or_default().trim();
        if key == "name" && line.contains(&format!("\"{}\"", said.name)) {
            let new = line.replacen(&said.name, file.trim_end_matches(".md"), 1);
            let mut text = source.to_string();
            text.replace_range(start..start + line.len(), &new);
            return text;
        }
        start += line.len();
    }
    source.to_string()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::prompts::{Library, Techniques, Wording};

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
        assert_eq!(Template::strip_front_matter(&other), "\nother {{ y }}\n");
        assert_eq!(Template::strip_front_matter("plain"), "plain");
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

    #[test]
    fn the_hash_covers_what_is_included_and_nothing_else() {
        let with = |b: &str, c: &str| {
            BTreeMap::from([
                ("_a.md".to_string(), "{% include '_b.md' %}".to_string()),
                ("_b.md".to_string(), b.to_string()),
                ("_c.md".to_string(), c.to_string()),
            ])
        };
        let source = "x {% include \"_a.md\" %}";
        let found = with("1", "1");
        assert_eq!(included(source, &found), BTreeSet::from(["_a.md", "_b.md"]));
        let now = hash(source, &with("1", "1"));
        assert_eq!(now, hash(source, &with("1", "2")));
        assert_ne!(now, hash(source, &with("2", "1")));
        assert_ne!(now, hash("y {% include \"_a.md\" %}", &with("1", "1")));
    }

    #[test]
    fn names_of_files() {
        assert_eq!(template_file(" short ").unwrap(), "short.md");
        assert_eq!(template_file("a-b.2.md").unwrap(), "a-b.2.md");
        for wrong in ["", ".md", "../x", "a/b", "_risk", ".hidden", "a b"] {
            assert!(template_file(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_name_in_the_front_matter_follows() {
        let shipped = Library::shipped("collision-ego.md").unwrap();
        let mine = renamed(shipped, "short.md");
        assert_eq!(Template::read(&mine).unwrap().front.name, "short");
        assert_eq!(mine.replacen("short", "collision-ego", 1), shipped);
        assert_eq!(renamed("no template", "short.md"), "no template");
    }
}
