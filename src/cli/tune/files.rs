//! The files of a tune: the diff, the template and the document in a folder, and a template of the user's.

use std::path::{Path, PathBuf};

use super::{Tune, TuneDocument, Tuned};
use crate::output::{self, refused};
use crate::{Failure, Outcome, json::Output};
use nearmiss_ask::prompts::{Library, renamed, template_file};
use nearmiss_base::system;
use nearmiss_settings::Folders;
use nearmiss_study::evaluation::validate;
use nearmiss_workflow::tune::{TuneOutcome, template_diff};

/// The files in the folder.
const FILES: [&str; 3] = ["template.diff", "template.md", "tune.json"];

/// Checks, before anything is paid, that nothing would be replaced.
pub fn check(arguments: &Tune, folders: &Folders) -> Outcome {
    if let (Some(folder), false) = (&arguments.output, arguments.overwrite) {
        if folder.is_file() {
            return Err(Failure::input(format!(
                "{}: is a file; name a folder",
                folder.display()
            )));
        }
        let there = FILES
            .iter()
            .map(|name| folder.join(name))
            .find(|path| path.exists());
        if let Some(path) = there {
            return Err(Failure::input(format!(
                "{} exists; use another folder, or --overwrite",
                path.display()
            )));
        }
    }
    if let Some(name) = &arguments.save {
        place(name, folders)?;
    }
    Ok(())
}

/// Where a template of this name is kept.
fn place(name: &str, folders: &Folders) -> Result<(String, PathBuf), Failure> {
    let file = template_file(name).map_err(|why| Failure::input(format!("--save: {why}")))?;
    if Library::shipped(&file).is_some() {
        return Err(Failure::input(format!(
            "--save: {file} is the name of a shipped template; choose another name"
        )));
    }
    let path = folders.prompts().join(&file);
    if path.exists() {
        Err(Failure::input(format!(
            "--save: {} exists; choose another name",
            path.display()
        )))
    } else {
        Ok((file, path))
    }
}

/// Writes the folder; diff and template only where a better one was found.
pub fn write(tuned: &Tuned<'_>, outcome: &TuneOutcome) -> Outcome {
    let Some(folder) = &tuned.arguments.output else {
        return Ok(());
    };
    std::fs::create_dir_all(folder).map_err(|error| Failure::system(folder.display(), &error))?;
    let plan = tuned.plan;
    let document = TuneDocument::new(tuned, outcome).document();
    let document = output::json_line(&document.map_err(Failure::input)?)?;
    let mut files = vec![(FILES[2], document)];
    if let Some(winner) = outcome.winner() {
        let diff = template_diff(&plan.file, &plan.template.source, &winner.source);
        files.push((FILES[0], diff));
        files.push((FILES[1], winner.source.clone()));
    }
    for (name, text) in &files {
        save_file(&folder.join(name), text, tuned.arguments.overwrite)?;
        output::say(&format!("nearmiss: wrote {}", folder.join(name).display()));
    }
    Ok(())
}

fn save_file(path: &Path, text: &str, overwrite: bool) -> Outcome {
    system::save(path, text.as_bytes(), overwrite).map_err(|error| refused(&error))
}

/// Keeps a better template in the user's folder, where that is asked for.
pub fn save(tuned: &Tuned<'_>, outcome: &TuneOutcome, folders: &Folders) -> Outcome {
    let (Some(name), Some(winner)) = (&tuned.arguments.save, outcome.winner()) else {
        return Ok(());
    };
    let (file, path) = place(name, folders)?;
    let folder = folders.prompts();
    system::make_folder(&folder).map_err(|error| Failure::system(folder.display(), &error))?;
    save_file(&path, &renamed(&winner.source, &file), false)?;
    let library = validate(Library::load(Some(&folder)));
    let stem = file.trim_end_matches(".md");
    let front = &tuned.plan.template.front;
    output::say(&if library.in_use(&file) {
        format!(
            "nearmiss: wrote {}; it is used for task {} in frame {} from now on",
            path.display(),
            front.task,
            front.frame
        )
    } else {
        format!(
            "nearmiss: wrote {}; `nearmiss prompt use {stem}` uses it for task {} in frame {}",
            path.display(),
            front.task,
            front.frame
        )
    });
    Ok(())
}
