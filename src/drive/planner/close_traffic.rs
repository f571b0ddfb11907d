//! The traffic that the candidates of one profile can meet: of all bodies, those near its stations.

use super::evaluate::CLEAR;
use super::motion::Station;
use super::traffic::{Occupied, Traffic};
use super::{Limits, Settings};

/// Bodies near the stations of a profile, step by step.
#[derive(Debug, Default)]
pub(super) struct CloseTraffic {
    boxes: Vec<Occupied>,
    /// Where the boxes of each step end.
    ends: Vec<usize>,
    /// Candidates faster than this at a step (m/s), or farther beside the path (m), have to look at all.
    fastest: Vec<f64>,
    widest: f64,
}

/// A candidate beside the path is faster than its profile by no more than this share and speed (m/s) but in sharp bends.
const FASTER: (f64, f64) = (1.1, 0.5);

/// Offsets go beyond the widest one by no more than this but for steep ones, metres.
const BEYOND: f64 = 0.5;

impl CloseTraffic {
    /// Takes from `traffic` what candidates along `stations` can meet; what it held is forgotten, its memory is used
    /// again.
    ///
    /// A body is left out if it is too far away to cost a candidate anything wherever that is beside its station, see
    /// `Judge::meet`: farther behind than bodies that are near, or farther away than one that is followed.
    pub fn take(
        &mut self,
        traffic: &Traffic,
        stations: &[Station],
        settings: &Settings,
        limits: &Limits,
    ) {
        self.boxes.clear();
        self.ends.clear();
        self.fastest.clear();
        self.widest = settings.sampling.widest + BEYOND;
        let aside = self.widest + limits.rear_to_centre;
        let own = (limits.length / 2.0).hypot(limits.width / 2.0);
        for (step, at) in stations.iter().enumerate() {
            let fastest = at.s[1] * FASTER.0 + FASTER.1;
            let stopping = settings.stopping(fastest);
            for other in traffic.at(step) {
                let (dx, dy) = (other.x - at.position.x, other.y - at.position.y);
                let near = own + other.reach + CLEAR;
                let ahead = stopping + near;
                let far = (ahead * ahead + near * near).sqrt() + aside;
                let along = dx * at.cos + dy * at.sin;
                if along > -(near + aside) && dx * dx + dy * dy < far * far {
                    self.boxes.push(*other);
                }
            }
            self.ends.push(self.boxes.len());
            self.fastest.push(fastest);
        }
    }

    /// The bodies at a step that a candidate with this speed (m/s) and offset (m) can meet; `None` where it has to look
    /// at all.
    #[inline]
    pub fn at(&self, step: usize, velocity: f64, offset: f64) -> Option<&[Occupied]> {
        if velocity > *self.fastest.get(step)? || offset.abs() > self.widest {
            return None;
        }
        let from = match step {
            0 => 0,
            _ => self.ends[step - 1],
        };
        self.boxes.get(from..self.ends[step])
    }
}
