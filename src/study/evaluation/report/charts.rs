//! Figures of reports as SVG: bars with intervals, curves by lead, calibration, confusion matrices, cost.

use std::fmt::Write;

use nearmiss_record::escaped_html as escaped;
use nearmiss_render::{
    BarChart, ChartAxis, ChartPoint, ChartSeries, Palette, Picture, PointChart, Provenance,
};
use nearmiss_scene::judge;
use strum::{IntoStaticStr, VariantArray};

use super::super::statistics::{Bin, Interval, wilson};
use super::super::{Confusion, Share};
use super::{Cell, Measure, Pivot, Report, ReportSubject, names};

/// A figure of a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum ReportFigure {
    /// A measure of every way, with its interval.
    Bars,
    /// The share of dangerous windows called so, by lead.
    Leads,
    /// The share of true yeses by stated probability.
    Reliability,
    /// The cost of a question against the share that is right of all.
    Cost,
}

nearmiss_record::named!(ReportFigure, "figure");

impl Report {
    /// A figure of the report; `measure` is that of bars.
    ///
    /// # Errors
    /// The report has nothing to draw: what is missing.
    pub fn figure(
        &self,
        figure: ReportFigure,
        measure: Measure,
        palette: Palette,
    ) -> Result<Picture, String> {
        let cells: Vec<&Cell> = self.full_cells().collect();
        let tasks = cells
            .windows(2)
            .any(|pair| pair[0].configuration.task != pair[1].configuration.task);
        let name = |cell: &Cell| {
            if tasks {
                format!(
                    "{} · {}",
                    cell.configuration.task.name(),
                    names::configuration_name(&cell.configuration)
                )
            } else {
                names::configuration_name(&cell.configuration)
            }
        };
        match figure {
            ReportFigure::Bars => {
                is_share(measure)?;
                let bar = |cell: &&Cell| nearmiss_render::Bar {
                    name: name(cell),
                    value: measure.value(cell),
                    interval: measure.interval(cell).map(ends),
                    n: cell.n,
                    apart: cell.configuration.model == judge::MODEL,
                };
                let axis = format!("{}, intervals of 95 %", measure.title());
                Ok(BarChart {
                    provenance: self.provenance(&axis),
                    axis,
                    bars: cells.iter().map(bar).collect(),
                    palette,
                }
                .picture())
            }
            ReportFigure::Leads => self.lead_curves(palette),
            ReportFigure::Reliability => {
                let series = cells.iter().filter(|cell| cell.calibration.fit.n > 0);
                let series: Vec<ChartSeries> =
                    series.map(|cell| reliability(name(cell), cell)).collect();
                let axes = [
                    ("probability of a yes", (0.0, 1.0)),
                    ("share that is a yes", (0.0, 1.0)),
                ];
                let missing = "no verdict beside a truth";
                self.points(axes, series, true, missing, palette)
                    .map(|chart| {
                        PointChart {
                            diagonal: true,
                            ..chart
                        }
                        .picture()
                    })
            }
            ReportFigure::Cost => {
                let series: Vec<ChartSeries> = cells
                    .iter()
                    .filter_map(|cell| cost(name(cell), cell))
                    .collect();
                let most = farthest(&series);
                let axes = [
                    ("cost of a question (US dollars)", (0.0, most)),
                    ("right of all asked, intervals of 95 %", (0.0, 1.0)),
                ];
                let missing = "no way has both a known cost and a truth";
                self.points(axes, series, false, missing, palette)
                    .map(|chart| chart.picture())
            }
        }
    }

    fn lead_curves(&self, palette: Palette) -> Result<Picture, String> {
        let mut series: Vec<ChartSeries> = Vec::new();
        for (_, configuration, point) in &self.varied.leads {
            let Some((y, interval)) = share(&point.yes) else {
                continue;
            };
            let name = names::configuration_name(configuration);
            let point = ChartPoint {
                x: point.lead,
                y,
                interval: interval.map(ends),
            };
            match series.iter_mut().find(|one| one.name == name) {
                Some(one) => one.points.push(point),
                None => series.push(ChartSeries {
                    name,
                    points: vec![point],
                }),
            }
        }
        for one in &mut series {
            one.points.sort_by(|a, b| a.x.total_cmp(&b.x));
        }
        let most = farthest(&series);
        let axes = [
            ("lead: seconds before the contact", (0.0, most)),
            ("dangerous windows called so", (0.0, 1.0)),
        ];
        let missing = "the answers have no leads; `nearmiss evaluate --set leads=0.5,1,2` asks with several, and `nearmiss report --batch ID` has them";
        self.points(axes, series, true, missing, palette)
            .map(|chart| chart.picture())
    }

    fn points(
        &self,
        [across, up]: [(&str, (f64, f64)); 2],
        series: Vec<ChartSeries>,
        joined: bool,
        missing: &str,
        palette: Palette,
    ) -> Result<PointChart, String> {
        if series.is_empty() {
            return Err(missing.into());
        }
        let axis = |(name, range): (&str, (f64, f64))| ChartAxis {
            name: name.into(),
            range,
        };
        Ok(PointChart {
            provenance: self.provenance(up.0),
            across: axis(across),
            up: axis(up),
            series,
            joined,
            diagonal: false,
            palette,
        })
    }

    fn provenance(&self, title: &str) -> Provenance {
        provenance(&self.about, title)
    }
}

impl Pivot {
    /// Bars of the measure, one for each cell of the table, with its interval.
    ///
    /// # Errors
    /// The measure is no share.
    pub fn bars(&self, palette: Palette) -> Result<Picture, String> {
        let measure = self.request.measure;
        is_share(measure)?;
        let several = self.parts.len() > 1;
        let bars = self.parts.iter().flat_map(|part| {
            let task = part.task.filter(|_| several);
            part.cells.iter().map(move |one| {
                let words = task
                    .map(|task| task.name().to_string())
                    .into_iter()
                    .chain([one.row.text.clone()])
                    .chain(one.column.iter().map(|value| value.text.clone()));
                nearmiss_render::Bar {
                    name: words.collect::<Vec<_>>().join(" · "),
                    value: measure.value(&one.cell),
                    interval: measure.interval(&one.cell).map(ends),
                    n: one.cell.n,
                    apart: one.cell.configuration.model == judge::MODEL,
                }
            })
        });
        let axis = format!("{}, intervals of 95 %", measure.title());
        Ok(BarChart {
            provenance: provenance(&self.about, &axis),
            axis,
            bars: bars.collect(),
            palette,
        }
        .picture())
    }
}

/// Bars are of shares alone.
fn is_share(measure: Measure) -> Result<(), String> {
    match measure {
        Measure::Seconds | Measure::Cost => Err(format!(
            "bars show shares from 0 to 1, not {}",
            measure.name()
        )),
        _ => Ok(()),
    }
}

fn provenance(about: &ReportSubject, title: &str) -> Provenance {
    let mut facts = vec![(
        "program",
        concat!("nearmiss ", env!("CARGO_PKG_VERSION")).to_string(),
    )];
    facts.extend(about.batch.clone().map(|batch| ("batch", batch)));
    facts.push(("truth", about.truth.words.clone()));
    Provenance {
        title: title.into(),
        description: about.notes.join(" "),
        facts,
    }
}

fn ends(interval: Interval) -> (f64, f64) {
    (interval.low, interval.high)
}

/// A share and its interval; `None` of nothing.
fn share(share: &Share) -> Option<(f64, Option<Interval>)> {
    Some((share.value()?, share.interval))
}

fn reliability(name: String, cell: &Cell) -> ChartSeries {
    let bins = &cell.calibration.fit.bins;
    let points = bins.iter().filter_map(|bin| {
        Some(ChartPoint {
            x: bin.mean?,
            y: f64::from(bin.yes) / f64::from(bin.n),
            interval: wilson(bin.yes, bin.n).map(ends),
        })
    });
    ChartSeries {
        name,
        points: points.collect(),
    }
}

fn cost(name: String, cell: &Cell) -> Option<ChartSeries> {
    let questions = cell.n - cell.unasked;
    let usd = cell.consumption.cost_usd?;
    let point = ChartPoint {
        x: (questions > 0).then(|| usd / f64::from(questions))?,
        y: Measure::RightOfAll.value(cell)?,
        interval: Measure::RightOfAll.interval(cell).map(ends),
    };
    Some(ChartSeries {
        name,
        points: vec![point],
    })
}

/// The largest value across of all points, at least 0.
fn farthest(series: &[ChartSeries]) -> f64 {
    let points = series.iter().flat_map(|one| &one.points);
    points.map(|point| point.x).fold(0.0, f64::max)
}

/// A bar: its name, its value from 0 to 1, and its interval.
pub(super) struct Bar {
    pub name: String,
    pub value: Option<f64>,
    pub interval: Option<Interval>,
    /// Drawn in the second colour, and hatched in words by its name: the built-in judge.
    pub other: bool,
}

/// Width of the scale from 0 to 1, pixels.
const SCALE: f64 = 420.0;

fn svg(width: f64, height: f64, words: &str) -> String {
    let words = escaped(words);
    format!(
        "<svg viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" height=\"{height:.0}\" font-size=\"11\" \
         font-family=\"system-ui, sans-serif\" role=\"img\" aria-label=\"{words}\">\n"
    )
}

/// Bars from the left, one a line, each with its interval and its number.
pub(super) fn bars(title: &str, bars: &[Bar]) -> String {
    let letters = bars.iter().map(|b| b.name.chars().count()).max();
    let left = 6.5 * letters.unwrap_or(0) as f64 + 14.0;
    let (row, top) = (20.0, 8.0);
    let bottom = top + row * bars.len() as f64;
    let mut text = svg(left + SCALE + 150.0, bottom + 24.0, title);
    for tick in 0..=5 {
        let x = left + SCALE * f64::from(tick) / 5.0;
        let _ = writeln!(
            text,
            "<line class=\"grid\" x1=\"{x:.1}\" y1=\"{top}\" x2=\"{x:.1}\" y2=\"{bottom}\"/>\
             <text class=\"soft\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{:.1}</text>",
            bottom + 15.0,
            f64::from(tick) / 5.0
        );
    }
    for (i, bar) in bars.iter().enumerate() {
        let middle = top + row * (i as f64 + 0.5);
        let base = middle + 4.0;
        let _ = writeln!(
            text,
            "<text x=\"{:.1}\" y=\"{base:.1}\" text-anchor=\"end\">{}</text>",
            left - 8.0,
            escaped(&bar.name)
        );
        let Some(value) = bar.value else {
            let _ = writeln!(
                text,
                "<text class=\"soft\" x=\"{:.1}\" y=\"{base:.1}\">no value</text>",
                left + 6.0
            );
            continue;
        };
        let class = if bar.other { "other" } else { "bar" };
        let _ = writeln!(
            text,
            "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"12\"/>",
            middle - 6.0,
            SCALE * value
        );
        let mut words = format!("{value:.2}");
        if let Some(Interval { low, high }) = bar.interval {
            let (from, to) = (left + SCALE * low, left + SCALE * high);
            let (up, down) = (middle - 4.0, middle + 4.0);
            let _ = writeln!(
                text,
                "<path class=\"whisker\" d=\"M{from:.1} {up:.1}V{down:.1}M{from:.1} {middle:.1}H{to:.1}M{to:.1} {up:.1}V{down:.1}\"/>"
            );
            let _ = write!(words, " [{low:.2}, {high:.2}]");
        }
        let _ = writeln!(
            text,
            "<text x=\"{:.1}\" y=\"{base:.1}\">{words}</text>",
            left + SCALE + 12.0
        );
    }
    let _ = writeln!(
        text,
        "<line class=\"axis\" x1=\"{left:.1}\" y1=\"{top}\" x2=\"{left:.1}\" y2=\"{bottom}\"/></svg>"
    );
    text
}

/// The share of true collisions by tenths of the probability, with Wilson intervals, beside the diagonal.
pub(super) fn calibration(title: &str, bins: &[Bin]) -> String {
    let (left, top, side) = (34.0, 8.0, 200.0);
    let at = |probability: f64| left + side * probability;
    let up = |share: f64| top + side * (1.0 - share);
    let mut text = svg(left + side + 10.0, top + side + 54.0, title);
    for tick in [0.0, 0.5, 1.0] {
        let y = up(tick);
        let _ = writeln!(
            text,
            "<line class=\"grid\" x1=\"{left}\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{y:.1}\"/>\
             <text class=\"soft\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{tick:.1}</text>",
            left + side,
            left - 5.0,
            y + 4.0
        );
    }
    let _ = writeln!(
        text,
        "<line class=\"dash\" x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\"/>",
        at(0.0),
        up(0.0),
        at(1.0),
        up(1.0)
    );
    for tick in [0.0, 0.5, 1.0] {
        let _ = writeln!(
            text,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{tick:.1}</text>",
            at(tick),
            top + side + 16.0
        );
    }
    for (place, bin) in (0_u8..).zip(bins) {
        let (Some(mean), Some(Interval { low, high })) = (bin.mean, wilson(bin.yes, bin.n)) else {
            continue;
        };
        let (x, middle) = (at(mean), at((f64::from(place) + 0.5) / bins.len() as f64));
        let _ = writeln!(
            text,
            "<text class=\"soft\" x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"9\">{}</text>",
            top + side + 30.0,
            bin.n
        );
        let share = f64::from(bin.yes) / f64::from(bin.n);
        let _ = writeln!(
            text,
            "<path class=\"whisker\" d=\"M{x:.1} {:.1}V{:.1}\"/><circle class=\"bar\" cx=\"{x:.1}\" cy=\"{:.1}\" r=\"4\"/>",
            up(low),
            up(high),
            up(share)
        );
    }
    let _ = writeln!(
        text,
        "<text class=\"soft\" x=\"{left}\" y=\"{:.1}\">probability; verdicts</text></svg>",
        top + side + 46.0
    );
    text
}

/// The four counts as a square: truth in rows, verdict in columns, the darker the larger the share of its row.
pub(super) fn confusion(title: &str, c: &Confusion) -> String {
    let (left, top, side) = (62.0, 20.0, 58.0);
    let mut text = svg(left + 2.0 * side + 4.0, top + 2.0 * side + 6.0, title);
    for (i, word) in ["yes", "no"].into_iter().enumerate() {
        let at = side * (i as f64 + 0.5);
        let truth = ["collision", "normal"][i];
        let _ = writeln!(
            text,
            "<text class=\"soft\" x=\"{:.1}\" y=\"14\" text-anchor=\"middle\">{word}</text>\
             <text class=\"soft\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{truth}</text>",
            left + at,
            left - 6.0,
            top + at + 4.0
        );
    }
    let rows = [
        [
            (c.true_positives, "right", "TP"),
            (c.false_negatives, "wrong", "FN"),
        ],
        [
            (c.false_positives, "wrong", "FP"),
            (c.true_negatives, "right", "TN"),
        ],
    ];
    for (i, row) in rows.into_iter().enumerate() {
        let all = f64::from(row[0].0 + row[1].0).max(1.0);
        for (j, (count, class, name)) in row.into_iter().enumerate() {
            let (x, y) = (left + side * j as f64, top + side * i as f64);
            // Never so dark that the number cannot be read on it.
            let dark = 0.08 + 0.42 * f64::from(count) / all;
            let (mid, base) = (x + side / 2.0, y + side / 2.0);
            let _ = writeln!(
                text,
                "<rect class=\"{class}\" fill-opacity=\"{dark:.2}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{0:.1}\" \
                 height=\"{0:.1}\"/><text x=\"{mid:.1}\" y=\"{1:.1}\" text-anchor=\"middle\" font-size=\"16\">{count}\
                 </text><text class=\"soft\" x=\"{mid:.1}\" y=\"{2:.1}\" text-anchor=\"middle\">{name}</text>",
                side - 2.0,
                base + 2.0,
                base + 18.0
            );
        }
    }
    text + "</svg>\n"
}
