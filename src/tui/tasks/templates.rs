//! Saves the user's templates, and which of them is in use.

use std::io::{Error, ErrorKind, Write};
use std::path::Path;

use nearmiss_ask::prompts::{Library, Template, choose_template};
use nearmiss_base::system;
use nearmiss_settings::Folders;

/// A system error with the name of its file.
pub fn named(path: &Path, error: &Error) -> String {
    let words = match error.kind() {
        ErrorKind::AlreadyExists => "exists already; nothing was written".into(),
        _ => system::error_text(error),
    };
    format!("{}: {words}", path.display())
}

/// Takes a template of the user's, and a draft that was not saved, out of use without losing them.
pub fn set_aside(path: &Path, draft: Option<&str>) -> std::io::Result<String> {
    let mut kept = Vec::new();
    let saved = path.with_extension("md.bak");
    match std::fs::rename(path, &saved) {
        Ok(()) => kept.push(saved.display().to_string()),
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    if let Some(draft) = draft {
        // Beside a saved one it gets a separate name.
        let to = if kept.is_empty() {
            saved
        } else {
            path.with_extension("draft.md.bak")
        };
        Folders::write(&to, draft)?;
        kept.push(to.display().to_string());
    }
    Ok(if kept.is_empty() {
        "the shipped template is in use".into()
    } else {
        format!(
            "the shipped template is in use; yours is kept as {}",
            kept.join(", your draft as ")
        )
    })
}

/// Writes a new template, never over another one, and uses it for its task and frame.
pub fn save_as(folder: &Path, file: &str, text: &str) -> Result<String, String> {
    let path = folder.join(file);
    let front = Template::read(text).map_err(|e| e.in_file(file))?.front;
    let write = || {
        system::make_folder(folder)?;
        std::fs::File::create_new(&path)?.write_all(text.as_bytes())
    };
    write().map_err(|e| named(&path, &e))?;
    choose_template(folder, &front.task, &front.frame, file)?;
    Ok(format!("saved as {}, and in use", path.display()))
}

/// Uses a template for its task and frame.
pub fn choose(folder: &Path, file: &str) -> Result<String, String> {
    let library = Library::load(Some(folder));
    let Some((template, _)) = library.file(file) else {
        return Err(format!("template {file} no longer exists"));
    };
    let front = &template.front;
    choose_template(folder, &front.task, &front.frame, file)?;
    Ok(format!(
        "{file} is used for {} in frame {}",
        front.task, front.frame
    ))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_draft_is_kept_as_a_saved_template_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("prompts/mine.md");
        let read = |name: &str| std::fs::read_to_string(folder.path().join("prompts").join(name));
        let words = set_aside(&path, Some("a draft")).unwrap();
        assert!(words.contains("mine.md.bak"), "{words}");
        assert_eq!(read("mine.md.bak").unwrap(), "a draft");
        std::fs::write(&path, "saved").unwrap();
        set_aside(&path, Some("another draft")).unwrap();
        assert_eq!(read("mine.md.bak").unwrap(), "saved");
        assert_eq!(read("mine.draft.md.bak").unwrap(), "another draft");
        assert_eq!(
            set_aside(&path, None).unwrap(),
            "the shipped template is in use"
        );
    }
}
