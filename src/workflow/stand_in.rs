//! Who is the ego of a scenario in which none is recorded: the built-in planner drives its planning problem, else the most
//! dangerous pair chooses.

use std::sync::Arc;

use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::Entry;
use nearmiss_scene::corpus::dangerous_follower;
use nearmiss_scene::metrics::{SEVERITY_NAMES, Thresholds};
use nearmiss_scene::scenario::{Diagnostic, Ego, Scenario, Scene, Severity};

use super::plan::prepare_opened;
use super::{INDEX_RADIUS, MissingEgo, OpenedScene};

/// Who is the ego where none is recorded.
#[derive(Debug, Clone, Copy)]
pub enum StandIn<'a> {
    /// None.
    None,
    /// Without a planning problem the follower of the most dangerous pair; with one none yet, as driving takes time.
    Follower,
    /// With a planning problem who is driven by the built-in planner with these settings; else that follower.
    Planner(&'a Settings),
}

impl StandIn<'_> {
    /// The scene of a scenario without a recorded ego.
    ///
    /// # Errors
    /// None stands in for it, or the planner cannot drive it.
    pub fn scene(self, entry: &Entry, scenario: &Arc<Scenario>) -> Result<Arc<Scene>, MissingEgo> {
        let has_problem = !scenario.planning_problems.is_empty();
        match self {
            Self::Planner(settings) if has_problem => driven(entry, scenario, settings),
            Self::Follower | Self::Planner(_) if !has_problem => follower(scenario),
            _ => None,
        }
        .unwrap_or(Err(MissingEgo::NotRecorded))
    }
}

/// The scene that the built-in planner drives; `None` where it was cancelled.
fn driven(
    entry: &Entry,
    scenario: &Arc<Scenario>,
    settings: &Settings,
) -> Option<Result<Arc<Scene>, MissingEgo>> {
    let opened = OpenedScene {
        scenario: Arc::clone(scenario),
        scene: Err(MissingEgo::NotRecorded),
        stands_in: false,
    };
    let planned = prepare_opened(entry, opened, None, settings)
        .and_then(|prepared| prepared.only_best().run(&Cancel::default(), &mut |_| {}));
    let outcome = match planned {
        Ok(outcome) => outcome?,
        Err(why) => {
            // It begins with the scenario, which is said already.
            let (said, shown) = (why.to_string(), format!("{}: ", entry.display()));
            let short = said.strip_prefix(&shown).unwrap_or(&said);
            return Some(Err(MissingEgo::NotDriven(short.to_string())));
        }
    };
    let problem = outcome.prepared.problem();
    let ego = outcome.drive.ego(problem, settings);
    let why = format!(
        "no ego is recorded, so the built-in planner drives planning problem {}",
        problem.id
    );
    Some(Ok(Arc::new(Scene::new(
        Arc::clone(scenario),
        noted(ego, why),
    ))))
}

/// The scene with the follower of the most dangerous pair as the ego; `None` where no two come near.
fn follower(scenario: &Arc<Scenario>) -> Option<Result<Arc<Scene>, MissingEgo>> {
    let (id, worst) = dangerous_follower(scenario, INDEX_RADIUS, Thresholds::shipped())?;
    let scene = Scene::with_obstacle_as_ego(Arc::clone(scenario), id).ok()?;
    let other = if worst.ego == id {
        worst.moment.obstacle
    } else {
        worst.ego
    };
    let why = format!(
        "no ego is recorded and no planning problem is given, so the ego is {id}, the follower of the most dangerous \
         pair: {id} and {other}, {} at {:.1} s",
        SEVERITY_NAMES[usize::from(worst.moment.grade.number())],
        scene.time_of(worst.moment.step),
    );
    let Scene { scenario, ego } = scene;
    Some(Ok(Arc::new(Scene {
        scenario,
        ego: noted(ego, why),
    })))
}

/// The ego with a note on why it is the ego.
fn noted(mut ego: Ego, message: String) -> Ego {
    let note = Diagnostic {
        severity: Severity::Note,
        line: 0,
        element: String::new(),
        message,
    };
    ego.diagnostics.insert(0, note);
    ego
}
