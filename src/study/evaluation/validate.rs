//! Validates the user's templates: those that parse but cannot be rendered are not used.

use super::dry_render;
use nearmiss_ask::prompts::Library;

/// The library without the user's files that no prompt can be made of: each is tried on a bundled scenario, and where
/// that fails the shipped one is in its place, with a problem that names file, line and mistake.
#[must_use]
pub fn validate(mut library: Library) -> Library {
    let files: Vec<String> = library.templates().map(|t| t.0.to_string()).collect();
    for file in files {
        // A fragment may be at fault, then another, then the template itself.
        while let Some((culprit, message)) = at_fault(&library, &file) {
            if !library.set_aside(&culprit, message) {
                break;
            }
        }
    }
    library
}

/// Which file of the user spoils a template, and how; `None` if it can be filled or none of it is the user's.
fn at_fault(library: &Library, file: &str) -> Option<(String, String)> {
    let users = library.users_in(file);
    let first = users.first()?;
    let error = dry_render(library, file).err()?;
    let culprit = users.iter().find(|one| **one == error.file);
    let Some(line) = error.line.filter(|_| culprit.is_some()) else {
        let message = match culprit {
            Some(_) => error.message,
            None => error.to_string(),
        };
        return Some((culprit.unwrap_or(first).clone(), message));
    };
    let culprit = culprit.unwrap_or(first);
    let text = library.source(culprit).map_or("", |(text, _)| text);
    let written = text.lines().nth(line - 1).unwrap_or_default().trim();
    let message = format!("line {line}: {}, in `{written}`", error.message);
    Some((culprit.clone(), message))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_ask::prompts::{Fallback, Origin};

    #[test]
    fn what_cannot_be_filled_is_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: String| {
            std::fs::write(folder.path().join(name), text).unwrap();
        };
        let shipped = |name: &str| Library::shipped(name).unwrap().to_string();
        let ego = shipped("collision-ego.md");
        write(
            "collision-ego.md",
            ego.replace("{{ description }}", "{{ nonsense }}"),
        );
        write("mine.md", ego.replace("collision-ego", "mine"));
        let unknown = "[defaults]\nmeasures = [\"ttc\", \"darc\"]\n+++\n{% block";
        let metrics = shipped("collision-metrics.md");
        write("measured.md", metrics.replacen("+++\n{% block", unknown, 1));
        write("_critical.md", "{{ no_such_value }}\n".into());
        let library = validate(Library::load(Some(folder.path())));
        let (_, origin) = library.file("collision-ego.md").unwrap();
        assert_eq!(*origin, Origin::Shipped);
        assert!(library.is_users("mine.md") && !library.is_users("_critical.md"));
        let said: Vec<String> = library.problems.iter().map(ToString::to_string).collect();
        assert_eq!(said.len(), 3, "{said:?}");
        let line = 1 + ego.lines().position(|l| l == "{{ description }}").unwrap();
        let of = |name: &str| said.iter().find(|s| s.contains(name)).unwrap();
        let told = of("collision-ego.md");
        assert!(told.contains(&format!("line {line}: ")), "{told}");
        assert!(told.contains("`{{ nonsense }}`"), "{told}");
        assert!(of("_critical.md").contains("line 1: "), "{said:?}");
        let told = of("measured.md");
        assert!(
            told.contains("line 9: unknown measure `darc`; did you mean `drac`"),
            "{told}"
        );
        for problem in &library.problems {
            let own = problem.path.ends_with("measured.md");
            let instead = if own {
                Fallback::Usual
            } else {
                Fallback::Shipped
            };
            assert_eq!(problem.instead, instead);
        }
    }
}
