//! The true values of quantities, of the exact bodies and in the other conventions that a text may have been told.

use nearmiss_base::geometry::{Point, angle_between};
use nearmiss_scene::metrics::{Contact, Encounter, Relation, measure, paper};
use nearmiss_scene::scenario::{Motion, Participant};

use super::check::{ClaimBasis, Judgement};
use super::{Quantity, Side, Subject};

/// The numbers that a quantity can mean, of the exact bodies, the usual one first: at the step, or of the window.
pub(super) fn exact_in(
    quantity: Quantity,
    subject: &Subject<'_>,
    participant: &Participant<'_>,
    encounter: &Encounter<'_>,
) -> Vec<f64> {
    if quantity != Quantity::MinDistance {
        return exact(quantity, encounter);
    }
    let steps = subject.steps().steps();
    let all = steps.filter_map(|step| Encounter::at(subject.scene, participant, step));
    let least = all
        .map(|encounter| encounter.distance())
        .min_by(f64::total_cmp);
    // Of the whole recording, too.
    let scene = subject.scene;
    let whole = (0..=scene.last_step()).filter_map(|step| Encounter::at(scene, participant, step));
    let ever = whole
        .map(|encounter| encounter.distance())
        .min_by(f64::total_cmp);
    least.into_iter().chain(ever).collect()
}

/// A true number with its unit; where only `sizes` are compared, words say what its minus means.
pub(super) fn worded(quantity: Quantity, truth: f64, decimals: u8, sizes: bool) -> String {
    let decimals = usize::from(decimals.max(1));
    let number = |value: f64| format!("{value:.decimals$} {}", quantity.unit());
    let minus = match quantity {
        Quantity::GapLat | Quantity::VelocityLat | Quantity::AccelerationLat => "to the right",
        Quantity::GapLong => "behind",
        Quantity::VelocityLong | Quantity::AccelerationLong => "backwards",
        Quantity::Acceleration => "of braking",
        _ => "",
    };
    if sizes && truth < 0.0 && !minus.is_empty() {
        format!("{} {minus}", number(-truth))
    } else {
        number(truth + 0.0)
    }
}

/// The numbers of the exact bodies that the quantity can mean, the usual one first.
pub(super) fn exact(quantity: Quantity, encounter: &Encounter<'_>) -> Vec<f64> {
    let relation = encounter.relation();
    let ttc = || measure("ttc").and_then(|m| m.evaluate(encounter).value());
    let one = |value: Option<f64>| value.into_iter().collect();
    match quantity {
        Quantity::Distance => vec![encounter.distance()],
        Quantity::LeastDistance => {
            vec![
                encounter.distance(),
                relation.gap_long.abs(),
                relation.gap_lat.abs(),
            ]
        }
        Quantity::GapLong => vec![relation.gap_long],
        Quantity::GapLat => vec![relation.gap_lat],
        Quantity::DistanceAlong => vec![encounter.distance(), relation.gap_long],
        Quantity::DistanceAcross => vec![encounter.distance(), relation.gap_lat],
        // Across the heading alone only where the bodies are beside each other.
        Quantity::Ttc => {
            let across = relation.time_lat().filter(|_| relation.gap_long == 0.0);
            let all = [ttc(), relation.time_long(), across];
            all.into_iter().flatten().collect()
        }
        Quantity::TtcLong => one(relation.time_long()),
        Quantity::TtcLat => one(relation.time_lat()),
        Quantity::VelocityLong => vec![relation.velocity.x],
        Quantity::VelocityLat => vec![relation.velocity.y],
        Quantity::AccelerationLong => vec![relation.acceleration.x],
        Quantity::AccelerationLat => vec![relation.acceleration.y],
        Quantity::MinDistance => vec![encounter.distance()],
        Quantity::ClosingSpeed => {
            let away = encounter.other.pose.position - encounter.ego.pose.position;
            let velocity = encounter.other.velocity_vector() - encounter.ego.velocity_vector();
            let along = (away.norm() > 0.0).then(|| -away.dot(&velocity) / away.norm());
            let axes = [relation.velocity.x, relation.velocity.y, velocity.norm()];
            along.into_iter().chain(axes).collect()
        }
        Quantity::Headway => one(measure("thw").and_then(|m| m.evaluate(encounter).value())),
        Quantity::Heading => {
            let own = encounter.other.pose.heading;
            let apart = angle_between(encounter.ego.pose.heading, own);
            vec![
                own.to_degrees(),
                apart.to_degrees(),
                own.to_degrees().rem_euclid(360.0),
            ]
        }
        Quantity::Speed => vec![encounter.other.velocity.abs()],
        Quantity::Acceleration => vec![encounter.other.acceleration],
        Quantity::Side
        | Quantity::Contact
        | Quantity::Time
        | Quantity::Motion
        | Quantity::Way
        | Quantity::Comparison
        | Quantity::Count
        | Quantity::Plan
        | Quantity::Risk
        | Quantity::Position
        | Quantity::Arithmetic => Vec::new(),
    }
}

/// Other values that the answer may have been given instead of the exact number.
pub(super) fn others(
    quantity: Quantity,
    encounter: &Encounter<'_>,
    written: Option<f64>,
) -> Vec<(ClaimBasis, f64)> {
    let centre: Point = encounter.ego.pose.to_local(&encounter.other.pose.position);
    let velocity = encounter.relation().velocity;
    let closing = |apart: f64, velocity: f64| {
        (apart * velocity < 0.0).then(|| (ClaimBasis::Centres, -apart / velocity))
    };
    let times = |all: &[Option<(ClaimBasis, f64)>]| all.iter().copied().flatten().collect();
    let mut all: Vec<(ClaimBasis, f64)> = match quantity {
        Quantity::Distance | Quantity::DistanceAlong | Quantity::DistanceAcross => {
            vec![(ClaimBasis::Centres, centre.coords.norm())]
        }
        Quantity::GapLong => vec![(ClaimBasis::Centres, centre.x)],
        Quantity::GapLat => vec![(ClaimBasis::Centres, centre.y)],
        Quantity::Ttc | Quantity::TtcLong => times(&[closing(centre.x, velocity.x)]),
        Quantity::TtcLat => times(&[closing(centre.y, velocity.y)]),
        _ => Vec::new(),
    };
    for told in paper_relations(encounter, written) {
        all.extend(of_paper(quantity, &told).map(|value| (ClaimBasis::Paper, value)));
    }
    all
}

/// The numbers that the paper's convention gives for a quantity.
pub(super) fn of_paper(quantity: Quantity, told: &paper::Relation) -> impl Iterator<Item = f64> {
    let values = match quantity {
        Quantity::GapLong | Quantity::DistanceAlong => vec![Some(told.adjusted_d_long)],
        Quantity::GapLat | Quantity::DistanceAcross => vec![Some(told.adjusted_d_lat)],
        Quantity::Distance => vec![Some(told.adjusted_d_long.hypot(told.adjusted_d_lat))],
        Quantity::ClosingSpeed => vec![Some(told.v_rel_long), Some(told.v_rel_lat)],
        Quantity::TtcLong => vec![told.ttc_long],
        Quantity::TtcLat => vec![told.ttc_lat],
        Quantity::Ttc => vec![told.ttc_long],
        Quantity::VelocityLong => vec![Some(told.v_rel_long)],
        Quantity::VelocityLat => vec![Some(told.v_rel_lat)],
        Quantity::AccelerationLong => vec![Some(told.a_rel_long)],
        Quantity::AccelerationLat => vec![Some(told.a_rel_lat)],
        _ => Vec::new(),
    };
    values.into_iter().flatten()
}

/// The relation as the paper's tables have it: with the ego's heading, and with the one that its recording writes, which
/// turns at random where it stands.
pub(super) fn paper_relations(
    encounter: &Encounter<'_>,
    written: Option<f64>,
) -> Vec<paper::Relation> {
    let mut egos = vec![*encounter.ego];
    if let Some(heading) = written {
        let mut as_written = *encounter.ego;
        as_written.pose.heading = heading;
        egos.push(as_written);
    }
    egos.iter()
        .filter_map(|ego| paper::Relation::new(ego, encounter.other))
        .map(paper::Relation::rounded)
        .collect()
}

/// Whether an obstacle is at a place, so far as that can be told.
pub fn is_at_side(side: Side, encounter: &Encounter<'_>) -> bool {
    judge_side(side, &encounter.relation(), encounter) == Judgement::Right
}

/// Whether a body stands, as words mean it.
pub fn stands(motion: &Motion) -> bool {
    motion.velocity.abs() < 0.5
}

/// Whether the other drives towards where the ego comes from.
pub fn opposes(encounter: &Encounter<'_>) -> bool {
    let apart = angle_between(encounter.ego.pose.heading, encounter.other.pose.heading).abs();
    apart > 0.75 * std::f64::consts::PI && !stands(encounter.other)
}

/// Whether the other moves across the ego's heading.
pub fn crosses(encounter: &Encounter<'_>) -> bool {
    let apart = angle_between(encounter.ego.pose.heading, encounter.other.pose.heading).abs();
    let slant = std::f64::consts::FRAC_PI_4;
    (slant..=3.0 * slant).contains(&apart) && !stands(encounter.other)
}

/// Where bodies overlap along an axis, the centres decide, and only for, not against.
pub(super) fn judge_side(side: Side, relation: &Relation, encounter: &Encounter<'_>) -> Judgement {
    let centre = encounter.ego.pose.to_local(&encounter.other.pose.position);
    let holds = |said: Option<bool>, gap: f64, centre: f64| match said {
        None => Judgement::Right,
        Some(positive) if gap != 0.0 => {
            if (gap > 0.0) == positive {
                Judgement::Right
            } else {
                Judgement::Wrong
            }
        }
        Some(positive) if (centre > 0.0) == positive => Judgement::Right,
        Some(_) => Judgement::Unknown("bodies overlap along this axis"),
    };
    let along = holds(side.front, relation.gap_long, centre.x);
    let across = holds(side.left, relation.gap_lat, centre.y);
    match (along, across) {
        (Judgement::Wrong, _) | (_, Judgement::Wrong) => Judgement::Wrong,
        (Judgement::Unknown(why), _) | (_, Judgement::Unknown(why)) => Judgement::Unknown(why),
        _ => Judgement::Right,
    }
}

/// When the bodies do touch.
pub(super) fn contact(subject: &Subject<'_>, participant: &Participant<'_>, now: bool) -> String {
    if now {
        return "contact".into();
    }
    match Contact::first(subject.scene, participant) {
        Some(contact) => format!("first contact at step {}", contact.step),
        None => "no contact at any step".into(),
    }
}
