//! Where a scenario takes place, and in what surroundings, as JSON.

use serde_json::{Value, json};

use crate::scenario::{Environment, GeoTransformation, Location};

pub fn location(location: &Location) -> Value {
    json!({
        "geo_name_id": location.geo_name_id,
        "gps_latitude": location.latitude,
        "gps_longitude": location.longitude,
        "geo_transformation": location.transformation.as_ref().map(transformation),
        "environment": location.environment.as_ref().map(environment),
    })
}

fn transformation(transformation: &GeoTransformation) -> Value {
    json!({
        "geo_reference": transformation.reference,
        "x_translation": transformation.x,
        "y_translation": transformation.y,
        "z_rotation": transformation.rotation,
        "scaling": transformation.scaling,
    })
}

fn environment(environment: &Environment) -> Value {
    json!({
        "time": environment.time,
        "time_of_day": environment.time_of_day,
        "weather": environment.weather,
        "underground": environment.underground,
    })
}
