//! Triggers of a storyboard that are moments: when acts and events begin, and when everything ends.

use crate::commonroad::ReadError;
use crate::recordings::opendrive::tree::Node;

/// When a trigger fires.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fires {
    /// At a moment, seconds.
    At(f64),
    /// Never.
    Never,
    /// When something happens that only a player works out.
    Depends,
}

impl Fires {
    /// When both this one and another one have fired.
    pub fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Never, _) | (_, Self::Never) => Self::Never,
            (Self::Depends, _) | (_, Self::Depends) => Self::Depends,
            (Self::At(a), Self::At(b)) => Self::At(a.max(b)),
        }
    }

    fn or(self, other: Self) -> Self {
        match (self, other) {
            (Self::Never, fires) | (fires, Self::Never) => fires,
            (Self::Depends, _) | (_, Self::Depends) => Self::Depends,
            (Self::At(a), Self::At(b)) => Self::At(a.min(b)),
        }
    }
}

/// When an act or an event begins: at once, where nothing tells it.
pub fn start(of: &Node) -> Result<Fires, ReadError> {
    match of.child("StartTrigger") {
        Some(trigger) if trigger.has("ConditionGroup") => fires(trigger),
        _ => Ok(Fires::At(0.0)),
    }
}

/// When a trigger fires: any of its groups, all conditions of a group.
pub fn fires(trigger: &Node) -> Result<Fires, ReadError> {
    let mut any = Fires::Never;
    for group in trigger.all("ConditionGroup") {
        let mut all = Fires::At(0.0);
        let mut passes = false;
        for condition in group.all("Condition") {
            let (fires, is_short) = self::condition(condition)?;
            all = all.and(fires);
            passes |= is_short;
        }
        // What holds for a while only may be over when another condition is met.
        let alone = group.all("Condition").count() < 2;
        any = any.or(if passes && !alone {
            Fires::Depends
        } else {
            all
        });
    }
    Ok(any)
}

/// When a condition is met, and whether only for a while.
fn condition(condition: &Node) -> Result<(Fires, bool), ReadError> {
    let by_value =
        condition.first(|c| c.name == "ByValueCondition" && c.has("SimulationTimeCondition"));
    let Some(time) = by_value.and_then(|c| c.child("SimulationTimeCondition")) else {
        return Ok((Fires::Depends, false));
    };
    let delay = condition.or_zero("delay")?;
    let value = time.needed_number("value")?;
    let falls = condition.text("conditionEdge") == Some("falling");
    Ok(match time.text("rule") {
        _ if falls => (Fires::Depends, false),
        Some("lessThan" | "lessOrEqual") if value < 0.0 => (Fires::Never, false),
        Some("lessThan" | "lessOrEqual") => (Fires::At(delay), true),
        Some("equalTo") => (Fires::At(value + delay), true),
        Some("notEqualTo") => (Fires::Depends, false),
        _ => (Fires::At(value + delay), false),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::recordings::opendrive::tree;

    fn time(rule: &str, value: f64, delay: f64) -> String {
        format!(
            r#"<Condition delay="{delay}"><ByValueCondition><SimulationTimeCondition rule="{rule}" value="{value}"/></ByValueCondition></Condition>"#
        )
    }

    fn of(groups: &[&[String]]) -> Fires {
        let groups: String = groups
            .iter()
            .map(|g| format!("<ConditionGroup>{}</ConditionGroup>", g.concat()))
            .collect();
        let text = format!("<Event><StartTrigger>{groups}</StartTrigger></Event>");
        start(&tree::read(text.as_bytes(), "x", "Event").unwrap()).unwrap()
    }

    #[test]
    fn triggers_fire_at_moments_or_depend_on_others() {
        let later = |value| time("greaterOrEqual", value, 0.5);
        let entity = "<Condition><ByEntityCondition/></Condition>".to_string();
        assert_eq!(of(&[]), Fires::At(0.0));
        assert_eq!(of(&[&[later(2.0)]]), Fires::At(2.5));
        assert_eq!(of(&[&[later(2.0), later(4.0)]]), Fires::At(4.5));
        assert_eq!(of(&[&[later(2.0)], &[later(4.0)]]), Fires::At(2.5));
        assert_eq!(of(&[&[later(2.0), entity.clone()]]), Fires::Depends);
        assert_eq!(of(&[&[later(2.0)], &[entity]]), Fires::Depends);
        assert_eq!(of(&[&[time("lessThan", 9.0, 1.0)]]), Fires::At(1.0));
        assert_eq!(
            of(&[&[time("lessThan", 9.0, 0.0), later(99.0)]]),
            Fires::Depends
        );
        assert_eq!(of(&[&[time("lessThan", -1.0, 0.0)]]), Fires::Never);
    }
}
