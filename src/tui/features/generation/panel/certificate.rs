//! The certificate of a variant in words: what the ideal driver does who survives it, when at the latest, and why that
//! counts.

use nearmiss_drive::generation::EvasionRecord;
use nearmiss_scene::description::visible;
use nearmiss_scene::scenario::{HumanLimits, ObstacleType};
use ratatui::style::Style;

use crate::theme::Theme;
use crate::widgets::row::Lines;

/// What is certified of a variant.
pub struct Certified<'a> {
    /// Reaction times in seconds, the shortest first, with why none survives with it; `None` where an ideal driver does.
    pub delays: Vec<(String, Option<String>)>,
    /// What the ideal driver does with the longest one that survives.
    pub driver: Option<&'a EvasionRecord>,
    /// The last step before an attacker leaves its recorded motion.
    pub from: i64,
    /// The step of the contact that is avoided.
    pub contact: Option<i64>,
    /// Seconds between two steps.
    pub dt: f64,
}

impl Certified<'_> {
    /// Adds what the ideal driver does, and with which reaction times.
    pub fn add_to(&self, lines: &mut Lines, theme: &Theme) {
        lines.title(match self.driver {
            Some(_) => "an ideal driver avoids it",
            None => "no way was found to avoid it",
        });
        if let Some(driver) = self.driver {
            self.drive(lines, theme, driver);
        }
        let delays = self.delays.iter();
        let survived = delays.filter(|(_, why)| why.is_none());
        let avoided: Vec<&str> = survived.map(|(delay, _)| delay.as_str()).collect();
        let mut name = "reaction";
        if !avoided.is_empty() {
            lines.say(name, &format!("avoided with {} s", avoided.join(", ")));
            name = "";
        }
        for (delay, why) in &self.delays {
            if let Some(why) = why {
                let style = Style::new().fg(theme.warning);
                lines.say_in(
                    name,
                    &format!("not with {delay} s: {}", visible(why)),
                    style,
                );
                name = "";
            }
        }
    }

    fn drive(&self, lines: &mut Lines, theme: &Theme, driver: &EvasionRecord) {
        let time = |step: i64| step as f64 * self.dt;
        lines.say("manoeuvre", &manoeuvre_words(driver));
        if let Some(step) = driver.departs_after_step {
            let after = time(step - self.from);
            let mut words = format!(
                "at {:.1} s at the latest, {after:.1} s after the attack begins",
                time(step)
            );
            if let Some(contact) = self.contact {
                let left = time(contact - step);
                words.push_str(&format!(" and {left:.1} s before the contact"));
            }
            lines.say("begins", &words);
        }
        if let Some(peak) = driver.max_acceleration {
            let people = HumanLimits::for_kind(ObstacleType::Car).braking;
            let mut words = format!("{peak:.1} m/s² acceleration, along and across together");
            let mut style = Style::new();
            if peak > people {
                words.push_str(&format!("; a human driver brakes with up to {people:.1}"));
                style = style.fg(theme.warning);
            }
            lines.say_in("peak", &words, style);
        }
        lines.say("driver", "ideal: it knows all motions to come");
        if let Some(last) = driver.ends.last_step {
            let words = format!(
                "no contact up to {:.1} s, nor 2 s straight on from there; on the road, within the limits of its vehicle",
                time(last)
            );
            lines.say("checked", &words);
        }
        if !driver.rules_broken.is_empty() {
            let rules = driver.rules_broken.join(", ").replace('_', " ");
            lines.say("breaks", &visible(&rules));
        }
        if let Some(step) = driver.leaves_roadway_step {
            lines.say("leaves", &format!("the lanelets of cars at step {step}"));
        }
    }
}

/// What it does, as one sentence without a subject.
fn manoeuvre_words(driver: &EvasionRecord) -> String {
    let Some(manoeuvre) = &driver.manoeuvre else {
        return match driver.found_by.strip_prefix("planner, ") {
            Some(name) => format!(
                "drives as the built-in planner ({}) that knows all motions to come",
                visible(name)
            ),
            None => visible(&driver.found_by).into_owned(),
        };
    };
    // What is asked for may be more than the tyres give.
    let most = driver.max_acceleration.unwrap_or(f64::INFINITY);
    let acceleration = manoeuvre.acceleration.max(-most);
    let until = manoeuvre.until_speed;
    let along = match acceleration {
        ..-0.05 if until < 0.05 => {
            format!("brakes with {:.1} m/s² to a standstill", -acceleration)
        }
        ..-0.05 => format!("brakes with {:.1} m/s² to {until:.1} m/s", -acceleration),
        0.05.. => format!("speeds up with {acceleration:.1} m/s² to {until:.1} m/s"),
        _ => "keeps its speed".into(),
    };
    let across = match manoeuvre.offset {
        ..-0.05 => format!("steers to {:.2} m right of its path", -manoeuvre.offset),
        0.05.. => format!("steers to {:.2} m left of its path", manoeuvre.offset),
        _ => "stays on its path".into(),
    };
    format!("{along} and {across}")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn what_it_does_is_a_sentence() {
        let record = |json: &str| serde_json::from_str::<EvasionRecord>(json).unwrap();
        let does = |json: &str| manoeuvre_words(&record(json));
        let braking = r#"{"manoeuvre": {"acceleration": -11.5, "until_speed": 0, "offset": -1.34, "grip": 0.5}}"#;
        assert_eq!(
            does(braking),
            "brakes with 11.5 m/s² to a standstill and steers to 1.34 m right of its path"
        );
        let beyond = r#"{"manoeuvre": {"acceleration": -11.5, "until_speed": 0, "offset": 0, "grip": 0.5}, "max_acceleration": 11.4}"#;
        assert_eq!(
            does(beyond),
            "brakes with 11.4 m/s² to a standstill and stays on its path"
        );
        let slowing =
            r#"{"manoeuvre": {"acceleration": -4, "until_speed": 7.5, "offset": 0, "grip": 0.5}}"#;
        assert_eq!(
            does(slowing),
            "brakes with 4.0 m/s² to 7.5 m/s and stays on its path"
        );
        let faster =
            r#"{"manoeuvre": {"acceleration": 3, "until_speed": 12, "offset": 1, "grip": 0.5}}"#;
        assert_eq!(
            does(faster),
            "speeds up with 3.0 m/s² to 12.0 m/s and steers to 1.00 m left of its path"
        );
        assert_eq!(
            does(r#"{"found_by": "planner, fine"}"#),
            "drives as the built-in planner (fine) that knows all motions to come"
        );
        let unchanged = r#"{"found_by": "driving on as if nothing had changed"}"#;
        assert_eq!(does(unchanged), "driving on as if nothing had changed");
    }
}
