//! A scenario with its ego: its tables, its worst moment, what happened, how it looks.

use std::path::PathBuf;
use std::sync::Arc;

use nearmiss_formats::{Entry, track_table};
use nearmiss_render::{Figure as Drawing, FigureContent, FigureOptions, Format, Subject};
use nearmiss_scene::corpus::IndexOptions;
use nearmiss_scene::metrics::{Context, Measure, Thresholds, measure};
use nearmiss_scene::scenario::{Scenario as Recorded, Scene};
use nearmiss_workflow::span::worst_step;
use nearmiss_workflow::tables::{
    RowFile, default_index_options, encounter_rows, encounter_table, encounters, exact_columns,
    exact_rows, in_order, index_table, lane_table, left_out, measure_table, window_rows,
};
use nearmiss_workflow::{MissingEgo, OpenedScene, Overview, SimulatedEgo, ToldStory, Verdicts};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::{Moment, Names, positive};
use crate::errors::Problem;
use crate::files::{OwnFolder, warn};
use crate::settings::{User, named_measures};
use crate::table::Table;
use crate::window::{Asked, Named, Window, description, json};
use crate::work;
use crate::write;

/// A scenario with its ego; `nearmiss.open` opens one.
#[pyclass(frozen, module = "nearmiss")]
#[derive(Clone)]
pub struct Scenario {
    /// Where it is.
    pub entry: Entry,
    /// What stands in the file.
    pub scenario: Arc<Recorded>,
    /// The same with its ego, or why there is none.
    pub opened: Result<Arc<Scene>, MissingEgo>,
    /// The ego that was asked for.
    pub asked: SimulatedEgo,
    /// Whether its ego stands in for one that is not recorded.
    pub stands_in: bool,
    /// The user's thresholds.
    pub thresholds: Arc<Thresholds>,
    /// What holds its file, where it came from a table in memory.
    pub folder: Option<Arc<OwnFolder>>,
}

impl Scenario {
    /// The scene with its ego.
    ///
    /// # Errors
    /// There is no ego, and what to do.
    pub fn scene(&self) -> Result<&Arc<Scene>, Problem> {
        self.opened.as_ref().map_err(|why| {
            let ids = self.scenario.possible_egos();
            let some: Vec<String> = ids.iter().take(8).map(i64::to_string).collect();
            Problem::new(format!(
                "{}: {why}; choose an obstacle with open(…, ego=ID): {}",
                self.entry.display(),
                if some.is_empty() {
                    "none has a trajectory".into()
                } else {
                    some.join(", ")
                }
            ))
        })
    }

    /// Its row among several, and its rank.
    pub fn overview(&self) -> Overview {
        let opened = OpenedScene {
            scenario: Arc::clone(&self.scenario),
            scene: self.opened.clone(),
            stands_in: false,
        };
        Overview::new(
            &self.entry,
            &opened,
            &self.thresholds,
            &Verdicts::default(),
            None,
        )
    }
}

#[pymethods]
impl Scenario {
    /// Its name: the file's, without the ending.
    #[getter]
    fn name(&self) -> &str {
        &self.entry.name
    }

    /// Its file.
    #[getter]
    fn file(&self) -> String {
        self.entry.display()
    }

    /// SHA-256 of its content.
    #[getter]
    fn hash(&self) -> String {
        self.scenario.hash.to_string()
    }

    /// Id of the ego; None where there is no ego.
    #[getter]
    fn ego(&self) -> Option<i64> {
        self.opened.as_ref().ok().map(|scene| scene.ego.id)
    }

    /// Seconds between time steps.
    #[getter]
    fn time_step(&self) -> f64 {
        self.scenario.dt()
    }

    /// The time steps of the ego, or of everybody where there is no ego.
    #[getter]
    fn steps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let steps = match &self.opened {
            Ok(scene) => scene.steps(),
            Err(_) => self.scenario.steps(),
        };
        py.import("builtins")?
            .getattr("range")?
            .call1((steps.start, steps.end))
    }

    /// What the reader had to say of the file: a line each.
    #[getter]
    fn diagnostics(&self) -> Vec<String> {
        self.scenario
            .diagnostics
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    fn __repr__(&self) -> String {
        let ego = match &self.opened {
            Ok(scene) => format!("ego {}", scene.ego.id),
            Err(_) => "no ego".into(),
        };
        let obstacles = self.scenario.obstacles.len();
        format!(
            "<nearmiss.Scenario {}: {obstacles} obstacles, {ego}>",
            self.entry.name
        )
    }

    /// Everyone's motion: a row a road user and time step, the ego among them.
    fn tracks(&self, py: Python<'_>) -> PyResult<Table> {
        Ok(py.detach(|| {
            let ego = self.opened.as_ref().ok().map(|scene| &scene.ego);
            let (table, rows) = track_table(&self.scenario, ego);
            Table::new(&table, rows)
        })?)
    }

    /// The lanes: a row a lanelet, its borders as lines in WKT.
    fn lanes(&self, py: Python<'_>) -> PyResult<Table> {
        Ok(py.detach(|| {
            let (table, rows) = lane_table(&self.scenario);
            Table::new(&table, rows)
        })?)
    }

    /// Safety measures: a row an obstacle and time step, as `nearmiss metrics` has them.
    ///
    /// names: the measures, such as ["ttc", "distance"]; None for all. `nearmiss help measures` explains them.
    /// radius: leave out obstacles whose centre is farther from that of the ego, metres.
    /// reasons: add a column NAME_reason for each measure: why a value is missing.
    #[pyo3(signature = (names=None, *, radius=None, reasons=false))]
    fn measures(
        &self,
        py: Python<'_>,
        names: Option<Names>,
        radius: Option<f64>,
        reasons: bool,
    ) -> PyResult<Table> {
        let measures = named_measures(names)?;
        let table = measures_of(&measures, &self.thresholds, reasons);
        let own = self.clone();
        Ok(work::run(py, move |_| {
            own.measured(&table, radius, &measures)
        })??)
    }

    /// Windows of all pairs of road users with manoeuvre, road, severity and the most dangerous values: a row a window, as
    /// `nearmiss corpus index` has them.
    ///
    /// length, stride: of a window and to the next one, seconds. radius: pairs that stay farther apart are left out, metres.
    /// measures: names; None for ten usual ones.
    #[pyo3(signature = (*, length=None, stride=None, radius=None, measures=None))]
    fn windows(
        &self,
        py: Python<'_>,
        length: Option<f64>,
        stride: Option<f64>,
        radius: Option<f64>,
        measures: Option<Names>,
    ) -> PyResult<Table> {
        let options = index_options(length, stride, radius, measures)?;
        let own = self.clone();
        Ok(work::run(py, move |_| own.index(&options))??)
    }

    /// Contacts, conflicts and near misses of the ego, and which drivers would have avoided each, until when: a row an
    /// encounter, as `nearmiss drivers` has them. `nearmiss.drivers` lists the drivers. Those that begin with the recording
    /// are a warning.
    fn encounters(&self, py: Python<'_>) -> PyResult<Table> {
        let own = self.clone();
        let (table, early) = work::run(py, move |_| own.judged())??;
        if let Some(words) = left_out(early) {
            warn(py, &format!("{}: {words}", self.entry.display()))?;
        }
        Ok(table)
    }

    /// The moment that matters, as a dict: `severity` from 0 (contact) to 5 (none), `moment` in seconds, `step`, `obstacle` and
    /// `what` in words. `ttc` and `distance` are the lowest of the whole recording with anyone. The other keys are those of
    /// `nearmiss.inspect`, whose `columns` explain them.
    fn worst<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.scene()?;
        let own = self.clone();
        let row = work::run(py, move |_| own.overview().row)?;
        json(py, &row)
    }

    /// What happened, in at most four sentences, and which drivers would have avoided it, in one.
    fn story(&self, py: Python<'_>) -> PyResult<String> {
        let scene = Arc::clone(self.scene()?);
        let (entry, thresholds) = (self.entry.clone(), Arc::clone(&self.thresholds));
        let told = work::run(py, move |_| {
            let told = ToldStory::new(&entry, &Context::under(&scene, &thresholds));
            told.map(|told| Some(told?.sentences().join(" ")))
        })?;
        Ok(told.map_err(Problem::new)?.ok_or_else(|| {
            let name = self.entry.display();
            Problem::new(format!(
                "{name}: nothing to tell: no other road user is there with the ego"
            ))
        })?)
    }

    /// A window of the scenario and what is asked about it, for `nearmiss.judge`, `prompt`, `ask` and `check`.
    ///
    /// task: collision, safety, recording, attacker or trajectory. at: the end of the window: a time step, seconds, a timedelta
    /// or "worst"; None for the last step of the recording, two steps earlier for safety. history: steps in the window.
    /// frame: ego, cartesian, metrics, trajectory or picture. techniques: such as "cp,cot,icl", "base" or "all".
    /// obstacle: the only obstacle that is described. More keywords are settings of the description, as of
    /// `nearmiss prompt show --set`: radius=30, form="compact", precision=2.
    #[pyo3(signature = (task="collision", *, at=None, history=None, frame=None, techniques=None, obstacle=None, **settings))]
    #[allow(clippy::too_many_arguments)]
    fn window(
        &self,
        py: Python<'_>,
        task: &str,
        at: Option<Moment>,
        history: Option<usize>,
        frame: Option<&str>,
        techniques: Option<&str>,
        obstacle: Option<i64>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Window> {
        let named = Named {
            at,
            history,
            obstacle,
        };
        let asked = Asked {
            task,
            frame,
            techniques,
        };
        Window::new(py, self, asked, named, settings)
    }

    /// A window of the scenario in words, as a model is told it; see `window`.
    #[pyo3(signature = (frame="ego", *, at=None, history=None, obstacle=None, **settings))]
    fn describe(
        &self,
        py: Python<'_>,
        frame: &str,
        at: Option<Moment>,
        history: Option<usize>,
        obstacle: Option<i64>,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<String> {
        description(
            py,
            self,
            frame,
            Named {
                at,
                history,
                obstacle,
            },
            settings,
        )
    }

    /// The map at a moment, and plots of measures below it; a notebook shows it.
    ///
    /// at: a time step, seconds, a timedelta, "worst" or "worst:ttc"; None for the moment that matters. plot: names of measures. ego_up: the
    /// ego drives upwards, not north.
    #[pyo3(signature = (at=None, *, plot=None, ego_up=false))]
    fn figure(
        &self,
        py: Python<'_>,
        at: Option<Moment>,
        plot: Option<Names>,
        ego_up: bool,
    ) -> PyResult<Figure> {
        let mut look = FigureOptions {
            ego_up,
            ..User::read()?.look()
        };
        if let Some(names) = plot {
            self.scene()?;
            look.what = FigureContent::Both;
            look.measures = named_measures(Some(names))?;
        }
        let (own, at) = (self.clone(), at.map(Moment::at).transpose()?);
        let drawn = work::run(py, move |_| {
            let figure = own.drawing(look)?;
            let worst = |by| worst_step(own.opened.as_ref().ok()?, &own.thresholds, by);
            let named = at.map(|at| at.step("at", &figure.steps(), own.scenario.dt(), worst));
            let telling = || figure.telling_step();
            Ok::<_, Problem>(Figure(
                figure.at(named.transpose()?.unwrap_or_else(telling)),
            ))
        })?;
        Ok(drawn?)
    }

    /// A page that plays the scenario in a browser, as HTML.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let (own, user) = (self.clone(), User::read()?);
        let page = work::run(py, move |_| {
            let mut look = user.look();
            let mut told = Vec::new();
            if let Ok(scene) = &own.opened {
                look.what = FigureContent::Both;
                look.measures = ["ttc", "distance", "risk"]
                    .into_iter()
                    .filter_map(measure)
                    .collect();
                let story = ToldStory::new(&own.entry, &Context::under(scene, &own.thresholds));
                let story = story.map_err(Problem::new)?;
                told = story.map_or_else(Vec::new, |story| story.sentences());
            }
            let figure = own.drawing(look)?;
            Ok::<_, Problem>(figure.page(figure.telling_step(), &user.dark()?, &told))
        })?;
        Ok(page?)
    }

    /// Writes the scenario in the format of the file's ending, as `nearmiss convert -o` does: .xml for CommonRoad 2020a with
    /// its ego beside it (NAME.ego_trajectory.csv), .xosc for OpenSCENARIO with its roads beside it (NAME.xodr), .csv,
    /// .parquet or .arrow for a table of tracks.
    ///
    /// The ego is the recorded one, or that of open(ego=…). One that stands in for a recorded one is left out, and in
    /// CommonRoad an obstacle stays an obstacle. What a format has no place for is a warning.
    ///
    /// overwrite: replace existing files; the scenario's own file only with all of it as CommonRoad.
    #[pyo3(signature = (path, *, overwrite=false))]
    fn write(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> PyResult<()> {
        write::write(py, self, path, overwrite)
    }
}

impl Scenario {
    /// These measures in a table with their columns.
    ///
    /// # Errors
    /// There is no ego.
    pub fn measured(
        &self,
        table: &nearmiss_record::Table,
        radius: Option<f64>,
        measures: &[&'static Measure],
    ) -> Result<Table, Problem> {
        positive("radius", radius)?;
        let scene = self.scene()?;
        let context = Context::under(scene, &self.thresholds);
        let file = RowFile::new(&self.entry, scene);
        Table::new(table, exact_rows(&file, &context, radius, measures))
    }

    /// Its encounters, and how many more no driver is judged in.
    ///
    /// # Errors
    /// There is no ego.
    pub fn judged(&self) -> Result<(Table, usize), Problem> {
        let scene = self.scene()?;
        let (found, early) =
            encounters(&self.entry, scene, &self.thresholds).map_err(Problem::new)?;
        let file = RowFile::new(&self.entry, scene);
        let rows = encounter_rows(&file, scene, &found);
        Ok((Table::new(&encounter_table(), rows)?, early))
    }

    /// Its windows.
    ///
    /// # Errors
    /// The recording beside it cannot be read.
    pub fn index(&self, options: &IndexOptions) -> Result<Table, Problem> {
        let table = index_table(options, &self.thresholds);
        let recorded = match &self.opened {
            // That of a drive is in no file.
            Ok(scene) if self.asked == SimulatedEgo::Planned => Some(scene.ego.clone()),
            _ => { self.entry.recorded_ego(&self.scenario) }.map_err(Problem::new)?,
        };
        let (rows, _) = window_rows(
            &self.entry,
            &self.scenario,
            recorded,
            options,
            &self.thresholds,
        );
        Table::new(&table, rows)
    }

    fn drawing(&self, look: FigureOptions) -> Result<Drawing<'_>, Problem> {
        let subject = match &self.opened {
            Ok(scene) => Subject::with_ego(scene),
            Err(_) => Subject {
                scenario: &self.scenario,
                scene: None,
            },
        };
        Drawing::new(subject, &self.entry.name, look, &self.thresholds)
            .map_err(|error| Problem::new(format!("{}: {error}", self.entry.display())))
    }
}

/// The table of these measures.
pub fn measures_of(
    measures: &[&'static Measure],
    thresholds: &Thresholds,
    reasons: bool,
) -> nearmiss_record::Table {
    let table = measure_table(exact_columns(measures), "exact", Some(thresholds), true);
    if reasons { table.with_reasons() } else { table }
}

/// How windows are measured: as usual unless something else is said.
pub fn index_options(
    length: Option<f64>,
    stride: Option<f64>,
    radius: Option<f64>,
    measures: Option<Names>,
) -> Result<IndexOptions, Problem> {
    let usual = default_index_options();
    for (name, value) in [("length", length), ("stride", stride), ("radius", radius)] {
        positive(name, value)?;
    }
    Ok(IndexOptions {
        length: length.unwrap_or(usual.length),
        stride: stride.unwrap_or(usual.stride),
        radius: radius.unwrap_or(usual.radius),
        measures: match measures {
            Some(names) => {
                let named = named_measures(Some(names))?;
                in_order(&named.iter().map(|m| m.id).collect::<Vec<_>>())
            }
            None => usual.measures,
        },
    })
}

/// A picture; a notebook shows it.
#[pyclass(frozen, module = "nearmiss")]
pub struct Figure(nearmiss_render::Picture);

#[pymethods]
impl Figure {
    /// The picture as SVG.
    #[getter]
    fn svg(&self) -> String {
        nearmiss_render::svg(&self.0)
    }

    fn _repr_svg_(&self) -> String {
        self.svg()
    }

    /// Writes it as .svg or .png.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        Ok(py.detach(|| {
            let named = Format::of_file(&path).filter(|format| format.is_picture());
            let format = named.ok_or_else(|| {
                Problem::new(format!("{}: a picture is .svg or .png", path.display()))
            })?;
            let encoded = format.encode(&self.0, format.usual_dpi());
            let bytes =
                encoded.map_err(|why| Problem::new(format!("{}: {why}", path.display())))?;
            nearmiss_base::system::save(&path, &bytes, true).map_err(Problem::new)
        })?)
    }
}
