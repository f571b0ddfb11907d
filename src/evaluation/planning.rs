//! How motions are planned, by the names that configuration files have for it.

use toml::Value;

use crate::planner::{self, Forecast};
use crate::scenario::VehicleType;
use crate::simulation::Settings;

/// What is planned with by default: every step anew, the others along their lanes.
#[must_use]
pub fn default_planning() -> Settings {
    Settings {
        planner: planner::Settings::default(),
        forecast: Forecast::Lane,
        replan: 1,
        without: None,
    }
}

/// A number that planning takes.
struct Knob {
    id: &'static str,
    get: fn(&Settings) -> Value,
    set: fn(&mut Settings, f64),
}

macro_rules! knobs {
    ($($id:literal $($field:ident).+ as $kind:ident;)+) => {
        const KNOBS: &[Knob] = &[$(knobs!(@$kind $id, $($field).+)),+];
    };
    (@number $id:literal, $($field:ident).+) => {
        Knob { id: $id, get: |s| Value::Float(s.$($field).+), set: |s, x| s.$($field).+ = x }
    };
    (@count $id:literal, $($field:ident).+) => {
        Knob {
            id: $id,
            get: |s| Value::Integer(i64::try_from(s.$($field).+).unwrap_or(i64::MAX)),
            set: |s, x| s.$($field).+ = x as usize,
        }
    };
}

knobs! {
    "horizon" planner.horizon as number;
    "replan" replan as count;
    "share" planner.share as number;
    "low_speed" planner.low_speed as number;
    "margin" planner.margin as number;
    "braking" planner.braking as number;
    "reaction" planner.reaction as number;
    "sampling.durations" planner.sampling.durations as count;
    "sampling.speeds" planner.sampling.speeds as count;
    "sampling.offsets" planner.sampling.offsets as count;
    "sampling.changes" planner.sampling.changes as count;
    "sampling.widest" planner.sampling.widest as number;
    "sampling.refinements" planner.sampling.refinements as count;
    "weights.longitudinal_jerk" planner.weights.longitudinal_jerk as number;
    "weights.lateral_jerk" planner.weights.lateral_jerk as number;
    "weights.acceleration" planner.weights.acceleration as number;
    "weights.speed" planner.weights.speed as number;
    "weights.offset" planner.weights.offset as number;
    "weights.clearance" planner.weights.clearance as number;
    "weights.following" planner.weights.following as number;
    "weights.risk" planner.weights.risk as number;
}

/// The value of the setting with this name; nothing where there is none.
#[must_use]
pub fn planning_value(settings: &Settings, id: &str) -> Option<Value> {
    match id {
        "prediction" => Some(Value::String(settings.forecast.name().into())),
        "vehicle" => Some(Value::Integer(settings.planner.vehicle.number().into())),
        _ => KNOBS.iter().find(|k| k.id == id).map(|k| (k.get)(settings)),
    }
}

/// Sets the setting of this name; the reader of the value has checked its bounds.
///
/// # Errors
/// There is no such setting, or the value is none of its kind: in words.
pub fn set_planning(settings: &mut Settings, id: &str, value: &Value) -> Result<(), String> {
    let wrong = || format!("planner.{id} = {value}: this is no value of it");
    match id {
        "prediction" => {
            let forecast = value.as_str().and_then(Forecast::parse);
            settings.forecast = forecast.ok_or_else(wrong)?;
        }
        "vehicle" => {
            let vehicle = VehicleType::parse(&value.to_string());
            settings.planner.vehicle = vehicle.ok_or_else(wrong)?;
        }
        _ => {
            let knob = KNOBS.iter().find(|knob| knob.id == id);
            let knob = knob.ok_or_else(|| format!("planner.{id} is not known"))?;
            let whole = value.as_integer().map(|n| n as f64);
            let number = whole.or(value.as_float()).ok_or_else(wrong)?;
            (knob.set)(settings, number);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_setting_is_one_of_its_own() {
        let mut settings = default_planning();
        for (place, knob) in KNOBS.iter().enumerate() {
            let value = Value::Integer(1000 + place as i64);
            set_planning(&mut settings, knob.id, &value).unwrap();
        }
        for (place, knob) in KNOBS.iter().enumerate() {
            let value = planning_value(&settings, knob.id).unwrap();
            let number = value.as_float().or(value.as_integer().map(|n| n as f64));
            assert_eq!(number, Some(1000.0 + place as f64), "{}", knob.id);
        }
        set_planning(&mut settings, "vehicle", &Value::Integer(4)).unwrap();
        assert_eq!(settings.planner.vehicle, VehicleType::Truck);
        set_planning(
            &mut settings,
            "prediction",
            &Value::String("recorded".into()),
        )
        .unwrap();
        assert_eq!(settings.forecast, Forecast::Recorded);
        for (id, value) in [
            ("vehicle", Value::Integer(7)),
            ("prediction", Value::String("oracle".into())),
            ("horizon", Value::String("4".into())),
            ("speed", Value::Integer(4)),
        ] {
            assert!(set_planning(&mut settings, id, &value).is_err(), "{id}");
        }
    }
}
