//! Copies a template under another name, beside the original.

use super::Template;
use super::template::split;

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
    use crate::prompts::Library;

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
