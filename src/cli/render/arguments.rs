//! Arguments of `render`, and which of them go together.

use std::path::PathBuf;

use crate::cli::Failure;
use crate::cli::open::EgoChoice;
use crate::metrics::{MEASURES, Measure, measure};
use crate::render::{FigureContent, Format, Look, MILLIMETRE, MapExtent, PIXEL};

/// Arguments of `render`.
#[derive(Debug, clap::Args)]
pub struct Render {
    /// CommonRoad files or folders, or names of bundled scenarios.
    #[arg(required = true)]
    pub paths: Vec<PathBuf>,
    #[command(flatten)]
    pub ego: EgoChoice,
    /// The time steps that are drawn, separated by commas [default: the first one of the smallest distance].
    #[arg(
        long,
        value_name = "STEP",
        value_delimiter = ',',
        allow_negative_numbers = true,
        conflicts_with = "all"
    )]
    pub at: Vec<i64>,
    /// Every time step: an animation as GIF, numbered files as SVG or PNG.
    #[arg(long)]
    pub all: bool,
    /// What is drawn.
    #[arg(long, value_enum, default_value = "map")]
    pub what: RenderContent,
    /// Which part of the map, in metres: ego, ego,WIDTH, all, or X,Y,WIDTH [default: ego,60].
    #[arg(long, value_name = "VIEW", value_parser = MapExtent::parse, allow_hyphen_values = true)]
    pub view: Option<MapExtent>,
    /// What a variant of `nearmiss generate` was made of, a CommonRoad file or the name of a bundled scenario: drawn is
    /// the attacker's motion before the change, too [default: looked for where the variant's papers say].
    #[arg(long, value_name = "FILE")]
    pub original: Option<PathBuf>,
    /// Turn the map so that the ego drives upwards.
    #[arg(long)]
    pub rotate: bool,
    /// Obstacles that are pointed out, and plotted [default: the nearest one at its nearest].
    #[arg(
        long,
        value_name = "ID",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    pub obstacle: Vec<i64>,
    /// Measures that are plotted over time; `nearmiss metrics --list` names them [default: distance].
    #[arg(long, value_name = "MEASURE", value_delimiter = ',', value_parser = named_measure)]
    pub plot: Vec<&'static Measure>,
    /// Width and height: 85x60 or 85x60mm, 800x600px, or only a width; of a screen columns and rows [default: 85mm
    /// wide].
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<Size>,
    /// Colours: paper (for print), dark, light, contrast, colorblind, or a theme of yours [default: paper; of a
    /// screen yours].
    #[arg(long, value_name = "NAME")]
    pub theme: Option<String>,
    /// Pixels of an inch in PNG and GIF [default: 300; 150 of GIF; 96 where the size is in pixels].
    #[arg(long, value_name = "N", value_parser = dpi)]
    pub dpi: Option<f64>,
    /// The file to write, .svg, .png or .gif, or a folder; several steps are numbered. A folder is made where --format
    /// is said and there are several pictures [default: SVG on standard output].
    #[arg(short, long, value_name = "PATH")]
    pub output: Option<PathBuf>,
    /// svg, png or gif, where the name of the file does not say it.
    #[arg(long, value_name = "FORMAT", value_parser = format)]
    pub format: Option<Format>,
    /// Replace files that are there already.
    #[arg(long)]
    pub overwrite: bool,
}

/// What is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum RenderContent {
    /// The map from above.
    Map,
    /// Measures over time.
    Plot,
    /// The map, and measures over time below it.
    Both,
    /// The workbench in the terminal.
    Screen,
}

/// A size as it was said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    width: f64,
    height: Option<f64>,
    unit: Unit,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
        "a size is WIDTHxHEIGHT in millimetres (85x60, 85x60mm) or pixels (800x600px), or only a width; 10 to 2000 mm"
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
    match fits(width) && height.is_none_or(fits) {
        true => Ok(Size {
            width,
            height,
            unit,
        }),
        false => Err(wrong()),
    }
}

fn named_measure(id: &str) -> Result<&'static Measure, String> {
    measure(id).ok_or_else(|| {
        let ids: Vec<&str> = MEASURES.iter().map(|m| m.id).collect();
        format!("no measure `{id}`; there are {}", ids.join(", "))
    })
}

fn format(name: &str) -> Result<Format, String> {
    Format::parse(name).ok_or_else(|| "there are svg, png and gif".into())
}

fn dpi(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok();
    let allowed = number.filter(|n| (10.0..=2400.0).contains(n));
    allowed.ok_or_else(|| "10 to 2400 pixels of an inch".into())
}

impl Render {
    /// Refuses what does not go together.
    pub fn check(&self) -> Result<(), Failure> {
        let screen = self.what == RenderContent::Screen;
        let unit = self.size.map(|s| s.unit);
        let no_map = matches!(self.what, RenderContent::Plot | RenderContent::Screen);
        let wrong = if screen && matches!(unit, Some(Unit::Millimetres | Unit::Pixels)) {
            "the size of a screen is in columns and rows: --size 160x45"
        } else if screen && self.size.is_some_and(|s| !s.is_cells()) {
            "the size of a screen is whole columns and rows, 80x24 to 1000x1000"
        } else if screen && (self.obstacle.len() > 1 || self.plot.len() > 1) {
            "a screen shows one --obstacle as picked and one measure as --plot"
        } else if no_map && self.view.is_some() {
            "--view is about the map, and --what does not ask for one"
        } else if no_map && self.rotate {
            "--rotate is about the map, and --what does not ask for one"
        } else if no_map && self.original.is_some() {
            "--original is about the map, and --what does not ask for one"
        } else if self.what == RenderContent::Map && !self.plot.is_empty() {
            "--plot needs --what plot or --what both"
        } else {
            return Ok(());
        };
        Err(Failure::input(wrong))
    }

    /// How the figure looks, but for its colours.
    pub fn look(&self) -> Result<Look, Failure> {
        let usual = Look::default();
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
        Ok(Look {
            what,
            seen: self.view.unwrap_or(usual.seen),
            ego_up: self.rotate,
            obstacles: self.obstacle.clone(),
            measures: if self.plot.is_empty() {
                usual.measures
            } else {
                self.plot.clone()
            },
            size: self.size.map_or(usual.size, points),
            palette: usual.palette,
        })
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
        if let (Some(_), Format::Svg) = (self.dpi, format) {
            return Err(Failure::input(
                "--dpi is about pixels, and SVG has none; leave it out, or write PNG or GIF",
            ));
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
