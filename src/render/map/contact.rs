//! Where the ego and another body touch at this step: a ring around the place.

use super::Map;
use super::bodies::rings;
use crate::render::display::{Area, Picture, Spot, Stroke};

/// Marks every contact; gives what the marks cover.
pub fn draw(map: &Map<'_>, picture: &mut Picture) -> Vec<Area> {
    let Some(scene) = map.subject.scene else {
        return Vec::new();
    };
    let (Some(ego), Some(motion)) = (scene.ego_at(map.step), scene.ego.track.at(map.step)) else {
        return Vec::new();
    };
    let own = rings(map, scene.ego_footprint_at(map.step), motion).concat();
    let mut covered = Vec::new();
    for other in scene.participants() {
        let Some(placed) = other.placed_at(map.step) else {
            continue;
        };
        if ego.distance(&placed) > 0.0 {
            continue;
        }
        let Some(there) = other.at(map.step) else {
            continue;
        };
        let ring = rings(map, other.footprint_at(map.step), there).concat();
        let at = between(&own, &ring);
        covered.push(mark(map, picture, at));
    }
    covered
}

/// The middle of what two outlines have in common, by their boxes of corners; of bodies that only touch, between them.
fn between(a: &[Spot], b: &[Spot]) -> Spot {
    let inside = |ring: &[Spot], p: &Spot| {
        let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
        let crossed = pairs.filter(|((x1, y1), (x2, y2))| {
            (*y1 > p.1) != (*y2 > p.1) && p.0 < (x2 - x1) * (p.1 - y1) / (y2 - y1) + x1
        });
        crossed.count() % 2 == 1
    };
    let mut common: Vec<Spot> = a.iter().filter(|p| inside(b, p)).copied().collect();
    common.extend(b.iter().filter(|p| inside(a, p)));
    common.extend(crossings(a, b));
    if common.is_empty() {
        common.extend(nearest(a, b));
    }
    let count = common.len().max(1) as f64;
    let sum = common
        .iter()
        .fold((0.0, 0.0), |s, p| (s.0 + p.0, s.1 + p.1));
    (sum.0 / count, sum.1 / count)
}

/// Where edges cross.
fn crossings(a: &[Spot], b: &[Spot]) -> Vec<Spot> {
    let edges = |ring: &[Spot]| -> Vec<(Spot, Spot)> {
        let next = ring.iter().cycle().skip(1);
        ring.iter().copied().zip(next.copied()).collect()
    };
    let mut found = Vec::new();
    for (p, q) in edges(a) {
        for (r, s) in edges(b) {
            let (d, e) = ((q.0 - p.0, q.1 - p.1), (s.0 - r.0, s.1 - r.1));
            let cross = d.0 * e.1 - d.1 * e.0;
            if cross.abs() < 1e-12 {
                continue;
            }
            let (x, y) = (r.0 - p.0, r.1 - p.1);
            let (t, u) = ((x * e.1 - y * e.0) / cross, (x * d.1 - y * d.0) / cross);
            if (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u) {
                found.push((p.0 + t * d.0, p.1 + t * d.1));
            }
        }
    }
    found
}

/// The two nearest corners.
fn nearest(a: &[Spot], b: &[Spot]) -> Vec<Spot> {
    let pairs = a.iter().flat_map(|p| b.iter().map(move |q| (*p, *q)));
    let far = |(p, q): &(Spot, Spot)| (p.0 - q.0).hypot(p.1 - q.1);
    let pair = pairs.min_by(|x, y| far(x).total_cmp(&far(y)));
    pair.map_or_else(Vec::new, |(p, q)| vec![p, q])
}

/// A ring with rays.
fn mark(map: &Map<'_>, picture: &mut Picture, (x, y): Spot) -> Area {
    let (palette, inner, outer) = (map.palette, 4.2, 7.0);
    let ring = Stroke::new(palette.danger, 1.1);
    let halo = Stroke::new(palette.background.at(0.85), 2.4);
    picture.circle((x, y), inner, None, Some(halo.clone()));
    let rays: Vec<[Spot; 2]> = (0..8)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * (f64::from(i) + 0.5) / 8.0).sin_cos();
            [
                (x + 5.2 * cos, y + 5.2 * sin),
                (x + outer * cos, y + outer * sin),
            ]
        })
        .collect();
    for ray in &rays {
        picture.line(ray, halo.clone());
    }
    picture.circle((x, y), inner, None, Some(ring.clone()));
    for ray in &rays {
        picture.line(ray, ring.clone());
    }
    Area {
        x: x - outer,
        y: y - outer,
        width: 2.0 * outer,
        height: 2.0 * outer,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_is_where_the_bodies_overlap() {
        let square = |x: f64, y: f64| [(x, y), (x + 4.0, y), (x + 4.0, y + 4.0), (x, y + 4.0)];
        let near = |a: Spot, b: Spot| (a.0 - b.0).hypot(a.1 - b.1) < 1e-9;
        assert!(near(
            between(&square(0.0, 0.0), &square(3.0, 3.0)),
            (3.5, 3.5)
        ));
        // A bar across: no corner of either lies in the other.
        let bar = [(-2.0, 1.0), (6.0, 1.0), (6.0, 2.0), (-2.0, 2.0)];
        assert!(near(between(&square(0.0, 0.0), &bar), (2.0, 1.5)));
    }
}
