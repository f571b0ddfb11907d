//! Arguments of `render`, and which of them go together.

use std::path::PathBuf;

use serde::Serialize;

use super::certificate::CertificateOption;
use crate::Failure;
use crate::many_files::ManyFiles;
use crate::open::{EgoChoice, named_measure};
use crate::span::{AT, At, history};
use nearmiss_ask::prompts::Defaults;
use nearmiss_render::{FigureContent, FigureOptions, Format, MILLIMETRE, MapExtent, PIXEL};
use nearmiss_scene::metrics::Measure;
use nearmiss_scene::scenario::WindowRule;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::{Settings, window_end};

/// Arguments of `render`.
#[derive(Debug, clap::Args, Serialize)]
pub struct Render {
    /// Scenario files, folders or names of bundled scenarios.
    #[arg(required = true)]
    #[serde(skip)]
    pub paths: Vec<PathBuf>,
    #[command(flatten)]
    #[serde(flatten)]
    pub ego: EgoChoice,
    /// Moments to draw, separated by commas [default: worst]
    ///
    /// A time step (32), seconds (3.2s), worst (the most severe moment, see `nearmiss help measures`), or the worst by
    /// one measure: worst:risk, worst:ttc, worst:distance.
    #[arg(
        long,
        value_name = AT,
        value_delimiter = ',',
        allow_negative_numbers = true,
        conflicts_with = "all"
    )]
    pub at: Vec<At>,
    /// Draw every time step: an animation as GIF, numbered files as SVG or PNG. MP4 and HTML always contain every step.
    #[arg(long)]
    pub all: bool,
    /// Draw several moments in one picture, 170 mm wide: rows x columns of maps at one scale. Filled row by row with
    /// the moments of --at.
    #[arg(long, value_name = "ROWSxCOLUMNS", value_parser = grid_shape, conflicts_with = "all")]
    pub grid: Option<GridShape>,
    /// With --grid, draw the original above each row of a variant, at the same moments; half of the rows show the
    /// original.
    #[arg(long, requires = "grid")]
    pub with_original: bool,
    /// Draw a case study of a variant from `nearmiss generate`: the original above the variant, at equal intervals
    ///
    /// Begins at the first changed step and ends at the contact with the attacker or the closest approach. --grid 2xN
    /// sets the number of moments [default: 4].
    #[arg(long, conflicts_with_all = ["at", "all", "with_original"])]
    pub case_study: bool,
    #[command(flatten)]
    #[serde(flatten)]
    pub certificate: CertificateOption,
    /// What to draw.
    #[arg(long, value_enum, default_value = "map")]
    pub what: RenderContent,
    /// Part of the map in metres: ego, ego,WIDTH, all, or X,Y,WIDTH [default: ego, 60 m wide, or wide enough for the
    /// highlighted obstacle].
    #[arg(long, value_name = "VIEW", value_parser = MapExtent::parse, allow_hyphen_values = true)]
    #[serde(skip)]
    pub view: Option<MapExtent>,
    /// Original of a variant from `nearmiss generate`, to draw the attacker's original motion: a CommonRoad file or
    /// bundled scenario [default: from the variant's manifest].
    #[arg(long, value_name = "FILE")]
    pub original: Option<PathBuf>,
    /// Table of predicted trajectories to draw over the map: time, id, x and y in metres, optionally mode and
    /// probability; --columns names the columns.
    #[arg(long, value_name = "FILE", conflicts_with = "with_certificate")]
    #[serde(skip)]
    pub overlay: Option<PathBuf>,
    /// Rotate the map so that the ego drives upwards.
    #[arg(long)]
    pub rotate: bool,
    /// Obstacles to highlight and plot, separated by commas [default: that of the moment that matters].
    #[arg(
        long,
        value_name = "ID",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    pub obstacle: Vec<i64>,
    /// Measures to plot, separated by commas; `nearmiss metrics --list` lists them [default: distance; for a page ttc,
    /// distance, risk].
    #[arg(long, value_name = "MEASURE", value_delimiter = ',', value_parser = named_measure)]
    #[serde(skip)]
    pub plot: Vec<&'static Measure>,
    /// Task whose window plots shade: collision (at the end of the recording) or safety (up to the drawn moment)
    /// [default: collision].
    #[arg(long, value_name = "TASK")]
    pub task: Option<Task>,
    /// Steps in the shaded window [default: `history` in config.toml, else 10].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = history)]
    pub history: Option<u32>,
    /// Width and height, such as 85x60, 85x60mm or 800x600px, or a width only [default: 85mm wide]
    ///
    /// The unit of --what screen is columns and rows.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<Size>,
    /// Theme: paper (for print), dark, light, contrast, colorblind, or one of your own [default: paper; for --what
    /// screen your configured theme].
    #[arg(long, value_name = "NAME")]
    #[serde(skip)]
    pub theme: Option<String>,
    /// Resolution of PNG and GIF in pixels per inch [default: 300; 150 for GIF; 96 if the size is in pixels].
    #[arg(long, value_name = "N", value_parser = dpi)]
    pub dpi: Option<f64>,
    /// File or folder to write [default: SVG on standard output]
    ///
    /// Files end in .svg, .png, .gif, .mp4 (a film, needs ffmpeg) or .html (a page that plays the scenario). Several
    /// steps get numbered files. With --format and several pictures, a missing folder is created.
    #[arg(short, long, value_name = "PATH")]
    #[serde(skip)]
    pub output: Option<PathBuf>,
    /// Format: svg, png, gif, mp4 or html [default: from the file name].
    #[arg(long, value_name = "FORMAT", value_parser = format)]
    #[serde(skip)]
    pub format: Option<Format>,
    /// Replace existing files.
    #[arg(long)]
    #[serde(skip)]
    pub overwrite: bool,
    #[command(flatten)]
    #[serde(skip)]
    pub many: ManyFiles,
}

/// What is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RenderContent {
    /// The map from above.
    Map,
    /// Measures over time.
    Plot,
    /// The map, with measures over time below.
    Both,
    /// The workbench as shown in a terminal.
    Screen,
}

/// Rows and columns of a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct GridShape {
    pub rows: usize,
    pub columns: usize,
}

/// Rows or columns of a grid, at most.
const MOST_PANELS: usize = 12;

fn grid_shape(text: &str) -> Result<GridShape, String> {
    let count = |word: &str| {
        let count = word.trim().parse().ok();
        count.filter(|n| (1..=MOST_PANELS).contains(n))
    };
    let both = text.split_once(['x', '×']);
    both.and_then(|(rows, columns)| {
        Some(GridShape {
            rows: count(rows)?,
            columns: count(columns)?,
        })
    })
    .ok_or_else(|| format!("expected ROWSxCOLUMNS, such as 2x3, each from 1 to {MOST_PANELS}"))
}

/// A size as it was said.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Size {
    width: f64,
    height: Option<f64>,
    unit: Unit,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Unit {
    None,
    Millimetres,
    Pixels,
}

/// Columns and rows of a screen unless something else is asked for.
const CELLS: (u16, u16) = (160, 45);

/// Millimetres that a figure may be wide or high.
const MILLIMETRES: std::ops::RangeInclusive<f64> = 10.0..=2000.0;

fn size(text: &str) -> Result<Size, String> {
    let wrong = || {
        "expected WIDTHxHEIGHT in millimetres (85x60, 85x60mm) or pixels (800x600px), or only a width; 10 to 2000 mm"
            .to_string()
    };
    let (numbers, unit) = match (text.strip_suffix("mm"), text.strip_suffix("px")) {
        (Some(rest), _) => (rest, Unit::Millimetres),
        (_, Some(rest)) => (rest, Unit::Pixels),
        _ => (text, Unit::None),
    };
    let number = |word: &str| {
        word.trim()
            .parse::<f64>()
            .ok()
            .filter(|n| n.is_finite() && *n > 0.0)
    };
    let (width, height) = match numbers.split_once(['x', '×']) {
        Some((width, height)) => (width, Some(number(height).ok_or_else(wrong)?)),
        None => (numbers, None),
    };
    let width = number(width).ok_or_else(wrong)?;
    let factor = if unit == Unit::Pixels {
        PIXEL / MILLIMETRE
    } else {
        1.0
    };
    let fits = |n: f64| MILLIMETRES.contains(&(n * factor));
    if fits(width) && height.is_none_or(fits) {
        Ok(Size {
            width,
            height,
            unit,
        })
    } else {
        Err(wrong())
    }
}

fn format(name: &str) -> Result<Format, String> {
    Format::parse(&name.to_ascii_lowercase())
        .ok_or_else(|| "expected svg, png, gif, mp4 or html".into())
}

fn dpi(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok();
    let allowed = number.filter(|n| (10.0..=2400.0).contains(n));
    allowed.ok_or_else(|| "expected 10 to 2400 pixels per inch".into())
}

impl Render {
    /// Whether several moments are in one picture.
    pub fn is_grid(&self) -> bool {
        self.grid.is_some() || self.case_study
    }

    /// Refuses what does not go together.
    pub fn check(&self, format: Format) -> Result<(), Failure> {
        let page = format == Format::Html;
        let screen = self.what == RenderContent::Screen;
        let unit = self.size.map(|s| s.unit);
        let no_map = matches!(self.what, RenderContent::Plot | RenderContent::Screen);
        let wrong = if self.is_grid() && self.what != RenderContent::Map {
            "--grid and --case-study need --what map"
        } else if self.case_study && self.grid.is_some_and(|grid| grid.rows != 2) {
            "--case-study has two rows, the original and the variant: --grid 2xCOLUMNS"
        } else if self.with_original && self.grid.is_some_and(|grid| grid.rows % 2 == 1) {
            "--with-original needs an even number of rows: half of them are the original's"
        } else if screen && matches!(unit, Some(Unit::Millimetres | Unit::Pixels)) {
            "--what screen takes columns and rows: --size 160x45"
        } else if screen && self.size.is_some_and(|s| !s.is_cells()) {
            "--what screen takes whole columns and rows, 80x24 to 1000x1000"
        } else if screen && (self.obstacle.len() > 1 || self.plot.len() > 1) {
            "--what screen takes one --obstacle and one --plot measure"
        } else if no_map && self.view.is_some() {
            "--view needs a map: --what map or both"
        } else if no_map && self.rotate {
            "--rotate needs a map: --what map or both"
        } else if no_map && self.overlay.is_some() {
            "--overlay needs a map: --what map or both"
        } else if page && no_map {
            "a page has map and plots: remove --what"
        } else if page && (self.is_grid() || self.certificate.with_certificate.is_some()) {
            "a page shows one drive at every step: remove --grid, --case-study and --with-certificate"
        } else if page && (self.size.is_some() || self.task.is_some() || self.history.is_some()) {
            "a page fills its window and has all steps: remove --size, --task and --history"
        } else if page && self.at.len() > 1 {
            "a page opens at one moment: name one with --at"
        } else if no_map && self.original.is_some() {
            "--original needs a map: --what map or both"
        } else if self.what == RenderContent::Map && !self.plot.is_empty() && !page {
            "--plot needs --what plot or --what both"
        } else if matches!(self.what, RenderContent::Map | RenderContent::Screen)
            && (self.task.is_some() || self.history.is_some())
        {
            "--task and --history need --what plot or --what both"
        } else {
            return Ok(());
        };
        Err(Failure::input(wrong))
    }

    /// How the figure looks, but for its colours; `history` is that of the configuration.
    pub fn look(&self, history: Option<usize>) -> Result<FigureOptions, Failure> {
        let usual = FigureOptions::default();
        let what = match self.what {
            RenderContent::Map | RenderContent::Screen => FigureContent::Map,
            RenderContent::Plot => FigureContent::Plot,
            RenderContent::Both => FigureContent::Both,
        };
        let points = |size: Size| {
            let unit = if size.unit == Unit::Pixels {
                PIXEL
            } else {
                MILLIMETRE
            };
            (size.width * unit, size.height.map(|h| h * unit))
        };
        Ok(FigureOptions {
            what,
            seen: self.view.unwrap_or(usual.seen),
            ego_up: self.rotate,
            obstacles: self.obstacle.clone(),
            measures: if self.plot.is_empty() {
                usual.measures
            } else {
                self.plot.clone()
            },
            window: Some(self.window(history)),
            size: self.size.map_or(usual.size, points),
            palette: usual.palette,
        })
    }

    /// The question's window.
    fn window(&self, configured: Option<usize>) -> WindowRule {
        let history = self.history.map(|steps| steps as usize).or(configured);
        let settings = Settings {
            history,
            ..Settings::default()
        };
        WindowRule {
            end: window_end(self.task.unwrap_or(Task::Collision)),
            history: settings.with(&Defaults::default()).history,
        }
    }

    /// Columns and rows of a screen.
    pub fn cells(&self) -> (u16, u16) {
        let whole = |n: f64| n as u16;
        match self.size {
            Some(Size {
                width,
                height: Some(height),
                ..
            }) => (whole(width), whole(height)),
            _ => CELLS,
        }
    }

    /// Pixels of an inch.
    pub fn dpi(&self, format: Format) -> Result<f64, Failure> {
        if let (Some(_), Format::Svg | Format::Html) = (self.dpi, format) {
            return Err(Failure::input(format!(
                "--dpi needs PNG, GIF or MP4: {} has no pixels",
                format.name().to_uppercase()
            )));
        }
        let pixels = self.size.is_some_and(|s| s.unit == Unit::Pixels);
        Ok(match self.dpi {
            Some(dpi) => dpi,
            None if pixels => 96.0,
            // A cell of 4.5 points is 9 pixels wide then.
            None if self.what == RenderContent::Screen => 144.0,
            None => format.usual_dpi(),
        })
    }

    /// The name of the theme; of a screen that of the configuration.
    pub fn theme(&self, configured: Option<&str>) -> String {
        let usual = match self.what {
            RenderContent::Screen => configured.unwrap_or("dark"),
            _ => "paper",
        };
        self.theme.as_deref().unwrap_or(usual).to_string()
    }
}

impl Size {
    fn is_cells(self) -> bool {
        let whole = |n: f64, least: f64| n.fract() == 0.0 && (least..=1000.0).contains(&n);
        whole(self.width, 80.0) && self.height.is_some_and(|h| whole(h, 24.0))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn grids_are_rows_by_columns() {
        assert_eq!(
            grid_shape("2x3"),
            Ok(GridShape {
                rows: 2,
                columns: 3
            })
        );
        for wrong in ["", "2", "0x3", "2x13", "2x3x4", "-1x2"] {
            assert!(grid_shape(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes_are_read_and_nonsense_is_refused() {
        let read = |text| size(text).map(|s| (s.width, s.height, s.unit));
        assert_eq!(read("85x60"), Ok((85.0, Some(60.0), Unit::None)));
        assert_eq!(read("85.5x60mm"), Ok((85.5, Some(60.0), Unit::Millimetres)));
        assert_eq!(read("800x600px"), Ok((800.0, Some(600.0), Unit::Pixels)));
        assert_eq!(read("174mm"), Ok((174.0, None, Unit::Millimetres)));
        for wrong in [
            "", "x", "85x", "x60", "0x60", "-3x4", "nanx4", "infx4", "9x60", "1e9x1e9", "85x60cm",
            "10x10px",
        ] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
