//! 2020a and 2024: states and signal states (`obstacle.proto`, `common/state.proto`).

use prost::bytes::{Buf, BufMut};
use prost::encoding::{DecodeContext, WireType, message, skip_field};
use prost::{DecodeError, Message};

use super::{FloatExactOrInterval, IntegerExactOrInterval, Point, Region};

/// A state. Fields 3 to 38 are quantities of one type, of which a state has a few: they are kept in a list, or a
/// file of empty states would take hundreds of times its own size.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct State {
    pub point: Option<Point>,
    pub shape: Option<Box<Region>>,
    /// Number of the field and its value, each number once.
    pub quantities: Vec<(u32, FloatExactOrInterval)>,
    pub time_step: Option<IntegerExactOrInterval>,
}

const POINT: u32 = 1;
const SHAPE: u32 = 2;
const QUANTITIES: std::ops::RangeInclusive<u32> = 3..=38;
const TIME_STEP: u32 = 39;

impl Message for State {
    fn encode_raw(&self, buf: &mut impl BufMut) {
        if let Some(point) = &self.point {
            message::encode(POINT, point, buf);
        }
        if let Some(shape) = &self.shape {
            message::encode(SHAPE, &**shape, buf);
        }
        for (number, value) in &self.quantities {
            message::encode(*number, value, buf);
        }
        if let Some(time) = &self.time_step {
            message::encode(TIME_STEP, time, buf);
        }
    }

    fn merge_field(
        &mut self,
        tag: u32,
        wire_type: WireType,
        buf: &mut impl Buf,
        ctx: DecodeContext,
    ) -> Result<(), DecodeError> {
        match tag {
            POINT => message::merge(wire_type, self.point.get_or_insert_default(), buf, ctx),
            SHAPE => message::merge(
                wire_type,
                &mut **self.shape.get_or_insert_default(),
                buf,
                ctx,
            ),
            TIME_STEP => {
                message::merge(wire_type, self.time_step.get_or_insert_default(), buf, ctx)
            }
            number if QUANTITIES.contains(&number) => {
                let known = self.quantities.iter().position(|(n, _)| *n == number);
                let place = known.unwrap_or_else(|| {
                    self.quantities
                        .push((number, FloatExactOrInterval::default()));
                    self.quantities.len() - 1
                });
                message::merge(wire_type, &mut self.quantities[place].1, buf, ctx)
            }
            _ => skip_field(wire_type, tag, buf, ctx),
        }
    }

    fn encoded_len(&self) -> usize {
        let point = self.point.iter().map(|p| message::encoded_len(POINT, p));
        let shape = self.shape.iter().map(|s| message::encoded_len(SHAPE, &**s));
        let quantities = self
            .quantities
            .iter()
            .map(|(n, q)| message::encoded_len(*n, q));
        let time = self
            .time_step
            .iter()
            .map(|t| message::encoded_len(TIME_STEP, t));
        point.chain(shape).chain(quantities).chain(time).sum()
    }

    fn clear(&mut self) {
        *self = Self::default();
    }
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct SignalState {
    #[prost(message, optional, tag = "1")]
    pub time_step: Option<IntegerExactOrInterval>,
    #[prost(bool, optional, tag = "2")]
    pub horn: Option<bool>,
    #[prost(bool, optional, tag = "3")]
    pub indicator_left: Option<bool>,
    #[prost(bool, optional, tag = "4")]
    pub indicator_right: Option<bool>,
    #[prost(bool, optional, tag = "5")]
    pub braking_lights: Option<bool>,
    #[prost(bool, optional, tag = "6")]
    pub hazard_warning_lights: Option<bool>,
    #[prost(bool, optional, tag = "7")]
    pub flashing_blue_lights: Option<bool>,
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_state_reads_back_and_the_last_value_of_a_field_counts() {
        let exact = |value| FloatExactOrInterval {
            exact: Some(value),
            interval: None,
        };
        let state = State {
            point: Some(Point {
                x: Some(1.0),
                y: Some(-2.0),
                z: None,
            }),
            shape: None,
            quantities: vec![(3, exact(0.5)), (38, exact(7.0))],
            time_step: Some(IntegerExactOrInterval {
                exact: Some(-4),
                interval: None,
            }),
        };
        let mut bytes = state.encode_to_vec();
        assert_eq!(bytes.len(), state.encoded_len());
        assert_eq!(State::decode(bytes.as_slice()).unwrap(), state);
        let again = State {
            quantities: vec![(3, exact(9.0))],
            ..State::default()
        };
        bytes.extend(again.encode_to_vec());
        let read = State::decode(bytes.as_slice()).unwrap();
        assert_eq!(read.quantities, [(3, exact(9.0)), (38, exact(7.0))]);
    }
}
