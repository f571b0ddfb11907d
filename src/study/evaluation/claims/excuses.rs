//! Why a claim that does not hold may still not be wrong: what else it can mean.

use nearmiss_scene::metrics::{Encounter, Relation};

use super::check::{Judgement, STANDING, at};
use super::{Claim, ClaimedValue, Quantity, Subject};

/// Another possible meaning of the claim at that step; `None` if it is plainly wrong.
pub fn excuse(claim: &Claim, subject: &Subject<'_>, step: i64) -> Option<&'static str> {
    // A change may lead to what a number can mean, too.
    if let ClaimedValue::Change {
        to,
        decimals,
        rough,
        ..
    } = claim.stated
    {
        let stated = ClaimedValue::Number {
            value: to,
            decimals,
            rough,
            magnitude: to >= 0.0,
        };
        let end = Claim {
            stated,
            ..claim.clone()
        };
        return excuse(&end, subject, step);
    }
    let holds = |claim: &Claim| at(claim, subject, step).judgement == Judgement::Right;
    let as_other = |quantity| {
        holds(&Claim {
            quantity,
            ..claim.clone()
        })
    };
    if claim.quantity == Quantity::Ttc && as_other(Quantity::TtcLat) {
        return Some("true for the time across the heading alone");
    }
    let ClaimedValue::Number {
        value, decimals, ..
    } = claim.stated
    else {
        return None;
    };
    if turned(claim, subject, step) {
        return Some("the ego stands still; its heading may have been described differently");
    }
    let time = matches!(
        claim.quantity,
        Quantity::Ttc | Quantity::TtcLong | Quantity::TtcLat
    );
    if time && value < 0.0 {
        let mut unsigned = claim.clone();
        if let ClaimedValue::Number { value, .. } = &mut unsigned.stated {
            *value = -*value;
        }
        return holds(&unsigned).then_some("true without the sign");
    }
    if time && from_rounded(claim, subject, step) {
        return Some("follows from a rounded velocity");
    }
    if claim.quantity == Quantity::Headway {
        let is_behind = met(claim, subject, step).is_some_and(|(_, _, r)| r.gap_long < 0.0);
        return is_behind.then_some("the time gap of one behind is its own");
    }
    if of_its_own(claim, subject, step) {
        return Some("true for its own velocity, not the relative one");
    }
    // Of what was told in relative numbers, an unnamed one may be relative.
    let is_relative = match claim.quantity {
        Quantity::Speed => as_other(Quantity::VelocityLong) || as_other(Quantity::VelocityLat),
        Quantity::Acceleration => {
            as_other(Quantity::AccelerationLong) || as_other(Quantity::AccelerationLat)
        }
        _ => false,
    };
    if is_relative && decimals >= 2 {
        return Some("true for the relative one, not its own");
    }
    if claim.quantity == Quantity::Distance
        && (as_other(Quantity::GapLong) || as_other(Quantity::GapLat))
    {
        return Some("true for the gap along or across the heading alone");
    }
    if claim.quantity == Quantity::LeastDistance {
        return Some("which least distance is meant is not told");
    }
    let length = matches!(
        claim.quantity,
        Quantity::Distance
            | Quantity::GapLong
            | Quantity::GapLat
            | Quantity::DistanceAlong
            | Quantity::DistanceAcross
    );
    if length && along_the_map(claim, subject, step) {
        return Some("true for the difference in x or y on the map");
    }
    // A sentence that names no participant takes its subject from what it stands under.
    let telling = decimals >= 2 && value != 0.0;
    if !claim.named && telling {
        let mut others = subject
            .scene
            .participants()
            .map(|p| p.obstacle.id)
            .filter(|id| *id != claim.obstacle);
        let of_another = others.any(|obstacle| {
            holds(&Claim {
                obstacle,
                ..claim.clone()
            })
        });
        return of_another.then_some("true for another obstacle");
    }
    None
}

/// What follows from the ego and the obstacle at the step; nothing where one of them is not there.
pub(super) fn encountered<T>(
    claim: &Claim,
    subject: &Subject<'_>,
    step: i64,
    value: impl FnOnce(&Encounter<'_>) -> T,
) -> Option<T> {
    let mut participants = subject.scene.participants();
    let participant = participants.find(|p| p.obstacle.id == claim.obstacle)?;
    Encounter::at(subject.scene, &participant, step).map(|encounter| value(&encounter))
}

/// The ego's speed, the distance of the centres, and where the obstacle is, at the step.
pub(super) fn met(claim: &Claim, subject: &Subject<'_>, step: i64) -> Option<(f64, f64, Relation)> {
    encountered(claim, subject, step, |encounter| {
        let apart = encounter.other.pose.position - encounter.ego.pose.position;
        let speed = encounter.ego.velocity.abs();
        (speed, apart.norm(), encounter.relation())
    })
}

/// Whether the ego stands still and the claim would hold for another heading of it.
pub(super) fn turned(claim: &Claim, subject: &Subject<'_>, step: i64) -> bool {
    let Some((speed, apart, _)) = met(claim, subject, step) else {
        return false;
    };
    let ClaimedValue::Number { value, .. } = claim.stated else {
        return false;
    };
    let seen_from_it = match claim.quantity {
        Quantity::GapLong
        | Quantity::GapLat
        | Quantity::DistanceAlong
        | Quantity::DistanceAcross => value.abs() <= apart,
        Quantity::Ttc
        | Quantity::TtcLong
        | Quantity::TtcLat
        | Quantity::VelocityLong
        | Quantity::VelocityLat => true,
        _ => false,
    };
    speed < STANDING && seen_from_it
}

/// Whether a velocity along an axis is the obstacle's own there, in the ego's axes.
pub(super) fn of_its_own(claim: &Claim, subject: &Subject<'_>, step: i64) -> bool {
    let ClaimedValue::Number { value, .. } = claim.stated else {
        return false;
    };
    let of_encounter = |encounter: &Encounter<'_>| {
        let turned = encounter.other.pose.heading - encounter.ego.pose.heading;
        let velocity = encounter.other.velocity;
        let own = match claim.quantity {
            Quantity::VelocityLong => velocity * turned.cos(),
            Quantity::VelocityLat => velocity * turned.sin(),
            Quantity::ClosingSpeed => velocity,
            _ => return false,
        };
        [own, velocity]
            .iter()
            .any(|own| (own.abs() - value.abs()).abs() <= (0.02 * own.abs()).max(0.05))
    };
    encountered(claim, subject, step, of_encounter) == Some(true)
}

/// Whether a time is the gap by a velocity that was rounded to two decimals: of slow ones that changes much.
pub(super) fn from_rounded(claim: &Claim, subject: &Subject<'_>, step: i64) -> bool {
    let (Some((_, _, relation)), ClaimedValue::Number { value, .. }) =
        (met(claim, subject, step), claim.stated)
    else {
        return false;
    };
    let axes = [
        (
            relation.gap_long,
            relation.velocity.x,
            claim.quantity != Quantity::TtcLat,
        ),
        (
            relation.gap_lat,
            relation.velocity.y,
            claim.quantity != Quantity::TtcLong,
        ),
    ];
    axes.iter().any(|(gap, velocity, meant)| {
        let (gap, velocity) = (gap.abs(), velocity.abs());
        let shortest = 0.95 * gap / (velocity + 0.005);
        let longest = 1.05 * gap / (velocity - 0.005).max(0.001);
        *meant && velocity < 0.5 && (shortest..=longest).contains(&value)
    })
}

/// Whether a length is the difference of the centres along an axis of the map: what a model that was given
/// coordinates may call longitudinal or lateral.
pub(super) fn along_the_map(claim: &Claim, subject: &Subject<'_>, step: i64) -> bool {
    let ClaimedValue::Number {
        value,
        decimals,
        rough,
        ..
    } = claim.stated
    else {
        return false;
    };
    let apart = encountered(claim, subject, step, |encounter| {
        encounter.other.pose.position - encounter.ego.pose.position
    });
    let Some(apart) = apart else {
        return false;
    };
    let digit = (0.5 * 10_f64.powi(-i32::from(decimals))).max(0.05);
    let share = if rough { 0.1 } else { 0.02 };
    [apart.x, apart.y, apart.norm()]
        .iter()
        .any(|d| (d.abs() - value.abs()).abs() <= digit.max(share * d.abs()))
}
