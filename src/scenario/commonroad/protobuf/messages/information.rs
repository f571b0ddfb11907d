//! 2020a and 2024: what a file says about itself (`commonroad.proto`, `common/scenario_meta_information.proto`).

use super::TimeStamp;

/// Of 2020a.
#[derive(Clone, PartialEq, prost::Message)]
pub struct ScenarioInformation {
    #[prost(string, optional, tag = "1")]
    pub common_road_version: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub benchmark_id: Option<String>,
    #[prost(message, optional, tag = "3")]
    pub date: Option<TimeStamp>,
    #[prost(string, optional, tag = "4")]
    pub author: Option<String>,
    #[prost(string, optional, tag = "5")]
    pub affiliation: Option<String>,
    #[prost(string, optional, tag = "6")]
    pub source: Option<String>,
    #[prost(double, optional, tag = "7")]
    pub time_step_size: Option<f64>,
}

/// Of 2024, as all that follow.
#[derive(Clone, PartialEq, prost::Message)]
pub struct MapId {
    #[prost(string, optional, tag = "1")]
    pub country_id: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub map_name: Option<String>,
    #[prost(uint64, optional, tag = "3")]
    pub map_id: Option<u64>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct ScenarioId {
    #[prost(bool, optional, tag = "1")]
    pub cooperative: Option<bool>,
    #[prost(message, optional, tag = "2")]
    pub map_id: Option<MapId>,
    #[prost(uint64, optional, tag = "3")]
    pub configuration_id: Option<u64>,
    #[prost(string, optional, tag = "4")]
    pub obstacle_behavior: Option<String>,
    #[prost(uint64, optional, tag = "5")]
    pub prediction_id: Option<u64>,
    #[prost(string, optional, tag = "6")]
    pub scenario_version: Option<String>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct FileInformation {
    #[prost(string, optional, tag = "1")]
    pub license_name: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub license_text: Option<String>,
    #[prost(message, optional, tag = "3")]
    pub date: Option<TimeStamp>,
    #[prost(string, optional, tag = "4")]
    pub author: Option<String>,
    #[prost(string, optional, tag = "5")]
    pub affiliation: Option<String>,
    #[prost(string, optional, tag = "6")]
    pub source: Option<String>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct ScenarioMetaInformation {
    #[prost(message, optional, tag = "1")]
    pub benchmark_id: Option<ScenarioId>,
    #[prost(message, optional, tag = "2")]
    pub file_information: Option<FileInformation>,
    #[prost(double, optional, tag = "3")]
    pub time_step_size: Option<f64>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct MapInformation {
    #[prost(message, optional, tag = "1")]
    pub map_id: Option<MapId>,
    #[prost(message, optional, tag = "2")]
    pub file_information: Option<FileInformation>,
}
