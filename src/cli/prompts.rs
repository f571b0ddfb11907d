//! `nearmiss prompt`: what models receive, and the templates it is made of.

use std::io::Write;
use std::path::{Path, PathBuf};

use nearmiss_ask::prompts::{
    Library, Origin, Problem, Template, choose_template, renamed, template_file,
};
use nearmiss_base::system;
use nearmiss_settings::Folders;
use nearmiss_study::evaluation::validate;
use schemars::JsonSchema;
use serde::Serialize;
use similar::TextDiff;

use super::open::configuration;
use super::prompt::{self, Describe, PromptArguments};
use super::{Failure, Outcome, output};

/// Subcommands of `prompt`.
#[derive(Debug, clap::Subcommand)]
pub enum Prompt {
    /// Print the messages that a model would receive.
    Show(PromptArguments),
    /// Same as `nearmiss describe`.
    #[command(hide = true)]
    Describe(Describe),
    /// List templates with task, frame, version, hash, origin and errors.
    List {
        #[command(flatten)]
        format: output::FormatOption,
    },
    /// Print a template or fragment as it is in use.
    Text(Name),
    /// Copy a template into your folder to edit it; existing files are kept.
    Copy {
        #[command(flatten)]
        name: Name,
        /// Name of the copy, to keep both templates.
        #[arg(long = "as", value_name = "NEW")]
        new: Option<String>,
    },
    /// Compare your version of a template with the built-in one.
    Diff(Name),
    /// Use a template for its task and frame, also in the workbench.
    Use(Name),
}

/// A template on the command line.
#[derive(Debug, clap::Args)]
pub struct Name {
    /// File name, with or without `.md`.
    name: String,
}

/// Runs `prompt`.
pub fn run(command: &Prompt) -> Outcome {
    let own = || {
        let (folders, _) = configuration()?;
        let folder = folders.prompts();
        Ok::<_, Failure>((validate(Library::load(Some(&folder))), folder))
    };
    match command {
        Prompt::Show(arguments) => prompt::show(arguments),
        Prompt::Describe(arguments) => prompt::describe(arguments),
        Prompt::List { format } => {
            let (library, folder) = own()?;
            let listed = list(&library, format.is_json());
            output::say(&format!("your templates: {}", folder.display()));
            listed
        }
        Prompt::Text(Name { name }) => output::text(&output::visible(known(&own()?.0, name)?.1)),
        Prompt::Diff(Name { name }) => diff(&own()?.0, name),
        Prompt::Copy { name, new } => {
            let (library, folder) = own()?;
            copy(&library, &folder, &name.name, new.as_deref())
        }
        Prompt::Use(Name { name }) => {
            let (library, folder) = own()?;
            let (template, file) = template(&library, name)?;
            let front = &template.front;
            choose_template(&folder, &front.task, &front.frame, &file).map_err(Failure::input)?;
            output::say(&format!(
                "{file} is now used for task {} in frame {}",
                front.task, front.frame
            ));
            Ok(())
        }
    }
}

/// Copies a template into the user's folder, under another name if so wished.
fn copy(library: &Library, folder: &Path, name: &str, new: Option<&str>) -> Outcome {
    let (file, text) = match new {
        None => {
            let (file, _) = known(library, name)?;
            let shipped = Library::shipped(&file)
                .ok_or_else(|| Failure::input(format!("{file} is not a shipped template")))?;
            (file, shipped.to_string())
        }
        Some(new) => {
            let (template, _) = template(library, name)?;
            let file = template_file(new).map_err(Failure::input)?;
            if Library::shipped(&file).is_some() {
                return Err(Failure::input(format!(
                    "{file} is the name of a shipped template; choose another name"
                )));
            }
            let text = renamed(&template.source, &file);
            (file, text)
        }
    };
    let path = folder.join(&file);
    write_new(&path, &text)?;
    output::text(&format!("{}\n", path.display()))
}

/// The file that a name means, with its text in use.
fn known<'l>(library: &'l Library, name: &str) -> Result<(String, &'l str), Failure> {
    let file = if name.ends_with(".md") {
        name.to_string()
    } else {
        format!("{name}.md")
    };
    match library.source(&file) {
        Some((text, _)) => Ok((file, text)),
        None => {
            if let Some(problem) = broken(library).find(|p| file_of(p) == file) {
                return Err(Failure::input(problem));
            }
            let fragments = library.fragments().keys().map(String::as_str);
            let all: Vec<&str> = library.templates().map(|t| t.0).chain(fragments).collect();
            Err(Failure::input(format!(
                "unknown template `{name}`; available: {}",
                all.join(", ")
            )))
        }
    }
}

/// The template that a name means, with its file.
fn template<'l>(library: &'l Library, name: &str) -> Result<(&'l Template, String), Failure> {
    let (file, _) = known(library, name)?;
    match library.file(&file) {
        Some((template, _)) => Ok((template, file)),
        None => Err(Failure::input(format!(
            "{file} is a fragment that templates include, not a template"
        ))),
    }
}

/// The user's templates and fragments that cannot be read or filled.
fn broken(library: &Library) -> impl Iterator<Item = &Problem> {
    let is_file = |p: &&Problem| p.path.extension().is_some_and(|x| x == "md");
    library.problems.iter().filter(is_file)
}

fn file_of(problem: &Problem) -> String {
    let name = problem.path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

fn place(origin: &Origin) -> String {
    match origin {
        Origin::Shipped => "shipped".into(),
        Origin::User(path) => path.display().to_string(),
    }
}

/// A template for programs; a broken file has no more than its name, place and problem.
#[derive(Default, Serialize, JsonSchema)]
pub struct Document {
    template: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    template_version: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    template_hash: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    task: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<String>,
    origin: String,
    /// Whether it is used for its task and frame.
    in_use: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    summary: Option<String>,
    problem: Option<String>,
}

fn list(library: &Library, as_json: bool) -> Outcome {
    let problems: Vec<String> = library.problems.iter().map(ToString::to_string).collect();
    let templates = library.templates();
    if as_json {
        for (file, template, origin) in templates {
            let front = &template.front;
            output::document(&Document {
                template: file.to_string(),
                template_version: Some(front.version.clone()),
                template_hash: Some(library.hash(&template.source)),
                task: Some(front.task.clone()),
                frame: Some(front.frame.clone()),
                origin: place(origin),
                in_use: library.in_use(file),
                summary: Some(front.summary.clone()),
                problem: None,
            })?;
        }
        for problem in &library.problems {
            output::document(&Document {
                template: file_of(problem),
                origin: problem.path.display().to_string(),
                problem: Some(problem.message.clone()),
                ..Document::default()
            })?;
        }
    } else {
        let titles = ["file", "task", "frame", "used", "version", "hash", "origin"];
        let mut rows = vec![titles.map(String::from)];
        rows.extend(templates.map(|(file, template, origin)| {
            let front = &template.front;
            [
                file.to_string(),
                front.task.clone(),
                front.frame.clone(),
                if library.in_use(file) { "yes" } else { "no" }.to_string(),
                front.version.clone(),
                library.hash(&template.source)[..12].to_string(),
                place(origin),
            ]
        }));
        let fragments = library.fragments().keys();
        rows.extend(fragments.filter_map(|file| {
            let (_, origin) = library.source(file)?;
            let dash = || "-".to_string();
            Some([
                file.clone(),
                dash(),
                dash(),
                dash(),
                dash(),
                dash(),
                place(origin),
            ])
        }));
        rows.extend(broken(library).map(|problem| {
            let mut row = [(); 7].map(|()| "-".to_string());
            row[0] = file_of(problem);
            row[3] = "broken".into();
            row[6] = problem.path.display().to_string();
            row
        }));
        output::text(&output::table_lines(&rows, &[]).collect::<String>())?;
        for problem in &problems {
            output::say(&format!("nearmiss: {problem}"));
        }
    }
    match problems.len() {
        0 => Ok(()),
        count => Err(Failure::finding(format!(
            "{count} of your templates cannot be used"
        ))),
    }
}

fn diff(library: &Library, name: &str) -> Outcome {
    let (file, _) = known(library, name)?;
    // Also a file that is broken and not in use has its differences.
    let broken = library.problems.iter().find(|p| {
        p.path
            .file_name()
            .is_some_and(|n| n.to_string_lossy() == file)
    });
    let (theirs, path) = match (broken, library.source(&file)) {
        (Some(problem), _) => {
            output::say(&format!("nearmiss: {problem}"));
            let text = system::read_text(&problem.path, system::LARGEST_TEXT).map_err(|error| {
                Failure::input(format!(
                    "{}: {}",
                    problem.path.display(),
                    system::error_text(&error)
                ))
            })?;
            (text, problem.path.clone())
        }
        (None, Some((text, Origin::User(path)))) => (text.to_string(), path.clone()),
        _ => {
            output::say(&format!("the shipped {file} is in use"));
            return Ok(());
        }
    };
    let Some((original, shipped)) = shipped_for(&file, &theirs) else {
        return Err(Failure::input(format!(
            "{file} has no shipped version to compare with"
        )));
    };
    // Of texts that have little in common a coarser difference will do.
    let difference = TextDiff::configure()
        .timeout(std::time::Duration::from_millis(300))
        .diff_lines(shipped, theirs.as_str());
    let mut unified = difference.unified_diff();
    let shown = path.display().to_string();
    let text = unified
        .header(&format!("shipped/{original}"), &shown)
        .to_string();
    output::text(&output::visible(&text))
}

/// The shipped file of this name, or, of a template with a name of its own, the one for its task and frame that it was
/// copied from: name and text.
fn shipped_for(file: &str, text: &str) -> Option<(String, &'static str)> {
    if let Some(shipped) = Library::shipped(file) {
        return Some((file.to_string(), shipped));
    }
    let front = Template::read(text).ok()?.front;
    let shipped = Library::load(None).with_pack(front.pack);
    let (original, _) = shipped.find(&front.task, &front.frame)?;
    Some((original.to_string(), Library::shipped(original)?))
}

/// Writes a file that must not be there yet.
fn write_new(path: &PathBuf, text: &str) -> Result<(), Failure> {
    let failed = |error: std::io::Error| {
        Failure::input(match error.kind() {
            std::io::ErrorKind::AlreadyExists => {
                format!("{} exists; nothing was written", path.display())
            }
            _ => format!("{}: {}", path.display(), system::error_text(&error)),
        })
    };
    if let Some(folder) = path.parent() {
        system::make_folder(folder).map_err(failed)?;
    }
    let mut file = std::fs::File::create_new(path).map_err(failed)?;
    file.write_all(text.as_bytes()).map_err(failed)
}

/// The templates that questions are made of. Files that are not in use are told.
///
/// # Errors
/// One that is in use is broken: nothing is sent in its place.
pub fn templates(folders: &Folders) -> Result<Library, Failure> {
    let library = validate(Library::load(Some(&folders.prompts())));
    let (stop, told): (Vec<&Problem>, Vec<_>) = library.problems.iter().partition(|p| p.stops());
    for problem in told {
        output::say(&format!("nearmiss: {problem}"));
    }
    let all: Vec<String> = stop.iter().map(ToString::to_string).collect();
    if all.is_empty() {
        Ok(library)
    } else {
        Err(Failure::input(all.join("\n")))
    }
}
