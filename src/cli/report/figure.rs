//! Figures of a report: `report --figure bars -o f1.svg`.

use std::path::Path;

use super::{AnyReport, Format as Tables, ReportArguments, of_folder, of_store};
use crate::output::{self, Target};
use crate::{Failure, Outcome};
use nearmiss_render::{Format, Palette};
use nearmiss_study::evaluation::report::ReportFigure;

/// What the endings of names ask for.
const ENDINGS: &[(&str, Format)] = &[("svg", Format::Svg), ("png", Format::Png)];

/// Writes a figure of the answers that the arguments choose.
pub fn write(arguments: &ReportArguments, figure: ReportFigure, file: Option<&Path>) -> Outcome {
    let format = output::format_of(None, file, Format::Svg, (ENDINGS, ".svg and .png"))?;
    // Its notes go into the file.
    let made = match &arguments.folder {
        Some(folder) => of_folder::made(arguments, folder, Tables::Md)?.0,
        None => of_store::made(arguments, Tables::Md)?,
    };
    let palette = Palette::paper();
    let picture = match (&made, made.reports().next()) {
        (AnyReport::Pivot(pivot), _) => pivot.bars(palette),
        (_, Some(report)) => report.figure(figure, arguments.pivot.measure(), palette),
        (_, None) => return Err(Failure::input("--figure: nothing to draw")),
    };
    let named = |why: String| Failure::input(format!("--figure {}: {why}", figure.name()));
    let picture = picture.map_err(named)?;
    let bytes = format
        .encode(&picture, format.usual_dpi())
        .map_err(|error| named(error.to_string()))?;
    Target::begin(file, arguments.overwrite)?.save(&bytes)
}
