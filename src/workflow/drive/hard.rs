//! Hard scenarios: which baseline solves them, and a drive that proves that they can be solved.

use nearmiss_drive::generation::Certificate;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{
    Collision, CollisionKind, Driver, Outcome, Policy, Rollout, Settings, TrafficMode,
};
use nearmiss_formats::{Entry, EntryLocation};
use schemars::JsonSchema;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

use super::{DriveOptions, PlannerChoice, drive};
use crate::{PlanError, PreparedPlan, VariantOrigin, prepare_beside, verify_variant};

/// Whose drive proves that a scenario can be solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum Solver {
    /// The recorded ego, which touches nothing, stays on the road and reaches the goal.
    RecordedEgo,
    /// A driver who knows the future of all others: a stored certificate of a variant, or one that was searched for.
    Certificate,
    /// The built-in planner.
    Planner,
}

nearmiss_record::named!(Solver);

impl Solver {
    /// Its name in a sentence.
    #[must_use]
    pub fn words(self) -> String {
        self.name().replace('_', " ")
    }
}

/// How hard a scenario is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hardness {
    /// This baseline solves it.
    SolvedBy(Policy),
    /// No baseline does, but traffic that follows its recording and does not see this one brake runs into it: that decides
    /// nothing.
    HitFromBehind(Policy),
    /// All leave the road without a contact: the road decides, not the traffic.
    OffRoad,
    /// No baseline does.
    Hard {
        /// How the drives of [`Policy::BASELINES`] end: the outcome, of a collision its kind.
        ends: [&'static str; Policy::BASELINES.len()],
        /// Whose drive proves that it can be solved, if one does.
        solver: Option<Solver>,
    },
}

/// How far a recorded ego may be from the problem's start, metres, and how much faster or slower, m/s: recordings are
/// rounded, and their reference point may be another one by centimetres.
const SAME_START: (f64, f64) = (0.5, 0.5);

/// How hard a scenario is, in recorded traffic; nothing where `cancel` asked for an end. A drive solves it if it ends at the
/// goal, or out of time without harm.
///
/// # Errors
/// It cannot be opened, or has nothing to drive, see [`drive`].
pub fn hardness(
    entry: &Entry,
    settings: &Settings,
    cancel: &Cancel,
) -> Result<Option<Hardness>, PlanError> {
    let settings = Settings {
        // What was recorded proves something, and certificates hold, where the others drive as recorded alone.
        traffic: TrafficMode::Recorded,
        policy: None,
        ..*settings
    };
    let prepared = prepare_beside(entry, None, &settings)?;
    let mut ends = [""; Policy::BASELINES.len()];
    let mut hit_from_behind = None;
    for (end, policy) in ends.iter_mut().zip(Policy::BASELINES) {
        let baseline = PlannerChoice::from(policy);
        let options = DriveOptions::of(&baseline);
        match drive(entry, prepared.clone(), options, cancel)? {
            Some(driven) if driven.unharmed() => return Ok(Some(Hardness::SolvedBy(policy))),
            Some(driven) => {
                let kind = driven.collision().map(Collision::kind);
                if kind == Some(CollisionKind::RearEnded) {
                    hit_from_behind = Some(policy);
                }
                *end = kind.map_or(driven.outcome().name(), CollisionKind::name);
            }
            None => return Ok(None),
        }
    }
    if let Some(policy) = hit_from_behind {
        return Ok(Some(Hardness::HitFromBehind(policy)));
    }
    if ends.iter().all(|end| *end == Outcome::OffRoad.name()) {
        return Ok(Some(Hardness::OffRoad));
    }
    let solver = solver(entry, &prepared, cancel)?;
    Ok((!cancel.is_asked()).then_some(Hardness::Hard { ends, solver }))
}

/// Whose drive solves it; the one who knows the future comes last.
fn solver(
    entry: &Entry,
    prepared: &PreparedPlan,
    cancel: &Cancel,
) -> Result<Option<Solver>, PlanError> {
    let driver = prepared
        .driver(&prepared.scenario, cancel)
        .map_err(|error| prepared.nothing(&error))?;
    if prepared.recorded_ego().is_some() {
        let recorded = prepared.clone().recorded_drive(cancel)?.drive;
        if matches!(recorded.outcome, Outcome::Goal(_)) && begins_there(&recorded, &driver) {
            // Beside a variant lies the drive of the planner that was attacked.
            let is_variant = VariantOrigin::read(entry)
                .map_err(PlanError::Unreadable)?
                .is_some();
            return Ok(Some(if is_variant {
                Solver::Planner
            } else {
                Solver::RecordedEgo
            }));
        }
    }
    if has_stored_certificate(entry, prepared).map_err(PlanError::Unreadable)? {
        return Ok(Some(Solver::Certificate));
    }
    // It sees no future, and says more than one who does.
    let planned = prepared.clone().only_best().run(cancel, &mut |_| {})?;
    if planned.is_some_and(|planned| planned.drive.outcome.is_unharmed()) {
        return Ok(Some(Solver::Planner));
    }
    let found = Certificate::of_problem(&driver, &prepared.scenario);
    Ok(found.avoidance().map(|_| Solver::Certificate))
}

/// Whether a drive begins where and as the problem says.
fn begins_there(drive: &Rollout, driver: &Driver) -> bool {
    let span = driver.full_span();
    let start = span.state.centre(driver.limits());
    drive.states.first().is_some_and(|(step, state)| {
        let own = state.centre(driver.limits());
        *step == span.step
            && (own.pose.position - start.pose.position).norm() <= SAME_START.0
            && (own.velocity - start.velocity).abs() <= SAME_START.1
    })
}

/// Whether a variant has a certificate for the same problem and vehicle that still holds.
fn has_stored_certificate(entry: &Entry, prepared: &PreparedPlan) -> Result<bool, String> {
    let EntryLocation::File(file) = &entry.place else {
        return Ok(false);
    };
    let is_same = |origin: &VariantOrigin| {
        origin.manifest.planning.problem == prepared.problem().id
            && origin.vehicle() == Some(prepared.settings.planner.vehicle)
    };
    let origin = VariantOrigin::read(entry)?.filter(is_same);
    let proofs = origin.and_then(|_| verify_variant(file));
    Ok(proofs.is_some_and(|proofs| {
        proofs.changed.is_empty() && proofs.certificates.iter().any(|one| one.result.is_ok())
    }))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use nearmiss_drive::generation::{
        AttackerRecord, CertificateRecord, EvasionRecord, Manifest, OriginalRecord,
    };
    use nearmiss_scene::scenario::ContentHash;
    use nearmiss_study::evaluation::default_planning;

    use super::*;
    use crate::tests::copied;

    fn judged(entry: &Entry) -> Hardness {
        let found = hardness(entry, &default_planning(), &Cancel::default());
        found.unwrap().unwrap()
    }

    fn solver_of(entry: &Entry) -> Option<Solver> {
        match judged(entry) {
            Hardness::Hard { solver, .. } => solver,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_baseline_solves_it_or_a_drive_proves_that_it_can_be_solved() {
        let folder = tempfile::tempdir().unwrap();
        let easy = copied(folder.path(), "ZAM_Overtaking-1_1_T-1");
        assert!(matches!(judged(&easy), Hardness::SolvedBy(_)));

        let hard = copied(folder.path(), "ZAM_Pedestrian-1_1_T-1");
        let found = judged(&hard);
        let Hardness::Hard { ends, solver } = found else {
            panic!("{found:?}");
        };
        assert_eq!(solver, Some(Solver::RecordedEgo));
        assert!(
            ends.iter()
                .all(|end| !["", "goal", "timeout"].contains(end)),
            "{ends:?}"
        );

        // An ego that began more slowly than the problem says proves nothing about it.
        let xml = folder.path().join("v.xml");
        let text = std::fs::read_to_string(&xml).unwrap();
        let (before, problem) = text.split_at(text.find("<planningProblem").unwrap());
        let faster = problem.replacen("<exact>12.6</exact>", "<exact>13.4</exact>", 1);
        assert_ne!(faster, problem);
        std::fs::write(&xml, format!("{before}{faster}")).unwrap();
        assert_ne!(solver_of(&hard), Some(Solver::RecordedEgo));
    }

    #[test]
    fn without_a_recorded_ego_the_planner_proves_it_or_a_driver_who_knows_the_future() {
        let folder = tempfile::tempdir().unwrap();
        let without_ego = |name: &str| {
            let hard = copied(folder.path(), name);
            std::fs::remove_file(folder.path().join("v.ego_trajectory.csv")).unwrap();
            hard
        };
        let hard = without_ego("ZAM_RedLight-1_1_T-1");
        assert_eq!(solver_of(&hard), Some(Solver::Certificate));
        let hard = without_ego("ZAM_Pedestrian-1_1_T-1");
        assert_eq!(solver_of(&hard), Some(Solver::Planner));
        let cancel = Cancel::default();
        cancel.ask();
        let cut_short = hardness(&hard, &default_planning(), &cancel).unwrap();
        assert_eq!(cut_short, None);
    }

    #[test]
    fn a_stored_certificate_counts_as_long_as_it_is_unchanged_and_touches_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let entry = copied(folder.path(), "ZAM_Pedestrian-1_1_T-1");
        let settings = default_planning();
        let prepared = prepare_beside(&entry, None, &settings).unwrap();
        let drive = folder.path().join("v.avoid-0.5.csv");
        std::fs::copy(folder.path().join("v.ego_trajectory.csv"), &drive).unwrap();
        let save = |problem: i64, changed: bool| {
            let hash = ContentHash::digest(&std::fs::read(&drive).unwrap()).to_string();
            let mut manifest = Manifest {
                variant: "v.xml".into(),
                original: OriginalRecord {
                    sha256: "00".into(),
                    ..OriginalRecord::default()
                },
                attackers: vec![AttackerRecord::default()],
                ..Manifest::default()
            };
            manifest.planning.problem = problem;
            manifest.planning.vehicle = settings.planner.vehicle.number();
            let hash = if changed { "00".into() } else { hash };
            manifest.sha256.insert("v.avoid-0.5.csv".into(), hash);
            let certificate = CertificateRecord {
                avoided: true,
                evasion: Some(EvasionRecord {
                    trajectory: Some("v.avoid-0.5.csv".into()),
                    ..EvasionRecord::default()
                }),
                ..CertificateRecord::default()
            };
            manifest.avoidable = Some([("0.5".to_owned(), certificate)].into());
            let text = serde_json::to_string(&manifest).unwrap();
            std::fs::write(folder.path().join("v.json"), text).unwrap();
            has_stored_certificate(&entry, &prepared).unwrap()
        };
        let problem = prepared.problem().id;
        assert!(save(problem, false));
        assert!(!save(problem, true), "its file is another one");
        assert!(!save(problem + 1, false), "it is of another problem");
        // Beside a variant lies the drive of a planner.
        assert!(save(problem, false));
        assert_eq!(solver_of(&entry), Some(Solver::Planner));
        // Through what stands on the road.
        let through = prepared.scenario.obstacles[0].id;
        let text = std::fs::read_to_string(&drive).unwrap();
        let place = prepared.scenario.obstacle(through).unwrap();
        let at = place.motion_at(0).unwrap().pose.position;
        let row = format!("1,0,{},{},0,0,0\n", at.x, at.y);
        let head = text.lines().next().unwrap();
        std::fs::write(&drive, format!("{head}\n{row}")).unwrap();
        assert!(!save(problem, false), "it touches something");
    }
}
