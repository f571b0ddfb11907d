//! `nearmiss render`: figures of scenes, plots and the workbench, for papers, and where they are written.

mod arguments;
mod certificate;
mod grid;
mod overlay;

pub use arguments::Render;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use nearmiss_formats::{EgoSelection, Entry, Forecast};
use nearmiss_render::{
    AnimationError, Figure, FigureContent, FigureError, FigureOptions, Format, Palette, Picture,
    Provenance, ScreenPainter, ScreenRequest, Subject, animate, film,
};
use nearmiss_scene::metrics::{Context, Thresholds, measure};
use nearmiss_scene::scenario::Scene;
use nearmiss_workflow::ToldStory;
use serde::Serialize;

use super::ending::interrupted;
use super::files::Inputs;
use super::many_files::{Failed, Job, NEXT, RunJournal, Unit, holds};
use super::open::{
    Opened, clash, configuration, found_beside, scene_and_doubts, scene_beside, user_thresholds,
};
use super::output::{self, Target};
use super::span::worst_step;
use super::{Failure, Outcome};
use arguments::RenderContent;
use certificate::Original;

/// Everything that holds for all scenarios of a call.
struct Drawing<'a> {
    arguments: &'a Render,
    thresholds: Thresholds,
    palette: Palette,
    /// Of pages, where the browser prefers dark colours.
    dark: Palette,
    /// The lines of `--overlay`.
    forecasts: Vec<Forecast>,
    ego: EgoSelection,
    target: Destination,
    dpi: f64,
    /// Steps of windows, as the configuration has them.
    history: Option<usize>,
    painter: ScreenPainter,
    stop: &'a AtomicBool,
}

/// Runs `render`; `painter` draws screens of the workbench.
pub fn run(arguments: &Render, painter: ScreenPainter) -> Outcome {
    let entries = arguments
        .many
        .part
        .of(found_beside(&arguments.paths, arguments.overlay.is_some())?);
    if entries.is_empty() {
        return Ok(());
    }
    Inputs::of(&entries).spare(arguments.output.as_deref())?;
    let target = Destination::new(arguments, &entries)?;
    let (folders, config) = configuration()?;
    let stop = interrupted(true);
    let theme = arguments.theme(config.theme.as_deref());
    let dark = arguments.theme.as_deref().unwrap_or("dark");
    let overlay = overlay::read(arguments.overlay.as_deref())?;
    let drawing = Drawing {
        arguments,
        thresholds: user_thresholds(&folders)?,
        palette: Palette::named(&theme, &folders.themes()).map_err(Failure::input)?,
        dark: Palette::named(dark, &folders.themes()).map_err(Failure::input)?,
        forecasts: overlay.forecasts,
        ego: arguments.ego.wanted(&entries)?,
        dpi: arguments.dpi(target.format)?,
        target,
        history: config.history,
        painter,
        stop: &stop,
    };
    arguments.check(drawing.target.format)?;
    let settings = RenderSettings {
        arguments,
        theme: &theme,
        format: drawing.target.format.name(),
        view: arguments.view.map(|view| view.to_string()),
        plot: arguments.plot.iter().map(|measure| measure.id).collect(),
        usual_history: drawing.history,
        thresholds: drawing.thresholds.change_words(),
        drives: drawing.ego.planner().map(|drives| drives.sha256.as_str()),
        overlay: overlay.hash,
    };
    let journal = arguments
        .many
        .journal("render", drawing.target.folder(), &settings)?;
    let mut failed = Failed::of(entries.len());
    for entry in &entries {
        match drawing.render_once(entry, &theme, &journal) {
            Ok(()) => {}
            Err(failure) if failure.is_interrupted() => return Err(failure),
            Err(failure) => failed.add(failure),
        }
    }
    failed.end("drawn")
}

/// Everything that changes pictures, apart from the scenarios.
#[derive(Serialize)]
struct RenderSettings<'a> {
    #[serde(flatten)]
    arguments: &'a Render,
    theme: &'a str,
    format: &'static str,
    view: Option<String>,
    plot: Vec<&'static str>,
    /// Steps of windows, as the configuration has them.
    usual_history: Option<usize>,
    /// What the user's file changes.
    thresholds: Vec<String>,
    /// The hash of a planner's drives.
    drives: Option<&'a str>,
    /// The hash of the table of predictions.
    #[serde(skip_serializing_if = "Option::is_none")]
    overlay: Option<String>,
}

/// Pictures of a scenario that are drawn at once.
const MOST_PICTURES: i64 = 20_000;

/// What a page plots unless something else is asked for.
const PAGE_MEASURES: [&str; 3] = ["ttc", "distance", "risk"];

/// The sentences on a page that tell what happened.
fn story(
    entry: &Entry,
    scene: Option<&Scene>,
    thresholds: &Thresholds,
) -> Result<Vec<String>, Failure> {
    let told = scene.map(|scene| ToldStory::new(entry, &Context::under(scene, thresholds)));
    let told = told.transpose().map_err(Failure::input)?.flatten();
    Ok(told.map_or_else(Vec::new, |told| told.sentences()))
}

/// What becomes of an interrupted run.
const INTERRUPTED: &str = "finished pictures are kept";

/// No ego is planned unless asked for; a note says that a picture has no ego.
fn without_ego(entry: &Entry) {
    output::say(&format!(
        "nearmiss: {}: drawn without an ego: no recording beside it; choose one with --ego ID|FILE, or plan one with `nearmiss plan -o`",
        entry.display()
    ));
}

/// The steps of a scenario that can be drawn.
struct Timeline<'a> {
    steps: std::ops::Range<i64>,
    /// Seconds between them.
    dt: f64,
    /// The step that is drawn unless another is named.
    telling: i64,
    scene: Option<&'a Scene>,
}

impl Drawing<'_> {
    /// The same as [`Drawing::render`], unless an earlier run has done it.
    fn render_once(&self, entry: &Entry, theme: &str, journal: &RunJournal) -> Outcome {
        if let Some(unit) = journal.unit::<(), ()>(entry, || Some(()))
            && let Unit::New((), earlier) = unit?
        {
            journal.write(entry, earlier, || {
                self.target.take_written();
                self.render(entry, theme)?;
                Ok((self.target.take_written(), ()))
            })?;
        }
        Ok(())
    }

    fn render(&self, entry: &Entry, theme: &str) -> Outcome {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Failure::interrupted(INTERRUPTED));
        }
        if self.arguments.what == RenderContent::Screen {
            return self.screens(entry, theme);
        }
        if let Some(delay) = self.arguments.certificate.with_certificate {
            return self.beside_certificate(entry, delay);
        }
        if self.arguments.is_grid() {
            return self.grid(entry);
        }
        let opened = self.open(entry)?;
        let scenario;
        let subject = match &opened {
            Some((scene, doubts)) => {
                doubts.iter().for_each(|doubt| output::say(doubt));
                Subject::with_ego(scene)
            }
            None => {
                scenario = entry.read().map_err(Failure::input)?;
                if self.arguments.what == RenderContent::Map {
                    without_ego(entry);
                }
                Subject {
                    scenario: &scenario,
                    scene: None,
                }
            }
        };
        let mut look = FigureOptions {
            palette: self.palette.clone(),
            ..self.arguments.look(self.history)?
        };
        let is_page = self.target.format == Format::Html;
        if is_page && opened.is_some() {
            look.what = FigureContent::Both;
            if self.arguments.plot.is_empty() {
                look.measures = PAGE_MEASURES.into_iter().filter_map(measure).collect();
            }
        }
        let forecasts = self.forecasts_of(entry, &subject);
        let named =
            |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", entry.display()));
        let (original, missing) = match (self.arguments.what, &self.arguments.original) {
            (RenderContent::Plot, _) => (None, None),
            (_, Some(named)) => (Some(Original::named(entry, named)?), None),
            (_, None) => match Original::find(entry) {
                Ok(original) => (original, None),
                Err(why) => (None, Some(why)),
            },
        };
        let mut figure =
            Figure::new(subject, &entry.name, look, &self.thresholds).map_err(|e| match e {
                FigureError::NoEgo => named(&format!(
                    "{e}; --ego ID|FILE chooses one, `nearmiss plan -o` plans one, --what map needs none"
                )),
                e => named(&e),
            })?;
        if let Some(original) = &original {
            figure = figure.with_variations(original.variations(subject.scenario));
        }
        figure = figure.with_forecasts(&forecasts);
        let timeline = Timeline {
            steps: figure.steps(),
            dt: subject.scenario.dt(),
            telling: figure.telling_step(),
            scene: opened.as_ref().map(|(scene, _)| &**scene),
        };
        let steps = self.steps(entry, &timeline)?;
        if is_page {
            let at = if self.arguments.at.is_empty() {
                timeline.telling
            } else {
                steps[0]
            };
            let page = figure.page(
                at,
                &self.dark,
                &story(entry, timeline.scene, &self.thresholds)?,
            );
            self.target.save(entry, None, page.as_bytes())?;
        } else {
            self.write(entry, &steps, subject.scenario.dt(), |step| {
                Ok(figure.at(step))
            })?;
        }
        // Not before: where nothing is drawn, nothing is drawn without something.
        if let Some(why) = missing {
            output::say(&format!(
                "nearmiss: {}: drawn without the original motion: {why}",
                entry.display()
            ));
        }
        Ok(())
    }

    fn open(&self, entry: &Entry) -> Result<Option<Opened>, Failure> {
        match self.ego {
            EgoSelection::Beside => scene_beside(entry),
            _ => scene_and_doubts(entry, &self.ego).map(Some),
        }
    }

    /// The steps that are drawn.
    fn steps(&self, entry: &Entry, timeline: &Timeline<'_>) -> Result<Vec<i64>, Failure> {
        let all = timeline.steps.clone();
        let worst = |by| worst_step(timeline.scene?, &self.thresholds, by);
        let at = self.arguments.at.iter();
        let at = at
            .map(|at| at.step("--at", &all, timeline.dt, worst))
            .collect::<Result<Vec<i64>, String>>()
            .map_err(|why| Failure::input(format!("{}: {why}", entry.display())))?;
        let count = all.end.saturating_sub(all.start);
        let is_whole = self.arguments.all || !self.target.format.is_picture();
        if is_whole && at.len() < 2 && count > MOST_PICTURES {
            return Err(Failure::input(format!(
                "{}: {count} time steps ({} to {}), but at most {MOST_PICTURES} pictures at once; choose steps with --at",
                entry.display(),
                all.start,
                all.end - 1
            )));
        }
        let whole = self.arguments.all || at.is_empty() && self.target.format.is_film();
        Ok(match (at.is_empty(), whole) {
            (_, true) => all.collect(),
            (true, false) => vec![timeline.telling],
            (false, false) => at,
        })
    }

    fn screens(&self, entry: &Entry, theme: &str) -> Outcome {
        let wanted = |step| ScreenRequest {
            entry: entry.clone(),
            ego: self.ego.clone(),
            size: self.arguments.cells(),
            step,
            obstacle: self.arguments.obstacle.first().copied(),
            measure: self.arguments.plot.first().copied(),
            theme: theme.to_string(),
        };
        let (_, telling) = (self.painter)(&wanted(None)).map_err(Failure::input)?;
        let scenario = entry.read().map_err(Failure::input)?;
        let opened = self.open(entry)?;
        let scene = opened.as_ref().map(|(scene, _)| &**scene);
        if scene.is_none() {
            without_ego(entry);
        }
        let timeline = Timeline {
            steps: scene.map_or_else(|| scenario.steps(), Scene::steps),
            dt: scenario.dt(),
            telling,
            scene,
        };
        let steps = self.steps(entry, &timeline)?;
        self.write(entry, &steps, scenario.dt(), |step| {
            let (screen, _) = (self.painter)(&wanted(Some(step)))?;
            Ok(screen.picture(Provenance {
                title: format!("nearmiss, {}", entry.name),
                description: format!(
                    "The workbench with the scenario {} at time step {step}.",
                    entry.name
                ),
                facts: vec![
                    (
                        "program",
                        concat!("nearmiss ", env!("CARGO_PKG_VERSION")).into(),
                    ),
                    ("scenario", entry.name.clone()),
                    ("sha256", scenario.hash.to_string()),
                    ("step", step.to_string()),
                ],
            }))
        })
    }

    fn write(
        &self,
        entry: &Entry,
        steps: &[i64],
        dt: f64,
        draw: impl Fn(i64) -> Result<Picture, String> + Sync,
    ) -> Outcome {
        let (target, dpi) = (&self.target, self.dpi);
        let named =
            |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", entry.display()));
        if target.format.is_film() {
            let drawn = |i: usize| draw(steps[i]);
            let ended = |drawn: Result<usize, AnimationError>| match drawn {
                Ok(_) => Ok(()),
                Err(_) if self.stop.load(Ordering::Relaxed) => {
                    Err(Failure::interrupted(INTERRUPTED))
                }
                Err(error) => Err(named(&error)),
            };
            let film = |out: &mut (dyn std::io::Write + Send)| {
                if target.format == Format::Gif {
                    return ended(animate(out, steps.len(), dt, dpi, drawn, self.stop));
                }
                // ffmpeg goes back in its file to write what lies where.
                let folder = tempfile::tempdir().map_err(|e| named(&e))?;
                let file = folder.path().join("film.mp4");
                ended(film(&file, steps.len(), dt, dpi, drawn, self.stop))?;
                let mut made = std::fs::File::open(&file).map_err(|e| named(&e))?;
                std::io::copy(&mut made, out).map_err(|e| named(&e))?;
                Ok(())
            };
            // One that is there already is compared as a whole.
            if self.arguments.many.resume {
                let mut bytes = Vec::new();
                film(&mut bytes)?;
                return target.save(entry, None, &bytes);
            }
            let mut file = target.begin(entry, None)?;
            film(&mut file)?;
            return file.finish();
        }
        let several = steps.len() > 1;
        let done = Job::new("pictures", self.stop).run(
            steps,
            |step| {
                let picture = draw(*step);
                let encoded = |picture| {
                    target
                        .format
                        .encode(&picture, dpi)
                        .map_err(|e| e.to_string())
                };
                Some(picture.and_then(encoded))
            },
            |step, bytes: Result<Vec<u8>, String>| {
                let bytes = bytes.map_err(|e| named(&e))?;
                target.save(entry, several.then_some(*step), &bytes)?;
                NEXT
            },
        );
        done.end(INTERRUPTED)
    }
}

/// Where pictures go, and how they are written.
struct Destination {
    place: Place,
    /// How.
    format: Format,
    overwrite: bool,
    /// Files that an earlier run wrote may be there.
    resumed: bool,
    /// Files of the present scenario.
    written: Mutex<Vec<PathBuf>>,
}

enum Place {
    Stdout,
    File(PathBuf),
    Folder(PathBuf),
}

impl Destination {
    /// The one that was asked for.
    fn new(arguments: &Render, entries: &[Entry]) -> Result<Self, Failure> {
        let steps = match (arguments.all, arguments.at.len()) {
            _ if arguments.is_grid() => 1,
            (true, _) => 2,
            (false, at) => at,
        };
        let whole = arguments.format.is_some_and(|format| !format.is_picture());
        let several =
            entries.len() > 1 || arguments.many.part.shard.is_some() || (steps > 1 && !whole);
        // Several pictures have no room in one file; without --format, an ending that was left out is asked for.
        let new_folder = |path: &Path| {
            several && arguments.format.is_some() && path.extension().is_none() && !path.exists()
        };
        let place = match &arguments.output {
            None => Place::Stdout,
            Some(path) if path.as_os_str() == "-" => Place::Stdout,
            Some(path) if path.is_dir() || new_folder(path) => Place::Folder(path.clone()),
            Some(path) => Place::File(path.clone()),
        };
        let of_name = match &place {
            Place::File(path) => Format::of_file(path),
            _ => None,
        };
        let format = match (arguments.format, of_name, &place) {
            (Some(asked), Some(named), Place::File(path)) if asked != named => {
                return Err(Failure::input(format!(
                    "--format {} contradicts the file name {}; drop --format or rename the file",
                    asked.name(),
                    path.display()
                )));
            }
            (None, None, Place::File(path)) => {
                let folder = match path.extension() {
                    None if several => ", and makes this a folder",
                    _ => "",
                };
                return Err(Failure::input(format!(
                    "{}: unknown file extension; known are .svg, .png, .gif, .mp4 and .html; --format works with any name{folder}",
                    path.display()
                )));
            }
            (asked, named, _) => asked.or(named).unwrap_or(Format::Svg),
        };
        if format.is_film() && arguments.is_grid() {
            return Err(Failure::input(
                "a grid is one picture, not a film: use .svg or .png",
            ));
        }
        if format.is_film() && steps == 1 {
            return Err(Failure::input(
                "a film needs several pictures: name several moments with --at, or none for every step",
            ));
        }
        let target = Self {
            place,
            format,
            overwrite: arguments.overwrite,
            resumed: arguments.many.resume,
            written: Mutex::default(),
        };
        match &target.place {
            Place::Folder(_) => target.without_clash(entries),
            _ if entries.len() > 1 => Err(Failure::input(format!(
                "pictures of {} scenarios need a folder: -o FOLDER, with --format if it does not exist yet",
                entries.len()
            ))),
            Place::Stdout if steps > 1 && format.is_picture() => Err(Failure::input(
                "several pictures need -o FOLDER, or -o NAME.svg or NAME.png for numbered files",
            )),
            _ => Ok(target),
        }
    }

    fn without_clash(self, entries: &[Entry]) -> Result<Self, Failure> {
        match clash(entries) {
            Some((a, b)) => Err(Failure::input(format!(
                "{} and {} would both be drawn as {}; draw them into separate folders",
                a.display(),
                b.display(),
                a.name
            ))),
            None => Ok(self),
        }
    }

    /// The folder, if pictures go into one.
    fn folder(&self) -> Option<&Path> {
        match &self.place {
            Place::Folder(folder) => Some(folder),
            _ => None,
        }
    }

    /// The files that were written since it was asked last.
    fn take_written(&self) -> Vec<PathBuf> {
        std::mem::take(&mut *self.written.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The file of a scenario, numbered by its step where there are several.
    fn path(&self, entry: &Entry, step: Option<i64>) -> Option<PathBuf> {
        let ending = self.format.name();
        let number = step.map_or(String::new(), |step| format!("_{step:04}"));
        match &self.place {
            Place::Stdout => None,
            Place::Folder(folder) => Some(folder.join(format!("{}{number}.{ending}", entry.name))),
            Place::File(path) if step.is_none() => Some(path.clone()),
            Place::File(path) => {
                let stem = path.file_stem().unwrap_or_default().to_string_lossy();
                let ending = path
                    .extension()
                    .map_or(ending.into(), |e| e.to_string_lossy());
                Some(path.with_file_name(format!("{stem}{number}.{ending}")))
            }
        }
    }

    /// Begins the file of a scenario.
    fn begin(&self, entry: &Entry, step: Option<i64>) -> Result<Target, Failure> {
        let path = self.path(entry, step);
        if let (Place::Folder(folder), Some(_)) = (&self.place, &path) {
            // Not before there is something to put into it.
            std::fs::create_dir_all(folder).map_err(|e| Failure::system(folder.display(), &e))?;
        }
        Target::begin_whole(path.as_deref(), self.overwrite)
    }

    /// Writes a whole picture.
    fn save(&self, entry: &Entry, step: Option<i64>, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.path(entry, step);
        if let Some(path) = &path {
            let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
            written.push(path.clone());
        }
        match path {
            Some(path) if self.resumed && holds(&path, bytes) => Ok(()),
            _ => self.begin(entry, step)?.save(bytes),
        }
    }
}
