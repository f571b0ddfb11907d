//! Places the labels of obstacles, and draws the legend.

use nearmiss_base::geometry::{Bounds, Point, Vector, ring_within};
use nearmiss_render::cells::{MapStyle, attacker_color, heading_arrow};
use nearmiss_render::scene::{GoalArea, Importance, LineStyle, MAX_NAMED, MapScene, Owner, Role};
use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use unicode_width::UnicodeWidthStr;

use crate::features::map::draw::CellView;
use crate::features::map::draw::bodies::Placed;
use crate::model::{Foreseen, Foresight, Model, Moment, On, Trails};

struct Label {
    text: String,
    style: Style,
    /// Around the vehicle.
    body: Area,
    owner: Owner,
}

pub fn draw(
    board: &mut LabelPlacer<'_>,
    model: &Model,
    moment: &Moment<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    let theme = &model.theme;
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    let touches = |id| scene.contacts.iter().any(|contact| contact.obstacle == id);
    let mut labels = Vec::new();
    for named in scene.named(MAX_NAMED) {
        let outside = !view.sees_point(&named.motion.pose.position);
        let corners = named.rings.iter().flatten().map(|p| view.at(p));
        let Some(body) = Body::around(corners) else {
            continue;
        };
        let (text, style) = match named.owner {
            Owner::Ego => match moment.opened.planned {
                Some(_) => ("ego planned".into(), bold(theme.ego)),
                None => ("ego".into(), bold(theme.ego)),
            },
            _ if outside || !(model.map.layers.labels || named.highlighted.is_some()) => continue,
            Owner::Obstacle(id) => match (touches(id), named.importance) {
                (true, _) => (format!("X {id} contact"), bold(theme.danger)),
                (_, Importance::Danger) => (format!("! {id}"), bold(theme.danger)),
                (_, Importance::Highlighted) => (id.to_string(), bold(theme.picked)),
                (_, Importance::Risky) => (id.to_string(), Style::new().fg(theme.warning)),
                _ => (id.to_string(), Style::new().fg(theme.dim)),
            },
        };
        let place = scene.attacker_place(named.owner);
        let (text, style) = match (named.role, place) {
            (_, None) => (text, style),
            (Role::Attacker(place), _) => (
                format!("{text} attacker"),
                bold(attacker_color(theme, place)),
            ),
            _ => (format!("{text} recorded"), style),
        };
        let body = board.cells(&body);
        labels.push(Label {
            text,
            style,
            body,
            owner: named.owner,
        });
    }
    // The attacker's label has its place before all others.
    labels.sort_by_key(|label| !scene.is_attacker(label.owner));
    for label in labels {
        // Where there is little room it loses words.
        let shorter = label.text.replace(" contact ", " ");
        let shortest = shorter.rsplit_once(' ').map_or("", |(start, _)| start);
        let texts = [label.text.as_str(), &shorter, shortest]
            .map(|text| if text.len() > 1 { text } else { "" });
        board.beside(&label.body, &texts, label.style);
    }
}

/// Where the picked obstacle is, if it is beside the map: an arrow towards it at the edge, with its id.
pub fn beyond(board: &mut LabelPlacer<'_>, model: &Model, moment: &Moment<'_>, view: &CellView) {
    let Some(id) = model.picked else { return };
    let body = moment.opened.body_of(On::Obstacle(id), moment.step);
    let Some(at) = body.map(|body| body.pose.position) else {
        return;
    };
    if view.sees_point(&at) {
        return;
    }
    let (x, y) = view.at(&at);
    let arrow = heading_arrow(&Vector::new(x, y));
    let style = { Style::new().fg(model.theme.picked) }.add_modifier(Modifier::BOLD);
    board.at_edge((x, y), &[&format!("{arrow} {id}"), arrow], style);
}

/// Keeps words away from bodies.
pub fn reserve_bodies(board: &mut LabelPlacer<'_>, scene: &MapScene<'_>, view: &CellView) {
    for body in scene.bodies.iter().chain(&scene.ego) {
        let corners = body.rings.iter().flatten().map(|p| view.at(p));
        let Some(around) = Body::around(corners) else {
            continue;
        };
        let rows = body.rings.iter().flat_map(|ring| board.rows(ring, view));
        let rows: Vec<Area> = rows.collect();
        board.taken.extend(&rows);
        board.bodies.push((board.cells(&around), rows));
    }
}

/// Keeps words, where there is room elsewhere, away from where the ego goes and from the regions of goals.
pub fn avoid_ways(
    board: &mut LabelPlacer<'_>,
    moment: &Moment<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    let trails = scene
        .trails
        .iter()
        .filter(|trail| trail.owner == Owner::Ego);
    let recorded = trails.flat_map(|trail| trail.future.iter().map(|(_, m)| m.pose.position));
    let planned = moment
        .cycle()
        .into_iter()
        .flat_map(|cycle| cycle.chosen.iter().copied());
    let ways = recorded.chain(planned).filter(|p| view.sees_point(p));
    let mut avoided: Vec<Area> = ways.map(|p| board.cell(view.at(&p))).collect();
    for goal in &scene.goals {
        if let GoalArea::Region(rings) = goal {
            avoided.extend(rings.iter().flat_map(|ring| board.rows(ring, view)));
        }
    }
    avoided.dedup();
    board.avoided = avoided;
}

/// Cells that no screen has.
const OUT_OF_SIGHT: i32 = 1_000_000;

/// A box of cells, the ends not in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Area {
    x: (i32, i32),
    y: (i32, i32),
}

impl Area {
    fn wider(self) -> Self {
        Self {
            x: (self.x.0 - 1, self.x.1 + 1),
            ..self
        }
    }

    fn meets(&self, other: &Self) -> bool {
        self.x.0 < other.x.1 && other.x.0 < self.x.1 && self.y.0 < other.y.1 && other.y.0 < self.y.1
    }

    /// How many columns away the other one is, a row for two; 1 where they are side by side.
    fn distance(&self, other: &Self) -> i32 {
        let apart = |a: (i32, i32), b: (i32, i32)| (b.0 - a.1 + 1).max(a.0 - b.1 + 1).max(0);
        apart(self.x, other.x) + 2 * apart(self.y, other.y)
    }
}

/// An area covered on the canvas, metres from the middle.
#[derive(Clone, Copy)]
pub struct Body {
    /// From left to right.
    pub x: (f64, f64),
    /// From below to above.
    pub y: (f64, f64),
}

impl Body {
    /// Around points of the canvas; nothing around none.
    pub fn around(points: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let mut points = points.into_iter();
        let (x, y) = points.next()?;
        let first = Self {
            x: (x, x),
            y: (y, y),
        };
        Some(points.fold(first, |b, (x, y)| Self {
            x: (b.x.0.min(x), b.x.1.max(x)),
            y: (b.y.0.min(y), b.y.1.max(y)),
        }))
    }
}

/// The cells of the map that can be written into.
pub struct LabelPlacer<'a> {
    buffer: &'a mut Buffer,
    area: Rect,
    /// Metres of a column and of a row.
    size: (f64, f64),
    half: (f64, f64),
    /// Behind words, where the road has a colour.
    ground: Option<Color>,
    taken: Vec<Area>,
    /// What is written.
    words: Vec<Area>,
    /// What words hide only where there is no room elsewhere.
    avoided: Vec<Area>,
    /// What the cells of each body are in, and they row by row.
    bodies: Vec<(Area, Vec<Area>)>,
}

/// The part of the map's width that a long label may take: a third.
const SHARE: i32 = 3;
/// Columns by which another body is farther from words than the one they name, so that they are not taken for its name.
const APART: i32 = 2;
/// Parts of the way from the middle of the map to its edge at which words about what is beside it may stand.
const NEARER: [f64; 4] = [1.0, 0.9, 0.8, 0.7];

impl<'a> LabelPlacer<'a> {
    pub fn new(buffer: &'a mut Buffer, area: Rect, view: &CellView, ground: Option<Color>) -> Self {
        Self {
            buffer,
            area,
            size: view.cell,
            half: view.half,
            ground,
            taken: Vec::new(),
            words: Vec::new(),
            avoided: Vec::new(),
            bodies: Vec::new(),
        }
    }

    /// The cells of a body.
    pub fn cells(&self, body: &Body) -> Area {
        let cell = |metres: f64, size: f64| {
            let far = f64::from(OUT_OF_SIGHT);
            (metres / size).floor().clamp(-far, far) as i32
        };
        let column = |x: f64| cell(x + self.half.0, self.size.0);
        let row = |y: f64| cell(self.half.1 - y, self.size.1);
        Area {
            x: (column(body.x.0), column(body.x.1) + 1),
            y: (row(body.y.1), row(body.y.0) + 1),
        }
    }

    /// The cells of a region of the world, row by row.
    fn rows(&self, ring: &[Point], view: &CellView) -> Vec<Area> {
        let spots: Vec<Point> = ring
            .iter()
            .map(|p| {
                let (x, y) = view.at(p);
                Point::new(x, y)
            })
            .collect();
        let Some(around) = Body::around(spots.iter().map(|p| (p.x, p.y))) else {
            return Vec::new();
        };
        let all = self.cells(&around);
        let rows = all.y.0.max(0)..all.y.1.min(i32::from(self.area.height));
        let row = |row: i32| {
            let top = self.half.1 - f64::from(row) * self.size.1;
            let band = Bounds {
                min: Point::new(around.x.0, top - self.size.1),
                max: Point::new(around.x.1, top),
            };
            let part = ring_within(&spots, &band);
            let columns = self
                .cells(&Body::around(part.iter().map(|p| (p.x, p.y)))?)
                .x;
            Some(Area {
                x: columns,
                y: (row, row + 1),
            })
        };
        rows.filter_map(row).collect()
    }

    fn inside(&self, area: &Area) -> bool {
        let (columns, rows) = (i32::from(self.area.width), i32::from(self.area.height));
        area.x.0 >= 0 && area.x.1 <= columns && area.y.0 >= 0 && area.y.1 <= rows
    }

    /// Writes words with their middle at a point of the canvas, over anything; they are not covered any more. Says
    /// whether there is room on the map.
    pub fn put(&mut self, at: (f64, f64), words: &str, style: Style) -> bool {
        let area = self.centered(at, words);
        let inside = self.inside(&area);
        if inside {
            self.write(area, words, style);
        }
        inside
    }

    /// The same, where nothing else is.
    pub fn put_if_free(&mut self, at: (f64, f64), words: &str, style: Style) -> bool {
        let area = self.centered(at, words);
        let free = self.is_free(&area);
        if free {
            self.write(area, words, self.grounded(style));
        }
        free
    }

    /// The same, where no words are in the rows above and below either.
    pub fn put_if_apart(&mut self, at: (f64, f64), words: &str, style: Style) -> bool {
        let area = self.centered(at, words);
        let around = Area {
            y: (area.y.0 - 1, area.y.1 + 1),
            ..area
        };
        !self.words.iter().any(|other| other.meets(&around)) && self.put_if_free(at, words, style)
    }

    /// Writes the first of these words that has room where the way from the middle to a point beside the map leaves it,
    /// or a little nearer to the middle; the last ones over anything.
    pub fn at_edge(&mut self, (x, y): (f64, f64), words: &[&str], style: Style) {
        let least = (self.half.0 / x.abs()).min(self.half.1 / y.abs());
        let (columns, rows) = (i32::from(self.area.width), i32::from(self.area.height));
        let place = |board: &Self, part: f64, words: &str| {
            let area = board.centered((x * least * part, y * least * part), words);
            let width = area.x.1 - area.x.0;
            let left = area.x.0.clamp(0, (columns - width).max(0));
            let top = area.y.0.clamp(0, (rows - 1).max(0));
            Area {
                x: (left, left + width),
                y: (top, top + 1),
            }
        };
        for words in words {
            let areas = NEARER.map(|part| place(self, part, words));
            if let Some(area) = areas.into_iter().find(|area| self.is_free(area)) {
                return self.write(area, words, self.grounded(style));
            }
        }
        let Some(words) = words.last() else { return };
        let area = place(self, 1.0, words);
        if self.inside(&area) {
            self.write(area, words, self.grounded(style));
        }
    }

    /// The cell of a point of the canvas.
    pub fn cell(&self, (x, y): (f64, f64)) -> Area {
        self.cells(&Body {
            x: (x, x),
            y: (y, y),
        })
    }

    fn centered(&self, at: (f64, f64), words: &str) -> Area {
        let cell = self.cell(at);
        let width = columns(words);
        let left = cell.x.0 - (width - 1) / 2;
        Area {
            x: (left, left + width),
            y: cell.y,
        }
    }

    /// Whether words are short beside the map: longer ones would hide what they stand on.
    pub fn has_room(&self, words: &str) -> bool {
        columns(words) * SHARE <= i32::from(self.area.width)
    }

    /// Writes the first of these words that has room beside a body, where they cover neither anything written nor anything
    /// reserved and no other body is nearer to them; fewer words far from others before more words between them. Says
    /// whether there was room.
    pub fn beside(&mut self, body: &Area, texts: &[&str], style: Style) -> bool {
        let free = |words: &&str| -> Vec<(Area, i32)> {
            let spots = spots(body, columns(words)).into_iter();
            let free = spots.filter(|area| !words.is_empty() && self.is_free(area));
            free.map(|area| (area, self.nearest_other(body, &area) - area.distance(body)))
                .collect()
        };
        let all: Vec<(&str, Vec<(Area, i32)>)> = { texts.iter() }
            .map(|words| (*words, free(words)))
            .collect();
        // Best where they are not taken for the name of another one; what is only an outline may have its name there alone.
        let is_body = self.bodies.iter().any(|(around, _)| around == body);
        let least = if is_body { 0 } else { 1 };
        let best = [(APART, true), (1, true), (1, false), (least, false)]
            .into_iter()
            .find_map(|(least, clear)| {
                let is_best = |(area, margin): &&(Area, i32)| {
                    *margin >= least && (!clear || self.hides_nothing(area))
                };
                all.iter()
                    .find_map(|(words, free)| Some((*words, free.iter().find(is_best)?.0)))
            });
        if let Some((words, area)) = best {
            self.write(area, words, self.grounded(style));
        }
        best.is_some()
    }

    /// How far the nearest body but this one is.
    fn nearest_other(&self, body: &Area, area: &Area) -> i32 {
        let others = self.bodies.iter().filter(|(around, _)| around != body);
        let rows = others.flat_map(|(_, rows)| rows);
        let nearest = rows.map(|row| row.distance(area)).min();
        nearest.unwrap_or(OUT_OF_SIGHT)
    }

    /// Writes words beside a point of the canvas, where they cover neither anything written nor anything reserved; says
    /// whether there was room.
    pub fn beside_point(&mut self, at: (f64, f64), words: &str, style: Style) -> bool {
        let cell = self.cell(at);
        let free: Vec<Area> = { spots(&cell, columns(words)).into_iter() }
            .filter(|area| self.is_free(area))
            .collect();
        // Best where they are not taken for the name of a body.
        let is_clear = |area: &&Area| self.hides_nothing(area);
        let is_apart = |area: &&Area| is_clear(area) && self.nearest_other(&cell, area) >= APART;
        let best = free.iter().find(is_apart);
        let best = best.or(free.iter().find(is_clear)).or(free.first());
        if let Some(area) = best {
            self.write(*area, words, self.grounded(style));
        }
        best.is_some()
    }

    fn grounded(&self, style: Style) -> Style {
        self.ground.map_or(style, |ground| style.bg(ground))
    }

    fn hides_nothing(&self, area: &Area) -> bool {
        !self.avoided.iter().any(|other| other.meets(area))
    }

    fn is_free(&self, area: &Area) -> bool {
        // A column stays free beside bodies, and two between labels, so that they do not read as one.
        let wider = area.wider();
        self.inside(area) && !self.taken.iter().any(|other| other.meets(&wider))
    }

    fn write(&mut self, area: Area, words: &str, style: Style) {
        let at = |from: u16, cell: i32| from + u16::try_from(cell).unwrap_or(0);
        let (x, y) = (at(self.area.x, area.x.0), at(self.area.y, area.y.0));
        let width = u16::try_from(area.x.1 - area.x.0).unwrap_or(0);
        for cell in Rect::new(x, y, width, 1)
            .intersection(self.area)
            .positions()
        {
            // What lies below may be dim or reversed; words are as their style says, and no more.
            self.buffer[cell].modifier = Modifier::empty();
        }
        self.buffer.set_string(x, y, words, style);
        self.taken.push(area.wider());
        self.words.push(area.wider());
    }
}

/// Where words of so many columns may stand beside a body, the best first.
fn spots(body: &Area, width: i32) -> [Area; 12] {
    let (right, left) = (body.x.1 + 1, body.x.0 - 1 - width);
    let (middle, over, under) = ((body.y.0 + body.y.1 - 1) / 2, body.y.0 - 1, body.y.1);
    let centered = (body.x.0 + body.x.1 - width) / 2;
    let (from_left, to_right) = (body.x.0, body.x.1 - width);
    let spots = [
        (right, middle),
        (left, middle),
        (centered, over),
        (centered, under),
        (from_left, over),
        (from_left, under),
        (to_right, over),
        (to_right, under),
        (right, over),
        (right, under),
        (left, over),
        (left, under),
    ];
    spots.map(|(x, y)| Area {
        x: (x, x + width),
        y: (y, y + 1),
    })
}

fn columns(words: &str) -> i32 {
    i32::try_from(words.width()).unwrap_or(OUT_OF_SIGHT)
}

/// Between two entries.
const SEPARATOR: &str = " │ ";

/// An entry: the sign as the map draws it, its colour, and what it means.
struct Entry {
    sign: &'static str,
    color: Color,
    words: String,
}

impl Entry {
    fn width(&self) -> usize {
        let blank = usize::from(!self.sign.is_empty());
        self.sign.width() + blank + self.words.width()
    }
}

/// Draws as many entries as fit into the free part of the border.
pub fn draw_legend(f: &mut Frame<'_>, free: Rect, model: &Model, shown: Placed) {
    let room = usize::from(free.width.saturating_sub(2));
    let entries = fitting(entries(model, shown), room);
    if entries.is_empty() || free.height == 0 {
        return;
    }
    let dim = Style::new().fg(model.theme.dim);
    let mut line = Line::from(" ");
    for (i, entry) in entries.into_iter().enumerate() {
        if i > 0 {
            line.push_span(Span::styled(SEPARATOR, dim));
        }
        if !entry.sign.is_empty() {
            let sign = format!("{} ", entry.sign);
            line.push_span(Span::styled(sign, Style::new().fg(entry.color)));
        }
        line.push_span(Span::styled(entry.words, dim));
    }
    line.push_span(Span::raw(" "));
    let width = u16::try_from(line.width())
        .unwrap_or(u16::MAX)
        .min(free.width);
    f.render_widget(line, Rect { width, ..free });
}

/// The sign of a line, as it is drawn from left to right.
fn sign(model: &Model, style: LineStyle) -> &'static str {
    match (super::look(model).style, style) {
        (MapStyle::Ascii, LineStyle::Solid) => "''",
        (MapStyle::Ascii, LineStyle::Thick) => "::",
        (MapStyle::Ascii, LineStyle::Dashed) => "'' ''",
        (MapStyle::Ascii, LineStyle::Dotted) => "' '",
        (_, LineStyle::Solid) => "⠒⠒",
        (_, LineStyle::Thick) => "⠶⠶",
        (_, LineStyle::Dashed) => "⠒⠐",
        (_, LineStyle::Dotted) => "⠂ ⠂",
    }
}

fn entries(model: &Model, shown: Placed) -> Vec<Entry> {
    let look = super::look(model);
    let line = |style, role, words: &str| Entry {
        sign: sign(model, style),
        color: look.color(role),
        words: words.into(),
    };
    let plain = |words: &str| Entry {
        sign: "",
        color: model.theme.dim,
        words: words.into(),
    };
    let mut entries = Vec::new();
    let horizon = Foresight::HORIZON;
    let predicted = |role, whose: &str| {
        let words = format!("predicted {horizon:.0} s{whose}");
        let straight = Role::ConstantVelocity;
        [
            line(LineStyle::Dashed, role, &words),
            line(LineStyle::Dotted, straight, "constant velocity"),
        ]
    };
    if let Some(variant) = model.variant().filter(|_| model.map.layers.variant) {
        let all = &variant.made.effect.attackers;
        for (place, attacker) in all.iter().enumerate() {
            let words = match all.len() {
                1 => "attack".into(),
                _ => format!("attack {}", attacker.obstacle),
            };
            entries.push(line(LineStyle::Thick, Role::Attacker(place), &words));
        }
        entries.push(line(LineStyle::Dashed, Role::Recorded, "recorded instead"));
    }
    if let Some(planned) = model.planned().filter(|_| model.map.layers.planner) {
        entries.push(line(LineStyle::Thick, Role::Ego, "chosen, 1 2 3 s ahead"));
        if model.map.layers.candidates {
            entries.push(line(LineStyle::Solid, Role::Feasible, "drivable"));
            entries.push(line(LineStyle::Dotted, Role::Rejected, "rejected"));
            let outlined = line(LineStyle::Solid, Role::PredictedBody, "predicted bodies");
            entries.push(outlined);
        }
        if planned.recorded.is_some() {
            entries.push(line(LineStyle::Dashed, Role::RecordedEgo, "recorded ego"));
        }
    }
    match model.map.layers.paths {
        Foreseen::Off => {}
        _ if model.scene().is_none() => entries.push(plain("no predictions without an ego")),
        Foreseen::Picked => {
            entries.extend(predicted(Role::Highlighted(0), ", picked: % how likely"));
        }
        Foreseen::Near => entries.extend(predicted(Role::Prediction, ", near the ego")),
    }
    if model.map.tape.is_some() {
        entries.push(plain("+ # tape: # moves"));
    }
    if shown.lights {
        entries.push(plain("R A G lights"));
    }
    if shown.posts {
        entries.push(plain("▫ sign"));
    }
    if model.map.layers.trails != Trails::Off {
        let color = match model.scene() {
            Some(_) => model.theme.ego_trail,
            None => model.theme.trail,
        };
        for (style, words) in [
            (LineStyle::Solid, "past"),
            (LineStyle::Dashed, "recorded future"),
        ] {
            entries.push(Entry {
                color,
                ..line(style, Role::Ego, words)
            });
        }
    }
    entries
}

/// The entries that are whole within so many columns, the first ones first.
fn fitting(entries: Vec<Entry>, room: usize) -> Vec<Entry> {
    let mut width = 0;
    let mut kept = Vec::new();
    for entry in entries {
        let separator = if kept.is_empty() {
            0
        } else {
            SEPARATOR.width()
        };
        if width + separator + entry.width() <= room {
            width += separator + entry.width();
            kept.push(entry);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_base::geometry::Pose;

    #[test]
    fn a_label_stands_where_no_other_body_is_nearer_or_nowhere() {
        let area = Rect::new(0, 0, 18, 2);
        let view = CellView::new(Pose::new(0.0, 0.0, 0.0), (9.0, 2.0), (1.0, 2.0));
        let mut buffer = Buffer::empty(area);
        let mut board = LabelPlacer::new(&mut buffer, area, &view, None);
        // Two vehicles in the first row, one behind the other.
        let [ours, other] = [(0, 4), (5, 9)].map(|x| Area { x, y: (0, 1) });
        for body in [ours, other] {
            board.taken.push(body);
            board.bodies.push((body, vec![body]));
        }
        assert!(board.beside(&ours, &["one"], Style::new()));
        assert!(
            !board.beside(&ours, &["again"], Style::new()),
            "nearer to two"
        );
        assert!(board.beside(&other, &["two"], Style::new()));
        let rows: Vec<String> = { buffer.content.chunks(18) }
            .map(|row| row.iter().map(ratatui::buffer::Cell::symbol).collect())
            .collect();
        assert_eq!(rows[0].trim_end(), "          two");
        assert_eq!(rows[1].trim_end(), "one");
    }

    #[test]
    fn names_leave_the_way_ahead_free_while_there_is_room_elsewhere() {
        let area = Rect::new(0, 0, 18, 2);
        let view = CellView::new(Pose::new(0.0, 0.0, 0.0), (9.0, 2.0), (1.0, 2.0));
        let mut buffer = Buffer::empty(area);
        let mut board = LabelPlacer::new(&mut buffer, area, &view, None);
        let body = Area {
            x: (8, 12),
            y: (0, 1),
        };
        board.taken.push(body);
        board.bodies.push((body, vec![body]));
        // To its right.
        board.avoided.push(Area {
            x: (12, 18),
            y: (0, 1),
        });
        assert!(board.beside(&body, &["ego"], Style::new()));
        assert!(board.beside(&body, &["too long for this map", "two"], Style::new()));
        let rows: Vec<String> = { buffer.content.chunks(18) }
            .map(|row| row.iter().map(ratatui::buffer::Cell::symbol).collect())
            .collect();
        assert_eq!(&rows[0][..8], "    ego ");
        assert!(rows[1].contains("two"));
    }

    #[test]
    fn what_is_beside_the_map_is_named_at_its_edge() {
        let area = Rect::new(0, 0, 18, 3);
        let view = CellView::new(Pose::new(0.0, 0.0, 0.0), (9.0, 3.0), (1.0, 2.0));
        let mut buffer = Buffer::empty(area);
        let mut board = LabelPlacer::new(&mut buffer, area, &view, None);
        board.at_edge((-40.0, 0.0), &["← 7", "←"], Style::new());
        board.at_edge((40.0, 15.0), &["↗ 8", "↗"], Style::new());
        // The edge is taken: the arrow alone is written over it.
        board.at_edge((-40.0, 0.0), &["← a long name", "⇐"], Style::new());
        let rows: Vec<String> = { buffer.content.chunks(18) }
            .map(|row| row.iter().map(ratatui::buffer::Cell::symbol).collect())
            .collect();
        assert_eq!(
            rows,
            ["               ↗ 8", "⇐ 7               ", &" ".repeat(18)]
        );
    }

    #[test]
    fn what_does_not_fit_is_left_out_whole() {
        let entry = |words: &str| Entry {
            sign: "",
            color: Color::Reset,
            words: words.into(),
        };
        let kept = |room| -> Vec<String> {
            let entries = ["one", "a long one", "two"].map(entry).into();
            fitting(entries, room)
                .into_iter()
                .map(|e| e.words)
                .collect()
        };
        assert_eq!(kept(40), ["one", "a long one", "two"]);
        assert_eq!(kept(12), ["one", "two"]);
        assert!(kept(2).is_empty());
    }
}
