//! Figures of reports for papers: bars with intervals, curves by lead, reliability, cost against what is right.

use super::super::Share;
use super::super::statistics::{Interval, wilson};
use super::{Cell, Measure, Pivot, Report, ReportSubject, names};
use nearmiss_base::system::unknown;
use nearmiss_render::{
    Bar, BarChart, ChartAxis, ChartPoint, ChartSeries, Palette, Picture, PointChart, Provenance,
};
use nearmiss_scene::judge;

/// A figure of a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

impl ReportFigure {
    /// Every one.
    pub const ALL: [Self; 4] = [Self::Bars, Self::Leads, Self::Reliability, Self::Cost];

    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bars => "bars",
            Self::Leads => "leads",
            Self::Reliability => "reliability",
            Self::Cost => "cost",
        }
    }

    /// The one that this word is for.
    ///
    /// # Errors
    /// There is none: with those that it may mean.
    pub fn parse(word: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|one| one.name() == word);
        found.ok_or_else(|| unknown("figure", word, Self::ALL.map(Self::name)))
    }
}

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
        let cells: Vec<&Cell> = self.whole().collect();
        let tasks = cells
            .windows(2)
            .any(|pair| pair[0].way.task != pair[1].way.task);
        let name = |cell: &Cell| {
            if tasks {
                format!("{} · {}", cell.way.task.name(), names::way(&cell.way))
            } else {
                names::way(&cell.way)
            }
        };
        match figure {
            ReportFigure::Bars => {
                is_share(measure)?;
                let bar = |cell: &&Cell| Bar {
                    name: name(cell),
                    value: measure.value(cell),
                    interval: measure.interval(cell).map(ends),
                    n: cell.n,
                    apart: cell.way.model == judge::MODEL,
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
        for (_, way, point) in &self.varied.leads {
            let Some((y, interval)) = share(&point.yes) else {
                continue;
            };
            let name = names::way(way);
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
                Bar {
                    name: words.collect::<Vec<_>>().join(" · "),
                    value: measure.value(&one.cell),
                    interval: measure.interval(&one.cell).map(ends),
                    n: one.cell.n,
                    apart: one.cell.way.model == judge::MODEL,
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
