//! Dangerous variants of a scenario, with proofs that an ideal driver survives them.

use std::path::PathBuf;

use nearmiss_drive::generation::{AttackStyle, Effort, VariantFiles, Wish};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{Settings, TrafficMode};
use nearmiss_formats::EntryLocation;
use nearmiss_workflow::variant::{
    AttackRequest, Generated, VariantLine, attacker_count, attackers_together, candidate_count,
    distinct_attackers, reaction_time,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::Obstacles;
use crate::errors::{Problem, of_keyword};
use crate::plan::{Chosen, Planner, planning};
use crate::scenario::Scenario;
use crate::settings::User;
use crate::window::json;
use crate::work;

/// What an attack made of a scenario; `nearmiss.attack` makes some.
#[pyclass(frozen, module = "nearmiss")]
pub struct Variant {
    generated: Box<Generated>,
    line: VariantLine,
    /// As JSON.
    certificate: Option<String>,
    scenario: Option<Scenario>,
}

#[pymethods]
impl Variant {
    /// The outcome and what is known of the attack, as a dict: `outcome` (collision, near_miss, planner_error, no_effect or
    /// none), `attackers`, `manoeuvre`, `min_distance`, `note` and more: the line of `nearmiss generate --format json`.
    #[getter]
    fn record<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json(py, &self.line)
    }

    /// Whether an ideal driver survives, by reaction time: a dict with "0.0", "0.5", "1.0" and "1.5" seconds, each a dict with
    /// `avoided`, how (`found_by`, `ends`, `max_acceleration`) or `why` not, and what was `searched`.
    ///
    /// None where no motion passed the gate, or the planner itself failed; record["note"] says why.
    #[getter]
    fn certificate<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let loads = |text| py.import("json")?.getattr("loads")?.call1((text,));
        self.certificate.as_ref().map(loads).transpose()
    }

    /// The changed scenario with the ego's drive in it; None where no motion passed the gate.
    #[getter]
    fn scenario(&self) -> Option<Scenario> {
        self.scenario.clone()
    }

    /// Writes the changed scenario into a folder, with its ego, solution, certificates and manifest, as
    /// `nearmiss generate -o` does; returns the scenario's file. The folder is made where there is none.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<PathBuf> {
        let saved = py.detach(|| {
            std::fs::create_dir_all(&folder)
                .map_err(|error| Problem::new(format!("{}: {error}", folder.display())))?;
            let saved = self.generated.save(&folder, &self.line);
            saved.map_err(Problem::new)?.ok_or_else(|| {
                Problem::new(format!(
                    "{}: nothing to write: no motion passed the gate",
                    self.line.file
                ))
            })
        });
        Ok(saved?.scenario)
    }

    fn __repr__(&self) -> String {
        let (name, outcome) = (&self.line.scenario, self.line.outcome.name());
        let ids: Vec<String> = self.line.ids().iter().map(i64::to_string).collect();
        match self.line.manoeuvres() {
            Some(does) => format!(
                "<nearmiss.Variant {name}: {outcome}, {does} by {}>",
                ids.join(" and ")
            ),
            None => format!("<nearmiss.Variant {name}: {outcome}>"),
        }
    }
}

/// Makes the scenario dangerous, as `nearmiss generate` does: changes the motion of others until the ego, which replans, comes
/// to harm, and an ideal driver does not. A list, so far of one variant; it says so itself where nothing was found.
///
/// attacker: id of the obstacle that attacks, or ids of those that may; None for any. wish: who, which manoeuvre, from where,
/// such as "actor:car manoeuvre:cut-in place:left-lane" (`nearmiss help generating`). attackers: how many attack together at
/// most, 1 to 3. candidates: how many motions are tried at most. seed: the same one finds the same attacks. survive: reaction
/// time with which an ideal driver must avoid it: 0, 0.5, 1 or 1.5 seconds. style: human, as people do in an emergency, or
/// limit, as far as vehicles can.
///
/// planner, problem and more keywords: who is attacked and how it is driven, as of `nearmiss.plan`. An exception of a
/// function that an attack causes is the outcome planner_error; one without an attack comes out of here.
#[pyfunction]
#[pyo3(signature = (scenario, *, attacker=None, wish=None, attackers=None, candidates=None, seed=None, survive=None, style=None, planner=None, problem=None, **settings))]
#[allow(clippy::too_many_arguments)]
pub fn attack(
    py: Python<'_>,
    scenario: &Scenario,
    attacker: Option<Obstacles>,
    wish: Option<&str>,
    attackers: Option<usize>,
    candidates: Option<usize>,
    seed: Option<u64>,
    survive: Option<f64>,
    style: Option<&str>,
    planner: Option<Planner<'_>>,
    problem: Option<i64>,
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<Vec<Variant>> {
    let user = User::read()?;
    let planning = planning(&user, None, settings)?;
    if planning.traffic == TrafficMode::Reactive
        && settings.is_some_and(|named| named.contains("traffic").unwrap_or(false))
    {
        return Err(Problem::new(
            "traffic=\"reactive\" is not for attack: variants are recordings, in which only the attackers move otherwise; \
             nearmiss.plan(variant.scenario, traffic=\"reactive\") shows whether it succeeds where others react",
        )
        .into());
    }
    let chosen = Chosen::new(planner, &user, planning.timeout)?;
    let only = match attacker {
        None => Vec::new(),
        Some(Obstacles::One(id)) => vec![id],
        Some(Obstacles::Many(ids)) => distinct_attackers(&ids),
    };
    let asked = attackers.map(|n| of_keyword("attackers", attacker_count(&n.to_string())));
    let (asked, usual) = (asked.transpose()?, user.config.attackers);
    let together = attackers_together(asked, only.len(), usual, ("attackers=", "attacker"))
        .map_err(Problem::new)?;
    let candidates = candidates.map(|n| of_keyword("candidates", candidate_count(&n.to_string())));
    let delay = survive.map(|seconds| of_keyword("survive", reaction_time(&seconds.to_string())));
    let usual = Effort::default();
    let effort = Effort {
        candidates: candidates.transpose()?.unwrap_or(usual.candidates),
        seed: seed.unwrap_or(usual.seed),
        delay: delay.transpose()?.unwrap_or(usual.delay),
        together,
        ..usual
    };
    let style = style.map(|word| of_keyword("style", word.parse::<AttackStyle>()));
    let request = AttackRequest {
        settings: Settings {
            traffic: TrafficMode::Recorded,
            policy: chosen.choice.as_ref().and_then(|choice| choice.policy),
            ..Settings::from(&planning)
        },
        planner: chosen.choice.and_then(|choice| choice.external),
        effort,
        style: { style.transpose()? }
            .or(user.config.attack_style)
            .unwrap_or_default(),
        only,
        wish: { wish.map(|words| of_keyword("wish", words.parse::<Wish>())) }.transpose()?,
    };
    let own = scenario.clone();
    let made = work::run(py, move |cancel| made(&own, problem, &request, cancel));
    chosen.calls.settle(py);
    let made = made?;
    // Under an attack an exception is what was looked for.
    if made.is_err() {
        chosen.calls.check()?;
    }
    Ok(vec![made?])
}

fn made(
    scenario: &Scenario,
    problem: Option<i64>,
    attack: &AttackRequest,
    cancel: &Cancel,
) -> Result<Variant, Problem> {
    let prepared = scenario.prepared(problem, &attack.settings)?;
    let settings = attack.settings(prepared.problem().id, None);
    let generated = Generated::make(&scenario.entry, prepared, (attack, settings), None, cancel);
    let made = generated.map_err(Problem::new)?;
    let generated = made.ok_or_else(|| Problem::new("interrupted"))?;
    let by = attack.search_in_words();
    let line = VariantLine::new(&generated, &by).with_rejected(&generated);
    let certificates = generated
        .variant(&by)
        .and_then(|variant| variant.certificates(&VariantFiles::default()));
    let certificate = certificates
        .map(|all| serde_json::to_string(&all))
        .transpose();
    let scene = generated.scene(&by).map_err(Problem::new)?;
    Ok(Variant {
        certificate: certificate.map_err(Problem::new)?,
        scenario: scene.map(|scene| {
            let mut changed = scenario.driven(scene);
            changed.entry.name = changed.scenario.header.benchmark_id.clone();
            // Messages go on to name the original's, also one that is bundled under another name.
            changed.entry.place = EntryLocation::File(scenario.entry.display().into());
            changed
        }),
        generated: Box::new(generated),
        line,
    })
}
