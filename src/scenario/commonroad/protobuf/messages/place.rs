//! 2020a and 2024: location and environment (`location.proto`; in 2024 the environment is part of the dynamic file).

use super::TimeStamp;

/// Without an environment in 2024.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Location {
    #[prost(int32, optional, tag = "1")]
    pub geo_name_id: Option<i32>,
    #[prost(double, optional, tag = "2")]
    pub gps_latitude: Option<f64>,
    #[prost(double, optional, tag = "3")]
    pub gps_longitude: Option<f64>,
    #[prost(message, optional, tag = "4")]
    pub geo_transformation: Option<GeoTransformation>,
    #[prost(message, optional, tag = "5")]
    pub environment: Option<Environment>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct GeoTransformation {
    #[prost(string, optional, tag = "1")]
    pub geo_reference: Option<String>,
    #[prost(double, optional, tag = "2")]
    pub x_translation: Option<f64>,
    #[prost(double, optional, tag = "3")]
    pub y_translation: Option<f64>,
    #[prost(double, optional, tag = "4")]
    pub z_rotation: Option<f64>,
    #[prost(double, optional, tag = "5")]
    pub scaling: Option<f64>,
}

/// The numbers of its words differ between the versions.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Environment {
    #[prost(message, optional, tag = "1")]
    pub time: Option<TimeStamp>,
    #[prost(int32, optional, tag = "2")]
    pub time_of_day: Option<i32>,
    #[prost(int32, optional, tag = "3")]
    pub weather: Option<i32>,
    #[prost(int32, optional, tag = "4")]
    pub underground: Option<i32>,
}
