//! 2020a: lanelets, signs, lights and intersections (`lanelet.proto`, `traffic_*.proto`, `intersection.proto`).

use super::Point;

#[derive(Clone, PartialEq, prost::Message)]
pub struct Lanelet {
    #[prost(uint32, optional, tag = "1")]
    pub lanelet_id: Option<u32>,
    #[prost(message, optional, tag = "2")]
    pub left_bound: Option<Bound>,
    #[prost(message, optional, tag = "3")]
    pub right_bound: Option<Bound>,
    #[prost(uint32, repeated, packed = "false", tag = "4")]
    pub predecessors: Vec<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "5")]
    pub successors: Vec<u32>,
    #[prost(uint32, optional, tag = "6")]
    pub adjacent_left: Option<u32>,
    #[prost(uint32, optional, tag = "7")]
    pub adjacent_right: Option<u32>,
    #[prost(int32, optional, tag = "8")]
    pub adjacent_left_dir: Option<i32>,
    #[prost(int32, optional, tag = "9")]
    pub adjacent_right_dir: Option<i32>,
    #[prost(message, optional, tag = "10")]
    pub stop_line: Option<StopLine>,
    #[prost(int32, repeated, packed = "false", tag = "11")]
    pub lanelet_types: Vec<i32>,
    #[prost(int32, repeated, packed = "false", tag = "12")]
    pub user_one_way: Vec<i32>,
    #[prost(int32, repeated, packed = "false", tag = "13")]
    pub user_bidirectional: Vec<i32>,
    #[prost(uint32, repeated, packed = "false", tag = "14")]
    pub traffic_sign_refs: Vec<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "15")]
    pub traffic_light_refs: Vec<u32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct Bound {
    #[prost(message, repeated, tag = "1")]
    pub points: Vec<Point>,
    #[prost(int32, optional, tag = "2")]
    pub line_marking: Option<i32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct StopLine {
    #[prost(message, repeated, tag = "1")]
    pub points: Vec<Point>,
    #[prost(int32, optional, tag = "2")]
    pub line_marking: Option<i32>,
    #[prost(uint32, repeated, packed = "false", tag = "3")]
    pub traffic_sign_refs: Vec<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "4")]
    pub traffic_light_refs: Vec<u32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct TrafficSign {
    #[prost(uint32, optional, tag = "1")]
    pub traffic_sign_id: Option<u32>,
    #[prost(message, repeated, tag = "2")]
    pub traffic_sign_elements: Vec<TrafficSignElement>,
    #[prost(uint32, repeated, packed = "false", tag = "3")]
    pub first_occurrences: Vec<u32>,
    #[prost(message, optional, tag = "4")]
    pub position: Option<Point>,
    #[prost(bool, optional, tag = "5")]
    pub is_virtual: Option<bool>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct TrafficSignElement {
    #[prost(
        oneof = "SignNumber",
        tags = "1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12, 13, 14"
    )]
    pub number: Option<SignNumber>,
    #[prost(string, repeated, tag = "15")]
    pub additional_values: Vec<String>,
}

/// Each country has an enumeration of its own.
#[derive(Clone, Copy, PartialEq, Eq, prost::Oneof)]
pub enum SignNumber {
    #[prost(int32, tag = "1")]
    Germany(i32),
    #[prost(int32, tag = "2")]
    Zamunda(i32),
    #[prost(int32, tag = "3")]
    Usa(i32),
    #[prost(int32, tag = "4")]
    China(i32),
    #[prost(int32, tag = "5")]
    Spain(i32),
    #[prost(int32, tag = "7")]
    Russia(i32),
    #[prost(int32, tag = "8")]
    Argentina(i32),
    #[prost(int32, tag = "9")]
    Belgium(i32),
    #[prost(int32, tag = "10")]
    France(i32),
    #[prost(int32, tag = "11")]
    Greece(i32),
    #[prost(int32, tag = "12")]
    Croatia(i32),
    #[prost(int32, tag = "13")]
    Italy(i32),
    #[prost(int32, tag = "14")]
    PuertoRico(i32),
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct TrafficLight {
    #[prost(uint32, optional, tag = "1")]
    pub traffic_light_id: Option<u32>,
    #[prost(message, repeated, tag = "2")]
    pub cycle_elements: Vec<CycleElement>,
    #[prost(message, optional, tag = "3")]
    pub position: Option<Point>,
    #[prost(uint32, optional, tag = "4")]
    pub time_offset: Option<u32>,
    #[prost(int32, optional, tag = "5")]
    pub direction: Option<i32>,
    #[prost(bool, optional, tag = "6")]
    pub active: Option<bool>,
}

/// The same in 2024.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct CycleElement {
    #[prost(uint32, optional, tag = "1")]
    pub duration: Option<u32>,
    #[prost(int32, optional, tag = "2")]
    pub color: Option<i32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct Intersection {
    #[prost(uint32, optional, tag = "1")]
    pub intersection_id: Option<u32>,
    #[prost(message, repeated, tag = "2")]
    pub incomings: Vec<Incoming>,
    #[prost(uint32, repeated, packed = "false", tag = "3")]
    pub crossing_lanelets: Vec<u32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct Incoming {
    #[prost(uint32, optional, tag = "1")]
    pub incoming_id: Option<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "2")]
    pub incoming_lanelets: Vec<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "3")]
    pub successors_right: Vec<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "4")]
    pub successors_straight: Vec<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "5")]
    pub successors_left: Vec<u32>,
    #[prost(uint32, optional, tag = "6")]
    pub is_left_of: Option<u32>,
}
