//! Pictures with what reaches far beyond them, against the same without anything cut off.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use tiny_skia::Pixmap;

use super::super::raster::pixels;
use super::super::{Color, svg};
use super::*;

const SIZE: (f64, f64) = (120.0, 80.0);

/// So fine that the thinnest lines are wider than a pixel: of thinner ones the rasteriser moves where they show.
const FINE: f64 = 288.0;

fn color() -> Color {
    Color::hex(0x103060)
}

fn picture(items: Vec<Item>) -> Picture {
    let mut picture = Picture::new(SIZE, Color::hex(0xffffff));
    picture.items = items;
    picture
}

/// Polygons and lines of all kinds through these points.
fn items(points: &[Spot], width: f64) -> Vec<Item> {
    let mut picture = picture(Vec::new());
    let stroke = || Stroke::new(color(), width);
    picture.polygon(points, Some(color().at(0.5)), Some(stroke().rounded()));
    picture.polygon(points, None, Some(stroke()));
    picture.line(points, stroke().dashed(&[7.0, 5.0]));
    if let [(x, y), (r, _), ..] = points {
        picture.circle((*x, *y), *r, Some(color()), Some(stroke()));
    }
    picture.items
}

/// The share of pixels that are clearly different from every pixel around the same place of the other picture. The
/// rasteriser shifts thin lines by up to half a pixel depending on how long they are; what is missing shows.
fn difference(a: &Pixmap, b: &Pixmap) -> f64 {
    let one_way = |a: &Pixmap, b: &Pixmap| {
        let (width, height) = (a.width(), a.height());
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let missing = places.filter(|&(x, y)| {
            let red = a.pixel(x, y).unwrap().red();
            let mut around = (y.saturating_sub(1)..=(y + 1).min(height - 1))
                .flat_map(|y| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |x| (x, y)));
            around.all(|(x, y)| b.pixel(x, y).unwrap().red().abs_diff(red) > 40)
        });
        missing.count() as f64 / a.pixels().len() as f64
    };
    one_way(a, b).max(one_way(b, a))
}

fn far() -> impl Strategy<Value = f64> {
    prop_oneof![
        2 => -200.0..300.0_f64,
        4 => (3.0..308.0_f64, prop::bool::ANY).prop_map(|(e, minus)| {
            10_f64.powf(e) * if minus { -1.0 } else { 1.0 }
        }),
        1 => prop::sample::select(vec![5e7, -1e8, 1e15, f64::MAX, f64::NAN, f64::INFINITY]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_cut_off_is_not_missed(
        points in prop::collection::vec((-900.0..1000.0_f64, -900.0..1000.0_f64), 2..6),
        width in 0.3..6.0_f64,
    ) {
        let page = Area { x: 0.0, y: 0.0, width: SIZE.0, height: SIZE.1 };
        for item in items(&points, width) {
            let cut = cut(&item, &page, 1.0).unwrap_or_else(|| vec![item.clone()]);
            let whole = pixels(&picture(vec![item.clone()]), FINE).unwrap();
            let after = pixels(&picture(cut), FINE).unwrap();
            let differs = difference(&whole, &after);
            prop_assert!(differs < 0.005, "{differs} of the page: {item:?}");
        }
    }

    #[test]
    fn whatever_the_coordinates_there_is_a_picture(
        points in prop::collection::vec((far(), far()), 0..7),
        width in prop_oneof![0.1..5.0_f64, far()],
    ) {
        let picture = picture(items(&points, width));
        prop_assert!(pixels(&picture, 96.0).is_ok());
        let text = svg(&picture);
        prop_assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        prop_assert!(text.len() < 1_000_000);
    }
}

#[test]
fn what_is_near_is_painted_as_it_is() {
    let near = items(&[(-500.0, 3.0), (19_000.0, 40.0), (60.0, -15_000.0)], 1.0);
    let page = Area {
        x: 0.0,
        y: 0.0,
        width: SIZE.0,
        height: SIZE.1,
    };
    // The circle reaches too far.
    for item in &near[..3] {
        assert_eq!(cut(item, &page, UNCLIPPED_DISTANCE), None);
    }
}

#[test]
fn a_body_that_is_far_too_large_covers_the_page() {
    for far in [1e5, 1e8, 1e15, 1e300] {
        let ring = [(-far, -far), (far, -far), (far, far), (-far, far)];
        let mut picture = picture(Vec::new());
        picture.polygon(&ring, Some(color()), None);
        let painted = pixels(&picture, 72.0).unwrap();
        let first = painted.pixels()[0];
        assert!(
            painted.pixels().iter().all(|p| *p == first) && first.red() == 0x10,
            "{far}"
        );
    }
}
