//! Trucks and semi-trailers by the dimensions that CommonRoad gives them since 2026.

use super::shape::positive;
use super::{Point, Pose, Shape, ShapeError};

/// A truck or a tractor. Lengths in metres, along the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(tag = "kind", rename = "truck")]
pub struct Truck {
    /// From end to end.
    pub length: f64,
    /// Across.
    pub width: f64,
    /// Between the axles.
    pub wheelbase: f64,
    /// From the rear end to the rear axle.
    pub rear_to_rear_axle: f64,
    /// Of the driver's cabin.
    pub cabin_length: f64,
    /// From the rear axle to the hitch; positive towards the front.
    pub rear_axle_to_hitch: f64,
    /// Where the position of a state lies, from the middle of the truck; negative towards the rear.
    /// The rear axle by custom.
    pub origin_x_shift: f64,
}

/// The trailer of a semi-trailer truck. Lengths in metres, along the trailer.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SemiTrailer {
    /// From end to end.
    pub length: f64,
    /// Across.
    pub width: f64,
    /// From the hitch to its axles.
    pub wheelbase: f64,
    /// From its front to the hitch.
    pub front_to_hitch: f64,
}

impl Truck {
    /// Checks that the truck has an extent.
    ///
    /// # Errors
    /// A dimension that is not positive and finite.
    pub fn check(&self) -> Result<(), ShapeError> {
        positive("length of the truck", self.length)?;
        positive("width of the truck", self.width)
    }

    /// Its body in the frame of its states.
    #[must_use]
    pub fn rectangle(&self) -> Shape {
        Shape::Rectangle {
            length: self.length,
            width: self.width,
            center: Point::origin(),
            orientation: 0.0,
            origin_x_shift: self.origin_x_shift,
        }
    }

    /// Where the hitch is, in the frame of its states: along x, metres.
    #[must_use]
    pub fn hitch(&self) -> f64 {
        let rear_axle = self.rear_to_rear_axle - self.length / 2.0 - self.origin_x_shift;
        rear_axle + self.rear_axle_to_hitch
    }
}

impl SemiTrailer {
    /// Checks that the trailer has an extent.
    ///
    /// # Errors
    /// A dimension that is not positive and finite.
    pub fn check(&self) -> Result<(), ShapeError> {
        positive("length of the trailer", self.length)?;
        positive("width of the trailer", self.width)
    }

    /// Its body in the frame of the tractor's states, turned by `angle` radians about the hitch.
    #[must_use]
    pub fn rectangle(&self, tractor: &Truck, angle: f64) -> Shape {
        let hitch = Pose::new(tractor.hitch(), 0.0, angle);
        Shape::Rectangle {
            length: self.length,
            width: self.width,
            center: hitch.to_world(&Point::new(self.front_to_hitch - self.length / 2.0, 0.0)),
            orientation: angle,
            origin_x_shift: 0.0,
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::geometry::Bounds;

    fn semi_trailer_truck(hitch_angle: f64) -> Shape {
        let tractor = Truck {
            length: 6.0,
            width: 2.5,
            wheelbase: 3.6,
            rear_to_rear_axle: 1.0,
            cabin_length: 2.5,
            rear_axle_to_hitch: 0.5,
            origin_x_shift: -2.0,
        };
        let trailer = SemiTrailer {
            length: 13.0,
            width: 2.5,
            wheelbase: 7.8,
            front_to_hitch: 1.0,
        };
        Shape::SemiTrailerTruck {
            tractor,
            trailer,
            hitch_angle,
        }
    }

    #[test]
    fn the_origin_is_the_rear_axle_and_the_trailer_follows() {
        // Rear axle at 0: the tractor covers -1 to 5, the hitch is at 0.5, the trailer covers -11.5 to 1.5.
        let straight = semi_trailer_truck(0.0);
        let bounds = Bounds::from_points(straight.outlines().iter().flatten()).unwrap();
        assert!((bounds.min.x + 11.5).abs() < 1e-12 && (bounds.max.x - 5.0).abs() < 1e-12);
        assert!((straight.size().0 - 16.5).abs() < 1e-12);
    }

    #[test]
    fn the_trailer_turns_about_the_hitch() {
        // Turned by a right angle the trailer, which trails, lies to the right of the hitch.
        let bent = semi_trailer_truck(0.0).hitched_at(FRAC_PI_2).unwrap();
        let trailer = &bent.outlines()[1];
        let bounds = Bounds::from_points(trailer).unwrap();
        assert!((bounds.min.y + 12.0).abs() < 1e-12 && (bounds.max.y - 1.0).abs() < 1e-12);
        assert!((bounds.center().x - 0.5).abs() < 1e-12);
        assert!(Shape::rectangle(4.0, 2.0).hitched_at(0.1).is_none());
    }

    /// The corners that commonroad-io 2026.1 computes for the same dimensions and state.
    #[test]
    fn an_external_reference_case() {
        let tractor = Truck {
            length: 5.1,
            width: 2.55,
            wheelbase: 3.6,
            rear_to_rear_axle: 0.5,
            cabin_length: 2.5,
            rear_axle_to_hitch: 0.45,
            origin_x_shift: -1.7,
        };
        let trailer = SemiTrailer {
            length: 13.6,
            width: 2.5,
            wheelbase: 7.8,
            front_to_hitch: 0.9,
        };
        let shape = Shape::SemiTrailerTruck {
            tractor,
            trailer,
            hitch_angle: -0.35,
        };
        let pose = Pose::new(12.0, -3.0, 0.6);
        let expected = [
            [
                (14.787_757_21, 0.452_033_421),
                (16.227_595_517, -1.652_572_397),
            ],
            [
                (12.645_299_792, -1.509_731_662),
                (13.263_809_69, -3.932_012_716),
            ],
        ];
        for (ring, [front_left, front_right]) in shape.outlines().iter().zip(expected) {
            for (corner, (x, y)) in [(ring[0], front_left), (ring[3], front_right)] {
                let at = pose.to_world(&corner);
                assert!(
                    (at - Point::new(x, y)).norm() < 1e-8,
                    "{at} is not ({x}, {y})"
                );
            }
        }
    }

    #[test]
    fn a_truck_without_extent_is_refused() {
        let Shape::SemiTrailerTruck { mut tractor, .. } = semi_trailer_truck(0.0) else {
            panic!("made as one");
        };
        tractor.width = 0.0;
        assert!(Shape::Truck(tractor).check().is_err());
    }
}
