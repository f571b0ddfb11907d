//! A judge beside the planner: it is asked the safety question at an interval while the ego drives, its answers count
//! from when they arrive, and its warnings may brake.

mod report;

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::runtime::Handle;

pub use report::{Incident, MonitorAnswer, MonitorReport, Warning};

use super::plan::prepared_ego;
use super::{AskRequest, PlanError, PlanEvent, PlanOutcome, PreparedPlan, ask};
use nearmiss_ask::prompts::Library;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{Control, Rollout};
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge::Judgement;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_store::Store;
use nearmiss_study::evaluation::batch::{Price, Size};
use nearmiss_study::evaluation::{
    AttackTerms, Case, Event, Judge, JudgeOutcome, Question, RunOptions, Settings, default_frame,
    prepare, template,
};

/// A judge that watches the drive.
#[derive(Debug)]
pub struct Monitor<'a> {
    /// The built-in judge or a model; recorded answers are about other drives.
    pub judge: &'a Judge,
    /// Templates of the question.
    pub library: &'a Library,
    /// How it is asked, where the template does not decide.
    pub settings: Settings,
    /// Thresholds of the risk scores.
    pub thresholds: Arc<Thresholds>,
    /// Where answers of models are stored and looked for.
    pub store: Option<Arc<Store>>,
    /// Where requests run; the calling thread is not one of its threads.
    pub runtime: &'a Handle,
    /// Seconds of the drive between two questions; to the nearest time step, at least one.
    pub every: f64,
    /// Seconds until an answer counts, in place of its own latency: measured times are not the same every time, and
    /// neither is then the drive.
    pub latency: Option<f64>,
    /// Whether the ego brakes fully while a warning is in force.
    pub brake: bool,
    /// Ask a model even where the store has its answer.
    pub fresh: bool,
}

/// What the questions of a drive cost, as estimated on the drive that no warning brakes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MonitorCost {
    /// Questions.
    pub questions: usize,
    /// Their tokens, roughly.
    pub tokens: u64,
    /// The most that they cost, US dollars; `None` if nothing bounds it.
    pub most_usd: Option<f64>,
}

/// How soon the end that a user asks for is noticed while a model answers.
const POLL: Duration = Duration::from_millis(50);

impl Monitor<'_> {
    /// Time steps between two questions.
    fn steps(&self, dt: f64) -> i64 {
        ((self.every / dt).round() as i64).max(1)
    }

    /// The question about a drive until now: the window ends with the last state, and the ego is not known beyond.
    fn question(&self, prepared: &PreparedPlan, so_far: &Rollout) -> Result<Question, PlanError> {
        let frame: Frame = default_frame(self.library, Task::Safety);
        let wrong = |error: &dyn std::fmt::Display| prepared.mismatch(error);
        let (_, chosen) = template(self.library, Task::Safety, frame).map_err(|e| wrong(&e))?;
        let decided = self.settings.with(&chosen.front.defaults);
        let ego = prepared_ego(prepared, so_far);
        let scene = Arc::new(Scene::new(prepared.driven(so_far), ego));
        let case = Case {
            name: prepared.name.clone(),
            task: Task::Safety,
            frame,
            techniques: decided.techniques,
            window: Window::ending_at(&scene, scene.last_step(), decided.history),
            options: decided.options,
            thresholds: Arc::clone(&self.thresholds),
            scene,
            horizon: Case::HORIZON,
            attack: AttackTerms::default(),
        };
        prepare(case, self.library, None).map_err(|e| wrong(&e))
    }

    /// Asks at a step of a drive. Nothing where `cancel` asked for an end.
    fn answer(
        &self,
        prepared: &PreparedPlan,
        so_far: &Rollout,
        step: i64,
        cancel: &Cancel,
    ) -> Result<Option<MonitorAnswer>, PlanError> {
        let question = self.question(prepared, so_far)?;
        let answer = |dangerous, latency: f64| MonitorAnswer {
            step,
            dangerous,
            latency,
            from: counts_from(step, self.latency.unwrap_or(latency), so_far.dt),
            run: None,
            stored: false,
            usd: None,
        };
        if matches!(self.judge, Judge::Reference) {
            let began = Instant::now();
            let Judgement { verdict, .. } = question.case.judgement();
            let latency = began.elapsed().as_secs_f64();
            return Ok(Some(answer(Some(verdict.dangerous), latency)));
        }
        let request = AskRequest {
            question: &question,
            judge: self.judge,
            store: self.store.clone(),
            options: RunOptions {
                fresh: self.fresh,
                ..RunOptions::default()
            },
        };
        let mut barred = false;
        let asked = self.runtime.block_on(async {
            tokio::select! {
                biased;
                () = asked_to_end(cancel) => None,
                asked = ask(request, |event| barred |= matches!(event, Event::Barred(_))) => Some(asked),
            }
        });
        let Some(asked) = asked else { return Ok(None) };
        let said = asked.map_err(|error| prepared.mismatch(&error))?.answer;
        let dangerous = match &said.judged {
            // The next questions would fail like it.
            JudgeOutcome::Missing(why) if barred => return Err(prepared.mismatch(why)),
            JudgeOutcome::Verdict(parsed) => Some(parsed.verdict.dangerous),
            JudgeOutcome::Other(_) | JudgeOutcome::Missing(_) => None,
        };
        let Some(ms) = said.consumed.duration_ms else {
            let run = said
                .run
                .map_or(String::new(), |run| format!(" (run {run})"));
            return Err(prepared.mismatch(&format!(
                "the stored answer to the question at step {step}{run} has no latency; --fresh asks again"
            )));
        };
        Ok(Some(MonitorAnswer {
            run: said.run,
            stored: said.past.is_some(),
            usd: said.consumed.cost_usd.filter(|_| said.past.is_none()),
            ..answer(dangerous, ms as f64 / 1e3)
        }))
    }
}

/// The first time step at or after the arrival of an answer to a question of a step; latency and time step in seconds.
fn counts_from(step: i64, latency: f64, dt: f64) -> i64 {
    // 0.3 s are 3 steps of 0.1 s, although the quotient is a little larger.
    step.saturating_add((latency / dt - 1e-9).ceil() as i64)
}

async fn asked_to_end(cancel: &Cancel) {
    while !cancel.is_asked() {
        tokio::time::sleep(POLL).await;
    }
}

/// The dangerous or not of the newest question whose answer has arrived at a step; an answer without a verdict changes
/// nothing.
fn in_force(answers: &[MonitorAnswer], step: i64) -> bool {
    let arrived = answers.iter().rev().filter(|answer| answer.from <= step);
    let mut verdicts = arrived.filter_map(|answer| answer.dangerous);
    verdicts.next().unwrap_or(false)
}

impl PreparedPlan {
    /// Drives beside a monitor. Nothing where `cancel` asked for an end; what a model answered until then is stored.
    ///
    /// The drive waits for each answer, and goes on as if it had not: an answer to the question of time t with the
    /// latency L counts from t + L on. The first question is asked one interval after the start.
    ///
    /// # Errors
    /// As [`PreparedPlan::run`]; and [`PlanError::Mismatch`] if a question is refused before it is sent, such as by
    /// the budget, or a stored answer has no latency.
    pub fn run_monitored(
        self,
        monitor: &Monitor<'_>,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(PlanEvent<'_>),
    ) -> Result<Option<(PlanOutcome, MonitorReport)>, PlanError> {
        let mut answers = Vec::new();
        let mut braked = Vec::new();
        let mut failed = None;
        let drive =
            self.drive_monitored(cancel, on_event, monitor, &mut |so_far, step, is_asked| {
                if is_asked {
                    match monitor.answer(&self, so_far, step, cancel) {
                        Ok(Some(answer)) => answers.push(answer),
                        Ok(None) => return Control::Stop,
                        Err(error) => {
                            failed = Some(error);
                            return Control::Stop;
                        }
                    }
                }
                if monitor.brake && in_force(&answers, step) {
                    braked.push(step);
                    Control::Brake
                } else {
                    Control::Follow
                }
            })?;
        if let Some(error) = failed {
            return Err(error);
        }
        let Some(drive) = drive else { return Ok(None) };
        let ego = prepared_ego(&self, &drive);
        let scene = Scene::new(self.driven(&drive), ego);
        let report = MonitorReport::new(monitor, answers, &braked, &drive, &scene);
        let outcome = PlanOutcome {
            prepared: self,
            drive,
        };
        Ok(Some((outcome, report)))
    }

    /// What the questions of a monitor would cost; nothing is sent. Nothing where `cancel` asked for an end.
    ///
    /// # Errors
    /// As [`PreparedPlan::run`], or a question cannot be made.
    pub fn monitor_cost(
        &self,
        monitor: &Monitor<'_>,
        cancel: &Cancel,
    ) -> Result<Option<MonitorCost>, PlanError> {
        let mut cost = MonitorCost {
            most_usd: Some(0.0),
            ..MonitorCost::default()
        };
        let mut failed = None;
        let drive =
            self.drive_monitored(cancel, &mut |_| {}, monitor, &mut |so_far, _, is_asked| {
                if !is_asked {
                    return Control::Follow;
                }
                match monitor.question(self, so_far) {
                    Ok(question) => {
                        cost.add(&Size::estimate(&question, monitor.judge));
                        Control::Follow
                    }
                    Err(error) => {
                        failed = Some(error);
                        Control::Stop
                    }
                }
            })?;
        match failed {
            Some(error) => Err(error),
            None => Ok(drive.map(|_| cost)),
        }
    }

    /// Drives under a control that hears once of each step, and whether a question is due there.
    fn drive_monitored(
        &self,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(PlanEvent<'_>),
        monitor: &Monitor<'_>,
        control: &mut dyn FnMut(&Rollout, i64, bool) -> Control,
    ) -> Result<Option<Rollout>, PlanError> {
        let driver = self
            .driver(&self.scenario, cancel)
            .map_err(|error| self.nothing(&error))?;
        let every = monitor.steps(driver.dt());
        let first = driver.full_span().step;
        let mut before = None;
        let mut decide = |so_far: &Rollout| {
            let step = so_far.states.last().map_or(first, |(step, _)| *step);
            match before {
                Some((asked, decision)) if asked == step => decision,
                _ => {
                    let due = step > first && (step - first) % every == 0;
                    let decision = control(so_far, step, due);
                    before = Some((step, decision));
                    decision
                }
            }
        };
        let mut watch = self.watch(&self.scenario, on_event);
        let drive = driver.drive_controlled(&self.scenario, &mut decide, &mut |planner, cycle| {
            watch(planner, cycle);
            !cancel.is_asked()
        });
        Ok((!cancel.is_asked()).then_some(drive))
    }
}

impl MonitorCost {
    fn add(&mut self, size: &Size) {
        self.questions += 1;
        self.tokens += size.tokens;
        let usd = match size.price {
            Price::Free => Some(0.0),
            Price::AtMost(usd) => Some(usd),
            Price::Question { .. } | Price::Unknown => None,
        };
        self.most_usd = self.most_usd.zip(usd).map(|(sum, usd)| sum + usd);
    }

    /// The cost of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            questions: self.questions + other.questions,
            tokens: self.tokens + other.tokens,
            most_usd: self.most_usd.zip(other.most_usd).map(|(a, b)| a + b),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::counts_from;

    #[test]
    fn answers_count_from_the_step_at_which_they_are_there() {
        for (latency, from) in [(0.0, 20), (0.001, 21), (0.1, 21), (0.3, 23), (0.31, 24)] {
            assert_eq!(counts_from(20, latency, 0.1), from, "{latency}");
        }
    }
}
