//! Writing templates of the user's, and which one is used.

use std::io::{Error, ErrorKind, Write};
use std::path::Path;

use crate::prompts::{Library, Template, choose_template};
use crate::system;

/// What the system says of a file, with its name.
pub fn named(path: &Path, error: &Error) -> String {
    let words = match error.kind() {
        ErrorKind::AlreadyExists => "it is there already; nothing was written".into(),
        _ => system::words(error),
    };
    format!("{}: {words}", path.display())
}

/// Writes a new template, never over another one, and uses it for its task and frame.
pub fn save_as(folder: &Path, file: &str, text: &str) -> Result<String, String> {
    let path = folder.join(file);
    let front = Template::read(text).map_err(|e| e.in_file(file))?.front;
    let write = || {
        std::fs::create_dir_all(folder)?;
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
        return Err(format!("{file}: there is no such template any longer"));
    };
    let front = &template.front;
    choose_template(folder, &front.task, &front.frame, file)?;
    Ok(format!(
        "{file} is used for {} in frame {}",
        front.task, front.frame
    ))
}
