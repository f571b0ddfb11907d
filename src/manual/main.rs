//! Builds the manual as an mdBook that reads offline: `cargo run -p nearmiss-manual [FOLDER]`, by default target/manual.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use mdbook_driver::MDBook;
use mdbook_driver::config::Config;
use nearmiss_docs::{TOPICS, Topic};

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = std::env::args_os().nth(1).map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| root.join("target/manual"));
    match build(&root, &folder) {
        Ok(()) => {
            println!("{}", folder.join("index.html").display());
            ExitCode::SUCCESS
        }
        Err(why) => {
            eprintln!("nearmiss-manual: {why}");
            ExitCode::FAILURE
        }
    }
}

/// Writes the book to a folder.
fn build(root: &Path, folder: &Path) -> Result<(), String> {
    let folder = std::path::absolute(folder).map_err(|why| why.to_string())?;
    let source = folder.with_extension("source");
    let pages = root.join("src/docs");
    copy(&pages, &source.join("src"))?;
    write(&source.join("src/SUMMARY.md"), &summary(&pages)?)?;
    let mut config = Config::default();
    config.book.title = Some("nearmiss".into());
    config.build.build_dir = folder;
    let book = MDBook::load_with_config(&source, config).map_err(|why| why.to_string())?;
    book.build().map_err(|why| why.to_string())?;
    std::fs::remove_dir_all(&source).map_err(|why| format!("{}: {why}", source.display()))
}

/// The pages in the order of reading: tasks, topics, reference.
fn summary(pages: &Path) -> Result<String, String> {
    let line = |topic: &Topic| {
        let title = topic.text.lines().next().unwrap_or(topic.name);
        format!("- [{}]({})\n", title.trim_start_matches("# "), topic.file)
    };
    let is_task = |topic: &&Topic| topic.file.starts_with("tasks/");
    let tasks: String = TOPICS.iter().filter(is_task).map(line).collect();
    let topics: String = TOPICS
        .iter()
        .filter(|one| !is_task(one))
        .map(line)
        .collect();
    let mut reference: Vec<String> = Vec::new();
    for entry in read(&pages.join("reference"))? {
        let name = entry
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let text = std::fs::read_to_string(&entry).map_err(|why| format!("{name}: {why}"))?;
        let title = text.lines().next().unwrap_or_default();
        reference.push(format!(
            "- [{}](reference/{name})\n",
            title.trim_start_matches("# ")
        ));
    }
    reference.sort();
    Ok(format!(
        "# Summary\n\n# Tasks\n\n{tasks}\n# Topics\n\n{topics}\n# Reference\n\n{}",
        reference.concat()
    ))
}

/// Copies the pages of a folder and of those in it.
fn copy(from: &Path, to: &Path) -> Result<(), String> {
    std::fs::create_dir_all(to).map_err(|why| format!("{}: {why}", to.display()))?;
    for path in read(from)? {
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy(&path, &target)?;
        } else if path.extension().is_some_and(|end| end == "md") {
            std::fs::copy(&path, &target).map_err(|why| format!("{}: {why}", path.display()))?;
        }
    }
    Ok(())
}

fn read(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let wrong = |why: std::io::Error| format!("{}: {why}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(wrong)?;
    entries
        .map(|entry| entry.map(|one| one.path()).map_err(wrong))
        .collect()
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|why| format!("{}: {why}", path.display()))
}
