//! The entries of a file of thresholds, one by one over those that are there.

use std::ops::Range;

use toml::Spanned;

use super::super::{Danger, LIMITS, MEASURES, Measure, measure};
use super::file::{OwnLevel, OwnLimit, OwnThreshold};
use super::{Threshold, Thresholds};

/// More critical values of one measure than this cannot be told apart in a plot.
const MAX_CRITICAL_VALUES: usize = 8;

/// Longest name or source, characters.
const MAX_CHARACTERS: usize = 80;

/// Largest bound of a risk level, metres or seconds.
const MAX_BOUND: f64 = 1e4;

/// The byte of the file at which something is wrong, and what.
type Wrong = (usize, String);

impl Thresholds {
    pub(super) fn take_thresholds(
        &mut self,
        all: &[OwnThreshold],
        file: &str,
    ) -> Result<(), Wrong> {
        let shipped = self.critical.clone();
        for own in all {
            self.take_threshold(own, file)?;
        }
        for own in all {
            self.keeps_order(own, &shipped)?;
        }
        let place = |t: &Threshold| MEASURES.iter().position(|m| m.id == t.measure);
        self.critical.sort_by(|a, b| {
            let of_one = place(a).cmp(&place(b));
            let danger = place(a).map_or(Danger::Neutral, |place| MEASURES[place].danger);
            of_one.then_with(|| danger.compare(a.value, b.value))
        });
        Ok(())
    }

    fn take_threshold(&mut self, own: &OwnThreshold, file: &str) -> Result<(), Wrong> {
        let measure = known(&own.measure)?;
        let name = one_line("name", &own.name)?;
        let value = finite("value", &own.value)?;
        unit(own.unit.as_ref(), measure.id, measure.unit)?;
        let source = match &own.source {
            Some(source) => one_line("source", source)?,
            None => file,
        };
        let of_measure = || self.critical.iter().filter(|t| t.measure == measure.id);
        let place = self
            .critical
            .iter()
            .position(|t| t.measure == measure.id && t.name == name);
        let old = place.map(|place| &self.critical[place]);
        let at = own.name.span().start;
        if old.is_some_and(|old| old.own) {
            let message = format!("name `{name}` of {} is given twice", measure.id);
            return Err((at, message));
        }
        if old.is_none() && of_measure().count() >= MAX_CRITICAL_VALUES {
            let message = format!(
                "measure `{}` has more than {MAX_CRITICAL_VALUES} thresholds",
                measure.id
            );
            return Err((at, message));
        }
        let threshold = Threshold {
            measure: measure.id.into(),
            value,
            name: name.into(),
            source: source.into(),
            strict: own.strict.unwrap_or(old.is_some_and(|old| old.strict)),
            own: true,
        };
        match place {
            Some(place) => self.critical[place] = threshold,
            None => self.critical.push(threshold),
        }
        Ok(())
    }

    /// Whether what an entry changes is still in the order of danger that its names promise.
    fn keeps_order(&self, own: &OwnThreshold, shipped: &[Threshold]) -> Result<(), Wrong> {
        let measure = known(&own.measure)?;
        let names = shipped.iter().filter(|t| t.measure == measure.id);
        let names: Vec<&str> = names.map(|t| t.name.as_str()).collect();
        let value = |name: &str| self.for_measure(measure.id).find(|t| t.name == name);
        for pair in names.windows(2) {
            let [Some(worse), Some(better)] = [value(pair[0]), value(pair[1])] else {
                continue;
            };
            let ordered = measure.danger.compare(worse.value, better.value).is_lt();
            if !ordered && pair.contains(&own.name.get_ref().as_str()) {
                let side = match measure.danger {
                    Danger::High => "above",
                    Danger::Low | Danger::Neutral => "below",
                };
                return Err((
                    own.value.span().start,
                    format!(
                        "value of {}: `{}` ({}) must be {side} `{}` ({})",
                        measure.id, worse.name, worse.value, better.name, better.value
                    ),
                ));
            }
        }
        Ok(())
    }

    pub(super) fn take_levels(&mut self, all: &[OwnLevel]) -> Result<(), Wrong> {
        let last = self.risk.levels.len() - 1;
        for own in all {
            let (at, score) = (own.score.span().start, *own.score.get_ref());
            let place = usize::try_from(score).ok().filter(|place| *place < last);
            let Some(place) = place else {
                let message = format!(
                    "score {score} has no bounds; allowed are 0 to {}, and {last} is everything above",
                    last - 1
                );
                return Err((at, message));
            };
            let level = &mut self.risk.levels[place];
            if self.own_levels.contains(&level.score) {
                return Err((at, format!("score {score} is given twice")));
            }
            if own.distance.is_none() && own.time.is_none() {
                return Err((
                    at,
                    format!("score {score} needs `distance`, `time` or both"),
                ));
            }
            if let Some(distance) = &own.distance {
                level.distance = Some(bound("distance", distance)?);
            }
            if let Some(time) = &own.time {
                level.time = Some(bound("time", time)?);
            }
            self.own_levels.push(level.score);
        }
        for own in all {
            let score = *own.score.get_ref();
            self.rises("distance", "m", own.distance.as_ref(), score, |l| {
                l.distance
            })?;
            self.rises("time", "s", own.time.as_ref(), score, |l| l.time)?;
        }
        Ok(())
    }

    /// Whether a bound lies above that of the score before and below that of the next one.
    fn rises(
        &self,
        key: &str,
        unit: &str,
        own: Option<&Spanned<f64>>,
        score: i64,
        bound: fn(&super::super::RiskLevel) -> Option<f64>,
    ) -> Result<(), Wrong> {
        let Some(own) = own else { return Ok(()) };
        let of = |score: i64| {
            let score = u8::try_from(score).ok()?;
            bound(self.risk.level(score)?)
        };
        let value = *own.get_ref();
        let beside = [(score - 1, "above"), (score + 1, "below")];
        for (other, side) in beside {
            let Some(limit) = of(other) else { continue };
            let fine = if other < score {
                value > limit
            } else {
                value < limit
            };
            if !fine {
                let message = format!(
                    "{key} {value} {unit} of score {score} must be {side} that of score {other}, {limit} {unit}"
                );
                return Err((own.span().start, message));
            }
        }
        Ok(())
    }

    pub(super) fn take_limits(&mut self, all: &[OwnLimit]) -> Result<(), Wrong> {
        for own in all {
            let (at, name) = (own.name.span().start, own.name.get_ref());
            let Some(limit) = LIMITS.iter().find(|l| l.id == name) else {
                let names: Vec<&str> = LIMITS.iter().map(|l| l.id).collect();
                let message = format!(
                    "unknown limit `{}`; available: {}",
                    name.escape_debug(),
                    names.join(", ")
                );
                return Err((at, message));
            };
            if self.own_limits.contains(&limit.id) {
                return Err((at, format!("limit {} is given twice", limit.id)));
            }
            unit(own.unit.as_ref(), limit.id, limit.unit)?;
            let value = *own.value.get_ref();
            if !limit.allowed.contains(&value) {
                let message = format!(
                    "value {value} of {} is not allowed; it must be {} to {} {}",
                    limit.id,
                    limit.allowed.start(),
                    limit.allowed.end(),
                    limit.unit
                );
                return Err((own.value.span().start, message));
            }
            limit.set(&mut self.limits, value);
            self.own_limits.push(limit.id);
        }
        // Whatever order is broken, an entry of the file broke it.
        let about = |order: &str| {
            let named = |own: &&OwnLimit| order.split(' ').any(|word| word == own.name.get_ref());
            all.iter().rev().find(named)
        };
        match self.limits.mistake() {
            None => Ok(()),
            Some(order) => {
                let at = about(order).map_or(0, |own| own.value.span().start);
                Err((at, format!("value: {order}")))
            }
        }
    }
}

fn known(id: &Spanned<String>) -> Result<&'static Measure, Wrong> {
    match measure(id.get_ref()) {
        Some(found) if found.danger != Danger::Neutral => Ok(found),
        found => {
            let why = match found {
                Some(_) => "is descriptive and has no dangerous values",
                None => "is not known",
            };
            let can = MEASURES.iter().filter(|m| m.danger != Danger::Neutral);
            let ids: Vec<&str> = can.map(|m| m.id).collect();
            let message = format!(
                "measure `{}` {why}; allowed are {}",
                id.get_ref().escape_debug(),
                ids.join(", ")
            );
            Err((id.span().start, message))
        }
    }
}

/// A text that can be shown on one line.
fn one_line<'a>(key: &str, text: &'a Spanned<String>) -> Result<&'a str, Wrong> {
    let words = text.get_ref().as_str();
    if words.trim().is_empty()
        || words.chars().count() > MAX_CHARACTERS
        || words.contains(char::is_control)
    {
        let message = format!(
            "{key} must be 1 to {MAX_CHARACTERS} characters on one line, without control characters"
        );
        return Err((text.span().start, message));
    }
    Ok(words)
}

fn finite(key: &str, value: &Spanned<f64>) -> Result<f64, Wrong> {
    let found = *value.get_ref();
    if found.is_finite() {
        Ok(found)
    } else {
        Err((
            value.span().start,
            format!("{key} must be a finite number, not {found}"),
        ))
    }
}

fn bound(key: &str, value: &Spanned<f64>) -> Result<f64, Wrong> {
    let found = *value.get_ref();
    if (0.0..=MAX_BOUND).contains(&found) {
        Ok(found)
    } else {
        let message = format!("{key} {found} is not allowed; it must be 0 to {MAX_BOUND}");
        Err((value.span().start, message))
    }
}

/// A unit may be left out, but what is said must be right.
fn unit(said: Option<&Spanned<String>>, of: &str, right: &str) -> Result<(), Wrong> {
    let Some(said) = said else { return Ok(()) };
    let plain = |unit: &str| unit.replace('²', "2").replace("^2", "2").replace(' ', "");
    if plain(said.get_ref()) == plain(right) {
        return Ok(());
    }
    let allowed = match right {
        "" => "it has none".to_string(),
        unit => format!("it is in {unit}"),
    };
    let message = format!(
        "unit `{}` of {of} is wrong: {allowed}",
        said.get_ref().escape_debug()
    );
    let Range { start, .. } = said.span();
    Err((start, message))
}
