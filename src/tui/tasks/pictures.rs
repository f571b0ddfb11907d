//! Draws and saves pictures in the background.

use std::io::Write;
use std::path::Path;

use crate::loaded::{PictureJob, PictureKind};
use crate::message::Effect;
use crate::model::Model;
use crate::request::{Replies, Request};
use crate::services::{DrawGuard, Services};
use nearmiss_base::system::shown_path;
use nearmiss_formats::commonroad::{NewFile, SaveError};
use nearmiss_render::{Figure, Format, Picture, Provenance, Subject, animate};

/// Draws and saves a picture.
#[derive(Debug)]
pub struct SavePicture(pub Box<PictureJob>);

impl Request for SavePicture {
    /// Where it is, or why there is none.
    type Reply = Result<String, String>;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let guard = services.drawing.begin();
        services.background(replies, move || save(&self.0, &guard));
    }

    fn reply(model: &mut Model, saved: Self::Reply) -> Vec<Effect> {
        match saved {
            // Long enough to read a path, whatever key comes next.
            Ok(path) => model.tell(format!("saved as {path}")),
            Err(error) => model.complain(format!("no picture: {error}")),
        }
        Vec::new()
    }
}

/// Resolution of screens: a cell is 9 pixels wide.
const SCREEN_DPI: f64 = 144.0;

/// Files of one name that are tried before another name is asked for.
const MOST: usize = 1000;

/// Draws and saves it; gives the path.
///
/// # Errors
/// It cannot be drawn or saved: in words, with what to do.
pub fn save(job: &PictureJob, held: &DrawGuard) -> Result<String, String> {
    let folder = job.folder.as_deref().unwrap_or(Path::new("."));
    let dpi = match job.kind {
        PictureKind::Screen => SCREEN_DPI,
        _ => job.format.usual_dpi(),
    };
    let moves = job.format == Format::Gif;
    let step = if moves {
        String::new()
    } else {
        format!("_step{}", job.step)
    };
    let stem = format!("{}{step}_{}", file_name(&job.name), job.kind.word());
    if let (PictureKind::Question, Some(shown)) = (job.kind, &job.shown) {
        let stem = format!("{}_{}", file_name(&job.name), job.kind.word());
        return save_new(folder, &stem, job.format.name(), &shown.image().bytes);
    }
    let still = match job.kind {
        PictureKind::Screen => Some(screen(job)?),
        _ => None,
    };
    let subject = Subject {
        scenario: &job.scenario,
        scene: job.scene.as_deref(),
    };
    let mut figure = Figure::new(subject, &job.name, job.look.clone(), &job.thresholds)
        .map_err(|e| e.to_string())?;
    if let Some(shown) = &job.variant {
        figure = figure.with_variations(shown.variations());
    }
    // Bytes first: a picture that cannot be drawn takes no name.
    let mut bytes = Vec::new();
    if moves {
        let steps: Vec<i64> = figure.steps().collect();
        let frame = |i: usize| Ok(figure.at(steps[i]));
        animate(
            &mut bytes,
            steps.len(),
            job.scenario.dt(),
            dpi,
            frame,
            held.stop(),
        )
        .map_err(|e| e.to_string())?;
    } else {
        let picture = still.unwrap_or_else(|| figure.at(job.step));
        bytes = job
            .format
            .encode(&picture, dpi)
            .map_err(|e| e.to_string())?;
    }
    save_new(folder, &stem, job.format.name(), &bytes)
}

/// Writes a new file, `stem.ending` or with a number behind it where that is there already; gives its path.
///
/// # Errors
/// It cannot be written: in words, with what to do.
pub fn save_new(folder: &Path, stem: &str, ending: &str, bytes: &[u8]) -> Result<String, String> {
    for number in 1..=MOST {
        let again = if number == 1 {
            String::new()
        } else {
            format!("_{number}")
        };
        let path = folder.join(format!("{stem}{again}.{ending}"));
        let written = NewFile::begin(&path, false).and_then(|mut file| {
            file.write_all(bytes).map_err(|source| SaveError::Io {
                path: path.clone(),
                source,
            })?;
            file.finish()
        });
        match written {
            Ok(()) => {
                return Ok(shown_path(&path));
            }
            Err(SaveError::Exists(_)) => {}
            Err(error) => {
                return Err(format!(
                    "{error}; `pictures` in config.toml names another folder"
                ));
            }
        }
    }
    Err(format!(
        "{MOST} files called {stem}.{ending} exist already; move some away"
    ))
}

/// A scenario's name as part of a file's name.
pub fn file_name(name: &str) -> String {
    let plain = |c: char| {
        if c.is_alphanumeric() || "-_.".contains(c) {
            c
        } else {
            '_'
        }
    };
    name.chars().take(120).map(plain).collect()
}

fn screen(job: &PictureJob) -> Result<Picture, String> {
    let painted = job.screen.clone()?;
    let screen = painted.ok_or("the screen was not painted")?;
    Ok(screen.picture(Provenance {
        title: format!("nearmiss, {}", job.name),
        description: format!(
            "The workbench with the scenario {} at time step {}.",
            job.name, job.step
        ),
        facts: vec![
            (
                "program",
                concat!("nearmiss ", env!("CARGO_PKG_VERSION")).into(),
            ),
            ("scenario", job.name.clone()),
            ("sha256", job.scenario.hash.to_string()),
            ("step", job.step.to_string()),
        ],
    }))
}
