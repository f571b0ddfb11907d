//! The surface of the road, lane borders by what is painted there, crossings, stop lines, lights and signs.

use nearmiss_scene::scenario::{Sign, SignElement, SignMeaning, SignalColor};
use nearmiss_settings::Theme;

use super::{Map, WorkbenchMap};
use crate::Color;
use crate::display::{Anchor, Area, Item, Picture, Segment, Spot, Stroke, Text, closed};
use crate::scene::{
    Border, DASH, MarkingLine, Paint, STRIPE, StopLine, Surface, SurfaceKind, offset,
};

/// Width of a painted line, metres.
const LINE: f64 = 0.15;
/// Stripes that lean less than this, as a slope, are upright or across.
const UPRIGHT: f64 = 0.15;
/// Where a character is wider than this, metres, the surface alone shows the road: lines within it would run together.
const FAR: f64 = 2.6;

pub fn draw(map: &Map<'_>, picture: &mut Picture) {
    let surfaces = || map.scene.surfaces.iter();
    picture.group("road", None, |p| match map.workbench {
        Some(look) if look.filled => grounds(map, look.theme, p),
        Some(_) => {}
        None => {
            let palette = map.palette;
            areas(map, p, palette.road.towards(palette.background, BESIDE));
            let roads = surfaces().filter(|s| s.kind != SurfaceKind::Crossing);
            roads.for_each(|road| surface(map, p, road));
        }
    });
    if let Some(look) = map.workbench {
        picture.group("junctions", None, |p| {
            merged(map, p, look.theme.map_junction, &|s| s.is_crossed);
        });
    }
    picture.group("crossings", None, |p| {
        let crossings = surfaces().filter(|s| s.kind == SurfaceKind::Crossing);
        crossings.for_each(|s| crossing(map, p, s));
    });
    picture.group("markings", None, |p| {
        map.scene.borders.iter().for_each(|b| border(map, p, b));
        let stop_lines = map.scene.stop_lines.iter();
        stop_lines.for_each(|line| stop_line(map, p, line));
    });
}

fn surface(map: &Map<'_>, picture: &mut Picture, surface: &Surface) {
    let color = match surface.kind {
        SurfaceKind::Sidewalk | SurfaceKind::Bicycle => map.palette.path,
        _ => map.palette.road,
    };
    let ring = map.view.all(&surface.ring);
    // A thin line of the same colour closes the seams between neighbours.
    picture.polygon(&ring, Some(color), Some(Stroke::new(color, 0.5).rounded()));
}

/// How much drivable areas, shoulders and parking spaces look like the ground: the part of the way from the road's colour.
const BESIDE: f64 = 0.3;

/// Drivable areas beside the lanes, below all else.
fn areas(map: &Map<'_>, picture: &mut Picture, color: Color) {
    for area in &map.scene.areas {
        picture.polygon(&map.view.all(&area.ring), Some(color), None);
    }
}

/// Roads over what lies beside them; junctions go over the lanes that lead through them.
fn grounds(map: &Map<'_>, theme: &Theme<Color>, picture: &mut Picture) {
    use SurfaceKind as K;
    let (road, beside) = (theme.map_road, theme.map_ground);
    let shoulder = road.towards(beside, BESIDE);
    areas(map, picture, shoulder);
    let of_kind = |kinds: &'static [K]| move |s: &Surface| kinds.contains(&s.kind);
    let mut merged =
        |color, is_meant: &dyn Fn(&Surface) -> bool| merged(map, picture, color, is_meant);
    merged(road.towards(beside, 0.55), &of_kind(&[K::Verge]));
    merged(theme.map_path, &of_kind(&[K::Sidewalk, K::Bicycle]));
    merged(shoulder, &of_kind(&[K::Shoulder, K::Parking]));
    merged(road, &of_kind(&[K::Driving, K::Bus, K::Crossing]));
}

/// All surfaces that are meant as one, so that there are no seams between neighbours.
fn merged(map: &Map<'_>, picture: &mut Picture, color: Color, is_meant: &dyn Fn(&Surface) -> bool) {
    let meant = map.scene.surfaces.iter().filter(|s| is_meant(s));
    let path: Vec<Segment> = meant.flat_map(|s| closed(&map.view.all(&s.ring))).collect();
    let fill = Some(color);
    picture
        .items
        .extend((!path.is_empty()).then_some(Item::Path {
            path,
            fill,
            stroke: None,
        }));
}

/// Fewer stripes than this, wider than they are, are no crossing.
const FEWEST: usize = 3;

/// Stripes along the way of those who drive, as they are painted on the road; in characters as wide as these show, if
/// there are some then.
fn crossing(map: &Map<'_>, picture: &mut Picture, crossing: &Surface) {
    let palette = map.palette;
    let ring = map.view.all(&crossing.ring);
    let (shade, stripe, stripes) = match map.workbench {
        None => (
            palette.road.towards(palette.lane, 0.35),
            palette.crosswalk,
            crossing.stripes(STRIPE),
        ),
        Some(look) => {
            let (road, paint) = (look.theme.map_road, look.theme.crosswalk);
            let wide = STRIPE.max(finest(map, crossing) * look.cell);
            let mut stripes = crossing.stripes(wide);
            if !look.markings || wide > STRIPE && stripes.len() < FEWEST {
                stripes.clear();
            }
            let shade = road.towards(paint, if stripes.is_empty() { 0.4 } else { 0.12 });
            (shade, road.towards(paint, 0.6), stripes)
        }
    };
    if map.workbench.is_some_and(|look| !look.filled) {
        return picture.polygon(&ring, None, Some(Stroke::new(palette.crosswalk, 0.6)));
    }
    picture.polygon(&ring, Some(shade), None);
    // Stripes that would be finer than a hair become a surface.
    if map.points(STRIPE) < 0.5 {
        return;
    }
    for ring in stripes {
        picture.polygon(&map.view.all(&ring), Some(stripe), None);
    }
}

/// How wide stripes are at least, in characters: finer ones would be a pattern of their own. Characters part their cells
/// upright best, then across.
fn finest(map: &Map<'_>, crossing: &Surface) -> f64 {
    let Some((left, right)) = crossing.across(f64::MAX, 0.0).next() else {
        return f64::MAX;
    };
    let (from, to) = (map.view.at(&left), map.view.at(&right));
    let (across, down) = ((to.0 - from.0).abs(), (to.1 - from.1).abs());
    if across < UPRIGHT * down {
        0.5
    } else if down < UPRIGHT * across {
        1.0
    } else {
        1.5
    }
}

fn border(map: &Map<'_>, picture: &mut Picture, border: &Border) {
    let width = map.points(LINE).clamp(0.35, 1.6);
    if map.workbench.is_some_and(|look| !look.markings) {
        let stroke = Stroke::new(map.palette.lane_dashed, 0.5 * width);
        return picture.line(&map.view.all(&border.points), stroke);
    }
    for line in border.lines {
        if map
            .workbench
            .is_some_and(|look| is_left_out(&look, border, line.paint))
        {
            continue;
        }
        let stroke = stroke(map, line, width);
        let points = match line.offset {
            0.0 => map.view.all(&border.points),
            aside => map
                .view
                .all(&offset(&border.points, aside * width / map.view.scale)),
        };
        picture.line(&points, stroke);
    }
}

/// In the workbench borders of which nothing is known are not drawn across the lanes of a junction; in characters none
/// is, and where surfaces end they are seen without a line. From far away only painted ones are.
fn is_left_out(look: &WorkbenchMap<'_>, border: &Border, paint: Paint) -> bool {
    if (border.is_crossed || border.is_edge && look.filled) && look.cell > 0.0 {
        return true;
    }
    match paint {
        Paint::None | Paint::Unknown => border.is_crossed || look.cell > FAR,
        Paint::Dashed => look.cell > FAR,
        Paint::Solid | Paint::Curb | Paint::LoweredCurb => look.cell > 2.0 * FAR,
    }
}

/// A line of a marking; `width` is that of a painted line, points.
fn stroke(map: &Map<'_>, line: &MarkingLine, width: f64) -> Stroke {
    let palette = map.palette;
    let (wide, dash) = (line.width * width, map.points(DASH));
    let (solid, broken) = match map.workbench {
        Some(look) if look.filled => [look.theme.map_marking; 2].into(),
        _ => (palette.lane, palette.lane_dashed),
    };
    let is_figure = map.workbench.is_none();
    let faded = |by: f64| solid.towards(palette.road, by);
    match line.paint {
        Paint::Solid | Paint::Curb => Stroke::new(solid, wide).rounded(),
        Paint::LoweredCurb => Stroke::new(faded(0.4), wide).rounded(),
        Paint::Dashed if dash >= 1.2 => Stroke::new(broken, wide).dashed(&[dash, dash]),
        // Dashes that would run together are a lighter line.
        Paint::Dashed => Stroke::new(broken.towards(palette.road, 0.5), wide),
        Paint::None => Stroke::new(faded(0.7), if is_figure { 0.25 } else { width }),
        Paint::Unknown => Stroke::new(faded(0.4), if is_figure { 0.35 } else { width }),
    }
}

fn stop_line(map: &Map<'_>, picture: &mut Picture, line: &StopLine) {
    let width = map.points(0.4).clamp(0.8, 2.4);
    let mut stroke = Stroke::new(map.palette.lane, width);
    let dash = map.points(0.6);
    if line.dashed && dash > 0.8 {
        stroke = stroke.dashed(&[dash, dash * 0.6]);
    }
    picture.line(&map.view.all(&line.ends), stroke);
}

/// On a map that is wider than this, metres, posts would lie over each other.
const MAX_WIDTH_WITH_POSTS: f64 = 120.0;

pub fn draw_posts(map: &Map<'_>, picture: &mut Picture) {
    let has_words = map.workbench.is_some_and(|look| look.cell > 0.0);
    if has_words || map.view.width() > MAX_WIDTH_WITH_POSTS {
        return;
    }
    let mut taken: Vec<Area> = Vec::new();
    // Posts at the same place would hide each other: the first one stands for all.
    let mut free = |(x, y): Spot| {
        let area = Area {
            x: x - 4.0,
            y: y - 4.0,
            width: 8.0,
            height: 8.0,
        };
        let free = map.shows(&area) && !taken.iter().any(|t| t.meets(&area));
        if free {
            taken.push(area);
        }
        free
    };
    for light in &map.scene.lights {
        let at = map.view.at(&light.at);
        if free(at) {
            lamp(map, picture, at, light.color);
        }
    }
    for post in map.scene.signs.iter().filter(|post| !post.sign.is_virtual) {
        let at = map.view.at(&post.at);
        if free(at) {
            plate(map, picture, at, post.sign);
        }
    }
}

/// Three lamps; those that are on have their colour and their place.
fn lamp(map: &Map<'_>, picture: &mut Picture, (x, y): Spot, color: SignalColor) {
    let housing = Area {
        x: x - 1.7,
        y: y - 4.3,
        width: 3.4,
        height: 8.6,
    };
    let edge = Stroke::new(map.palette.background, 0.4);
    picture.rectangle(&housing, Some(Color::hex(0x222222)), Some(edge));
    let red = matches!(color, SignalColor::Red | SignalColor::RedYellow);
    let yellow = matches!(color, SignalColor::Yellow | SignalColor::RedYellow);
    let green = color == SignalColor::Green;
    let lamps = [
        (red, Color::hex(0xff4030)),
        (yellow, Color::hex(0xffc400)),
        (green, Color::hex(0x20d060)),
    ];
    for (i, (on, lit)) in lamps.into_iter().enumerate() {
        let at = (x, y + (i as f64 - 1.0) * 2.7);
        let fill = if on { lit } else { Color::hex(0x4a4a4a) };
        picture.circle(at, 1.15, Some(fill), None);
    }
}

const RED: Color = Color::hex(0xc1121f);
const WHITE: Color = Color::hex(0xffffff);
const BLACK: Color = Color::hex(0x111111);

/// A sign in its own shape where that is known, else a small square.
fn plate(map: &Map<'_>, picture: &mut Picture, (x, y): Spot, sign: &Sign) {
    let ring = |corners: u8, turn: f64, r: f64| -> Vec<Spot> {
        let corner = |i: u8| {
            let angle = std::f64::consts::TAU * (f64::from(i) + turn) / f64::from(corners);
            (x + r * angle.sin(), y - r * angle.cos())
        };
        (0..corners).map(corner).collect()
    };
    let red = || Some(Stroke::new(RED, 0.7));
    let known = sign
        .elements
        .iter()
        .find_map(|e| Some((e, Kind::from_sign(e)?)));
    match known {
        Some((_, Kind::Stop)) => {
            picture.polygon(&ring(8, 0.5, 3.0), Some(RED), Some(Stroke::new(WHITE, 0.4)));
        }
        Some((_, Kind::Yield)) => picture.polygon(&ring(3, 0.5, 3.2), Some(WHITE), red()),
        Some((_, Kind::Priority)) => {
            let edge = Some(Stroke::new(BLACK, 0.3));
            picture.polygon(&ring(4, 0.0, 3.2), Some(WHITE), edge);
            picture.polygon(&ring(4, 0.0, 2.0), Some(Color::hex(0xf2b705)), None);
        }
        Some((element, Kind::Limit)) => {
            picture.circle((x, y), 3.3, Some(WHITE), red());
            if let Some(SignMeaning::SpeedLimit(speed)) = element.meaning()
                && speed < 100.0
            {
                let words = format!("{:.0}", sign.speed_shown(speed).0);
                let text = Text::new((x, y + 1.1), words, 3.0, BLACK);
                picture.text(text.in_bold(true).anchored(Anchor::Middle));
            }
        }
        None => {
            let edge = Some(Stroke::new(map.palette.dim, 0.4));
            picture.polygon(&ring(4, 0.5, 2.2), Some(map.palette.background), edge);
        }
    }
}

enum Kind {
    Stop,
    Yield,
    Priority,
    Limit,
}

impl Kind {
    /// By the German number, which most files use, or the American one.
    fn from_sign(element: &SignElement) -> Option<Self> {
        match element.id.as_str() {
            "206" | "R1-1" => Some(Self::Stop),
            "205" | "R1-2" => Some(Self::Yield),
            "301" | "306" => Some(Self::Priority),
            "274" | "R2-1" => Some(Self::Limit),
            _ => {
                matches!(element.meaning(), Some(SignMeaning::SpeedLimit(_))).then_some(Self::Limit)
            }
        }
    }
}
