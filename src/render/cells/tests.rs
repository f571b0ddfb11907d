//! Cells of small scenes, worked out by hand.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier};

use super::canvas::Canvas;
use super::{Blocks, CellView, MapStyle};
use nearmiss_base::geometry::Pose;

const GROUND: Color = Color::Rgb(10, 10, 10);
const BODY: Color = Color::Rgb(200, 0, 0);
const LINE: Color = Color::Rgb(0, 0, 200);

/// Ten columns of 1 m, five rows of 2 m; up is north.
fn drawn(style: MapStyle, draw: impl FnOnce(&mut Canvas<'_>)) -> Buffer {
    let north = Pose::new(0.0, 0.0, std::f64::consts::FRAC_PI_2);
    let view = CellView::new(north, (5.0, 5.0), (1.0, 2.0));
    let area = Rect::new(0, 0, 10, 5);
    let mut canvas = Canvas::new(&view, area, style, GROUND);
    draw(&mut canvas);
    let mut buffer = Buffer::empty(area);
    canvas.paint(&mut buffer, area);
    buffer
}

fn rectangle(x: (f64, f64), y: (f64, f64)) -> [(f64, f64); 4] {
    [(x.0, y.0), (x.1, y.0), (x.1, y.1), (x.0, y.1)]
}

#[test]
fn a_body_covers_whole_cells_and_halves() {
    // From the left edge of column 2 to the middle of column 4, the lower half of row 2 and all of row 3.
    let body = rectangle((-3.0, -0.5), (-3.0, 0.0));
    for (blocks, half) in [
        (Blocks::Quadrants, '▄'),
        (Blocks::Sextants, '🬭'),
        (Blocks::Octants, '▄'),
    ] {
        let buffer = drawn(MapStyle::Cells(blocks), |canvas| {
            canvas.layer();
            canvas.area(&body, BODY);
        });
        let cell = |column, row| {
            let cell = &buffer[(column, row)];
            (cell.symbol().to_string(), cell.fg, cell.bg)
        };
        assert_eq!(cell(0, 0).2, GROUND, "{blocks:?}");
        assert_eq!(cell(2, 3).2, BODY, "{blocks:?}");
        if blocks != Blocks::Sextants {
            assert_eq!(cell(2, 2), (half.to_string(), BODY, GROUND), "{blocks:?}");
        }
        assert_eq!(cell(4, 3), ("▌".into(), BODY, GROUND), "{blocks:?}");
    }
}

#[test]
fn lines_are_seen_on_the_ground_and_hidden_by_bodies() {
    let style = MapStyle::Cells(Blocks::Quadrants);
    let buffer = drawn(style, |canvas| {
        canvas.line((-5.0, 0.9), (5.0, 0.9), LINE);
        canvas.layer();
        canvas.area(&rectangle((-1.0, 1.0), (-1.0, 1.0)), BODY);
        canvas.layer();
        canvas.line((0.4, -5.0), (0.4, 5.0), LINE);
    });
    assert_eq!(
        (
            buffer[(0, 2)].symbol(),
            buffer[(0, 2)].fg,
            buffer[(0, 2)].bg
        ),
        ("⠉", LINE, GROUND)
    );
    assert_eq!((buffer[(4, 2)].symbol(), buffer[(4, 2)].bg), (" ", BODY));
    // Drawn later, a line lies on the body.
    assert_eq!(
        (
            buffer[(5, 2)].symbol(),
            buffer[(5, 2)].fg,
            buffer[(5, 2)].bg
        ),
        ("⡇", LINE, BODY)
    );
}

#[test]
fn without_backgrounds_bodies_are_solid_and_lanes_dim() {
    let plain = |style| {
        drawn(style, |canvas| {
            canvas.faint(true);
            canvas.line((-5.0, 4.9), (5.0, 4.9), Color::Reset);
            canvas.faint(false);
            canvas.layer();
            canvas.area(&rectangle((-1.0, 1.0), (-1.0, 1.0)), Color::Reset);
        })
    };
    let buffer = plain(MapStyle::Braille);
    assert_eq!(buffer[(4, 2)].symbol(), "█");
    assert_eq!(buffer[(0, 0)].symbol(), "⠉");
    assert!(buffer[(0, 0)].modifier.contains(Modifier::DIM));
    assert!(buffer.content.iter().all(|cell| cell.bg == Color::Reset));
    let buffer = plain(MapStyle::Ascii);
    assert_eq!(
        (buffer[(4, 2)].symbol(), buffer[(0, 0)].symbol()),
        ("#", "'")
    );
    assert!(buffer.content.iter().all(|cell| cell.symbol().is_ascii()));
}

#[test]
fn lines_of_any_length_are_cut_off() {
    for far in [1e3, 1e9, 1e300, f64::INFINITY, f64::NAN] {
        drawn(MapStyle::Braille, |canvas| {
            canvas.line((-far, -far), (far, 3.0), LINE);
            canvas.bar((0.0, 0.0), (far, far), LINE);
            canvas.area(&rectangle((-far, far), (0.0, far)), LINE);
            canvas.scatter(&rectangle((-far, far), (0.0, far)), LINE);
            canvas.point((far, far), LINE);
        });
    }
}

#[test]
fn without_colours_shades_tell_bodies_from_the_ego() {
    let drawn = |style| {
        drawn(style, |canvas| {
            let place = |ring: [(f64, f64); 4]| vec![ring.to_vec()];
            let other = canvas.silhouette(&place(rectangle((-3.0, -1.0), (-1.0, 3.0))), (0.0, 0.0));
            let ego = canvas.silhouette(&place(rectangle((-1.0, 1.5), (-1.0, 3.0))), (0.0, 0.0));
            canvas.layer();
            canvas.fill(&other, Color::Reset, true);
            canvas.fill(&ego, Color::Reset, false);
        })
    };
    let buffer = drawn(MapStyle::Braille);
    let row: String = (0..10).map(|x| buffer[(x, 1)].symbol()).collect();
    assert_eq!(row, "  ▒▒██▌   ");
    let buffer = drawn(MapStyle::Ascii);
    let row: String = (0..10).map(|x| buffer[(x, 1)].symbol()).collect();
    assert_eq!(row, "  %%###   ");
}
