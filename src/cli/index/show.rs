//! `nearmiss corpus show`: how many windows an index holds by manoeuvre, road and severity.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;

use crate::output::{self, Target};
use crate::{Failure, Outcome, json};
use nearmiss_drive::planner::Cancel;
use nearmiss_render::{Format, Palette, coverage_picture};
use nearmiss_scene::corpus::{self, Coverage, SEVERITIES};
use nearmiss_scene::metrics::SEVERITY_NAMES;
use nearmiss_workflow::read_index;

/// Arguments of `corpus show`.
#[derive(Debug, clap::Args)]
pub struct Show {
    /// Folder of the index.
    folder: PathBuf,
    #[command(flatten)]
    format: output::FormatOption,
    /// Also draw the table: a file .svg or .png.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long, requires = "output")]
    overwrite: bool,
}

/// The table for programs.
#[derive(Serialize, JsonSchema)]
pub struct ShowDocument {
    /// Number of windows.
    windows: u64,
    /// Windows by manoeuvre and road: `manoeuvre`, `road` and `counts`, whose place is the severity from 0 (contact)
    /// to 5 (none).
    coverage: Vec<ShowRow>,
}

#[derive(Serialize, JsonSchema)]
struct ShowRow {
    manoeuvre: String,
    road: String,
    counts: [u64; SEVERITIES],
}

impl json::Output for ShowDocument {
    const NAME: &'static str = "corpus-show";
    const TITLE: &'static str =
        "`corpus show --format json`: windows by manoeuvre, road and severity";
}

/// Prints the table.
pub fn run(arguments: &Show) -> Outcome {
    let coverage = coverage(&arguments.folder)?;
    if let Some(path) = &arguments.output {
        draw(&coverage, path, arguments.overwrite)?;
    }
    if arguments.format.is_json() {
        output::document(&document(&coverage))
    } else {
        output::text(&text(&coverage))
    }
}

fn coverage(folder: &Path) -> Result<Coverage, Failure> {
    // Answers do not matter here, and nothing cancels.
    let read = read_index(folder, &[], &Cancel::default(), &mut |_, _| {});
    let index = read.map_err(Failure::input)?;
    Ok(index.map_or_else(Coverage::default, |index| index.coverage()))
}

fn document(coverage: &Coverage) -> ShowDocument {
    let row = |(cell, counts): (&corpus::Cell, &[u64; SEVERITIES])| ShowRow {
        manoeuvre: output::visible(&cell.manoeuvre),
        road: output::visible(&cell.road),
        counts: *counts,
    };
    ShowDocument {
        windows: coverage.totals().iter().sum(),
        coverage: coverage.rows().map(row).collect(),
    }
}

fn text(coverage: &Coverage) -> String {
    let line = |manoeuvre: &str, road: &str, counts: &[u64; SEVERITIES]| {
        let mut cells: [String; SEVERITIES + 3] = Default::default();
        cells[0] = manoeuvre.into();
        cells[1] = road.into();
        for (cell, count) in cells[2..].iter_mut().zip(counts) {
            *cell = match count {
                0 => "·".into(),
                count => count.to_string(),
            };
        }
        cells[SEVERITIES + 2] = counts.iter().sum::<u64>().to_string();
        cells
    };
    let mut head: [String; SEVERITIES + 3] = Default::default();
    head[0] = "manoeuvre".into();
    head[1] = "road".into();
    for (cell, name) in head[2..].iter_mut().zip(SEVERITY_NAMES) {
        *cell = name.into();
    }
    head[SEVERITIES + 2] = "all".into();
    let mut rows = vec![head];
    let of_cell =
        |(c, counts): (&corpus::Cell, &[u64; SEVERITIES])| line(&c.manoeuvre, &c.road, counts);
    rows.extend(coverage.rows().map(of_cell));
    rows.push(line("all", "", &coverage.totals()));
    let right: Vec<usize> = (2..SEVERITIES + 3).collect();
    output::table_lines(&rows, &right).collect()
}

fn draw(coverage: &Coverage, path: &Path, overwrite: bool) -> Outcome {
    let format = Format::of_file(path)
        .filter(|format| *format != Format::Gif)
        .ok_or_else(|| {
            Failure::input(format!("-o {}: name a file .svg or .png", path.display()))
        })?;
    let picture = coverage_picture(coverage, &Palette::paper());
    let bytes = format
        .encode(&picture, format.usual_dpi())
        .map_err(|e| Failure::input(format!("{}: {e}", path.display())))?;
    Target::begin(Some(path), overwrite)?.save(&bytes)?;
    output::say(&format!("nearmiss: wrote {}", path.display()));
    Ok(())
}
