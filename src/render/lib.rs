//! Pictures: figures of scenes, plots and screens as SVG, PNG and GIF, without another program; films by ffmpeg, and pages
//! that play a scenario in a browser.
//!
//! What is seen of a map is worked out once, in the world's coordinates and with roles for colours: a
//! [`scene`], which figures and the workbench draw. A figure is a list of things to draw, in
//! points; every format is written from that list.

mod animation;
pub mod cells;
mod chart;
mod clip;
mod display;
mod figure;
mod film;
mod glyphs;
mod grid;
mod map;
mod page;
mod palette;
mod plot;
mod raster;
pub mod scene;
mod screen;
mod storyboard;
mod svg;
#[cfg(test)]
mod tests;
mod view;

pub use animation::{AnimationError, animate};
pub use chart::{
    Axis as ChartAxis, Bar, BarChart, BoundaryChart, BoundaryPanel, ChartPoint, ChartSeries,
    JudgedEvent, PointChart, RateChart, RatePoint, TwoAxesChart, coverage_picture,
};
pub use display::{Anchor, Area, Format, Item, Picture, Provenance, Segment, Spot, Stroke, Text};
pub use figure::{
    COLUMN, Figure, FigureContent, FigureError, FigureOptions, MILLIMETRE, MapPage, PIXEL,
};
pub use film::film;
pub use grid::{FigureGrid, GridError, GridRow, PAGE};
pub use map::WorkbenchMap;
pub use palette::{Color, Palette};
pub use plot::{Ticks, runs, steps, value_range};
pub use raster::{MOST_PIXELS, RasterError, pixels, png, sixel};
pub use screen::{Cell, Screen, ScreenPainter, ScreenRequest};
pub use storyboard::{Storyboard, StoryboardPanel};
pub use svg::svg;
pub use view::{MapExtent, Subject, Variation, Variations};
