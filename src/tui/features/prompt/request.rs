//! Saves the user's templates, and which of them is in use.

use std::collections::HashMap;
use std::io::{Error, ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::message::Effect;
use crate::model::Model;
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::session::file::{KeptDraft, beside};
use nearmiss_ask::prompts::{Library, Template, choose_template};
use nearmiss_base::system;
use nearmiss_settings::Folders;

/// Changes a template of the user's, by its file.
#[derive(Debug)]
pub struct ChangeTemplate(pub String, pub TemplateChange);

/// What becomes of a template.
#[derive(Debug)]
pub enum TemplateChange {
    /// It is written.
    Save {
        /// Its text.
        text: String,
        /// The text that it was made from.
        from: String,
    },
    /// It is written under a new name, and used for its task and frame.
    SaveAs(String),
    /// It is taken out of use, with the draft that was not saved.
    Remove(Option<String>),
    /// It is used, of all those for its task and frame.
    Use,
}

impl Request for ChangeTemplate {
    /// Its file, and the library as it is now with what to say.
    type Reply = (String, Result<(Library, String), String>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let folder = services.folders.prompts();
        services.background(replies, move || {
            let Self(file, change) = self;
            let path = folder.join(&file);
            let changed = match change {
                TemplateChange::Save { text, from } => {
                    save(&path, &text, &from).map_err(|error| named(&path, &error))
                }
                TemplateChange::SaveAs(text) => save_as(&folder, &file, &text),
                TemplateChange::Remove(draft) => {
                    set_aside(&path, draft.as_deref()).map_err(|error| named(&path, &error))
                }
                TemplateChange::Use => choose(&folder, &file),
            };
            let result = changed.map(|words| (Library::load(Some(&folder)), words));
            (file, result)
        });
    }

    fn reply(model: &mut Model, (file, result): Self::Reply) -> Vec<Effect> {
        super::saved(model, &file, result)
    }
}

/// Reads all templates again.
#[derive(Debug)]
pub struct RereadTemplates;

impl Request for RereadTemplates {
    type Reply = Library;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let folder = services.folders.prompts();
        services.background(replies, move || Library::load(Some(&folder)));
    }

    fn reply(model: &mut Model, library: Library) -> Vec<Effect> {
        super::reread(model, library);
        Vec::new()
    }
}

/// A system error with the name of its file.
fn named(path: &Path, error: &Error) -> String {
    let words = match error.kind() {
        ErrorKind::AlreadyExists => "exists already; nothing was written".into(),
        _ => system::error_text(error),
    };
    format!("{}: {words}", path.display())
}

/// Writes a template made `from` another text. One there that could not be read, or that another program has written
/// since, is no earlier version of it: it is kept.
fn save(path: &Path, text: &str, from: &str) -> std::io::Result<String> {
    let mut words = format!("saved as {}", path.display());
    let kept_as = |before: Vec<u8>| match String::from_utf8(before) {
        Ok(before) if Template::read(&before).is_ok() => {
            let known = [text, from].map(str::trim_end).contains(&before.trim_end());
            (!known).then_some(("the file that another program has written", "other.md.bak"))
        }
        _ => Some(("the file that could not be read", "unread.md.bak")),
    };
    if let Some((what, end)) = std::fs::read(path).ok().and_then(kept_as) {
        let mut kept = path.with_extension(end);
        if kept.exists() {
            kept = beside(&kept);
        }
        std::fs::rename(path, &kept)?;
        words += &format!("; {what} is kept as {}", kept.display());
    }
    Folders::write(path, text)?;
    Ok(words)
}

/// Takes a template of the user's, and a draft that was not saved, out of use without losing them.
fn set_aside(path: &Path, draft: Option<&str>) -> std::io::Result<String> {
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
fn save_as(folder: &Path, file: &str, text: &str) -> Result<String, String> {
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
fn choose(folder: &Path, file: &str) -> Result<String, String> {
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

/// Keeps the draft of a template for the next start. One that another instance of the program has kept stays.
#[derive(Debug)]
pub struct KeepDraft {
    /// The file of the template.
    pub file: String,
    /// The text; nothing removes what this instance kept.
    pub draft: Option<String>,
    /// The draft that was found at the start.
    pub found: Option<String>,
}

impl Request for KeepDraft {
    /// Where it is kept beside that of another instance, with its template's file; or why it is not.
    type Reply = Result<Option<(String, PathBuf)>, String>;

    // At once and not in the background: the program may be about to end.
    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Self { file, draft, found } = self;
        let folder = services.folders.drafts();
        let all: &mut HashMap<String, KeptDraft> = services.state();
        let new = || KeptDraft::new(&folder, &file, found);
        let own = all.entry(file.clone()).or_insert_with(new);
        let kept = own.keep(draft.as_deref());
        replies.send(kept.map(|other| Some((file, other?.to_path_buf()))));
    }

    fn reply(model: &mut Model, kept: Self::Reply) -> Vec<Effect> {
        model.prompt.lost = kept.is_err();
        match kept {
            Ok(None) => {}
            Ok(Some((file, path))) => model.complain(format!(
                "another nearmiss has a draft of {file}: this one is kept as {}",
                path.display()
            )),
            Err(why) => model.complain(format!("the draft is not kept for the next start: {why}")),
        }
        Vec::new()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_could_not_be_read_is_not_lost() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("collision-ego.md");
        std::fs::write(&path, "+++\nname = \"mine\"\nno end").unwrap();
        let shipped = Library::shipped("collision-ego.md").unwrap();
        let words = save(&path, shipped, shipped).unwrap();
        assert!(words.contains("unread.md.bak"), "{words}");
        let kept = std::fs::read_to_string(path.with_extension("unread.md.bak"));
        assert!(kept.unwrap().contains("no end"));
        // A template that can be read is an earlier version.
        let again = save(&path, shipped, shipped).unwrap();
        assert!(!again.contains("bak"), "{again}");
    }

    #[test]
    fn a_template_that_another_program_has_written_is_not_lost() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("collision-ego.md");
        let shipped = Library::shipped("collision-ego.md").unwrap();
        let [mine, theirs] = ["mine", "theirs"].map(|words| format!("{shipped}\n{words}\n"));
        let first = save(&path, &theirs, shipped).unwrap();
        assert!(!first.contains("bak"), "{first}");
        let words = save(&path, &mine, shipped).unwrap();
        assert!(words.contains("other.md.bak"), "{words}");
        let read = |path: &Path| std::fs::read_to_string(path).unwrap();
        assert_eq!(read(&path.with_extension("other.md.bak")), theirs);
        assert_eq!(read(&path), mine);
    }

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
