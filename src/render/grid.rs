//! Snapshots of several moments in one picture: rows and columns of maps with one scale.

use super::display::{Anchor, Area, Picture, Provenance, Text};
use super::figure::{Figure, MILLIMETRE};
use super::view::{MapExtent, View};
use nearmiss_base::geometry::{Bounds, Point, Pose};

/// Width of a page of a paper, points.
pub const PAGE: f64 = 170.0 * MILLIMETRE;

/// Between two panels, points.
const GAP: f64 = 5.0;

/// Room around the bodies of the common extent, metres.
const MARGIN: f64 = 8.0;

/// The common extent is at least so wide, metres.
const MIN_EXTENT: f64 = 30.0;

/// Height of a panel by its width, at least and at most.
const ASPECT: (f64, f64) = (0.45, 1.2);

/// A row of snapshots.
#[derive(Clone, Copy)]
pub struct GridRow<'a> {
    /// What is drawn.
    pub figure: &'a Figure<'a>,
    /// What stands beside the row.
    pub name: Option<&'a str>,
    /// The time steps, one a panel.
    pub steps: &'a [i64],
}

/// Several moments in one picture.
///
/// All panels have the same scale. Their extent: with `seen`, [`MapExtent::Ego`] follows the ego of each panel, the
/// others are the same place in all; without it, all show the smallest box around the egos and the obstacles that are
/// pointed out, in all panels, with 8 m around it, at least 30 m wide.
#[derive(Clone, Copy)]
pub struct FigureGrid<'a> {
    /// The rows, from above; those below the first look like the first.
    pub rows: &'a [GridRow<'a>],
    /// Which part of the map.
    pub seen: Option<MapExtent>,
    /// Width and height, points; without a height it follows from the extent.
    pub size: (f64, Option<f64>),
}

/// Why there is no grid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GridError {
    /// It has no row, or a row without a panel.
    #[error("a grid needs a panel")]
    Empty,
    /// The panels have no room.
    #[error("the panels are too small; choose a larger --size or fewer panels")]
    TooSmall,
    /// A map that follows the ego has none.
    #[error("{name}: no ego at step {step}, which the view ego follows; choose another --view")]
    NoEgo {
        /// The scenario.
        name: String,
        /// The time step.
        step: i64,
    },
}

/// A row's name, without its last parts (after ` · `, and then after a comma) where the row is too low for all of it.
fn fitting(name: &str, room: f64, size: f64) -> &str {
    let is_long = |name: &str| name.chars().count() as f64 * size * LETTER > room;
    let mut short = name;
    for sign in [" · ", ", "] {
        while is_long(short) {
            let Some((before, _)) = short.rsplit_once(sign) else {
                break;
            };
            short = before;
        }
    }
    short
}

/// Width of a letter on average, of its size.
const LETTER: f64 = 0.5;

/// A panel is at least so wide and high, points.
const MIN_PANEL_SIZE: f64 = 36.0;

impl FigureGrid<'_> {
    /// Draws it.
    ///
    /// # Errors
    /// See [`GridError`].
    pub fn picture(&self) -> Result<Picture, GridError> {
        let columns = self.rows.iter().map(|row| row.steps.len()).max();
        let first = self.rows.first().ok_or(GridError::Empty)?;
        let columns = columns.filter(|n| *n > 0).ok_or(GridError::Empty)?;
        let (width, height) = self.size;
        let named = self.rows.iter().any(|row| row.name.is_some());
        let gutter = if named { 12.0 } else { 0.0 };
        let between = |count: usize| GAP * (count - 1) as f64;
        let panel = (width - gutter - between(columns)) / columns as f64;
        let rows = self.rows.len();
        let up = self.up();
        let extent = self.common(up);
        let deep = match height {
            Some(height) => (height - between(rows)) / rows as f64,
            None => {
                let aspect = extent.map_or(0.68, |(_, size)| size.y / size.x);
                panel * aspect.clamp(ASPECT.0, ASPECT.1)
            }
        };
        if panel < MIN_PANEL_SIZE || deep < MIN_PANEL_SIZE {
            return Err(GridError::TooSmall);
        }
        let look = first.figure.look();
        let letters = (panel / 20.0).clamp(5.5, 8.0);
        let size = (width, deep * rows as f64 + between(rows));
        let mut picture = Picture::new(size, look.palette.background);
        picture.provenance = self.provenance();
        let at = |row: usize, column: usize| {
            let area = Area {
                x: gutter + (panel + GAP) * column as f64,
                y: (deep + GAP) * row as f64,
                width: panel,
                height: deep,
            };
            // Half of the frame's line would be cut off otherwise.
            area.grown(-0.25)
        };
        let shared = self.shared(up, extent, at(0, 0))?;
        for (place, row) in self.rows.iter().enumerate() {
            if let Some(name) = row.name {
                let spot = (letters + 1.0, at(place, 0).center().1);
                let text = Text {
                    upwards: true,
                    ..Text::new(
                        spot,
                        fitting(name, deep, letters + 1.0),
                        letters + 1.0,
                        look.palette.text,
                    )
                };
                picture.text(text.anchored(Anchor::Middle));
            }
            for (column, &step) in row.steps.iter().enumerate() {
                let area = at(place, column);
                let view = match shared {
                    Some(view) => View { area, ..view },
                    None => self.following(row, step, area)?,
                };
                // One scale bar for all.
                let bar = place + 1 == rows && column == 0;
                row.figure.draw_map(&mut picture, step, view, letters, bar);
            }
        }
        Ok(picture)
    }

    /// The direction that is up in panels that show the same place: that of the first one.
    fn up(&self) -> f64 {
        let first = self
            .rows
            .first()
            .and_then(|row| Some((row.figure, *row.steps.first()?)));
        first.map_or(std::f64::consts::FRAC_PI_2, |(figure, step)| {
            figure.subject().up(figure.look().ego_up, step)
        })
    }

    /// The view of all panels, but for their places on the page; `None` where each follows its ego.
    fn shared(
        &self,
        up: f64,
        extent: Option<(Point, Point)>,
        area: Area,
    ) -> Result<Option<View>, GridError> {
        let row = self.rows.first().ok_or(GridError::Empty)?;
        let step = *row.steps.first().ok_or(GridError::Empty)?;
        let whole = |seen| View::turned(seen, up, &row.figure.subject(), step, area);
        Ok(match (self.seen, extent) {
            (Some(MapExtent::Ego { .. }), _) => None,
            (Some(seen), _) => Some(whole(seen)),
            (None, Some((center, size))) => Some(View {
                frame: Pose {
                    position: center,
                    heading: up,
                },
                scale: (area.width / size.x).min(area.height / size.y),
                area,
            }),
            (None, None) => Some(whole(MapExtent::All)),
        })
    }

    /// The view of a panel around its ego.
    fn following(&self, row: &GridRow<'_>, step: i64, area: Area) -> Result<View, GridError> {
        let (figure, subject) = (row.figure, row.figure.subject());
        let ego = subject.scene.and_then(|scene| scene.ego.track.at(step));
        match (self.seen, ego) {
            (Some(seen), Some(_)) => {
                Ok(View::new(seen, figure.look().ego_up, &subject, step, area))
            }
            _ => Err(GridError::NoEgo {
                name: figure.name().to_string(),
                step,
            }),
        }
    }

    /// The middle of the common extent, and its width and height in the turned frame, metres; `None` where it is
    /// empty, or something else is wanted.
    fn common(&self, up: f64) -> Option<(Point, Point)> {
        if self.seen.is_some() {
            return None;
        }
        let turned = Pose {
            position: Point::origin(),
            heading: up,
        };
        let places = self.rows.iter().flat_map(|row| {
            let (subject, figure) = (row.figure.subject(), row.figure);
            row.steps.iter().flat_map(move |&step| {
                let ego = subject.scene.and_then(|scene| scene.ego.track.at(step));
                let pointed_out = figure
                    .obstacles()
                    .iter()
                    .filter_map(move |id| subject.scenario.obstacle(*id)?.track().at(step));
                ego.into_iter().chain(pointed_out)
            })
        });
        let places: Vec<Point> = places
            .map(|motion| turned.to_local(&motion.pose.position))
            .collect();
        let bounds = Bounds::from_points(&places)?;
        let size = bounds.max - bounds.min;
        // In the turned frame x is up and y to the left.
        let (width, height) = (size.y + 2.0 * MARGIN, size.x + 2.0 * MARGIN);
        let center = turned.to_world(&bounds.center());
        Some((center, Point::new(width.max(MIN_EXTENT), height)))
    }

    fn provenance(&self) -> Provenance {
        let figures: Vec<_> = self.rows.iter().map(|row| row.figure).collect();
        let all = |fact: &dyn Fn(&Figure<'_>) -> String| {
            let mut facts: Vec<String> = figures.iter().map(|figure| fact(figure)).collect();
            facts.dedup();
            facts.join("; ")
        };
        let steps = self.rows.iter().map(|row| {
            let steps: Vec<String> = row.steps.iter().map(i64::to_string).collect();
            steps.join(", ")
        });
        let names = all(&|figure| figure.name().to_string());
        let steps = steps.collect::<Vec<_>>().join("; ");
        Provenance {
            title: format!("{names}, several moments"),
            description: format!("The scene from above of {names} at the time steps {steps}."),
            facts: vec![
                (
                    "program",
                    concat!("nearmiss ", env!("CARGO_PKG_VERSION")).to_string(),
                ),
                ("scenario", names),
                (
                    "sha256",
                    all(&|figure| figure.subject().scenario.hash.to_string()),
                ),
                ("steps", steps),
                (
                    "ego",
                    all(&|figure| {
                        let ego = figure.subject().scene.map(|scene| scene.ego.to_string());
                        ego.unwrap_or_else(|| "none".into())
                    }),
                ),
            ],
        }
    }
}
