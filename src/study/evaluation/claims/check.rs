//! Checks claims against the geometry, and why one that does not hold may still not be wrong.
//!
//! Calling a true sentence wrong is worse than leaving a wrong one undecided.

use nearmiss_base::geometry::Point;
use nearmiss_scene::metrics::{Encounter, RiskAspect, paper};
use schemars::JsonSchema;
use serde::Serialize;

use super::ego::of_ego;
use super::excuses::excuse;
use super::measured;
use super::plans::follow;
use super::truth::{contact, exact, judge_side, of_paper, paper_relations};
use super::worded::{Known, axis_word, risk, state};
use super::{Claim, ClaimedValue, Extent, Predicate, Quantity, Side, Subject};

/// Tolerance between a stated number and the true one, for display; see [`check`].
pub const TOLERANCES: &str = "half of the last stated digit, 0.05 of the unit or 2 %, whichever is largest; 10 % if stated as approximate";

/// The geometry a claim was checked against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ClaimBasis {
    /// Exact bodies of real size.
    Exact,
    /// The distance between the centres: all that a Cartesian description lets one compute.
    Centres,
    /// The convention of the paper, which recorded answers were told in.
    Paper,
}

impl ClaimBasis {
    /// Its description.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Exact => "exact bodies",
            Self::Centres => "between centres",
            Self::Paper => "in the paper's convention",
        }
    }
}

/// Result of checking a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Judgement {
    /// It does.
    Right,
    /// It does not.
    Wrong,
    /// It cannot be told; why.
    Unknown(&'static str),
}

/// A claim with the truth beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedClaim {
    /// The claim.
    pub claim: Claim,
    /// The step it was checked at.
    pub step: i64,
    /// The true value, in the quantity's unit; `None` if there is no such number.
    pub truth: Option<f64>,
    /// The true state, described.
    pub is: String,
    /// The geometry it was checked against; for a wrong claim, the exact bodies.
    pub basis: ClaimBasis,
    /// Whether it holds.
    pub judgement: Judgement,
    /// A sentence of its text, or the verdict there, that cannot be true beside it.
    pub contradicts: Option<String>,
}

impl CheckedClaim {
    /// The stated value with its unit.
    #[must_use]
    pub fn stated(&self) -> String {
        let value = self.value();
        match self.claim.extent {
            Extent::Moment => value,
            Extent::Least => format!("least {value}"),
            Extent::Most => format!("most {value}"),
            Extent::All => format!("{value} throughout"),
        }
    }

    /// The stated value at a moment.
    fn value(&self) -> String {
        match self.claim.stated {
            ClaimedValue::Number {
                value, decimals, ..
            } => {
                if value.is_infinite() {
                    return "never".into();
                }
                format!(
                    "{value:.*} {}",
                    usize::from(decimals),
                    self.claim.quantity.unit()
                )
            }
            ClaimedValue::Bounds { from, to, decimals } => {
                let decimals = usize::from(decimals);
                let unit = self.claim.quantity.unit();
                match (from, to) {
                    (Some(from), Some(to)) => {
                        format!("{from:.decimals$} to {to:.decimals$} {unit}")
                    }
                    (Some(from), None) => format!("over {from:.decimals$} {unit}"),
                    (None, Some(to)) => format!("under {to:.decimals$} {unit}"),
                    (None, None) => "any".into(),
                }
            }
            ClaimedValue::Side(side) => side.to_string(),
            ClaimedValue::Contact => "contact".into(),
            ClaimedValue::Event(event) => event.to_string(),
            ClaimedValue::Word {
                predicate,
                is_denied,
            } => match (predicate, is_denied) {
                (Predicate::Touches, true) => "no contact".into(),
                (Predicate::WillTouch, true) => "no contact to come".into(),
                (predicate, true) => format!("not {predicate}"),
                (predicate, false) => predicate.to_string(),
            },
            ClaimedValue::Score { score, of } => match of {
                RiskAspect::Overall => score.to_string(),
                RiskAspect::Distance(axis) => format!("{score} of {}distance", axis_word(axis)),
                RiskAspect::Time(axis) => format!("{score} of {}time", axis_word(axis)),
            },
            ClaimedValue::Change {
                from, to, decimals, ..
            } => {
                let decimals = usize::from(decimals);
                let unit = self.claim.quantity.unit();
                format!("{from:.decimals$} to {to:.decimals$} {unit}")
            }
            ClaimedValue::Count { number, of, .. } => format!("{number} {of}"),
            ClaimedValue::Place(x, y, decimals) => {
                let decimals = usize::from(decimals);
                format!("({x:.decimals$}, {y:.decimals$})")
            }
            ClaimedValue::Quotient([(a, _), (b, _), (c, decimals)]) => {
                format!("{a} / {b} = {c:.*}", usize::from(decimals))
            }
        }
    }

    /// Whom it is about, in a word.
    #[must_use]
    pub fn who(&self) -> String {
        if self.claim.is_of_ego {
            "ego".into()
        } else {
            self.claim.obstacle.to_string()
        }
    }

    /// As one line: `30308: claimed 3.2 m, actual 7.9 m (distance, step 14)`.
    #[must_use]
    pub fn line(&self) -> String {
        let is_number = matches!(self.claim.stated, ClaimedValue::Number { .. });
        let (agrees, basis) = match self.basis {
            ClaimBasis::Exact => (self.by_centre(), String::new()),
            other if is_number => (String::new(), format!(", {}", other.label())),
            other => (
                format!(", {} {}", self.stated(), other.label()),
                String::new(),
            ),
        };
        let why = match self.judgement {
            Judgement::Unknown(why) => format!("; {why}"),
            _ => String::new(),
        };
        let (stated, step) = (self.stated(), self.step);
        // A contact is named by what is claimed.
        let (id, is_contact) = (self.who(), self.claim.stated == ClaimedValue::Contact);
        let about = if is_contact {
            String::new()
        } else {
            format!("{}, ", self.claim.quantity.name())
        };
        let both = if is_contact && self.is == stated {
            format!("{stated}, as claimed")
        } else {
            format!("claimed {stated}, actual {}", self.is)
        };
        let against = match &self.contradicts {
            Some(other) => format!("; contradicts: {}", other.trim()),
            None => String::new(),
        };
        format!("{id}: {both}{agrees} ({about}step {step}{basis}{why}){against}")
    }

    /// The same in few columns: `30308: 3.2 m, actual 7.9 m`.
    #[must_use]
    pub fn short_line(&self) -> String {
        format!("{}: {}, actual {}", self.who(), self.stated(), self.is)
    }

    /// Why a right place is one where the true state is described by other words.
    fn by_centre(&self) -> String {
        let (ClaimedValue::Side(side), Judgement::Right) = (self.claim.stated, self.judgement)
        else {
            return String::new();
        };
        let unsaid = |said: Option<bool>, yes: &[&str], no: &[&str]| {
            said.filter(|&said| {
                let words = if said { yes } else { no };
                !words.iter().any(|word| self.is.contains(word))
            })
        };
        let unsaid = Side {
            front: unsaid(side.front, &["front"], &["behind", "rear"]),
            left: unsaid(side.left, &["left"], &["right"]),
        };
        match (unsaid.front, unsaid.left) {
            (None, None) => String::new(),
            _ => format!(", its centre {unsaid}"),
        }
    }
}

/// Holds a claim against the geometry of the step that it names, or of the last one that was described.
///
/// It is right where it is within [`TOLERANCES`] of the number of the exact bodies, or of what it may have been told
/// instead: the distance between the centres, or the number in the paper's convention. Which of them is
/// [`CheckedClaim::basis`]. A number without a sign may be a magnitude. A value that was true at an earlier step of the
/// window, where no step is named, is neither right nor wrong, nor is one that may mean something else.
#[must_use]
pub fn check(claim: Claim, subject: &Subject<'_>) -> CheckedClaim {
    let step = claim.step.unwrap_or_else(|| subject.present());
    if let (
        Quantity::Plan,
        ClaimedValue::Word {
            predicate,
            is_denied,
        },
    ) = (claim.quantity, claim.stated)
    {
        let (judgement, is) = follow(predicate, is_denied, subject.trajectory);
        return CheckedClaim {
            claim,
            step,
            truth: None,
            is,
            basis: ClaimBasis::Exact,
            judgement,
            contradicts: None,
        };
    }
    if claim.extent != Extent::Moment {
        return measured::over_window(&claim, subject);
    }
    // What it did not do it did at no step.
    let is_never = matches!(
        claim.stated,
        ClaimedValue::Word {
            is_denied: true,
            ..
        }
    );
    if claim.is_past && claim.step.is_none() && is_never {
        return measured::over_window(
            &Claim {
                extent: Extent::All,
                ..claim
            },
            subject,
        );
    }
    if claim.is_past && claim.step.is_none() {
        return remembered(&claim, subject, step);
    }
    let mut checked = at(&claim, subject, step);
    if checked.judgement == Judgement::Wrong
        && let Some(why) = excuse(&claim, subject, step)
    {
        checked.judgement = Judgement::Unknown(why);
    }
    // Who begins to brake does so about then.
    let is_motion =
        matches!(claim.stated, ClaimedValue::Word { .. }) && claim.quantity == Quantity::Motion;
    if checked.judgement == Judgement::Wrong
        && is_motion
        && let Some(step) = claim.step
        && (-2..=2).any(|more| at(&claim, subject, step + more).judgement == Judgement::Right)
    {
        checked.judgement = Judgement::Unknown("true a moment before or after");
    }
    // A score is of the window's end; a contact that is denied or to come is not true of earlier steps alone.
    let is_of_all = matches!(
        claim.stated,
        ClaimedValue::Score { .. }
            | ClaimedValue::Quotient(_)
            | ClaimedValue::Word {
                predicate: Predicate::Touches | Predicate::WillTouch,
                ..
            }
    );
    if checked.judgement == Judgement::Wrong && claim.step.is_none() && !is_of_all {
        let window = subject.steps();
        // What moves now did not do so long ago.
        let is_place = claim.quantity == Quantity::Side;
        // A number to a digit behind the point may be one of an earlier step that was looked up; a round one speaks of now.
        let is_exact = matches!(
            claim.stated,
            ClaimedValue::Number {
                decimals: 1..,
                rough: false,
                ..
            }
        );
        let is_now = is_motion
            || is_place
            || !is_exact
                && !matches!(
                    claim.stated,
                    ClaimedValue::Place(..) | ClaimedValue::Word { .. }
                );
        let least = if is_now { step - 3 } else { i64::MIN };
        let earlier = window.steps().filter(|s| *s != step && *s >= least);
        if subject.window.is_none() {
            checked.judgement = Judgement::Unknown("the described steps are unknown");
        } else if earlier
            .into_iter()
            .any(|s| at(&claim, subject, s).judgement == Judgement::Right)
        {
            checked.judgement = Judgement::Unknown("true at an earlier step");
        }
    }
    checked
}

/// What is said of a time before: it is right where it held at any step of the window.
fn remembered(claim: &Claim, subject: &Subject<'_>, present: i64) -> CheckedClaim {
    let all = subject.steps().steps().map(|step| at(claim, subject, step));
    let mut last = None;
    let mut is_open = subject.window.is_none();
    for checked in all {
        match checked.judgement {
            Judgement::Right => return checked,
            Judgement::Unknown(_) => is_open = true,
            Judgement::Wrong => {}
        }
        last = Some(checked);
    }
    let mut checked = last.unwrap_or_else(|| at(claim, subject, present));
    if is_open && checked.judgement == Judgement::Wrong {
        checked.judgement = Judgement::Unknown("it may speak of steps that were not described");
    }
    checked
}

pub(super) fn at(claim: &Claim, subject: &Subject<'_>, step: i64) -> CheckedClaim {
    let scene = subject.scene;
    let participant = scene
        .participants()
        .find(|p| p.obstacle.id == claim.obstacle);
    let encounter = participant
        .as_ref()
        .and_then(|p| Encounter::at(scene, p, step));
    let mut checked = CheckedClaim {
        step,
        truth: None,
        is: "not there".into(),
        basis: ClaimBasis::Exact,
        judgement: Judgement::Unknown("ego or obstacle absent at that step"),
        contradicts: None,
        claim: claim.clone(),
    };
    if let ClaimedValue::Change {
        from,
        to,
        decimals,
        rough,
    } = claim.stated
    {
        changed(&mut checked, subject, (from, to), (decimals, rough));
        return checked;
    }
    let is_finite = match claim.stated {
        ClaimedValue::Number { value, .. } => value.is_finite(),
        ClaimedValue::Bounds { .. } => true,
        _ => false,
    };
    if is_finite {
        if let Some(all) = measured::truths(claim, subject, step) {
            measured::measure(&mut checked, &all);
        }
        return checked;
    }
    if claim.obstacle == scene.ego.id {
        of_ego(&mut checked, subject);
        return checked;
    }
    let (Some(participant), Some(encounter)) = (participant, encounter) else {
        return checked;
    };
    let sample = scene.ego.recorded.iter().find(|s| s.step == step);
    let written = sample.and_then(|sample| sample.heading);
    match claim.stated {
        ClaimedValue::Number { value, rough, .. } if value.is_infinite() => {
            let none = |values: &[f64]| !values.iter().any(|t| t.is_finite());
            let mut of_bodies = exact(claim.quantity, &encounter);
            if claim.quantity == Quantity::Ttc {
                of_bodies.extend(exact(Quantity::TtcLat, &encounter));
            }
            let mut told = paper_relations(&encounter, written);
            told.retain(|told| none(&of_paper(claim.quantity, told).collect::<Vec<_>>()));
            checked.truth = of_bodies.first().copied();
            checked.is = match checked.truth {
                Some(truth) => format!("{truth:.1} {}", claim.quantity.unit()),
                None => "none: never reached".into(),
            };
            checked.judgement = match (none(&of_bodies), told.is_empty()) {
                (true, _) => Judgement::Right,
                (false, false) => {
                    checked.basis = ClaimBasis::Paper;
                    Judgement::Right
                }
                (false, true) if rough => Judgement::Unknown("it may only not have been computed"),
                (false, true) => Judgement::Wrong,
            };
        }
        ClaimedValue::Side(side) => {
            let relation = encounter.relation();
            checked.is = relation.direction.name().to_lowercase();
            checked.judgement = judge_side(side, &relation, &encounter);
            let stands = encounter.ego.velocity.abs() < STANDING;
            if checked.judgement == Judgement::Wrong && stands {
                // The heading of a standing ego may have been described as its recording writes it.
                let agrees = |told: &paper::Relation| {
                    let fits =
                        |said: Option<bool>, apart: f64| said.is_none_or(|s| (apart > 0.0) == s);
                    fits(side.front, told.d_long) && fits(side.left, told.d_lat)
                };
                if paper_relations(&encounter, written).iter().any(agrees) {
                    checked.basis = ClaimBasis::Paper;
                    checked.judgement = Judgement::Right;
                }
            }
        }
        ClaimedValue::Contact => {
            let touches = encounter.contact().is_some();
            checked.judgement = if touches {
                Judgement::Right
            } else {
                Judgement::Wrong
            };
            checked.is = contact(subject, &participant, touches);
            // As the paper's tables have it, bodies that pass each other closely may touch.
            if !touches
                && encounter.distance() < 0.5
                && paper_relations(&encounter, written)
                    .iter()
                    .any(|r| r.adjusted_d_long == 0.0 && r.adjusted_d_lat == 0.0)
            {
                checked.basis = ClaimBasis::Paper;
                checked.judgement = Judgement::Right;
            }
        }
        ClaimedValue::Word {
            predicate,
            is_denied,
        } => {
            let told = paper_relations(&encounter, written);
            let Known { holds, is } =
                state(predicate, subject, &participant, (&encounter, step), &told);
            checked.is = is;
            // A contact at another step than the one that is named.
            let is_elsewhere = predicate == Predicate::Touches
                && claim.step.is_some()
                && holds == Ok(true)
                && encounter.contact().is_none();
            checked.judgement = match holds {
                Ok(_) if is_elsewhere => Judgement::Unknown("contact at another step"),
                Err(why) => Judgement::Unknown(why),
                Ok(holds) if holds != is_denied => Judgement::Right,
                Ok(_) => Judgement::Wrong,
            };
        }
        ClaimedValue::Score { score, of } => {
            let (risk, judgement) = risk(claim, subject, &participant, &encounter, (score, of));
            checked.truth = Some(f64::from(risk));
            checked.is = risk.to_string();
            checked.judgement = judgement;
        }
        ClaimedValue::Event(event) => measured::event(&mut checked, subject, event),
        ClaimedValue::Number { .. }
        | ClaimedValue::Bounds { .. }
        | ClaimedValue::Change { .. }
        | ClaimedValue::Count { .. } => {}
        ClaimedValue::Place(x, y, decimals) => {
            let place = encounter.other.pose.position;
            let digit = (0.5 * 10_f64.powi(-i32::from(decimals))).max(0.05) + 1e-9;
            let fits = |place: &Point| (place.x - x).abs() <= digit && (place.y - y).abs() <= digit;
            // A model may speak of the place on the map, seen from the ego, or of the difference on the map.
            let seen = encounter.ego.pose.to_local(&place);
            let apart = Point::from(place - encounter.ego.pose.position);
            checked.is = format!("({:.2}, {:.2})", place.x, place.y);
            checked.judgement = if fits(&place) || fits(&seen) || fits(&apart) {
                Judgement::Right
            } else {
                Judgement::Wrong
            };
        }
        ClaimedValue::Quotient(parts) => {
            let [(a, _), (b, _), (c, decimals)] = parts;
            // What was rounded may be half a digit off.
            let half = |(value, decimals): (f64, u8)| {
                let half = 0.5 * 10_f64.powi(-i32::from(decimals));
                [value.abs() - half, value.abs() + half]
            };
            let ([a0, a1], [b0, b1]) = (half(parts[0]), half(parts[1]));
            let digit = 0.5 * 10_f64.powi(-i32::from(decimals));
            let least = a0.max(0.0) / b1 - digit;
            let most = if b0 > 0.0 {
                a1 / b0 + digit
            } else {
                f64::INFINITY
            };
            checked.truth = (b != 0.0).then(|| a / b);
            checked.is = checked
                .truth
                .map_or("no number".into(), |truth| format!("{truth:.3}"));
            let near = (0.02 * c.abs()).max(digit);
            checked.judgement = if (least - near..=most + near).contains(&c.abs()) {
                Judgement::Right
            } else {
                Judgement::Wrong
            };
        }
    }
    checked
}

/// A change from one value to another: the value had the first at a step of the window, and the second at a later one.
fn changed(
    checked: &mut CheckedClaim,
    subject: &Subject<'_>,
    (from, to): (f64, f64),
    (decimals, rough): (u8, bool),
) {
    let step = checked.step;
    let number = |value: f64| Claim {
        stated: ClaimedValue::Number {
            value,
            decimals,
            rough,
            magnitude: value >= 0.0,
        },
        ..checked.claim.clone()
    };
    let steps = subject
        .window
        .map_or(step..=step, |(first, _)| first..=step);
    let holds = |value: f64| {
        let claim = number(value);
        let held = steps
            .clone()
            .filter(|step| at(&claim, subject, *step).judgement == Judgement::Right);
        held.collect::<Vec<i64>>()
    };
    let (before, after) = (holds(from), holds(to));
    let now = at(&number(to), subject, step);
    checked.is = now.is;
    checked.truth = now.truth;
    checked.judgement = match (before.first(), after.last()) {
        (Some(first), Some(last)) if first < last => Judgement::Right,
        (Some(_), Some(_)) => Judgement::Unknown("it may speak of steps that were not described"),
        _ if subject.window.is_some() => Judgement::Wrong,
        _ => Judgement::Unknown("the described steps are unknown"),
    };
}

/// Whether a stated number is within [`TOLERANCES`] of the truth; where only `sizes` are compared, without signs.
pub(super) fn fits(truth: f64, value: f64, (decimals, rough, sizes): (u8, bool, bool)) -> bool {
    let told = if sizes { truth.abs() } else { truth };
    let share = if rough { 0.1 } else { 0.02 };
    let digit = 0.5 * 10_f64.powi(-i32::from(decimals));
    (told - value).abs() <= digit.max(0.05).max(share * truth.abs()) + 1e-9
}

/// Whether a true number is between bounds; open within rounding of them.
pub(super) fn bounded(truth: f64, from: Option<f64>, to: Option<f64>, decimals: u8) -> Judgement {
    let slack = |bound: f64| {
        (0.5 * 10_f64.powi(-i32::from(decimals)))
            .min(0.05)
            .max(0.01 * bound)
    };
    let over = from.map_or(f64::INFINITY, |from| truth - from);
    let under = to.map_or(f64::INFINITY, |to| to - truth);
    if over >= 0.0 && under >= 0.0 {
        Judgement::Right
    } else if from.is_some_and(|from| over < -slack(from))
        || to.is_some_and(|to| under < -slack(to))
    {
        Judgement::Wrong
    } else {
        Judgement::Unknown("at the bound within rounding")
    }
}

/// Below this speed a heading is not told from motion, m/s.
pub(super) const STANDING: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::super::truth::worded;
    use super::*;

    #[test]
    fn words_say_what_the_minus_of_a_size_means() {
        let lateral = |truth, sizes| worded(Quantity::GapLat, truth, 2, sizes);
        assert_eq!(lateral(-2.45, true), "2.45 m to the right");
        assert_eq!(lateral(-2.45, false), "-2.45 m");
        assert_eq!(lateral(10.79, true), "10.79 m");
        assert_eq!(worded(Quantity::GapLong, -3.0, 0, true), "3.0 m behind");
        assert_eq!(worded(Quantity::Ttc, 0.5, 1, true), "0.5 s");
    }
}
