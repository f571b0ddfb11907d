//! `--grid` and `--case-study`: several moments in one picture, a variant's original above it.

use std::ops::Range;
use std::sync::Arc;

use super::arguments::GridShape;
use super::certificate::Original;
use super::{Drawing, Timeline, without_ego};
use crate::open::{Opened, scene_beside};
use crate::{Failure, Outcome, output};
use nearmiss_formats::Entry;
use nearmiss_render::{Figure, FigureGrid, FigureOptions, GridRow, PAGE, Subject};
use nearmiss_scene::metrics::{Context, MEASURES, Reading, Series, Thresholds};
use nearmiss_scene::scenario::{EgoSource, Scenario, Scene};

/// Columns of a case study unless others are asked for.
const COLUMNS: usize = 4;

impl std::fmt::Display for GridShape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.rows, self.columns)
    }
}

/// A scenario with or without its ego.
struct Drawn {
    scenario: Arc<Scenario>,
    scene: Option<Arc<Scene>>,
}

impl Drawn {
    fn new(entry: &Entry, opened: Option<Opened>) -> Result<Self, Failure> {
        match opened {
            Some((scene, doubts)) => {
                doubts.iter().for_each(|doubt| output::say(doubt));
                Ok(Self {
                    scenario: Arc::clone(&scene.scenario),
                    scene: Some(scene),
                })
            }
            None => {
                without_ego(entry);
                Ok(Self {
                    scenario: entry.read().map_err(Failure::input)?,
                    scene: None,
                })
            }
        }
    }

    fn subject(&self) -> Subject<'_> {
        Subject {
            scenario: &self.scenario,
            scene: self.scene.as_deref(),
        }
    }
}

impl Drawing<'_> {
    /// Draws several moments of a scenario in one picture.
    pub(super) fn grid(&self, entry: &Entry) -> Outcome {
        let arguments = self.arguments;
        let named =
            |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", entry.display()));
        let variant = Drawn::new(entry, self.open(entry)?)?;
        let original = if arguments.case_study || arguments.with_original {
            Some(self.original(entry)?)
        } else {
            None
        };
        let above = match &original {
            Some(original) => Some(Drawn::new(&original.entry, scene_beside(&original.entry)?)?),
            None => None,
        };
        let mut look = FigureOptions {
            palette: self.palette.clone(),
            ..arguments.look(self.history)?
        };
        if arguments.size.is_none() {
            look.size = (PAGE, None);
        }
        if let (Some(original), true) = (&original, look.obstacles.is_empty()) {
            look.obstacles = original.origin.ids();
        }
        let size = look.size;
        let forecasts = self.forecasts_of(entry, &variant.subject());
        let below = Figure::new(
            variant.subject(),
            &entry.name,
            look.clone(),
            &self.thresholds,
        )
        .map_err(|e| named(&e))?
        .with_forecasts(&forecasts);
        let top =
            match (&above, &original) {
                (Some(drawn), Some(original)) => {
                    let figure = Figure::new(
                        drawn.subject(),
                        &original.entry.name,
                        look,
                        &self.thresholds,
                    );
                    Some(figure.map_err(|e| {
                        Failure::input(format!("{}: {e}", original.entry.display()))
                    })?)
                }
                _ => None,
            };
        let steps = match (&original, arguments.case_study) {
            (Some(original), true) => self.case_steps(&variant, original).map_err(|e| named(&e))?,
            _ => {
                let timeline = Timeline {
                    steps: below.steps(),
                    dt: variant.scenario.dt(),
                    telling: below.telling_step(),
                    scene: variant.scene.as_deref(),
                };
                self.steps(entry, &timeline)?
            }
        };
        let shape = arguments.grid.unwrap_or(GridShape {
            rows: 2,
            columns: steps.len(),
        });
        let rows_of_steps = match &top {
            Some(_) => shape.rows / 2,
            None => shape.rows,
        };
        fits(shape, rows_of_steps, steps.len(), top.is_some()).map_err(|e| named(&e))?;
        let names = above.as_ref().map(|above| self.row_names(above));
        if let Some([original, variant]) = names {
            output::say(&format!("nearmiss: rows: {original}; {variant}"));
        }
        let above: Vec<i64> = match &top {
            Some(figure) => held(&steps, &figure.steps()),
            None => Vec::new(),
        };
        if let Some(last) = above.iter().zip(&steps).find(|(a, b)| a != b) {
            output::say(&format!(
                "nearmiss: the original has no step {}: its panel shows step {}, the nearest",
                last.1, last.0
            ));
        }
        let mut rows = Vec::new();
        let mut above = above.chunks(shape.columns);
        for steps in steps.chunks(shape.columns) {
            if let (Some(figure), Some(steps)) = (&top, above.next()) {
                rows.push(GridRow {
                    figure,
                    name: names.map(|names| names[0]),
                    steps,
                });
            }
            rows.push(GridRow {
                figure: &below,
                name: names.map(|names| names[1]),
                steps,
            });
        }
        let grid = FigureGrid {
            rows: &rows,
            seen: arguments.view,
            size,
        };
        let picture = grid.picture().map_err(|e| named(&e))?;
        let bytes = self.target.format.encode(&picture, self.dpi);
        self.target
            .save(entry, None, &bytes.map_err(|e| named(&e))?)
    }

    /// What the rows of an original and of its variant are called, and whose motion is the ego's.
    fn row_names(&self, original: &Drawn) -> [&'static str; 2] {
        let above = match original.scene.as_ref().map(|scene| &scene.ego.source) {
            Some(EgoSource::Planned { .. }) => "original, planned ego",
            Some(_) => "original, recorded ego",
            None => "original, without ego",
        };
        let below = if self.arguments.ego.is_beside() {
            "variant, planned ego"
        } else {
            "variant, chosen ego"
        };
        [above, below]
    }

    /// The original of a variant, which has to be there.
    fn original(&self, entry: &Entry) -> Result<Original, Failure> {
        let named =
            |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", entry.display()));
        if let Some(original) = &self.arguments.original {
            return Original::named(entry, original);
        }
        Original::find(entry).map_err(|e| named(&e))?.ok_or_else(|| {
            named(
                &"no original, as no manifest of `nearmiss generate` (NAME.json) is beside it; --case-study and --with-original need a variant",
            )
        })
    }

    /// The steps of a case study.
    fn case_steps(&self, variant: &Drawn, original: &Original) -> Result<Vec<i64>, String> {
        let scene = variant
            .scene
            .as_deref()
            .ok_or("--case-study needs the ego of the variant; --ego ID|FILE")?;
        let from = original.origin.from().saturating_add(1);
        let attacker = original.origin.manifest.attacker;
        let until = nearest_approach(scene, attacker, from, &self.thresholds).ok_or_else(|| {
            format!(
                "ego and attacker {attacker} are never there together from step {from} on, the first changed one"
            )
        })?;
        let columns = match self.arguments.grid {
            Some(grid) => grid.columns,
            // So many steps as there are.
            None => usize::try_from(until - from + 1).map_or(COLUMNS, |n| n.min(COLUMNS)),
        };
        spread(from, until, columns).ok_or_else(|| {
            let count = until - from + 1;
            let steps = output::counted(usize::try_from(count).unwrap_or(0), "step");
            format!(
                "--grid 2x{columns}: only {steps} from the first changed one ({from}) to the contact or nearest approach ({until}); use --grid 2x{count}"
            )
        })
    }
}

/// The first step from `from` on at which the bodies of the ego and an obstacle are closest: that of the contact, if
/// they touch.
fn nearest_approach(
    scene: &Scene,
    obstacle: i64,
    from: i64,
    thresholds: &Thresholds,
) -> Option<i64> {
    let context = Context::under(scene, thresholds);
    let distance = MEASURES.iter().filter(|m| m.id == "distance").collect();
    let series = Series::of_obstacle(&context, distance, obstacle);
    let steps = series.steps();
    let contact = series.contact(obstacle).map(|contact| contact.step);
    if let Some(contact) = contact.filter(|step| *step >= from) {
        return Some(contact);
    }
    let steps = steps.start.max(from)..steps.end;
    let gaps = steps.filter_map(|step| match series.at("distance", obstacle, step) {
        Reading::Value(gap) => Some((step, gap)),
        _ => None,
    });
    let nearest = gaps.min_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(nearest.0)
}

/// `count` steps from the first to the last at equal intervals, to the nearest step; of one, the last; nothing where
/// there are fewer.
fn spread(from: i64, until: i64, count: usize) -> Option<Vec<i64>> {
    let parts = i64::try_from(count).ok()? - 1;
    if until - from < parts {
        return None;
    }
    if parts == 0 {
        return Some(vec![until]);
    }
    let all = 0..=parts;
    Some(
        all.map(|i| from + (2 * i * (until - from) + parts) / (2 * parts))
            .collect(),
    )
}

/// Whether the moments fill the panels.
fn fits(shape: GridShape, rows: usize, steps: usize, doubled: bool) -> Result<(), String> {
    let room = rows * shape.columns;
    if steps == room {
        return Ok(());
    }
    let panels = if doubled {
        format!(
            "{} panels, half of them of the original",
            shape.rows * shape.columns
        )
    } else {
        format!("{room} panels")
    };
    let study = if doubled && shape.rows == 2 {
        ", or let --case-study choose them"
    } else {
        ""
    };
    Err(format!(
        "--grid {shape} has {panels}, so it needs {}, but there {}; name as many with --at{study}, or choose another grid",
        output::counted(room, "moment"),
        if steps == 1 {
            "is 1".into()
        } else {
            format!("are {steps}")
        },
    ))
}

/// Of each step the nearest of those that there are: a planned ego may arrive later than the recorded one.
fn held(steps: &[i64], all: &Range<i64>) -> Vec<i64> {
    let last = (all.end - 1).max(all.start);
    steps
        .iter()
        .map(|step| (*step).clamp(all.start, last))
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_grid_of_an_original_and_its_variant_without_moments_names_case_study() {
        let shape = GridShape {
            rows: 2,
            columns: 3,
        };
        let wrong = fits(shape, 1, 1, true).unwrap_err();
        assert!(
            wrong.contains("there is 1; name as many with --at, or let --case-study"),
            "{wrong}"
        );
        assert!(
            !fits(shape, 2, 1, false)
                .unwrap_err()
                .contains("--case-study")
        );
    }

    #[test]
    fn where_the_original_has_no_step_the_nearest_one_is_shown() {
        assert_eq!(held(&[5, 20, 33], &(0..33)), [5, 20, 32]);
        assert_eq!(held(&[2, 4], &(3..9)), [3, 4]);
    }

    #[test]
    fn steps_are_spread_evenly_from_the_first_to_the_last() {
        assert_eq!(spread(10, 40, 4), Some(vec![10, 20, 30, 40]));
        assert_eq!(spread(10, 15, 3), Some(vec![10, 13, 15]));
        assert_eq!(spread(10, 12, 3), Some(vec![10, 11, 12]));
        assert_eq!(spread(10, 12, 1), Some(vec![12]));
        assert_eq!(spread(10, 11, 3), None);
    }
}
