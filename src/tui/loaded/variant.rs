//! A scenario that was made dangerous, with all that is known about it, and the original to compare it with.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::planned::driven;
use super::{Opened, Planned};
use crate::generation::{
    Attack, Avoidability, Change, Chosen, ClosedLoop, Effect, Effort, Found, Gate, Ground, Passed,
    Progress, Refusal, Stage, Variant, choose, search_watched,
};
use crate::metrics::Thresholds;
use crate::planner::Forecast;
use crate::scenario::commonroad;
use crate::scenario::{ContentHash, Ego, Entry, PlanningProblem, Scene, Transform, WantedEgo};
use crate::simulation::Settings;
use crate::verdict::Motion;

/// What is to be made.
#[derive(Debug, Clone)]
pub struct Wish {
    /// Of which scenario.
    pub entry: Entry,
    /// What of it is changed before.
    pub change: Option<Transform>,
    /// What the planner is told.
    pub forecast: Forecast,
    /// The one obstacle that may attack; anybody where none is named.
    pub only: Option<i64>,
    /// Of the random numbers.
    pub seed: u64,
    /// Where it would be saved, which decides its name; the current folder if none.
    pub folder: Option<PathBuf>,
}

/// What is being done about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Working {
    /// The ego is planned in the original: so many steps, of so many at most.
    Driving(usize, usize),
    /// Attacks are searched for: how far that is, and how many motions there are to try.
    Searching(Progress, usize),
    /// Ways out of the best attacks are searched for.
    Proving,
    /// The ego is planned in the variant: so many steps, of so many at most.
    Showing(usize, usize),
}

/// Everything that is known about a variant.
#[derive(Debug)]
pub struct Made {
    /// The original scenario and the ego's drive in it.
    pub closed: ClosedLoop,
    /// What was asked of the attacker.
    pub asked: Motion,
    /// What it does.
    pub change: Change,
    /// What that leads to.
    pub effect: Effect,
    /// Whether a good driver avoids it.
    pub avoidability: Avoidability,
    /// What the gate held it against.
    pub passed: Passed,
    /// What was refused on the way.
    pub refused: Vec<Refusal>,
    /// How far the search had come.
    pub progress: Progress,
    /// The one obstacle that was allowed to attack.
    pub only: Option<i64>,
    /// Who thought of it.
    pub by: String,
}

/// A variant that is shown, or the original beside it.
#[derive(Debug, Clone)]
pub struct VariantShown {
    /// The variant.
    pub made: Arc<Made>,
    /// Whether the variant is shown, and not the original.
    pub changed: bool,
}

/// What a search came to.
#[derive(Debug, Clone)]
pub enum Generated {
    /// A variant.
    Found {
        /// The original with its planned ego.
        original: Box<Opened>,
        /// The variant.
        variant: Box<Opened>,
    },
    /// Nothing dangerous: in words.
    Nothing(String),
}

impl Made {
    /// The variant as it is exported.
    #[must_use]
    pub fn variant(&self) -> Variant<'_> {
        Variant {
            closed: &self.closed,
            change: &self.change,
            asked: &self.asked,
            effect: &self.effect,
            avoidability: &self.avoidability,
            refusals: &self.refused,
            by: &self.by,
            made: None,
        }
    }

    /// The hash of the original.
    #[must_use]
    pub fn original(&self) -> ContentHash {
        self.closed.scenario().hash
    }

    /// The variant opened: under the name and with the hash of the file that would be saved, so that an answer about it
    /// is never taken for one about the original.
    fn opened(
        self,
        wish: &Wish,
        cycles: Vec<super::CycleShown>,
        thresholds: &Thresholds,
    ) -> Result<Opened, String> {
        let id = {
            let folder = wish.folder.as_deref().unwrap_or(Path::new("."));
            self.variant().free_id(folder)
        };
        let mut scenario = self.variant().scenario(&id);
        let bytes = commonroad::write(&scenario);
        let bytes = bytes.map_err(|error| format!("the variant has no file: {error}"))?;
        scenario.hash = ContentHash::of(&bytes);
        let scenario = Arc::new(scenario);
        let driver = self.closed.driver();
        let ego = self.effect.drive.ego(driver.problem(), driver.settings());
        let scene = Arc::new(Scene::new(scenario.clone(), ego));
        let planned = Planned {
            forecast: driver.settings().forecast,
            vehicle: driver.settings().planner.vehicle,
            problem: driver.problem().id,
            outcome: self.effect.drive.outcome,
            cycles,
            recorded: None,
        };
        let mut opened = Opened::with(&wish.entry, wish.change, scenario, Ok(scene), thresholds);
        opened.name = id;
        opened.planned = Some(Arc::new(planned));
        opened.variant = Some(VariantShown {
            made: Arc::new(self),
            changed: true,
        });
        Ok(opened)
    }
}

impl Opened {
    /// Makes a scenario dangerous: plans its ego, searches for attacks, takes the most dangerous one that a good driver
    /// survives, and opens the scenario with it. `watch` hears what is being done, and says whether to go on. Nothing
    /// where it said no.
    ///
    /// # Errors
    /// Nothing can be tried: those of [`Opened::planned`], or there is no obstacle that could attack.
    pub fn generated(
        wish: &Wish,
        wanted: &WantedEgo,
        thresholds: &Thresholds,
        (settings, effort): (&Settings, &Effort),
        watch: &mut dyn FnMut(Working) -> bool,
    ) -> Result<Option<Generated>, String> {
        let mut drives = |done, of| watch(Working::Driving(done, of));
        let how = (wish.change, settings);
        let original = Self::planned(&wish.entry, wanted, thresholds, how, &mut drives)?;
        let Some(original) = original else {
            return Ok(None);
        };
        let (Some(scene), Some(planned)) = (&original.scene, &original.planned) else {
            return Err("the ego was not planned".into());
        };
        let scenario = original.scenario.clone();
        let mut problems = scenario.planning_problems.iter();
        let problem = problems.find(|problem| problem.id == planned.problem);
        let problem = problem.ok_or("the planning problem is gone")?;
        if !watch(Working::Searching(Progress::default(), effort.candidates)) {
            return Ok(None);
        }
        let closed = ClosedLoop::new(scenario.clone(), problem, settings);
        let closed = closed.map_err(|error| error.to_string())?;
        let effort = Effort {
            seed: wish.seed,
            ..*effort
        };
        let tried = attack(&closed, &scene.ego, (&effort, wish.only), watch)?;
        let Some((found, chosen, passed)) = tried else {
            return Ok(None);
        };
        let (Some(chosen), Some(passed)) = (chosen.filter(|c| c.attack.has_effect()), passed)
        else {
            return Ok(Some(Generated::Nothing(nothing(&found, wish))));
        };
        let made = made(wish, closed, &found, (chosen, passed))?;
        let Some(cycles) = cycles(&made, problem, settings, watch)? else {
            return Ok(None);
        };
        let variant = made.opened(wish, cycles, thresholds)?;
        Ok(Some(Generated::Found {
            original: Box::new(original),
            variant: Box::new(variant),
        }))
    }
}

/// A search, its best attack, and what the gate says of that.
type Tried = (Found, Option<Chosen>, Option<Passed>);

fn attack(
    closed: &ClosedLoop,
    ego: &Ego,
    (effort, only): (&Effort, Option<i64>),
    watch: &mut dyn FnMut(Working) -> bool,
) -> Result<Option<Tried>, String> {
    let scenario = closed.scenario();
    let stage = Stage::new(scenario, &ego.footprint, &ego.track)
        .ok_or("the planned ego never moves: there is no way that anybody could cut off")?;
    let gate = Gate::new(scenario).with_ego(ego);
    let ground = Ground {
        stage: &stage,
        gate: &gate,
        closed_loop: closed,
    };
    let mut goes_on = true;
    let found = search_watched(&ground, effort, only, &mut |progress| {
        goes_on = watch(Working::Searching(progress, effort.candidates));
        goes_on
    });
    if !goes_on || !watch(Working::Proving) {
        return Ok(None);
    }
    if found.candidates == 0 {
        return Err(match only {
            Some(id) => format!(
                "{id} cannot attack: it does not move by itself, or never comes near enough to the ego"
            ),
            None => "nobody moves who could come near to the ego".into(),
        });
    }
    let chosen = choose(closed, &found.attacks, effort.delay);
    let passed = chosen.as_ref().map(|c| gate.passes(&c.attack.change, None));
    let passed = passed.transpose().map_err(|refusal| refusal.to_string())?;
    Ok(Some((found, chosen, passed)))
}

fn made(
    wish: &Wish,
    closed: ClosedLoop,
    found: &Found,
    (chosen, passed): (Chosen, Passed),
) -> Result<Made, String> {
    let Attack {
        asked,
        change,
        effect,
        ..
    } = chosen.attack;
    Ok(Made {
        closed,
        asked,
        change,
        effect: effect.ok_or("the ego was not driven against the attack")?,
        avoidability: chosen.avoidability,
        passed,
        refused: found.refused.clone(),
        progress: found.progress(),
        only: wish.only,
        by: format!("search, seed {}", wish.seed),
    })
}

/// What the planner saw and chose in the variant: the search does not keep that, and the same drive has the same
/// cycles.
fn cycles(
    made: &Made,
    problem: &PlanningProblem,
    settings: &Settings,
    watch: &mut dyn FnMut(Working) -> bool,
) -> Result<Option<Vec<super::CycleShown>>, String> {
    let mut drives = |done, of| watch(Working::Showing(done, of));
    let again = driven(&made.effect.scenario, problem, settings, &mut drives)?;
    Ok(again.map(|(_, cycles)| cycles))
}

/// Why there is no variant, in words.
fn nothing(found: &Found, wish: &Wish) -> String {
    let Progress {
        tried,
        refused,
        driven,
        ..
    } = found.progress();
    let who = wish.only.map_or("anybody".to_string(), |id| id.to_string());
    format!(
        "nothing dangerous was found for {who} with seed {}: of {tried} motions {refused} were refused, against \
         {driven} the ego was driven, and it got away or was only hit from behind",
        wish.seed
    )
}
