//! Transverse Mercator projections, such as UTM: from degrees on WGS 84 to metres.

/// Semi-major axis, metres, and flattening of WGS 84; those of GRS 80 differ by less than a millimetre.
const AXIS: f64 = 6_378_137.0;
const FLATTENING: f64 = 1.0 / 298.257_223_563;

/// Scale of UTM along the central meridian.
const SCALE: f64 = 0.9996;

/// East of UTM's central meridian, metres.
const FALSE_EASTING: f64 = 500_000.0;

/// What UTM adds to north in the southern half, metres.
const FALSE_NORTHING: f64 = 10_000_000.0;

/// The zone of a longitude, from 1 to 60.
pub fn zone(longitude: f64) -> i64 {
    (((longitude + 180.0) / 6.0).floor() as i64).rem_euclid(60) + 1
}

/// East and north of a place, metres, in a zone of the northern half.
pub fn forward(latitude: f64, longitude: f64, zone: i64) -> (f64, f64) {
    TransverseMercator::utm(zone, false).forward(latitude, longitude)
}

/// A transverse Mercator projection of WGS 84.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransverseMercator {
    /// Longitude of its central meridian, degrees.
    pub meridian: f64,
    /// Latitude of its origin, degrees.
    pub latitude: f64,
    /// Along the central meridian.
    pub scale: f64,
    /// East and north of its origin, metres.
    pub origin: (f64, f64),
}

impl TransverseMercator {
    /// A zone of UTM, in the northern or southern half.
    pub fn utm(zone: i64, south: bool) -> Self {
        Self {
            meridian: zone as f64 * 6.0 - 183.0,
            latitude: 0.0,
            scale: SCALE,
            origin: (FALSE_EASTING, if south { FALSE_NORTHING } else { 0.0 }),
        }
    }

    /// The plane that touches the Earth at a place, which is its origin.
    pub fn around(latitude: f64, longitude: f64) -> Self {
        Self {
            meridian: longitude,
            latitude,
            scale: 1.0,
            origin: (0.0, 0.0),
        }
    }

    /// East and north of a place, metres.
    pub fn forward(&self, latitude: f64, longitude: f64) -> (f64, f64) {
        let (east, north) = krueger(latitude, longitude - self.meridian);
        let (_, zero) = krueger(self.latitude, 0.0);
        (
            self.origin.0 + self.scale * east,
            self.origin.1 + self.scale * (north - zero),
        )
    }
}

/// East of the central meridian and north of the equator, metres: the series of Krüger to the third order, exact to less
/// than a millimetre within a zone of UTM. Longitudes are from the meridian.
fn krueger(latitude: f64, longitude: f64) -> (f64, f64) {
    let n = FLATTENING / (2.0 - FLATTENING);
    let (n2, n3) = (n * n, n * n * n);
    let radius = AXIS / (1.0 + n) * (1.0 + n2 / 4.0 + n2 * n2 / 64.0);
    let alpha = [
        n / 2.0 - 2.0 / 3.0 * n2 + 5.0 / 16.0 * n3,
        13.0 / 48.0 * n2 - 3.0 / 5.0 * n3,
        61.0 / 240.0 * n3,
    ];
    let (phi, lambda) = (latitude.to_radians(), longitude.to_radians());
    let root = 2.0 * n.sqrt() / (1.0 + n);
    let t = (phi.sin().atanh() - root * (root * phi.sin()).atanh()).sinh();
    let xi = t.atan2(lambda.cos());
    let eta = (lambda.sin() / (1.0 + t * t).sqrt()).atanh();
    let (mut east, mut north) = (eta, xi);
    for (j, a) in (1..).zip(alpha) {
        let k = 2.0 * f64::from(j);
        east += a * (k * xi).cos() * (k * eta).sinh();
        north += a * (k * xi).sin() * (k * eta).cosh();
    }
    (radius * east, radius * north)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_places() {
        // On the central meridian at the equator; and a quarter of a meridian, 10,001,965.729 m, scaled.
        let (east, north) = forward(0.0, 9.0, 32);
        assert!((east - 500_000.0).abs() < 1e-6 && north.abs() < 1e-6);
        let (_, north) = forward(90.0, 9.0, 32);
        assert!((north - 10_001_965.729_3 * SCALE).abs() < 1e-2, "{north}");
        // The CN Tower, in the example of Wikipedia on UTM: 17N 630084 4833438.
        let (east, north) = forward(43.642_566_67, -79.387_138_89, 17);
        assert!((east - 630_084.0).abs() < 1.0, "{east}");
        assert!((north - 4_833_438.0).abs() < 1.5, "{north}");
        assert_eq!(zone(6.1), 32);
        assert_eq!(zone(-180.0), 1);
        let south = TransverseMercator::utm(32, true);
        assert!((south.forward(0.0, 9.0).1 - FALSE_NORTHING).abs() < 1e-6);
    }

    #[test]
    fn a_plane_around_a_place_has_true_metres() {
        let plane = TransverseMercator::around(48.0, 11.0);
        let (east, north) = plane.forward(48.0, 11.0);
        assert!(east.abs() < 1e-9 && north.abs() < 1e-9);
        // A second of latitude at 48° is 30.8863 m, one of longitude 20.7293 m: the series of the degree's length.
        let (east, north) = plane.forward(48.0 + 1.0 / 3600.0, 11.0 + 1.0 / 3600.0);
        assert!(
            (north - 30.8863).abs() < 2e-4 && (east - 20.7293).abs() < 2e-4,
            "{east} {north}"
        );
    }
}
