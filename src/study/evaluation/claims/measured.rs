//! Numbers held against the true ones, of the ego and of obstacles: at a step, and over the window.

use nearmiss_scene::metrics::{Contact, Encounter};

use super::check::{CheckedClaim, ClaimBasis, Judgement, at, bounded, fits};
use super::truth::{exact_in, others, worded};
use super::{Claim, ClaimedValue, Event, Extent, Quantity, Subject};

/// A true number, and the geometry it is of.
type Truth = (ClaimBasis, f64);

/// The true numbers that a claim can mean at a step, the usual one first; `None` where there is none of whom it is about.
pub(super) fn truths(claim: &Claim, subject: &Subject<'_>, step: i64) -> Option<Vec<Truth>> {
    let scene = subject.scene;
    if claim.obstacle == scene.ego.id {
        let ego = scene.ego.track.at(step)?;
        let truth = match claim.quantity {
            Quantity::Speed => ego.velocity.abs(),
            Quantity::Acceleration => ego.acceleration,
            Quantity::Heading => ego.pose.heading.to_degrees(),
            _ => return None,
        };
        return Some(vec![(ClaimBasis::Exact, truth)]);
    }
    let participant = { scene.participants() }.find(|p| p.obstacle.id == claim.obstacle)?;
    let encounter = Encounter::at(scene, &participant, step)?;
    let sample = scene.ego.recorded.iter().find(|s| s.step == step);
    let written = sample.and_then(|sample| sample.heading);
    let exact = exact_in(claim.quantity, subject, &participant, &encounter).into_iter();
    let mut all: Vec<Truth> = exact.map(|truth| (ClaimBasis::Exact, truth)).collect();
    all.extend(others(claim.quantity, &encounter, written));
    Some(all)
}

/// Holds a stated number or its bounds against the true numbers that it can mean.
pub(super) fn measure(checked: &mut CheckedClaim, all: &[Truth]) {
    let usual = { all.iter() }
        .find(|one| one.0 == ClaimBasis::Exact)
        .copied();
    let (quantity, stated) = (checked.claim.quantity, checked.claim.stated);
    let judged = |truth: f64| held(stated, truth);
    let good = { all.iter() }.find(|(_, truth)| judged(*truth) == Judgement::Right);
    let shown = good.copied().or(usual);
    let (decimals, sizes) = match stated {
        ClaimedValue::Number {
            value,
            decimals,
            magnitude,
            ..
        } => (decimals, magnitude && value >= 0.0),
        ClaimedValue::Bounds { decimals, .. } => (decimals, true),
        _ => return,
    };
    checked.truth = shown.map(|one| one.1);
    checked.is = checked.truth.map_or("none: never reached".into(), |truth| {
        worded(quantity, truth, decimals, sizes)
    });
    let is_bound = matches!(stated, ClaimedValue::Bounds { .. });
    let is_lower = matches!(stated, ClaimedValue::Bounds { to: None, .. });
    checked.judgement = match good {
        // The centres are always farther apart.
        Some((ClaimBasis::Centres, _)) if is_bound => {
            Judgement::Unknown("true between the centres")
        }
        Some((basis, _)) => {
            checked.basis = *basis;
            Judgement::Right
        }
        // What is never reached takes longer than any time.
        None if all.is_empty() && is_lower => Judgement::Right,
        None if is_bound && { all.iter() }.any(|(_, truth)| judged(*truth) != Judgement::Wrong) => {
            Judgement::Unknown("at the bound within rounding")
        }
        None => Judgement::Wrong,
    };
}

/// Whether a true number is the stated one, or between its bounds.
fn held(stated: ClaimedValue, truth: f64) -> Judgement {
    match stated {
        ClaimedValue::Number {
            value,
            decimals,
            rough,
            magnitude,
        } if fits(truth, value, (decimals, rough, magnitude && value >= 0.0)) => Judgement::Right,
        ClaimedValue::Bounds { from, to, decimals } => bounded(truth.abs(), from, to, decimals),
        _ => Judgement::Wrong,
    }
}

/// Holds what is said of a window, and not of one step, against all of its steps.
pub(super) fn over_window(claim: &Claim, subject: &Subject<'_>) -> CheckedClaim {
    let present = claim.step.unwrap_or_else(|| subject.present());
    let mut checked = match claim.extent {
        Extent::All => throughout(claim, subject, present),
        extent => extreme(claim, subject, (present, extent == Extent::Most)),
    };
    if subject.window.is_none() && checked.judgement == Judgement::Wrong {
        checked.judgement = Judgement::Unknown("the described steps are unknown");
    }
    checked
}

/// What holds throughout: right at every step at which it can be told, wrong where it is at one.
fn throughout(claim: &Claim, subject: &Subject<'_>, present: i64) -> CheckedClaim {
    let mut last = at(claim, subject, present);
    let mut is_open = last.judgement != Judgement::Right;
    for step in subject.steps().steps() {
        let checked = at(claim, subject, step);
        match checked.judgement {
            Judgement::Wrong => return checked,
            Judgement::Right => {}
            Judgement::Unknown(_) => is_open |= truths(claim, subject, step).is_some(),
        }
        if step == present {
            last = checked;
        }
    }
    if is_open && last.judgement == Judgement::Right {
        last.judgement = Judgement::Unknown("at some steps that cannot be told");
    }
    last
}

/// The least or the greatest value of the window; of the whole recording, too.
fn extreme(claim: &Claim, subject: &Subject<'_>, (present, is_most): (i64, bool)) -> CheckedClaim {
    let mut checked = at(claim, subject, present);
    let is_now = checked.judgement == Judgement::Right;
    // The hardest braking is the least acceleration.
    let (sizes, sign) = match claim.stated {
        ClaimedValue::Number {
            value, magnitude, ..
        } => (
            magnitude && value >= 0.0,
            if value < 0.0 { -1.0 } else { 1.0 },
        ),
        _ => (true, 1.0),
    };
    let size = |truth: f64| if sizes { truth.abs() } else { sign * truth };
    let peak = |steps: &mut dyn Iterator<Item = i64>| -> Vec<(i64, f64)> {
        let mut found: Vec<(i64, f64)> = Vec::new();
        for step in steps {
            let all = truths(claim, subject, step).unwrap_or_default();
            let exact = all.into_iter().filter(|one| one.0 == ClaimBasis::Exact);
            for (place, (_, truth)) in exact.enumerate() {
                match found.get_mut(place) {
                    Some(best) if (size(truth) > size(best.1)) == is_most => *best = (step, truth),
                    Some(_) => {}
                    None => found.push((step, truth)),
                }
            }
        }
        found
    };
    let mut all = peak(&mut subject.steps().steps());
    let window = all.first().copied();
    all.extend(peak(&mut (0..=subject.scene.last_step())));
    let good = { all.iter() }.find(|one| held(claim.stated, one.1) == Judgement::Right);
    let Some((step, truth)) = good.copied().or(window) else {
        checked.judgement = Judgement::Unknown("there is no such number in the window");
        return checked;
    };
    checked.step = step;
    checked.truth = Some(truth);
    checked.is = worded(claim.quantity, truth, 2, sizes);
    checked.basis = ClaimBasis::Exact;
    // Where a step is named, it is that of the extreme.
    let is_then = { present - 1..=present + 1 }
        .any(|step| at(claim, subject, step).judgement == Judgement::Right);
    checked.judgement = match good {
        Some(_) if claim.step.is_some() && !is_then => Judgement::Wrong,
        Some(_) => Judgement::Right,
        None if is_now
            && claim.step.is_none()
            && matches!(claim.stated, ClaimedValue::Number { .. }) =>
        {
            Judgement::Unknown("true at the last step, which is not the extreme of the window")
        }
        None => Judgement::Wrong,
    };
    checked
}

/// Steps between the one that is named and the true one that are none, and those that are too many.
const SAME_MOMENT: i64 = 1;
const OTHER_MOMENT: i64 = 3;

/// When something happened: the claim names the step.
pub(super) fn event(checked: &mut CheckedClaim, subject: &Subject<'_>, event: Event) {
    let scene = subject.scene;
    let dt = scene.scenario.dt();
    let mut all = scene.participants();
    let Some(who) = all.find(|p| p.obstacle.id == checked.claim.obstacle) else {
        return;
    };
    let steps = subject.steps().steps();
    let distance = |step: i64| Encounter::at(scene, &who, step).map(|e| e.distance());
    let moments: Vec<i64> = match event {
        Event::Contact => Contact::first(scene, &who)
            .map(|one| one.step)
            .into_iter()
            .collect(),
        Event::Closest => {
            let all: Vec<(i64, f64)> = { steps }
                .filter_map(|step| Some((step, distance(step)?)))
                .collect();
            let least = all.iter().map(|one| one.1).fold(f64::INFINITY, f64::min);
            let near = least + (0.02 * least).max(0.05);
            { all.iter() }
                .filter(|one| one.1 <= near)
                .map(|one| one.0)
                .collect()
        }
        // What is told of a time before the window is looked up.
        Event::Passing => {
            let along = |step: i64| Some(Encounter::at(scene, &who, step)?.relation().gap_long);
            let all = 0..=subject.present();
            all.filter(|step| along(*step) == Some(0.0)).collect()
        }
    };
    let step = checked.step;
    let apart = moments.iter().map(|moment| (moment - step).abs()).min();
    let nearest = { moments.iter() }.min_by_key(|moment| (*moment - step).abs());
    checked.truth = nearest.map(|moment| *moment as f64 * dt);
    checked.is = checked
        .truth
        .map_or("never".into(), |time| format!("{time:.2} s"));
    checked.judgement = match apart {
        Some(apart) if apart <= SAME_MOMENT => Judgement::Right,
        Some(apart) if apart <= OTHER_MOMENT => Judgement::Unknown("true a moment before or after"),
        _ if subject.window.is_none() => Judgement::Unknown("the described steps are unknown"),
        _ => Judgement::Wrong,
    };
}
