//! 2020a and 2024: regions of the world, and bodies of obstacles (`util.proto` of both).

use super::Point;

/// A `Shape` of 2020a, which is an `Occupancy` of 2024 on the wire.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Region {
    #[prost(oneof = "RegionShape", tags = "1, 2, 3, 4")]
    pub shape: Option<RegionShape>,
}

#[derive(Clone, PartialEq, prost::Oneof)]
pub enum RegionShape {
    #[prost(message, tag = "1")]
    Rectangle(Rectangle),
    #[prost(message, tag = "2")]
    Circle(Circle),
    #[prost(message, tag = "3")]
    Polygon(Polygon),
    #[prost(message, tag = "4")]
    Group(Group),
}

/// A `Shape` of 2024: an obstacle's body, centred on its origin.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Body {
    #[prost(oneof = "BodyShape", tags = "1, 2, 3, 4, 5")]
    pub shape: Option<BodyShape>,
}

/// What a body may be.
#[derive(Clone, PartialEq, prost::Oneof)]
pub enum BodyShape {
    #[prost(message, tag = "1")]
    Rectangle(Rectangle),
    #[prost(message, tag = "2")]
    Circle(Circle),
    #[prost(message, tag = "3")]
    Polygon(Polygon),
    #[prost(message, tag = "4")]
    Truck(TruckShape),
    #[prost(message, tag = "5")]
    SemiTrailerTruck(SemiTrailerTruckShape),
}

/// `TruckShape`.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct TruckShape {
    #[prost(message, optional, tag = "1")]
    pub truck_dims: Option<TruckDims>,
    #[prost(double, optional, tag = "2")]
    pub origin_x_shift: Option<f64>,
}

/// `TruckDims`.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct TruckDims {
    #[prost(double, optional, tag = "1")]
    pub length: Option<f64>,
    #[prost(double, optional, tag = "2")]
    pub width: Option<f64>,
    #[prost(double, optional, tag = "3")]
    pub wheelbase: Option<f64>,
    #[prost(double, optional, tag = "4")]
    pub dist_from_rear_to_rear_axle: Option<f64>,
    #[prost(double, optional, tag = "5")]
    pub cabin_length: Option<f64>,
    #[prost(double, optional, tag = "6")]
    pub dist_from_rear_axle_to_hitch: Option<f64>,
}

/// `SemiTrailerTruckShape`.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct SemiTrailerTruckShape {
    #[prost(message, optional, tag = "1")]
    pub truck_shape: Option<TruckShape>,
    #[prost(message, optional, tag = "2")]
    pub trailer_dims: Option<TrailerDims>,
}

/// `TrailerDims`.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct TrailerDims {
    #[prost(double, optional, tag = "1")]
    pub length: Option<f64>,
    #[prost(double, optional, tag = "2")]
    pub width: Option<f64>,
    #[prost(double, optional, tag = "3")]
    pub wheelbase: Option<f64>,
    #[prost(double, optional, tag = "4")]
    pub dist_from_front_to_hitch: Option<f64>,
}

/// A `Rect` of 2024 has neither centre nor orientation.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Rectangle {
    #[prost(double, optional, tag = "1")]
    pub length: Option<f64>,
    #[prost(double, optional, tag = "2")]
    pub width: Option<f64>,
    #[prost(message, optional, tag = "3")]
    pub center: Option<Point>,
    #[prost(double, optional, tag = "4")]
    pub orientation: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Circle {
    #[prost(double, optional, tag = "1")]
    pub radius: Option<f64>,
    #[prost(message, optional, tag = "2")]
    pub center: Option<Point>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct Polygon {
    #[prost(message, repeated, tag = "1")]
    pub vertices: Vec<Point>,
}

#[derive(Clone, PartialEq, prost::Message)]
pub struct Group {
    #[prost(message, repeated, tag = "1")]
    pub shapes: Vec<Region>,
}
