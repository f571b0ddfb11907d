//! Sentences of a text that cannot both be true of the scene, whatever the scene is.

use std::collections::{HashMap, VecDeque};
use std::ops::Range;

use nearmiss_scene::metrics::RiskAspect;

use super::{CheckedClaim, Claim, ClaimedValue, Extent, Predicate, Quantity};

/// A claim that contradicts another sentence, or the verdict.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Against {
    /// The place of its sentence.
    pub sentence: usize,
    /// Its place in the sentence.
    pub claim: usize,
    /// What it contradicts, bytes of the text.
    pub other: Range<usize>,
}

/// The claims of sentences that contradict another sentence: they are of the same obstacle and time as a claim of it, and one
/// excludes the other.
pub fn contradictions(sentences: &[(Range<usize>, &[CheckedClaim])]) -> Vec<Against> {
    let mut found: Vec<Against> = Vec::new();
    // Each claim beside those of its obstacle and time: of long texts the last ones.
    let mut before: HashMap<(i64, Option<i64>), Earlier<'_>> = HashMap::new();
    for (sentence, (span, claims)) in sentences.iter().enumerate() {
        for (place, claim) in claims.iter().enumerate() {
            let own = before
                .entry((claim.claim.obstacle, claim.claim.step))
                .or_default();
            let against = own
                .iter()
                .filter(|(at, _, earlier)| *at != sentence && excludes(earlier, claim));
            for (other, at, _) in against {
                found.push(Against {
                    sentence,
                    claim: place,
                    other: sentences[*other].0.clone(),
                });
                found.push(Against {
                    sentence: *other,
                    claim: *at,
                    other: span.clone(),
                });
            }
            own.push_back((sentence, place, claim));
            if own.len() > LOOKED_BACK {
                own.pop_front();
            }
        }
    }
    found
}

/// The claims of sentences that the verdict of a text contradicts: of contact, or of a risk that is critical.
pub fn against_verdict(text: &str, sentences: &[(Range<usize>, &[CheckedClaim])]) -> Vec<Against> {
    let verdict = |key: &str| {
        let at = text.rfind(&format!("\"{key}\""))?;
        let rest = text[at + key.len() + 2..].trim_start().strip_prefix(':')?;
        let value = rest.trim_start().strip_prefix("false")?;
        Some(at..text.len() - value.len())
    };
    let (no_contact, not_critical) = (verdict("collision"), verdict("safety_critical"));
    let other = |claim: &CheckedClaim| {
        let meets = match claim.claim.stated {
            ClaimedValue::Contact => true,
            ClaimedValue::Word {
                predicate,
                is_denied: false,
            } => matches!(predicate, Predicate::Touches | Predicate::WillTouch),
            _ => false,
        };
        let is_critical = matches!(
            claim.claim.stated,
            ClaimedValue::Score {
                score: 0 | 1,
                of: RiskAspect::Overall
            }
        );
        let safe = not_critical.clone().filter(|_| meets || is_critical);
        no_contact.clone().filter(|_| meets).or(safe)
    };
    let all = sentences
        .iter()
        .enumerate()
        .flat_map(|(sentence, (_, claims))| {
            let own = claims.iter().enumerate();
            own.map(move |(place, claim)| (sentence, place, claim))
        });
    let all = all.filter_map(|(sentence, claim, one)| {
        Some(Against {
            sentence,
            claim,
            other: other(one)?,
        })
    });
    all.collect()
}

/// Claims with the places of their sentences, and their own there.
type Earlier<'a> = VecDeque<(usize, usize, &'a CheckedClaim)>;

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
        (ClaimedValue::Score { score, of }, met) | (met, ClaimedValue::Score { score, of }) => {
            of == RiskAspect::Overall && denies_score(met, score)
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

/// Whether a claim excludes a risk score: contact is 0, and no contact is not.
fn denies_score(met: ClaimedValue, score: u8) -> bool {
    match met {
        ClaimedValue::Contact => score > 0,
        ClaimedValue::Word {
            predicate: Predicate::Touches,
            is_denied: true,
        } => score == 0,
        ClaimedValue::Word {
            predicate: Predicate::WillTouch,
            is_denied,
        } => is_denied && score == 0 || !is_denied && score > 3,
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
