//! Sentences of a text that cannot both be true of the scene, whatever the scene is.

use std::collections::{HashMap, VecDeque};
use std::ops::Range;

use super::{CheckedClaim, Claim, ClaimedValue, Extent, Predicate, Quantity};

/// The sentences that contradict another one, with the spans of those: of each sentence, by its place. The claims of two
/// sentences contradict each other where they are of the same obstacle and time, and one excludes the other.
pub fn contradictions(sentences: &[(Range<usize>, &[CheckedClaim])]) -> Vec<Vec<Range<usize>>> {
    let mut found: Vec<Vec<Range<usize>>> = vec![Vec::new(); sentences.len()];
    // Each claim beside those of its obstacle and time: of long texts the last ones.
    let mut before: HashMap<(i64, Option<i64>), Earlier<'_>> = HashMap::new();
    for (place, (_, claims)) in sentences.iter().enumerate() {
        for claim in *claims {
            let own = before
                .entry((claim.claim.obstacle, claim.claim.step))
                .or_default();
            for (other, earlier) in own.iter().filter(|(other, _)| *other != place) {
                if excludes(earlier, claim) && found[place].last() != Some(&sentences[*other].0) {
                    found[place].push(sentences[*other].0.clone());
                    found[*other].push(sentences[place].0.clone());
                }
            }
            own.push_back((place, claim));
            if own.len() > LOOKED_BACK {
                own.pop_front();
            }
        }
    }
    for all in &mut found {
        all.sort_by_key(|span| span.start);
        all.dedup();
    }
    found
}

/// Claims with the places of their sentences.
type Earlier<'a> = VecDeque<(usize, &'a CheckedClaim)>;

/// Claims about one obstacle that the next one is held against.
const LOOKED_BACK: usize = 200;

/// Whether two claims cannot both hold.
fn excludes(a: &CheckedClaim, b: &CheckedClaim) -> bool {
    let (one, other) = (&a.claim, &b.claim);
    let is_same =
        one.obstacle == other.obstacle && one.step == other.step && !one.is_past && !other.is_past;
    let is_now = |claim: &Claim| claim.extent == Extent::Moment && !claim.is_apart;
    if !is_same
        || !is_now(one)
        || !is_now(other)
        || one.quantity == Quantity::Plan
        || other.quantity == Quantity::Plan
    {
        return false;
    }
    match (one.stated, other.stated) {
        (ClaimedValue::Side(x), ClaimedValue::Side(y)) => {
            let differ = |a: Option<bool>, b: Option<bool>| a.zip(b).is_some_and(|(a, b)| a != b);
            differ(x.front, y.front) || differ(x.left, y.left)
        }
        (
            ClaimedValue::Word {
                predicate: x,
                is_denied: no_x,
            },
            ClaimedValue::Word {
                predicate: y,
                is_denied: no_y,
            },
        ) => {
            x == y && no_x != no_y
                || !no_x && !no_y && (opposite(x) == Some(y) || opposite(y) == Some(x))
        }
        (
            ClaimedValue::Contact,
            ClaimedValue::Word {
                predicate,
                is_denied,
            },
        )
        | (
            ClaimedValue::Word {
                predicate,
                is_denied,
            },
            ClaimedValue::Contact,
        ) => predicate == Predicate::Touches && is_denied,
        (ClaimedValue::Score { score: x, of: a }, ClaimedValue::Score { score: y, of: b }) => {
            a == b && x != y
        }
        (
            ClaimedValue::Number {
                value: x,
                decimals: a,
                rough: r,
                ..
            },
            ClaimedValue::Number {
                value: y,
                decimals: b,
                rough: s,
                ..
            },
        ) => {
            // "None" and a number, and numbers that are not the same rounded.
            let digit = 0.5 * 10_f64.powi(-i32::from(a.min(b)));
            let share = if r || s { 0.2 } else { 0.04 };
            let far = (x.abs() - y.abs()).abs() > digit.max(0.1) + share * x.abs().min(y.abs());
            one.quantity == other.quantity
                && is_one(one.quantity)
                && x.is_finite()
                && y.is_finite()
                && far
        }
        (ClaimedValue::Number { value, .. }, ClaimedValue::Bounds { from, to, .. })
        | (ClaimedValue::Bounds { from, to, .. }, ClaimedValue::Number { value, .. }) => {
            let outside = from.is_some_and(|from| value.abs() < 0.95 * from)
                || to.is_some_and(|to| value.abs() > 1.05 * to);
            one.quantity == other.quantity && is_one(one.quantity) && value.is_finite() && outside
        }
        _ => false,
    }
}

/// Whether a quantity has one value at a time, whatever is meant by its name.
fn is_one(quantity: Quantity) -> bool {
    matches!(
        quantity,
        Quantity::Distance
            | Quantity::GapLong
            | Quantity::GapLat
            | Quantity::TtcLong
            | Quantity::TtcLat
            | Quantity::VelocityLong
            | Quantity::VelocityLat
            | Quantity::Speed
            | Quantity::Headway
    )
}

/// The predicate that excludes another one.
fn opposite(predicate: Predicate) -> Option<Predicate> {
    Some(match predicate {
        Predicate::Approaching(axis) => Predicate::Receding(axis),
        Predicate::Braking => Predicate::Accelerating,
        Predicate::FasterThanEgo => Predicate::SlowerThanEgo,
        Predicate::SameWay => Predicate::Oncoming,
        Predicate::SameLane => Predicate::OtherLane,
        Predicate::SameLanelet => Predicate::OtherLanelet,
        Predicate::Turning(left) => Predicate::Turning(!left),
        Predicate::NeighbourLane(left) => Predicate::NeighbourLane(!left),
        _ => return None,
    })
}
