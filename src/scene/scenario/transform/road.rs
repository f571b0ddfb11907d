//! The road after a change of the plane: in a mirror left is right, on both sides of everything.

use super::plane::Plane;
use crate::scenario::{
    Adjacent, Bound, Incoming, Intersection, Lanelet, LaneletNetwork, LineMarking, Sign,
    SignElement, StopLine, TrafficDirection, TrafficLight,
};

impl Plane {
    pub(super) fn network(&self, network: &LaneletNetwork) -> LaneletNetwork {
        LaneletNetwork::new(
            network.lanelets.iter().map(|l| self.lanelet(l)).collect(),
            network.signs.iter().map(|s| self.sign(s)).collect(),
            network.lights.iter().map(|l| self.light(l)).collect(),
            if self.mirrored {
                network.intersections.iter().map(mirrored).collect()
            } else {
                network.intersections.clone()
            },
        )
    }

    fn lanelet(&self, lanelet: &Lanelet) -> Lanelet {
        let (left, right) = self.sides(self.bound(&lanelet.left), self.bound(&lanelet.right));
        let (before_left, before_right) = (lanelet.adjacent_left, lanelet.adjacent_right);
        let (adjacent_left, adjacent_right): (Option<Adjacent>, Option<Adjacent>) =
            self.sides(before_left, before_right);
        Lanelet {
            left,
            right,
            adjacent_left,
            adjacent_right,
            stop_line: lanelet.stop_line.as_ref().map(|line| self.stop_line(line)),
            ..lanelet.clone()
        }
    }

    fn sides<T>(&self, left: T, right: T) -> (T, T) {
        if self.mirrored {
            (right, left)
        } else {
            (left, right)
        }
    }

    fn bound(&self, bound: &Bound) -> Bound {
        Bound {
            points: bound.points.iter().map(|p| self.point(p)).collect(),
            heights: bound.heights.clone(),
            marking: self.marking(bound.marking),
        }
    }

    /// Of double lines the left one is named first.
    fn marking(&self, marking: LineMarking) -> LineMarking {
        match marking {
            LineMarking::SolidDashed if self.mirrored => LineMarking::DashedSolid,
            LineMarking::DashedSolid if self.mirrored => LineMarking::SolidDashed,
            other => other,
        }
    }

    /// Its ends stay in their order, from the left to the right.
    fn stop_line(&self, line: &StopLine) -> StopLine {
        let ends = |(a, b)| self.sides(self.point(&a), self.point(&b));
        StopLine {
            points: line.points.map(ends),
            marking: self.marking(line.marking),
            ..line.clone()
        }
    }

    fn sign(&self, sign: &Sign) -> Sign {
        let mut placed = sign.clone();
        placed.position = sign.position.map(|p| self.point(&p));
        if self.mirrored {
            placed.elements.iter_mut().for_each(mirror_element);
        }
        placed
    }

    fn light(&self, light: &TrafficLight) -> TrafficLight {
        use TrafficDirection as D;
        let direction = |direction| match direction {
            D::Right => D::Left,
            D::Left => D::Right,
            D::LeftStraight => D::StraightRight,
            D::StraightRight => D::LeftStraight,
            D::Straight | D::LeftRight | D::All => direction,
        };
        TrafficLight {
            position: light.position.map(|p| self.point(&p)),
            direction: if self.mirrored {
                light.direction.map(direction)
            } else {
                light.direction
            },
            ..light.clone()
        }
    }
}

/// Signs that tell left from right by their number: to the left, to the right.
const SIDED: &[(&str, &str)] = &[
    ("103-10", "103-20"),
    ("209-10", "209-20"),
    ("211-10", "211-20"),
    ("220-10", "220-20"),
    ("222-10", "222-20"),
    ("R3-5L", "R3-5R"),
    ("R6-1L", "R6-1R"),
];

fn mirror_element(element: &mut SignElement) {
    let id = element.id.as_str();
    let image = SIDED.iter().find_map(|(left, right)| match id {
        _ if id == *left => Some(*right),
        _ if id == *right => Some(*left),
        _ => None,
    });
    if let Some(image) = image {
        element.id = image.to_string();
    }
}

/// Left and right turns are swapped, and so are neighbours on the left and right.
fn mirrored(crossing: &Intersection) -> Intersection {
    let has_on_its_left = |id: i64| {
        let mut all = crossing.incomings.iter();
        all.find(|other| other.is_left_of == Some(id)).map(|o| o.id)
    };
    let incoming = |incoming: &Incoming| Incoming {
        right: incoming.left.clone(),
        left: incoming.right.clone(),
        is_left_of: has_on_its_left(incoming.id),
        ..incoming.clone()
    };
    Intersection {
        incomings: crossing.incomings.iter().map(incoming).collect(),
        ..crossing.clone()
    }
}
