//! What the user's configuration says, as commands read it.

use std::collections::HashSet;

use nearmiss_ask::prompts::Defaults;
use nearmiss_base::system::unknown;
use nearmiss_drive::simulation::{Settings, TrafficMode};
use nearmiss_formats::TableOptions;
use nearmiss_render::{FigureOptions, Palette};
use nearmiss_scene::metrics::{Measure, OwnMeasures, Thresholds, measure, measures};
use nearmiss_scene::scenario::WindowRule;
use nearmiss_scene::verdict::Task;
use nearmiss_settings::{Config, Folders};
use nearmiss_study::evaluation::{Settings as Described, window_end};
use nearmiss_workflow::named_tables;

use crate::arguments::Names;
use crate::errors::Problem;

/// Folders, configuration and thresholds of the user; what ships with nearmiss where there is no home folder.
pub struct User {
    /// None without a home folder.
    pub folders: Option<Folders>,
    /// The configuration.
    pub config: Config,
    /// Thresholds of measures.
    pub thresholds: Thresholds,
}

impl User {
    /// Reads them.
    ///
    /// # Errors
    /// One of the files is wrong: with its lines.
    pub fn read() -> Result<Self, Problem> {
        let folders = Folders::find().ok();
        let (mut config, mut thresholds) = (Config::default(), Thresholds::shipped().clone());
        if let Some(folders) = &folders {
            let file = folders.config_file();
            config = Config::read(&file).map_err(|error| Problem::new(error.in_short()))?;
            thresholds = folders.user_thresholds()?;
            let own = Config::measures(&file);
            OwnMeasures::register(own.map_err(|error| Problem::new(error.in_short()))?);
        }
        Ok(Self {
            folders,
            config,
            thresholds,
        })
    }

    /// How figures look unless something else is asked for.
    pub fn look(&self) -> FigureOptions {
        let settings = Described {
            history: self.config.history,
            ..Described::default()
        };
        let history = settings.with(&Defaults::default()).history;
        FigureOptions {
            window: Some(WindowRule {
                end: window_end(Task::Collision),
                history,
            }),
            ..FigureOptions::default()
        }
    }

    /// The colours of pages where the browser prefers dark ones.
    ///
    /// # Errors
    /// The user's theme of that name is wrong.
    pub fn dark(&self) -> Result<Palette, Problem> {
        let themes = self.folders.as_ref().map(Folders::themes);
        Palette::named("dark", &themes.unwrap_or_default()).map_err(Problem::new)
    }

    /// How egos are driven that are not recorded.
    pub fn driving(&self) -> Settings {
        Settings {
            traffic: TrafficMode::Recorded,
            ..Settings::from(&self.config.planning())
        }
    }

    /// How tables of tracks are read, with these options over those of the configuration.
    ///
    /// # Errors
    /// The columns are not what columns are called.
    pub fn tables(
        &self,
        columns: Option<&str>,
        rate: Option<f64>,
        map: Option<std::path::PathBuf>,
    ) -> Result<TableOptions, Problem> {
        let columns = columns.map(str::parse).transpose();
        Ok(TableOptions {
            columns: columns.map_err(|error| Problem::new(format!("columns: {error}")))?,
            rate,
            map,
            named: named_tables(&self.config)?,
        })
    }
}

/// The measures with these names; all of them where none are named.
///
/// # Errors
/// One is not known, with what was probably meant.
pub fn named_measures(names: Option<Names>) -> Result<Vec<&'static Measure>, Problem> {
    let Some(names) = names else {
        return Ok(measures().collect());
    };
    let named = |name: String| {
        measure(&name)
            .ok_or_else(|| Problem::new(unknown("measure", &name, measures().map(|m| m.id))))
    };
    let mut found = names
        .all()
        .into_iter()
        .map(named)
        .collect::<Result<Vec<_>, _>>()?;
    let mut seen = HashSet::new();
    found.retain(|measure| seen.insert(measure.id));
    Ok(found)
}
