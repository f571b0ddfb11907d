//! 2024: the road in the map file (`map/*.proto`), and what the dynamic file adds to it (`dynamic/traffic_*.proto`).

use super::{CycleElement, Point};

/// A `Lanelet` of the map; its borders and its stop line are elsewhere in the file.
#[derive(Clone, PartialEq, prost::Message)]
pub struct MapLanelet {
    #[prost(uint32, optional, tag = "1")]
    pub lanelet_id: Option<u32>,
    #[prost(int32, optional, tag = "2")]
    pub left_bound: Option<i32>,
    #[prost(int32, optional, tag = "3")]
    pub right_bound: Option<i32>,
    #[prost(bool, optional, tag = "4")]
    pub left_bound_reverse: Option<bool>,
    #[prost(bool, optional, tag = "5")]
    pub right_bound_reverse: Option<bool>,
    #[prost(uint32, repeated, packed = "false", tag = "6")]
    pub predecessors: Vec<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "7")]
    pub successors: Vec<u32>,
    #[prost(uint32, optional, tag = "8")]
    pub adjacent_left: Option<u32>,
    #[prost(uint32, optional, tag = "9")]
    pub adjacent_right: Option<u32>,
    #[prost(bool, optional, tag = "10")]
    pub adjacent_left_opposite_dir: Option<bool>,
    #[prost(bool, optional, tag = "11")]
    pub adjacent_right_opposite_dir: Option<bool>,
    #[prost(uint32, optional, tag = "12")]
    pub stop_line: Option<u32>,
    #[prost(int32, repeated, packed = "false", tag = "13")]
    pub lanelet_types: Vec<i32>,
    #[prost(int32, repeated, packed = "false", tag = "14")]
    pub user_one_way: Vec<i32>,
    #[prost(int32, repeated, packed = "false", tag = "15")]
    pub user_bidirectional: Vec<i32>,
    #[prost(uint32, repeated, packed = "false", tag = "16")]
    pub traffic_sign_refs: Vec<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "17")]
    pub traffic_light_refs: Vec<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "18")]
    pub adjacent_areas: Vec<u32>,
}

/// A `Bound` of the map: a border that lanelets share.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Boundary {
    #[prost(int32, optional, tag = "1")]
    pub boundary_id: Option<i32>,
    #[prost(message, repeated, tag = "2")]
    pub points: Vec<Point>,
    #[prost(int32, optional, tag = "3")]
    pub line_marking: Option<i32>,
}

/// A `StopLine` of the map.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct MapStopLine {
    #[prost(uint32, optional, tag = "1")]
    pub stop_line_id: Option<u32>,
    #[prost(message, optional, tag = "2")]
    pub start_point: Option<Point>,
    #[prost(message, optional, tag = "3")]
    pub end_point: Option<Point>,
    #[prost(int32, optional, tag = "4")]
    pub line_marking: Option<i32>,
}

/// A `TrafficSign` of the map.
#[derive(Clone, PartialEq, prost::Message)]
pub struct MapSign {
    #[prost(uint32, optional, tag = "1")]
    pub traffic_sign_id: Option<u32>,
    #[prost(message, repeated, tag = "2")]
    pub traffic_sign_elements: Vec<MapSignElement>,
    #[prost(message, optional, tag = "3")]
    pub position: Option<Point>,
    #[prost(bool, optional, tag = "4")]
    pub is_virtual: Option<bool>,
}

/// A `TrafficSignElement`: one enumeration for all countries.
#[derive(Clone, PartialEq, prost::Message)]
pub struct MapSignElement {
    #[prost(int32, optional, tag = "1")]
    pub element_id: Option<i32>,
    #[prost(string, repeated, tag = "2")]
    pub additional_values: Vec<String>,
}

/// A `TrafficLight` of the map; its cycle is in the dynamic file.
#[derive(Clone, PartialEq, prost::Message)]
pub struct MapLight {
    #[prost(uint32, optional, tag = "1")]
    pub traffic_light_id: Option<u32>,
    #[prost(message, optional, tag = "2")]
    pub position: Option<Point>,
    #[prost(int32, repeated, packed = "false", tag = "3")]
    pub color: Vec<i32>,
    #[prost(int32, optional, tag = "4")]
    pub direction: Option<i32>,
}

/// An `Intersection` of the map; its outgoing groups are not decoded, nothing here can hold them.
#[derive(Clone, PartialEq, prost::Message)]
pub struct MapIntersection {
    #[prost(uint32, optional, tag = "1")]
    pub intersection_id: Option<u32>,
    #[prost(message, repeated, tag = "2")]
    pub incomings: Vec<IncomingGroup>,
    #[prost(bytes = "vec", repeated, tag = "3")]
    pub outgoings: Vec<Vec<u8>>,
    #[prost(message, repeated, tag = "4")]
    pub crossings: Vec<CrossingGroup>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct IncomingGroup {
    #[prost(uint32, optional, tag = "1")]
    pub incoming_group_id: Option<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "2")]
    pub incoming_lanelets: Vec<u32>,
    #[prost(uint32, optional, tag = "3")]
    pub outgoing_group_id: Option<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "4")]
    pub outgoing_right: Vec<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "5")]
    pub outgoing_straight: Vec<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "6")]
    pub outgoing_left: Vec<u32>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct CrossingGroup {
    #[prost(uint32, optional, tag = "1")]
    pub crossing_group_id: Option<u32>,
    #[prost(uint32, repeated, packed = "false", tag = "2")]
    pub crossing_lanelets: Vec<u32>,
    #[prost(uint32, optional, tag = "3")]
    pub incoming_group_id: Option<u32>,
    #[prost(uint32, optional, tag = "4")]
    pub outgoing_group_id: Option<u32>,
}

/// Of the dynamic file.
#[derive(Clone, PartialEq, prost::Message)]
pub struct TrafficLightCycle {
    #[prost(uint32, optional, tag = "1")]
    pub traffic_light_id: Option<u32>,
    #[prost(message, repeated, tag = "2")]
    pub cycle_elements: Vec<CycleElement>,
    #[prost(uint32, optional, tag = "4")]
    pub time_offset: Option<u32>,
    #[prost(bool, optional, tag = "6")]
    pub active: Option<bool>,
}

/// A `TrafficSignValue` of the dynamic file: what a sign of the map says in this scenario.
#[derive(Clone, PartialEq, prost::Message)]
pub struct SignValue {
    #[prost(uint32, optional, tag = "1")]
    pub traffic_sign_id: Option<u32>,
    #[prost(message, repeated, tag = "2")]
    pub traffic_sign_elements: Vec<MapSignElement>,
}
