//! Data that tasks load and compute from scenario files: facts for the list, and opened scenarios.

mod driven;
mod generated;
mod planned;
mod source;

pub use driven::{DriverDrive, DriverSeat};
pub use generated::{
    AuthoringProgress, Authorship, GeneratedVariant, GenerationInputs, GenerationOutcome,
    GenerationProgress, GenerationStage, VariantRequest, VariantShown, Writer,
};
pub use nearmiss_workflow::{Facts, Tally, Verdicts, country_code};
pub use planned::{CycleShown, DriveFiles, DriveKey, PlannedEgo};
pub use source::Source;

use std::path::PathBuf;
use std::sync::Arc;

use nearmiss_drive::generation::{AttackerEffect, AttackerRecord};
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_render::scene::Basemap;
use nearmiss_render::{FigureOptions, Format, Screen, Variation, Variations};
use nearmiss_scene::judge::{Judgement, judge_collision, judge_recording};
use nearmiss_scene::metrics::{
    self, Contact, Context, CriticalMoment, Grade, Headline, Measure, Reading, SCENE_MEASURES,
    Series, Thresholds, measures,
};
use nearmiss_scene::scenario::{EgoSource, Scenario, Scene, Severity, Transform};
use nearmiss_study::evaluation::ScenePicture;
use nearmiss_workflow::{MissingEgo, OpenRequest, OpenedScene, StandIn, VariantOrigin, open};
use strum::{IntoStaticStr, VariantArray};

/// An opened scenario.
#[derive(Debug, Clone)]
pub struct Opened {
    /// Its name, with the change in brackets where there is one.
    pub name: String,
    /// Where it was read from.
    pub file: String,
    /// The change of the scene, if an answer was about a changed one.
    pub change: Option<Transform>,
    /// The scenario.
    pub scenario: Arc<Scenario>,
    /// Of its map what does not depend on time.
    pub basemap: Arc<Basemap>,
    /// The scenario with its ego, if it has one.
    pub scene: Option<Arc<Scene>>,
    /// Why there is no ego.
    pub no_ego: Option<MissingEgo>,
    /// Whether the ego's file was chosen, and is not just the one beside the scenario.
    pub chosen: bool,
    /// Distance, time to collision and risk over all steps.
    pub series: Option<Series>,
    /// The most dangerous values.
    pub headline: Option<Headline>,
    /// The built-in judge on the collision task.
    pub collision: Option<Judgement>,
    /// The built-in judge on the recording task.
    pub recording: Option<Judgement>,
    /// Obstacles, the most dangerous first.
    pub ranking: Vec<i64>,
    /// How the ego was planned, where it was.
    pub planned: Option<Arc<PlannedEgo>>,
    /// The variant that was made of it, where that or the original beside it is shown.
    pub variant: Option<VariantShown>,
    /// Its origin, where it is a variant that was saved.
    pub saved: Option<Arc<SavedVariant>>,
    /// The ideal driver who survives it, where it is a variant with a certificate.
    pub certificate: Option<Arc<CertificateDrive>>,
}

/// The measures that the workbench shows.
const SHOWN: [&str; 3] = ["distance", "ttc", "risk"];

impl Opened {
    /// Reads a scenario and works everything out with this ego. One that lies beside it is looked for, and where it is
    /// missing or broken, there is none.
    ///
    /// # Errors
    /// It cannot be read, or the obstacle or file that was asked for cannot be the ego.
    pub fn read(
        entry: &Entry,
        wanted: &EgoSelection,
        thresholds: &Thresholds,
    ) -> Result<Self, String> {
        Self::changed(entry, wanted, thresholds, None)
    }

    /// The same after a change of the scene, if there is one.
    ///
    /// # Errors
    /// As of [`Opened::read`]; or it has no ego, without which nothing can be changed.
    pub fn changed(
        entry: &Entry,
        wanted: &EgoSelection,
        thresholds: &Thresholds,
        change: Option<Transform>,
    ) -> Result<Self, String> {
        let mut opened = Self::alone(entry, wanted, thresholds, change)?;
        if change.is_none() {
            opened.saved = SavedVariant::new(entry, thresholds)?.map(Arc::new);
            let drive = CertificateDrive::saved(entry, &opened, thresholds);
            opened.certificate = drive.map(Arc::new);
        }
        Ok(opened)
    }

    /// The same without the original of a saved variant.
    fn alone(
        entry: &Entry,
        wanted: &EgoSelection,
        thresholds: &Thresholds,
        change: Option<Transform>,
    ) -> Result<Self, String> {
        let request = OpenRequest {
            entry,
            ego: wanted,
            transform: change,
            strict: false,
            stand_in: StandIn::Follower,
        };
        let OpenedScene {
            scenario, scene, ..
        } = open(&request).map_err(|error| error.to_string())?;
        let mut opened = Self::with(entry, change, scenario, scene, thresholds);
        opened.chosen = matches!(wanted, EgoSelection::File { .. } | EgoSelection::Planner(_));
        Ok(opened)
    }

    /// A scenario with this scene, with everything displayed of it computed, or why there is none.
    fn with(
        entry: &Entry,
        change: Option<Transform>,
        scenario: Arc<Scenario>,
        scene: Result<Arc<Scene>, MissingEgo>,
        thresholds: &Thresholds,
    ) -> Self {
        let (scene, no_ego) = match scene {
            Ok(scene) => (Some(scene), None),
            Err(why) => (None, Some(why)),
        };
        let measured = scene.as_deref().map(|scene| measured(scene, thresholds));
        let (series, headline) = measured.unzip();
        let judged = |judge: fn(&Scene, &Thresholds) -> Judgement| {
            scene.as_deref().map(|scene| judge(scene, thresholds))
        };
        let (collision, recording) = (judged(judge_collision), judged(judge_recording));
        Self {
            name: change.map_or_else(|| entry.name.clone(), |c| c.name(&entry.name)),
            change,
            file: entry.display(),
            ranking: { headline.as_ref().zip(series.as_ref()) }
                .map(|(headline, series)| ranking(headline, series))
                .unwrap_or_default(),
            basemap: Arc::new(Basemap::new(&scenario)),
            scenario,
            scene,
            no_ego,
            chosen: false,
            series,
            headline,
            collision,
            recording,
            planned: None,
            variant: None,
            saved: None,
            certificate: None,
        }
    }

    /// How many warnings there are about the scenario and its ego.
    #[must_use]
    pub fn warnings(&self) -> usize {
        let ego = self.scene.iter().flat_map(|s| &s.ego.diagnostics);
        let all = self.scenario.diagnostics.iter().chain(ego);
        all.filter(|d| d.severity == Severity::Warning).count()
    }

    /// The first contact of the ego.
    #[must_use]
    pub fn contact(&self) -> Option<&Contact> {
        self.headline.as_ref()?.contact.as_ref()
    }

    /// The moment that matters, where it is no contact, which has a mark of its own.
    #[must_use]
    pub fn worst_untouched(&self) -> Option<&CriticalMoment> {
        let worst = self.headline.as_ref().and_then(Headline::worst);
        worst.filter(|moment| moment.grade != Grade::Contact)
    }

    /// The steps to show: those of the ego, or of all obstacles where there is none.
    #[must_use]
    pub fn steps(&self) -> std::ops::Range<i64> {
        if let Some(scene) = &self.scene {
            return scene.steps();
        }
        self.scenario.steps()
    }

    /// Seconds from the first of these steps to the last.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        seconds(self.steps(), &self.scenario)
    }
}

/// Seconds from the first of these steps to the last.
fn seconds(steps: std::ops::Range<i64>, scenario: &Scenario) -> f64 {
    (steps.end - 1 - steps.start).max(0) as f64 * scenario.dt()
}

/// The shown measures of a scene, and what is most dangerous in it.
fn measured(scene: &Scene, thresholds: &Thresholds) -> (Series, Headline) {
    let wanted = |m: &&'static Measure| SHOWN.contains(&m.id);
    let context = Context::under(scene, thresholds);
    let series = Series::from_context(&context, measures().filter(wanted).collect());
    let headline = Headline::new(&context, &series);
    (series, headline)
}

/// Obstacles by their most severe moment; after the first those without a severe one as the judge has them: by the lowest
/// risk score, then the smallest distance.
fn ranking(headline: &Headline, series: &Series) -> Vec<i64> {
    let least = |measure, id| {
        let values = series.row(measure, id).iter().filter_map(|r| r.value());
        values.fold(f64::INFINITY, f64::min)
    };
    let order = |(place, moment): (usize, &CriticalMoment)| {
        let id = moment.obstacle;
        let is_severe = place == 0 || moment.grade.number() < Grade::Near.number();
        match is_severe.then_some(place as f64) {
            Some(place) => (id, [0.0, place, 0.0]),
            None => (id, [1.0, least("risk", id), least("distance", id)]),
        }
    };
    let mut all: Vec<_> = headline.moments.iter().enumerate().map(order).collect();
    all.sort_by(|(_, a), (_, b)| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    all.into_iter().map(|(id, _)| id).collect()
}

/// What the list is sorted by, where that is not known with the facts of a scenario.
#[derive(Debug, Clone, Default)]
pub struct Ranked {
    /// The most dangerous value of the measure; nothing without one, or without an ego.
    pub value: Option<f64>,
    /// What matters with the ego that stands in, where none is recorded.
    pub stand_in: Option<StandInEgo>,
}

/// What the list says of an ego that stands in for one that is not recorded.
#[derive(Debug, Clone)]
pub struct StandInEgo {
    /// The obstacle; `None` for a planned drive.
    pub obstacle: Option<i64>,
    /// What matters with it.
    pub headline: Headline,
    /// How long its motion is, seconds.
    pub seconds: f64,
}

impl StandInEgo {
    /// That of an opened scenario; `None` where its ego was recorded, or there is none.
    #[must_use]
    pub fn of(opened: &Opened) -> Option<Self> {
        let headline = opened.headline.clone()?;
        Self::new(opened.scene.as_deref()?, headline)
    }

    fn new(scene: &Scene, headline: Headline) -> Option<Self> {
        let obstacle = match scene.ego.source {
            EgoSource::Obstacle(id) => Some(id),
            EgoSource::Planned { .. } => None,
            _ => return None,
        };
        Some(Self {
            obstacle,
            headline,
            seconds: seconds(scene.steps(), &scene.scenario),
        })
    }
}

impl Ranked {
    /// That of a scenario with this ego; without a recorded one, the planner drives its planning problem, else an
    /// obstacle stands in.
    #[must_use]
    pub fn read(
        entry: &Entry,
        ego: &EgoSelection,
        order: &str,
        planning: &Settings,
        thresholds: &Thresholds,
    ) -> Self {
        let request = OpenRequest {
            entry,
            ego,
            transform: None,
            strict: false,
            stand_in: StandIn::Planner(planning),
        };
        let Ok(opened) = open(&request) else {
            return Self::default();
        };
        let Ok(scene) = opened.scene else {
            return Self::default();
        };
        let context = Context::under(&scene, thresholds);
        let value = metrics::measure(order).and_then(|measure| {
            let series = Series::from_context(&context, vec![measure]);
            let (_, value) = series.most_dangerous(measure.id)?;
            Some(value)
        });
        let stand_in = { opened.stands_in }
            .then(|| StandInEgo::new(&scene, Headline::from_context(&context)))
            .flatten();
        Self { value, stand_in }
    }
}

/// A measure over a scene, for the plot.
#[must_use]
pub fn plotted(scene: &Scene, measure: &'static Measure, thresholds: &Thresholds) -> Series {
    Series::from_context(&Context::under(scene, thresholds), vec![measure])
}

/// Every measure of one obstacle, and those of the whole scene, at every step.
#[derive(Debug)]
pub struct Measured {
    /// The obstacle; `None` if none is picked.
    pub obstacle: Option<i64>,
    /// Every measure of it.
    pub series: Series,
    /// Readings of [`SCENE_MEASURES`], by measure, then step.
    scene: Vec<Vec<Reading>>,
}

impl Measured {
    /// Works them out.
    #[must_use]
    pub fn new(scene: &Scene, obstacle: Option<i64>, thresholds: &Thresholds) -> Self {
        let context = Context::under(scene, thresholds);
        let all = || measures().collect();
        let series = match obstacle {
            Some(id) => Series::of_obstacle(&context, all(), id),
            None => Series::of_obstacle(&context, Vec::new(), i64::MIN),
        };
        let steps = || context.steps();
        let row = |m: &nearmiss_scene::metrics::SceneMeasure| {
            steps().map(|step| (m.compute)(&context, step)).collect()
        };
        Self {
            obstacle,
            scene: SCENE_MEASURES.iter().map(row).collect(),
            series,
        }
    }

    /// The readings of the whole scene at a step, in the order of [`SCENE_MEASURES`]; nothing outside its steps.
    #[must_use]
    pub fn scene_at(&self, step: i64) -> Option<Vec<Reading>> {
        let place = usize::try_from(step - self.series.steps().start).ok()?;
        self.scene
            .iter()
            .map(|row| row.get(place).copied())
            .collect()
    }
}

/// A saved variant's origin, with its original opened beside it.
#[derive(Debug)]
pub struct SavedVariant {
    /// What the certificate says.
    pub origin: VariantOrigin,
    /// The original, or why there is none.
    pub original: Result<(Entry, Box<Opened>), String>,
}

impl SavedVariant {
    /// Of a scenario; `None` where no certificate says that it is a variant.
    ///
    /// # Errors
    /// As of [`VariantOrigin::read`].
    fn new(entry: &Entry, thresholds: &Thresholds) -> Result<Option<Self>, String> {
        let Some(origin) = VariantOrigin::read(entry)? else {
            return Ok(None);
        };
        let original = match origin.original() {
            None => Err(origin.missing()),
            Some((entry, _)) => Opened::alone(&entry, &EgoSelection::Beside, thresholds, None)
                .map(|opened| (entry, Box::new(opened))),
        };
        Ok(Some(Self { origin, original }))
    }

    /// Both motions of each attacker, in this variant or its original; none where there is no original.
    #[must_use]
    pub fn variations<'a>(&'a self, variant: &'a Scenario, shows_changed: bool) -> Variations<'a> {
        let Ok((_, original)) = &self.original else {
            return Variations::default();
        };
        let both = |attacker: &AttackerRecord| {
            Some(Variation {
                recorded: original.scenario.obstacle(attacker.id)?,
                changed: variant.obstacle(attacker.id)?,
                from: attacker.from_step,
                shows_changed,
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

/// The certificate's drive in a variant.
#[derive(Debug)]
pub struct CertificateDrive {
    /// Reaction time of the driver, seconds: the longest one that survives.
    pub delay: f64,
    /// The variant with that drive as its ego.
    pub opened: Opened,
}

impl CertificateDrive {
    /// Of a variant that was just made; nothing where no ideal driver survives it.
    fn made(
        made: &GeneratedVariant,
        entry: &Entry,
        scenario: &Arc<Scenario>,
        thresholds: &Thresholds,
    ) -> Option<Self> {
        let certificates = made.avoidability.certificates.iter().rev();
        let mut survived = certificates.filter_map(|(delay, c)| Some((*delay, c.avoidance()?)));
        let (delay, avoidance) = survived.next()?;
        let driver = made.closed.driver();
        let ego = avoidance.drive.ego(driver.problem(), driver.settings());
        let scene = Arc::new(Scene::new(Arc::clone(scenario), ego));
        let opened = Opened::with(entry, None, Arc::clone(scenario), Ok(scene), thresholds);
        Some(Self { delay, opened })
    }

    /// Of a variant that was saved, from the file that its manifest names.
    fn saved(entry: &Entry, variant: &Opened, thresholds: &Thresholds) -> Option<Self> {
        let saved = variant.saved.as_ref()?;
        let (delay, path) = saved.origin.certificate(None)?;
        let from_file = EgoSelection::File {
            path,
            planning_problem: None,
        };
        let mut ego = from_file.resolve(entry, &variant.scenario).ok()??;
        // The same vehicle drives; a recording cannot say so.
        ego.footprint = variant.scene.as_ref()?.ego.footprint.clone();
        let scenario = Arc::clone(&variant.scenario);
        let scene = Arc::new(Scene::new(Arc::clone(&scenario), ego));
        let opened = Opened::with(entry, None, scenario, Ok(scene), thresholds);
        Some(Self { delay, opened })
    }
}

/// Subject of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum PictureKind {
    /// The map.
    Map,
    /// The plot.
    Plot,
    /// The map, and the plot below it.
    #[strum(to_string = "map_plot")]
    Both,
    /// The whole screen.
    Screen,
    /// The map at every step.
    Animation,
    /// The picture that models are shown with the question.
    Question,
}

nearmiss_record::named!(PictureKind);

/// A picture to be drawn and saved.
#[derive(Debug)]
pub struct PictureJob {
    /// Its subject.
    pub kind: PictureKind,
    /// How it is written.
    pub format: Format,
    /// Name of the scenario.
    pub name: String,
    /// The scenario.
    pub scenario: Arc<Scenario>,
    /// The scenario with its ego.
    pub scene: Option<Arc<Scene>>,
    /// The variant that is open, or whose original is.
    pub variant: Option<VariantShown>,
    /// The current step.
    pub step: i64,
    /// How it looks.
    pub look: FigureOptions,
    /// From where on values are dangerous.
    pub thresholds: Arc<Thresholds>,
    /// Where it is saved; the current folder if none.
    pub folder: Option<PathBuf>,
    /// The screen, when it is painted; or why it could not be.
    pub screen: Result<Option<Screen>, String>,
    /// The picture of the question, if its frame has one.
    pub shown: Option<ScenePicture>,
}

impl GeneratedVariant {
    /// Both motions of each attacker, beside the variant or its original.
    #[must_use]
    pub fn variations(&self, shows_changed: bool) -> Variations<'_> {
        let both = |attacker: &AttackerEffect| {
            Some(Variation {
                recorded: self.closed.scenario().obstacle(attacker.obstacle)?,
                changed: self.effect.scenario.obstacle(attacker.obstacle)?,
                from: attacker.from,
                shows_changed,
            })
        };
        self.effect.attackers.iter().filter_map(both).collect()
    }
}

impl VariantShown {
    /// Both motions of each attacker.
    #[must_use]
    pub fn variations(&self) -> Variations<'_> {
        self.made.variations(self.changed)
    }
}

impl PictureJob {
    /// Whether the screen is still to be painted.
    #[must_use]
    pub fn needs_screen(&self) -> bool {
        self.kind == PictureKind::Screen && self.screen == Ok(None)
    }
}
