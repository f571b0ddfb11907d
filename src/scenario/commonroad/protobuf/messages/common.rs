//! 2020a and 2024: points, numbers that may be intervals, points in time (`util.proto` of both).

/// `z` is of 2024 only.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Point {
    #[prost(double, optional, tag = "1")]
    pub x: Option<f64>,
    #[prost(double, optional, tag = "2")]
    pub y: Option<f64>,
    #[prost(double, optional, tag = "3")]
    pub z: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct IntegerInterval {
    #[prost(int32, optional, tag = "1")]
    pub start: Option<i32>,
    #[prost(int32, optional, tag = "2")]
    pub end: Option<i32>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct FloatInterval {
    #[prost(double, optional, tag = "1")]
    pub start: Option<f64>,
    #[prost(double, optional, tag = "2")]
    pub end: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct IntegerExactOrInterval {
    #[prost(int32, optional, tag = "1")]
    pub exact: Option<i32>,
    #[prost(message, optional, tag = "2")]
    pub interval: Option<IntegerInterval>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct FloatExactOrInterval {
    #[prost(double, optional, tag = "1")]
    pub exact: Option<f64>,
    #[prost(message, optional, tag = "2")]
    pub interval: Option<FloatInterval>,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct TimeStamp {
    #[prost(uint32, optional, tag = "1")]
    pub year: Option<u32>,
    #[prost(uint32, optional, tag = "2")]
    pub month: Option<u32>,
    #[prost(uint32, optional, tag = "3")]
    pub day: Option<u32>,
    #[prost(uint32, optional, tag = "4")]
    pub hour: Option<u32>,
    #[prost(uint32, optional, tag = "5")]
    pub minute: Option<u32>,
}
