//! 2020a and 2024: obstacles and what is predicted of them (`*_obstacle.proto` of both).
//!
//! `B` is the message of an obstacle's body: [`super::Region`] in 2020a, [`super::Body`] in 2024.

use std::fmt::Debug;

use prost::Message;

use super::{IntegerExactOrInterval, Region, SignalState, State};

#[derive(Clone, PartialEq, Message)]
pub struct StaticObstacle<B: Message + Default + Debug> {
    #[prost(uint32, optional, tag = "1")]
    pub static_obstacle_id: Option<u32>,
    #[prost(int32, optional, tag = "2")]
    pub obstacle_type: Option<i32>,
    #[prost(message, optional, tag = "3")]
    pub shape: Option<B>,
    #[prost(message, optional, tag = "4")]
    pub initial_state: Option<State>,
    #[prost(message, optional, tag = "5")]
    pub initial_signal_state: Option<SignalState>,
    #[prost(message, repeated, tag = "6")]
    pub signal_series: Vec<SignalState>,
}

/// Fields from 9 on are of 2024 only, and not decoded: nothing here can hold them.
#[derive(Clone, PartialEq, Message)]
pub struct DynamicObstacle<B: Message + Default + Debug> {
    #[prost(uint32, optional, tag = "1")]
    pub dynamic_obstacle_id: Option<u32>,
    #[prost(int32, optional, tag = "2")]
    pub obstacle_type: Option<i32>,
    #[prost(message, optional, tag = "3")]
    pub shape: Option<B>,
    #[prost(message, optional, tag = "4")]
    pub initial_state: Option<State>,
    #[prost(message, optional, tag = "5")]
    pub trajectory_prediction: Option<TrajectoryPrediction<B>>,
    #[prost(message, optional, tag = "6")]
    pub set_based_prediction: Option<SetBasedPrediction>,
    #[prost(message, optional, tag = "7")]
    pub initial_signal_state: Option<SignalState>,
    #[prost(message, repeated, tag = "8")]
    pub signal_series: Vec<SignalState>,
    #[prost(bytes = "vec", optional, tag = "9")]
    pub initial_meta_information_state: Option<Vec<u8>>,
    #[prost(bytes = "vec", repeated, tag = "10")]
    pub meta_information_series: Vec<Vec<u8>>,
    #[prost(uint32, optional, tag = "11")]
    pub external_dataset_id: Option<u32>,
}

#[derive(Clone, PartialEq, Message)]
pub struct TrajectoryPrediction<B: Message + Default + Debug> {
    #[prost(message, optional, tag = "1")]
    pub trajectory: Option<Trajectory>,
    #[prost(message, optional, tag = "2")]
    pub shape: Option<B>,
}

#[derive(Clone, PartialEq, Message)]
pub struct Trajectory {
    #[prost(uint32, optional, tag = "1")]
    pub initial_time_step: Option<u32>,
    #[prost(message, repeated, tag = "2")]
    pub states: Vec<State>,
}

#[derive(Clone, PartialEq, Message)]
pub struct SetBasedPrediction {
    #[prost(uint32, optional, tag = "1")]
    pub initial_time_step: Option<u32>,
    #[prost(message, optional, tag = "2")]
    pub occupancy_set: Option<OccupancySet>,
}

#[derive(Clone, PartialEq, Message)]
pub struct OccupancySet {
    #[prost(message, repeated, tag = "1")]
    pub occupancies: Vec<Occupancy>,
}

/// An `OccupancyWithTime` in 2024.
#[derive(Clone, PartialEq, Message)]
pub struct Occupancy {
    #[prost(message, optional, tag = "1")]
    pub time_step: Option<IntegerExactOrInterval>,
    #[prost(message, optional, tag = "2")]
    pub shape: Option<Region>,
}

/// Part of the map in 2024, with types of its own.
#[derive(Clone, PartialEq, Message)]
pub struct EnvironmentObstacle {
    #[prost(uint32, optional, tag = "1")]
    pub environment_obstacle_id: Option<u32>,
    #[prost(int32, optional, tag = "2")]
    pub obstacle_type: Option<i32>,
    #[prost(message, optional, tag = "3")]
    pub obstacle_shape: Option<Region>,
}

#[derive(Clone, PartialEq, Message)]
pub struct PhantomObstacle {
    #[prost(uint32, optional, tag = "1")]
    pub obstacle_id: Option<u32>,
    #[prost(message, optional, tag = "2")]
    pub prediction: Option<SetBasedPrediction>,
}
