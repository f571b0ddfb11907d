//! Variants in pictures: the ideal driver who survives one (`--with-certificate`), and both motions of each attacker.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use nearmiss_drive::generation::{AttackerRecord, DELAYS};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_render::{
    Figure, FigureGrid, FigureOptions, GridRow, MapExtent, PAGE, Picture, Subject, Variation,
    Variations,
};
use nearmiss_scene::metrics::{Context, Series, Thresholds, measure};
use nearmiss_scene::scenario::{Scenario, Scene};
use nearmiss_workflow::VariantOrigin;
use serde::Serialize;

use super::arguments::RenderContent;
use super::{Drawing, Timeline};
use crate::open::{Opened, entry, scene_and_doubts};
use crate::{Failure, Outcome, output};

/// The ideal driver beside the drive in a variant.
#[derive(Debug, clap::Args, Serialize)]
pub struct CertificateOption {
    /// Draw the ideal driver of a variant's certificate below each map, with the gap of each.
    ///
    /// S is its reaction time in seconds, for variants from `nearmiss generate` [default: the longest that survives].
    /// With --all, -o FILE.gif makes a film.
    #[arg(long, value_name = "S", num_args = 0..=1, default_missing_value = "longest", value_parser = reaction, conflicts_with_all = ["grid", "case_study", "with_original", "ego"])]
    pub with_certificate: Option<Reaction>,
}

/// Reaction time of a certificate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Reaction {
    Longest,
    Seconds(f64),
}

/// A reaction time by its word.
fn reaction(word: &str) -> Result<Reaction, String> {
    let known = DELAYS.into_iter().find(|s| word.parse() == Ok(*s));
    match (word, known) {
        ("longest", _) => Ok(Reaction::Longest),
        (_, Some(seconds)) => Ok(Reaction::Seconds(seconds)),
        _ => {
            let known = DELAYS.map(|delay| format!("{delay:.1}"));
            Err(format!("expected one of {}", known.join(", ")))
        }
    }
}

/// A drive, and what is said beside its map.
struct Drive {
    name: String,
    scene: Arc<Scene>,
    gaps: Series,
}

impl Drive {
    fn new(name: String, scene: Arc<Scene>, thresholds: &Thresholds) -> Self {
        let context = Context::under(&scene, thresholds);
        let gaps = Series::from_context(&context, measure("distance").into_iter().collect());
        Self { name, gaps, scene }
    }

    /// The steps of the drive.
    fn steps(&self) -> Range<i64> {
        self.scene.ego.track.steps()
    }

    /// The step that is shown: before the start the first one, after the end the last one.
    fn at(&self, step: i64) -> i64 {
        let steps = self.steps();
        step.min(steps.end - 1).max(steps.start)
    }

    /// Whose drive it is, the gap to the nearest obstacle, and how it ends once it has ended.
    fn words(&self, step: i64) -> String {
        let shown = self.at(step);
        let gap = self.gaps.most_dangerous_at("distance", shown);
        let mut words = self.name.clone();
        if let Some((id, gap)) = gap {
            words += &format!(" · gap {gap:.1} m ({id})");
        }
        if step >= self.steps().end - 1 {
            let obstacles = self.gaps.obstacles().iter();
            let contacts = obstacles.filter_map(|id| self.gaps.contact(*id));
            words += if { contacts }.any(|contact| contact.step <= shown) {
                " · contact"
            } else {
                " · no contact"
            };
        }
        words
    }
}

impl Drawing<'_> {
    /// Draws a variant's two drives.
    pub(super) fn beside_certificate(&self, entry: &Entry, reaction: Reaction) -> Outcome {
        let named =
            |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", entry.display()));
        if self.arguments.what != RenderContent::Map {
            return Err(Failure::input("--with-certificate needs --what map"));
        }
        let (origin, planned, survived) = self.drives(entry, reaction)?;
        let mut look = FigureOptions {
            palette: self.palette.clone(),
            ..self.arguments.look(self.history)?
        };
        if self.arguments.size.is_none() {
            look.size = (PAGE / 2.0, None);
        }
        if look.obstacles.is_empty() {
            look.obstacles = origin.ids();
        }
        let (size, seen) = (look.size, look.seen);
        let drives = [planned, survived];
        let figures = drives.each_ref().map(|drive| {
            Figure::new(
                Subject::with_ego(&drive.scene),
                &entry.name,
                look.clone(),
                &self.thresholds,
            )
        });
        let [first, second] = figures;
        let figures = [
            first.map_err(|e| named(&e))?,
            second.map_err(|e| named(&e))?,
        ];
        let all = drives[0].steps().start.min(drives[1].steps().start)
            ..drives[0].steps().end.max(drives[1].steps().end);
        let dt = drives[0].scene.scenario.dt();
        let timeline = Timeline {
            steps: all,
            dt,
            telling: drives[0].steps().end - 1,
            scene: Some(&drives[0].scene),
        };
        let steps = self.steps(entry, &timeline)?;
        self.write(entry, &steps, dt, |step| {
            picture(&drives, &figures, step, (seen, size))
        })
    }

    /// What is known of a variant, the drive in it and the one that survives.
    fn drives(
        &self,
        entry: &Entry,
        reaction: Reaction,
    ) -> Result<(VariantOrigin, Drive, Drive), Failure> {
        let named =
            |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", entry.display()));
        let origin = VariantOrigin::read(entry).map_err(|why| named(&why))?;
        let origin = origin.ok_or_else(|| {
            named(
                &"no manifest of `nearmiss generate` (NAME.json) beside it; --with-certificate needs a variant",
            )
        })?;
        let delay = match reaction {
            Reaction::Longest => None,
            Reaction::Seconds(seconds) => Some(seconds),
        };
        let Some((delay, file)) = origin.certificate(delay) else {
            let known: Vec<&str> = origin.certificates().map(|(seconds, _)| seconds).collect();
            return Err(named(&match (delay, known.is_empty()) {
                (_, true) => "no ideal driver survives it, so there is no certificate".to_string(),
                (delay, false) => format!(
                    "no certificate for a reaction time of {:.1} s; there is one for {}",
                    delay.unwrap_or_default(),
                    known.join(", ")
                ),
            }));
        };
        let opened = |ego: &EgoSelection| -> Result<Arc<Scene>, Failure> {
            let (scene, doubts): Opened = scene_and_doubts(entry, ego)?;
            doubts.iter().for_each(|doubt| output::say(doubt));
            Ok(scene)
        };
        let planned = opened(&EgoSelection::Beside)?;
        let mut survived = Scene::clone(&*opened(&EgoSelection::File {
            path: file,
            planning_problem: None,
        })?);
        // A certificate is driven with the same vehicle; its recording cannot say so.
        survived.ego.footprint = planned.ego.footprint.clone();
        let planner = origin.planner();
        let thresholds = &self.thresholds;
        let survivor = format!("ideal driver, {delay:.1} s");
        Ok((
            origin,
            Drive::new(planner, planned, thresholds),
            Drive::new(survivor, Arc::new(survived), thresholds),
        ))
    }
}

/// Both drives at a step.
fn picture(
    drives: &[Drive; 2],
    figures: &[Figure<'_>; 2],
    step: i64,
    (seen, size): (MapExtent, (f64, Option<f64>)),
) -> Result<Picture, String> {
    let words = drives.each_ref().map(|drive| drive.words(step));
    let steps = drives.each_ref().map(|drive| [drive.at(step)]);
    let rows = [0, 1].map(|place| GridRow {
        figure: &figures[place],
        name: Some(&words[place]),
        steps: &steps[place],
    });
    let grid = FigureGrid {
        rows: &rows,
        seen: Some(seen),
        size,
    };
    grid.picture().map_err(|error| error.to_string())
}

/// A variant's original, and how the two differ.
pub struct Original {
    /// Where it is.
    pub entry: Entry,
    /// The original.
    pub scenario: Arc<Scenario>,
    /// What the manifest says of the variant.
    pub origin: VariantOrigin,
}

impl Original {
    /// The original of an entry; `None` if there is no manifest of `nearmiss generate` beside it.
    ///
    /// # Errors
    /// The original is not available, and why.
    pub fn find(entry: &Entry) -> Result<Option<Self>, String> {
        let Some(origin) = VariantOrigin::read(entry)? else {
            return Ok(None);
        };
        match origin.original() {
            Some((entry, scenario)) => Ok(Some(Self {
                entry,
                scenario,
                origin,
            })),
            None => Err(format!(
                "{}; name it with --original FILE",
                origin.missing()
            )),
        }
    }

    /// The scenario that `--original` names for an entry.
    ///
    /// # Errors
    /// It cannot be read, there is no manifest beside the entry, or it names another original.
    pub fn named(variant: &Entry, original: &Path) -> Result<Self, Failure> {
        let origin = VariantOrigin::read(variant)
            .map_err(Failure::input)?
            .ok_or_else(|| {
                Failure::input(format!(
                    "--original: {} has no manifest of `nearmiss generate` (NAME.json) beside it",
                    variant.display()
                ))
            })?;
        let entry = entry(original)?;
        let scenario = entry.read().map_err(Failure::input)?;
        if origin.is_original(&scenario) {
            Ok(Self {
                entry,
                scenario,
                origin,
            })
        } else {
            Err(Failure::input(format!(
                "--original {}: its SHA-256 is {}, but {} was generated from {} with {}",
                original.display(),
                scenario.hash,
                variant.display(),
                output::visible(&origin.manifest.original.benchmark_id),
                output::visible(&origin.manifest.original.sha256)
            )))
        }
    }

    /// Both motions of each attacker, in a variant of this.
    pub fn variations<'a>(&'a self, variant: &'a Scenario) -> Variations<'a> {
        let both = |attacker: &AttackerRecord| {
            Some(Variation {
                recorded: self.scenario.obstacle(attacker.id)?,
                changed: variant.obstacle(attacker.id)?,
                from: attacker.from_step,
                shows_changed: true,
            })
        };
        self.origin
            .manifest
            .attackers
            .iter()
            .filter_map(both)
            .collect()
    }
}
