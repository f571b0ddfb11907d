//! A scenario that was made dangerous, with all that is known about it, and the original to compare it with.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::authorship::{Authorship, Writer, Writing};
use super::planned::driven;
use super::{Opened, Planned};
use crate::generation::attacker::{self, Candidate};
use crate::generation::{
    Attack, Avoidability, Change, Chosen, ClosedLoop, Effect, Effort, Found, Gate, Ground, Passed,
    Progress, Refusal, Stage, Variant, choose, search_until,
};
use crate::metrics::Thresholds;
use crate::planner::Forecast;
use crate::scenario::commonroad;
use crate::scenario::{ContentHash, Entry, PlanningProblem, Scene, Transform, WantedEgo};
use crate::simulation::{Outcome, Settings};
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
    /// Of the random numbers of a search.
    pub seed: u64,
    /// The model that thinks of the attack, in place of a search.
    pub writer: Option<Box<Writer>>,
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
    /// A model chooses the attacker and writes motions.
    Writing(Writing),
    /// The ego is driven against motions that a model wrote: so many are done, of so many.
    Trying(usize, usize),
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
    /// Who could attack, by the reference, the least change first.
    pub ranked: Vec<Candidate>,
    /// Who thought of it.
    pub by: String,
    /// What the model chose and wrote, where one did.
    pub authorship: Option<Arc<Authorship>>,
    /// The same as its papers have it.
    pub author: Option<serde_json::Value>,
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
    /// A model made nothing dangerous: in words, and what it wrote.
    Unwritten(String, Arc<Authorship>),
}

/// What came of thinking: everything that was tried, and the best of it.
pub(super) struct Thought {
    pub found: Found,
    pub chosen: Option<Chosen>,
    /// Who thought.
    pub by: String,
    /// What a model wrote.
    pub authorship: Option<Authorship>,
}

/// How a search goes on.
pub struct How<'a> {
    /// How the ego is planned.
    pub settings: &'a Settings,
    /// How much is tried.
    pub effort: &'a Effort,
    /// Whether it shall end, asked more often than it tells how far it is.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

/// Who hears what is being done, and says whether to go on.
type Watch<'a> = &'a mut dyn FnMut(Working) -> bool;

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
            author: self.author.as_ref(),
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
        how: &How<'_>,
        watch: &mut dyn FnMut(Working) -> bool,
    ) -> Result<Option<Generated>, String> {
        let effort = Effort {
            seed: wish.seed,
            ..*how.effort
        };
        let mut think = |ground: &Ground<'_>, _: &Arc<Scene>, watch: Watch<'_>| {
            searched(ground, (&effort, wish.only), how.stop, watch)
        };
        Self::thought_of(wish, wanted, thresholds, how.settings, &mut think, watch)
    }

    /// The same, whoever thinks of the attack.
    pub(super) fn thought_of(
        wish: &Wish,
        wanted: &WantedEgo,
        thresholds: &Thresholds,
        settings: &Settings,
        think: Think<'_>,
        watch: Watch<'_>,
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
        if let Outcome::Collision(collision) = planned.outcome {
            return Err(format!(
                "the scenario is not safe as it is: the planned ego touches {collision}"
            ));
        }
        let scenario = original.scenario.clone();
        let mut problems = scenario.planning_problems.iter();
        let problem = problems.find(|problem| problem.id == planned.problem);
        let problem = problem.ok_or("the planning problem is gone")?;
        let closed = ClosedLoop::new(scenario.clone(), problem, settings);
        let closed = closed.map_err(|error| error.to_string())?;
        let (ranked, thought, passed) = {
            let stage = Stage::new(&scenario, &scene.ego.footprint, &scene.ego.track)
                .ok_or("the planned ego never moves: there is no way that anybody could cut off")?;
            let gate = Gate::new(&scenario).with_ego(&scene.ego);
            let ground = Ground {
                stage: &stage,
                gate: &gate,
                closed_loop: &closed,
            };
            let Some(thought) = think(&ground, scene, watch)? else {
                return Ok(None);
            };
            let chosen = thought.chosen.as_ref();
            let passed = chosen.map(|c| gate.passes(&c.attack.change, None));
            let passed = passed.transpose().map_err(|refusal| refusal.to_string())?;
            (attacker::rank(&stage), thought, passed)
        };
        let effective = |c: &Chosen| c.attack.has_effect();
        let (Some(chosen), Some(passed)) = (thought.chosen.filter(effective), passed) else {
            return Ok(Some(match thought.authorship {
                Some(wrote) => Generated::Unwritten(wrote.nothing(), Arc::new(wrote)),
                None => Generated::Nothing(nothing(&thought.found, wish)),
            }));
        };
        let author = thought.authorship.as_ref();
        let author = author.map(|wrote| wrote.authored.document(Some(&chosen.attack)));
        let who = (thought.by, wish.only);
        let mut made = made(who, closed, &thought.found, (chosen, passed))?;
        (made.author, made.ranked) = (author, ranked);
        if let Some(wrote) = thought.authorship {
            made.refused = wrote.authored.refusals();
            made.authorship = Some(Arc::new(wrote));
        }
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

/// Thinks of attacks, on the ego's drive in a scene; nothing where somebody said no.
pub(super) type Think<'a> =
    &'a mut dyn FnMut(&Ground<'_>, &Arc<Scene>, Watch<'_>) -> Result<Option<Thought>, String>;

fn searched(
    ground: &Ground<'_>,
    (effort, only): (&Effort, Option<i64>),
    stop: &(dyn Fn() -> bool + Sync),
    watch: Watch<'_>,
) -> Result<Option<Thought>, String> {
    let of = effort.candidates;
    if !watch(Working::Searching(Progress::default(), of)) {
        return Ok(None);
    }
    let mut goes_on = true;
    let mut round = |progress| {
        goes_on = watch(Working::Searching(progress, of));
        goes_on
    };
    let found = search_until(ground, effort, only, &mut round, stop);
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
    let chosen = choose(ground.closed_loop, &found.attacks, effort.delay);
    Ok(Some(Thought {
        found,
        chosen,
        by: effort.to_string(),
        authorship: None,
    }))
}

fn made(
    (by, only): (String, Option<i64>),
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
        only,
        ranked: Vec::new(),
        by,
        authorship: None,
        author: None,
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
