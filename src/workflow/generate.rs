//! Generates a dangerous variant: plans the ego, searches attacks, and takes the best one that is avoidable.

use std::sync::Arc;
use std::time::Duration;

use tokio::runtime::Handle;
use tokio::sync::mpsc::unbounded_channel;

use super::{PlanError, PlanEvent, PreparedPlan};
use nearmiss_drive::generation::{
    AllowedAttacks, AttackSetup, AttackStyle, Capability, ClosedLoop, Effort, GeneratorError,
    Progress, SearchEvent, Selection, VariantGenerator, Wish,
};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Outcome;
use nearmiss_scene::scenario::{ObstacleRole, Scene};
use nearmiss_study::evaluation::generating::{self, Author, AuthorError, Authored};

/// A request to generate a variant: the scenario, and the source of attacks.
pub struct GenerateRequest<'a> {
    /// The scenario and how its ego is planned.
    pub prepared: &'a PreparedPlan,
    /// The obstacles that may attack; any of them where none is named.
    pub attackers: &'a [i64],
    /// What the search is to look for; models are not told.
    pub wish: Option<&'a Wish>,
    /// Reaction time of the ideal driver who has to survive it, seconds.
    pub delay: f64,
    /// How attackers move.
    pub style: AttackStyle,
    /// Where attacks come from.
    pub source: AttackSource<'a>,
}

/// Source of attacks.
#[derive(Clone, Copy)]
pub enum AttackSource<'a> {
    /// A search, without any model.
    Search(&'a Effort),
    /// A language model.
    Model(&'a dyn AttackWriter),
}

/// Writes attacks.
pub trait AttackWriter {
    /// Writes them on some ground, about the ego's drive in a scene, which is the ground's baseline; an ideal driver with
    /// a reaction time of `delay` seconds has to survive them. Nothing where `cancel` asked for an end.
    ///
    /// # Errors
    /// Nothing could be asked.
    fn write(
        &self,
        ground: &AttackSetup<'_>,
        scene: &Arc<Scene>,
        delay: f64,
        cancel: &Cancel,
        on_progress: &mut dyn FnMut(generating::Progress),
    ) -> Result<Option<Authored>, AuthorError>;
}

/// A language model that writes attacks, asked on a runtime.
pub struct ModelWriter<'a> {
    /// The model and how it is asked.
    pub author: &'a Author,
    /// Where requests run; the calling thread is not one of its threads.
    pub runtime: &'a Handle,
}

/// Events while a variant is generated.
pub enum GenerateEvent<'a> {
    /// The ego is planned in the original.
    Planning(PlanEvent<'a>),
    /// A round of the search has ended, of so many motions in all.
    Searching(Progress, usize),
    /// The model is asked now.
    Asking,
    /// The model chose, wrote or was refused.
    Model(generating::Progress),
    /// The ego is driven against motions of the model: so many are done, of so many.
    Driving(usize, usize),
    /// Ways out of the best attacks are searched for.
    Certifying,
}

/// Result of a generation.
#[derive(Debug)]
pub struct Generation {
    /// The original with the ego's drive in it.
    pub workshop: VariantGenerator,
    /// Everything that was tried, and what was taken.
    pub made: Selection,
    /// What a model wrote, where one was asked.
    pub authored: Option<Authored>,
}

/// How soon the end that a user asks for is noticed while a model answers.
const POLL: Duration = Duration::from_millis(50);

/// Makes a scenario dangerous. Nothing where `cancel` asked for an end; what a model answered until then is in the
/// store. Nothing is searched and no model is asked where the planned ego touches something in the original.
///
/// # Errors
/// [`PlanError::Mismatch`]: the attacker is not there or does not move, or the model's question cannot be asked,
/// whatever the scenario. [`PlanError::NothingToPlan`]: the ego cannot be planned, or never moves.
/// [`PlanError::PlannerFailed`]: the planner's process fails in the scenario as it was recorded.
pub fn generate(
    request: &GenerateRequest<'_>,
    cancel: &Cancel,
    on_event: &mut dyn FnMut(GenerateEvent<'_>),
) -> Result<Option<Generation>, PlanError> {
    let prepared = request.prepared;
    let on_event = &mut |event: GenerateEvent<'_>| {
        if !cancel.is_asked() {
            on_event(event);
        }
    };
    for id in request.attackers {
        can_attack(prepared, *id)?;
    }
    let closed = {
        let mut planning = |event: PlanEvent<'_>| on_event(GenerateEvent::Planning(event));
        let mut watch = prepared.watch(&prepared.scenario, &mut planning);
        let driver = prepared.driver(&prepared.scenario, cancel);
        driver.map(|driver| {
            let scenario = Arc::clone(&prepared.scenario);
            ClosedLoop::of_driver(scenario, driver, &mut |planner, cycle| {
                watch(planner, cycle);
                !cancel.is_asked()
            })
        })
    };
    let closed = closed.map_err(|error| prepared.nothing(&error))?;
    if cancel.is_asked() {
        return Ok(None);
    }
    let baseline = closed.baseline().drive();
    if let (Outcome::PlannerError(_), Some(report)) = (baseline.outcome, &baseline.external)
        && let Some(failed) = prepared.failed(report)
    {
        return Err(failed);
    }
    let workshop = VariantGenerator::from_closed_loop(closed)
        .map_err(|error| prepared.nothing(&error))?
        .of_style(request.style);
    let found = if workshop.unsafe_already().is_some() {
        Ok(Some((Selection::default(), None)))
    } else {
        attack(request, &workshop, cancel, on_event)
    };
    let found = found.map_err(|error| match error {
        AttackError::Generator(error) => prepared.nothing(&error),
        AttackError::Author(error) => prepared.mismatch(&error),
    })?;
    Ok(found
        .filter(|_| !cancel.is_asked())
        .map(|(made, authored)| Generation {
            workshop,
            made,
            authored,
        }))
}

/// Whether an obstacle that was named can attack at all.
fn can_attack(prepared: &PreparedPlan, id: i64) -> Result<(), PlanError> {
    let obstacle = prepared
        .scenario
        .obstacle(id)
        .ok_or_else(|| prepared.mismatch(&format!("no obstacle {id}")))?;
    if obstacle.role != ObstacleRole::Dynamic
        || Capability::for_obstacle(obstacle, AttackStyle::Limit).is_none()
    {
        return Err(prepared.mismatch(&format!("obstacle {id} does not move by itself")));
    }
    Ok(())
}

enum AttackError {
    Generator(GeneratorError),
    Author(AuthorError),
}

/// Everything that was tried, and what a model wrote; `None` if it was cancelled.
type Attacked = Option<(Selection, Option<Authored>)>;

fn attack(
    request: &GenerateRequest<'_>,
    workshop: &VariantGenerator,
    cancel: &Cancel,
    on_event: &mut dyn FnMut(GenerateEvent<'_>),
) -> Result<Attacked, AttackError> {
    match request.source {
        AttackSource::Search(effort) => {
            let of = effort.motions();
            on_event(GenerateEvent::Searching(Progress::default(), of));
            let allowed = AllowedAttacks {
                among: request.attackers,
                wish: request.wish,
            };
            let made = workshop.search(effort, allowed, &mut |event| {
                on_event(match event {
                    SearchEvent::Round(progress) => GenerateEvent::Searching(progress, of),
                    SearchEvent::Certifying => GenerateEvent::Certifying,
                });
                !cancel.is_asked()
            });
            Ok(Some((made.map_err(AttackError::Generator)?, None)))
        }
        AttackSource::Model(writer) => {
            on_event(GenerateEvent::Asking);
            let scenario = Arc::clone(workshop.closed.scenario());
            let scene = Arc::new(Scene::new(scenario, workshop.ego.clone()));
            let asked = workshop.on(|ground| {
                let mut hear = |progress| on_event(GenerateEvent::Model(progress));
                let authored = writer.write(ground, &scene, request.delay, cancel, &mut hear);
                let Some(mut authored) = authored.map_err(AttackError::Author)? else {
                    return Ok(None);
                };
                let (of, delay) = (authored.attacks.len(), request.delay);
                let driven = authored.drive_watched(ground, delay, &mut |done| {
                    on_event(GenerateEvent::Driving(done, of));
                    !cancel.is_asked()
                });
                if !driven {
                    return Ok(None);
                }
                on_event(GenerateEvent::Certifying);
                if cancel.is_asked() {
                    return Ok(None);
                }
                Ok(Some((authored.taken(ground, delay), Some(authored))))
            });
            asked.map_err(AttackError::Generator)?
        }
    }
}

impl AttackWriter for ModelWriter<'_> {
    fn write(
        &self,
        ground: &AttackSetup<'_>,
        scene: &Arc<Scene>,
        delay: f64,
        cancel: &Cancel,
        on_progress: &mut dyn FnMut(generating::Progress),
    ) -> Result<Option<Authored>, AuthorError> {
        let (sender, mut receiver) = unbounded_channel();
        let hear = move |progress| {
            // The receiver lives as long as this.
            let _ = sender.send(progress);
        };
        self.runtime.block_on(async {
            let writing = generating::write(self.author, ground, scene, delay, &hear);
            tokio::pin!(writing);
            loop {
                tokio::select! {
                    biased;
                    () = asked_to_end(cancel) => return Ok(None),
                    Some(progress) = receiver.recv() => on_progress(progress),
                    written = &mut writing => {
                        while let Ok(progress) = receiver.try_recv() {
                            on_progress(progress);
                        }
                        return written.map(Some);
                    }
                }
            }
        })
    }
}

async fn asked_to_end(cancel: &Cancel) {
    while !cancel.is_asked() {
        tokio::time::sleep(POLL).await;
    }
}
