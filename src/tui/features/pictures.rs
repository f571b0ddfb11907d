//! Pictures of the current view: chosen, drawn and saved.

use std::io::Write;
use std::path::Path;

use nearmiss_base::system::shown_path;
use nearmiss_formats::commonroad::{NewFile, SaveError};
use nearmiss_render::{
    Figure, FigureContent, FigureOptions, Format, MapExtent, Picture, Provenance, Subject, animate,
};
use ratatui::Frame;
use ratatui::layout::Rect;

use crate::features::Step;
use crate::features::picker::{self, Choice};
use crate::loaded::{PictureJob, PictureKind};
use crate::message::Effect;
use crate::model::{Model, Pane, Picker, matching};
use crate::request::{Replies, Request};
use crate::services::{DrawGuard, Services};
use crate::widgets::{picker as list, window};

/// Pictures by name.
#[derive(Debug)]
pub struct Pictures;

/// Opens the list, where there is something to be seen on a picture.
pub fn open(model: &mut Model) {
    if model.opened.is_none() {
        return model.say("no scenario is open");
    }
    picker::open(model, Pictures);
}

impl Choice for Pictures {
    fn count(&self, model: &Model, picker: &Picker) -> usize {
        pictures_shown(picker, model).len()
    }

    fn choose(&mut self, model: &mut Model, picker: &Picker) -> Step {
        let shown = pictures_shown(picker, model);
        let (Some(offer), Some(opened)) = (shown.get(picker.selected), &model.opened) else {
            return Step::close();
        };
        let kind = offer.kind;
        let question = model.prompt.question.as_ref();
        let asked = question.and_then(|question| question.picture.clone());
        if kind == PictureKind::Question && asked.is_none() {
            model.say("this question has no picture; choose the frame picture or ego+picture");
            return Step::close();
        }
        if matches!(kind, PictureKind::Plot | PictureKind::Both) && opened.scene.is_none() {
            let why = model.without_ego();
            model.say(format!("nothing to plot: {why}"));
            return Step::close();
        }
        let job = PictureJob {
            kind,
            format: offer.format,
            name: opened.name.clone(),
            scenario: opened.scenario.clone(),
            scene: opened.scene.clone(),
            // As on the map, where the layer is shown.
            variant: { opened.variant.clone() }.filter(|_| model.map.layers.variant),
            step: model.clock.step(),
            look: look(model, kind),
            thresholds: model.thresholds.clone(),
            folder: model.config.pictures.clone(),
            screen: Ok(None),
            shown: asked,
        };
        if kind == PictureKind::Animation {
            model.say("the animation is being drawn");
        }
        Step::Close(vec![Effect::Picture(Box::new(job))])
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        let inner = window::window(frame, screen, model, "save a figure or picture", (64, 16));
        let rows = pictures_shown(picker, model)
            .into_iter()
            .map(|offer| (offer.name.to_string(), offer.format.name().to_string()));
        list::draw(frame, inner, model, picker, &rows.collect::<Vec<_>>());
    }
}

/// As the map and the plot are seen now, in the colours of a paper.
fn look(model: &Model, kind: PictureKind) -> FigureOptions {
    let (columns, _) = model.drawn.map_size();
    let width = (model.camera.cell * f64::from(columns)).max(2.0);
    let seen = if model.camera.follow {
        MapExtent::Ego { width }
    } else {
        MapExtent::Around {
            center: model.camera.center,
            width,
        }
    };
    let ego = model.scene().map(|scene| scene.ego.id);
    let mut obstacles: Vec<i64> = model.picked.into_iter().collect();
    obstacles.extend(
        model
            .plot
            .marked
            .iter()
            .filter(|id| Some(**id) != model.picked),
    );
    obstacles.retain(|id| Some(*id) != ego);
    FigureOptions {
        what: match kind {
            PictureKind::Plot => FigureContent::Plot,
            PictureKind::Both => FigureContent::Both,
            _ => FigureContent::Map,
        },
        seen,
        ego_up: model.camera.ego_up,
        obstacles,
        measures: vec![model.plot.measure],
        window: Some(model.window_rule()),
        ..FigureOptions::default()
    }
}

/// A picture that can be chosen.
#[derive(Debug)]
struct PictureOffer {
    /// Its subject.
    kind: PictureKind,
    /// How it is written.
    format: Format,
    /// Its name.
    name: &'static str,
}

const fn offer(kind: PictureKind, format: Format, name: &'static str) -> PictureOffer {
    PictureOffer { kind, format, name }
}

const OFFERS: &[PictureOffer] = &[
    offer(PictureKind::Map, Format::Svg, "map, for papers"),
    offer(PictureKind::Map, Format::Png, "map, in pixels"),
    offer(PictureKind::Plot, Format::Svg, "plot, for papers"),
    offer(PictureKind::Plot, Format::Png, "plot, in pixels"),
    offer(
        PictureKind::Both,
        Format::Svg,
        "figure of map and plot, for papers",
    ),
    offer(
        PictureKind::Both,
        Format::Png,
        "figure of map and plot, in pixels",
    ),
    offer(PictureKind::Screen, Format::Svg, "whole screen, for papers"),
    offer(PictureKind::Screen, Format::Png, "whole screen, in pixels"),
    offer(
        PictureKind::Animation,
        Format::Gif,
        "map at every step, animated",
    ),
    offer(
        PictureKind::Question,
        Format::Png,
        "picture that models are shown with the question",
    ),
];

/// The pictures that the list shows, the best match first; nothing typed, those of the pane that has the keys, and
/// elsewhere the whole figure.
fn pictures_shown(picker: &Picker, model: &Model) -> Vec<&'static PictureOffer> {
    let first = match model.focus {
        Pane::Plot | Pane::Timeline => PictureKind::Plot,
        Pane::Map => PictureKind::Map,
        _ if model.scene().is_none() => PictureKind::Map,
        _ => PictureKind::Both,
    };
    let texts = OFFERS
        .iter()
        .map(|o| format!("{} {}", o.name, o.format.name()));
    let mut shown: Vec<_> = matching(&picker.text, texts)
        .into_iter()
        .map(|i| &OFFERS[i])
        .collect();
    if picker.text.is_empty() {
        shown.sort_by_key(|offer| offer.kind != first);
    }
    shown
}

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
const MAX_FILE_TRIES: usize = 1000;

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
    let stem = format!("{}{step}_{}", file_name(&job.name), job.kind.name());
    if let (PictureKind::Question, Some(shown)) = (job.kind, &job.shown) {
        let stem = format!("{}_{}", file_name(&job.name), job.kind.name());
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
    for number in 1..=MAX_FILE_TRIES {
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
        "{MAX_FILE_TRIES} files called {stem}.{ending} exist already; move some away"
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
