//! Universal Transverse Mercator: from degrees on WGS 84 to metres.

/// Semi-major axis, metres, and flattening of WGS 84.
const AXIS: f64 = 6_378_137.0;
const FLATTENING: f64 = 1.0 / 298.257_223_563;

/// Scale along the central meridian.
const SCALE: f64 = 0.9996;

/// East of the central meridian, metres.
const FALSE_EASTING: f64 = 500_000.0;

/// The zone of a longitude, from 1 to 60.
pub fn zone(longitude: f64) -> i64 {
    (((longitude + 180.0) / 6.0).floor() as i64).rem_euclid(60) + 1
}

/// East and north of a place, metres, in a zone of the northern half: the series of Krüger to the third order, exact to
/// less than a millimetre within a zone.
pub fn forward(latitude: f64, longitude: f64, zone: i64) -> (f64, f64) {
    let n = FLATTENING / (2.0 - FLATTENING);
    let (n2, n3) = (n * n, n * n * n);
    let radius = AXIS / (1.0 + n) * (1.0 + n2 / 4.0 + n2 * n2 / 64.0);
    let alpha = [
        n / 2.0 - 2.0 / 3.0 * n2 + 5.0 / 16.0 * n3,
        13.0 / 48.0 * n2 - 3.0 / 5.0 * n3,
        61.0 / 240.0 * n3,
    ];
    let middle = (zone as f64 * 6.0 - 183.0).to_radians();
    let (phi, lambda) = (latitude.to_radians(), longitude.to_radians() - middle);
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
    (
        FALSE_EASTING + SCALE * radius * east,
        SCALE * radius * north,
    )
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
    }
}
