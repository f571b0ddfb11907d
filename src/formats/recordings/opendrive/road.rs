//! Roads as OpenDRIVE tells them: reference line, lane sections with lanes, links, signs and lights.

use nearmiss_base::geometry::{Point, Pose};

use super::geometry::{Cubic, Offset, Piece, pose, value};
use super::tree::Node;
use crate::commonroad::ReadError;
use crate::opendrive::user_data::{KeptLanelet, LANELET, PART_OF};

/// A road.
pub struct Road {
    pub id: String,
    /// Metres.
    pub length: f64,
    pub pieces: Vec<Piece>,
    pub offset: Vec<Cubic>,
    pub sections: Vec<Section>,
    /// What the links name: before and behind.
    pub links: [Option<RoadLink>; 2],
    pub is_connecting: bool,
    /// Vehicles drive on the left.
    pub left_hand: bool,
    /// From the beginning on.
    pub types: Vec<Type>,
    pub signals: Vec<Signal>,
    pub has_heights: bool,
    pub is_tilted: bool,
}

/// The type of a road from a place on.
#[derive(Default)]
pub struct Type {
    /// Metres.
    pub from: f64,
    pub kind: String,
    /// m/s.
    pub limit: Option<f64>,
}

/// The end of a road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum End {
    Start,
    End,
}

/// What a road is linked to.
pub enum RoadLink {
    Road(String, End),
    Junction(String),
}

/// The end of a road that a link names.
pub fn contact(node: &Node) -> End {
    match node.text("contactPoint") {
        Some("end") => End::End,
        _ => End::Start,
    }
}

/// Reads a `<road>`.
pub fn read(node: &Node, moved: &Offset) -> Result<Road, ReadError> {
    let mut pieces = Vec::new();
    for geometry in node
        .child("planView")
        .iter()
        .flat_map(|p| p.all("geometry"))
    {
        pieces.push(Piece::read(geometry, moved)?);
    }
    if pieces.is_empty() {
        return Err(node.fail("no <geometry> in its <planView>"));
    }
    pieces.sort_by(|a, b| a.s.total_cmp(&b.s));
    let length = node.needed_number("length")?;
    if !(length > 0.0 && length <= 1e6) {
        return Err(node.fail(format!("length=\"{length}\" is not from 0 to 1000000")));
    }
    let lanes = node
        .child("lanes")
        .ok_or_else(|| node.fail("no <lanes> in it"))?;
    let mut offset = Vec::new();
    for cubic in lanes.all("laneOffset") {
        offset.push(Cubic::read(cubic, "s")?);
    }
    offset.sort_by(|a, b| a.from.total_cmp(&b.from));
    let link = |name: &str| -> Result<Option<RoadLink>, ReadError> {
        let Some(link) = node.at(&["link", name]) else {
            return Ok(None);
        };
        if link.text("elementType") == Some("junction") {
            let id = link.text("elementId").unwrap_or_default();
            return Ok(Some(RoadLink::Junction(id.to_string())));
        }
        let id = link.needed("elementId")?.to_string();
        Ok(Some(RoadLink::Road(id, contact(link))))
    };
    let mut signals = Vec::new();
    for signal in node.child("signals").iter().flat_map(|s| s.all("signal")) {
        signals.push(read_signal(signal)?);
    }
    let is_flat = |profile: &str, of: &str| -> Result<bool, ReadError> {
        let mut all = node
            .child(profile)
            .into_iter()
            .flat_map(|p| p.all(of))
            .map(|of| Cubic::read(of, "s"));
        all.try_fold(true, |flat, of| Ok(flat && of?.of == [0.0; 4]))
    };
    Ok(Road {
        id: node.needed("id")?.to_string(),
        length,
        pieces,
        offset,
        sections: sections(lanes, length)?,
        links: [link("predecessor")?, link("successor")?],
        is_connecting: node
            .text("junction")
            .is_some_and(|j| j != "-1" && !j.is_empty()),
        left_hand: node.text("rule") == Some("LHT"),
        types: types(node)?,
        signals,
        has_heights: !is_flat("elevationProfile", "elevation")?,
        is_tilted: !is_flat("lateralProfile", "superelevation")?,
    })
}

fn types(node: &Node) -> Result<Vec<Type>, ReadError> {
    let mut all = Vec::new();
    for of in node.all("type") {
        let limit = of.child("speed").map(|s| speed(s, "max", "unit"));
        all.push(Type {
            from: of.or_zero("s")?,
            kind: of.text("type").unwrap_or_default().to_string(),
            limit: limit.transpose()?.flatten(),
        });
    }
    all.sort_by(|a, b| a.from.total_cmp(&b.from));
    Ok(all)
}

impl Road {
    /// Its type at a place: the first one before it begins.
    pub fn kind(&self, s: f64) -> Option<&Type> {
        let begun = self.types.iter().rfind(|t| t.from <= s + 1e-9);
        begun.or(self.types.first())
    }

    /// Whether a lane is driven the way its road runs.
    pub fn is_along(&self, lane: &Lane) -> bool {
        ((lane.id < 0) != self.left_hand) != lane.is_reversed
    }

    /// The pose of its reference line.
    pub fn pose(&self, s: f64) -> Pose {
        pose(&self.pieces, s)
    }

    /// A place beside its reference line.
    pub fn point(&self, s: f64, t: f64) -> Point {
        self.pose(s).to_world(&Point::new(0.0, t))
    }

    /// How far to the left the borders of the lanes of a section are, from the left to the right: one more than lanes.
    pub fn borders(&self, section: &Section, s: f64) -> Vec<f64> {
        let middle = value(&self.offset, s);
        let side = |lanes: &mut dyn Iterator<Item = &Lane>, sign: f64| -> Vec<f64> {
            let mut reached = 0.0;
            let all = lanes.map(|lane| {
                reached = lane.reaches(reached, s);
                middle + sign * reached
            });
            all.collect()
        };
        let mut left = side(&mut section.lanes.iter().rev().filter(|l| l.id > 0), 1.0);
        left.reverse();
        left.push(middle);
        left.extend(side(&mut section.lanes.iter().filter(|l| l.id < 0), -1.0));
        left
    }

    /// The places at which borders of a section have points: where something begins, and so close that straight lines
    /// between them are within `tolerance` metres; and whether they are, or would need too many points.
    pub fn places(&self, section: &Section, tolerance: f64) -> (Vec<f64>, bool) {
        let mut fixed = vec![section.from, section.to];
        fixed.extend(self.pieces.iter().map(|p| p.s));
        fixed.extend(self.offset.iter().map(|c| c.from));
        fixed.extend(section.lanes.iter().flat_map(Lane::changes));
        fixed.retain(|s| (section.from..=section.to).contains(s));
        fixed.sort_by(f64::total_cmp);
        fixed.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let mut all = Vec::new();
        let mut is_exact = true;
        for pair in fixed.windows(2) {
            all.push(pair[0]);
            is_exact &= self.between(section, (pair[0], pair[1]), tolerance, MAX_DEPTH, &mut all);
        }
        all.extend(fixed.last());
        (all, is_exact)
    }

    /// The points across the road at a place, without the jump to what begins there.
    fn across(&self, section: &Section, s: f64) -> Vec<Point> {
        let all = self.borders(section, s).into_iter();
        all.map(|t| self.point(s, t)).collect()
    }

    /// Adds the places between two; whether they are enough.
    fn between(
        &self,
        section: &Section,
        (from, to): (f64, f64),
        tolerance: f64,
        deeper: usize,
        all: &mut Vec<f64>,
    ) -> bool {
        if to - from < SHORTEST {
            return true;
        }
        let middle = f64::midpoint(from, to);
        let quarter = f64::midpoint(from, middle);
        let (a, b) = (self.across(section, from), self.across(section, to - 1e-7));
        let off = |s: f64| {
            let points = self.across(section, s);
            let each = points.iter().zip(a.iter().zip(&b));
            let away =
                each.map(|(p, (a, b))| nearmiss_base::geometry::distance_to_segment(p, a, b));
            away.fold(0.0, f64::max)
        };
        if off(middle).max(off(quarter)) <= tolerance {
            return true;
        }
        if deeper == 0 {
            return false;
        }
        let before = self.between(section, (from, middle), tolerance, deeper - 1, all);
        all.push(middle);
        self.between(section, (middle, to), tolerance, deeper - 1, all) && before
    }
}

/// No points are nearer to each other, metres.
const SHORTEST: f64 = 0.05;

/// Halvings of a stretch at most.
const MAX_DEPTH: usize = 12;

/// A sign or a light.
pub struct Signal {
    pub id: String,
    pub s: f64,
    pub t: f64,
    pub kind: String,
    pub subtype: String,
    pub is_dynamic: bool,
    /// Whether it is for those that drive along the road, and for those against it.
    pub along: bool,
    pub against: bool,
    /// In m/s where it is a speed.
    pub value: Option<f64>,
    /// Ids of lanes; all that it looks at where none is named.
    pub lanes: Vec<(i64, i64)>,
}

/// Reads a `<signal>`.
fn read_signal(node: &Node) -> Result<Signal, ReadError> {
    let mut lanes = Vec::new();
    for validity in node.all("validity") {
        let id = |name: &str| Ok::<i64, ReadError>(validity.or_zero(name)? as i64);
        lanes.push((id("fromLane")?, id("toLane")?));
    }
    let orientation = node.text("orientation");
    Ok(Signal {
        id: node.text("id").unwrap_or_default().to_string(),
        s: node.or_zero("s")?,
        t: node.or_zero("t")?,
        kind: node.text("type").unwrap_or_default().to_string(),
        subtype: node.text("subtype").unwrap_or_default().to_string(),
        along: orientation != Some("-"),
        against: orientation != Some("+"),
        is_dynamic: node.text("dynamic") == Some("yes"),
        value: speed(node, "value", "unit")?,
        lanes,
    })
}

/// Lanes that stay the same for a while.
pub struct Section {
    /// Where it begins and ends, metres.
    pub from: f64,
    pub to: f64,
    /// From the left to the right, without the one in the middle.
    pub lanes: Vec<Lane>,
    pub middle_mark: Option<(String, String)>,
}

/// A lane.
#[derive(Clone)]
pub struct Lane {
    /// Positive to the left of the reference line.
    pub id: i64,
    pub kind: String,
    /// Whether it is driven against the direction that its side has.
    pub is_reversed: bool,
    /// Whether it is driven in both directions.
    pub is_both_ways: bool,
    /// Where its section begins as the file tells it, metres.
    begins: f64,
    widths: Vec<Cubic>,
    /// Distances of its outer border, instead of widths.
    borders: Vec<Cubic>,
    pub predecessors: Vec<i64>,
    pub successors: Vec<i64>,
    /// Type and weight of the marking of its outer border.
    pub mark: Option<(String, String)>,
    /// m/s.
    pub limit: Option<f64>,
    /// The id of the lanelet that it was.
    pub lanelet: Option<i64>,
    /// The lanelet that it was, where all of it was written.
    pub kept: Option<KeptLanelet>,
    /// The lanelet from whose lane it was cut off.
    pub part_of: Option<i64>,
}

/// A speed in m/s.
fn speed(node: &Node, name: &str, unit: &str) -> Result<Option<f64>, ReadError> {
    if node
        .text(name)
        .is_some_and(|t| t.trim().parse::<f64>().is_err())
    {
        // `no limit` and `undefined`.
        return Ok(None);
    }
    let factor = match node.text(unit).map(str::trim) {
        None | Some("" | "m/s" | "ms") => 1.0,
        Some("km/h" | "kmh" | "kph") => 1.0 / 3.6,
        Some("mph") => 0.447_04,
        // The unit is unknown: the report says that the speed was not used.
        Some(_) => return Ok(None),
    };
    let value = node.number(name)?.filter(|v| *v > 0.0);
    Ok(value.map(|v| v * factor))
}

/// A section as the file tells it, and the sides of the road of which it tells: left and right.
struct SectionInFile {
    section: Section,
    sides: [bool; 2],
}

/// The sections of a road, in order.
///
/// Those of one side only end where the next of that side begins: sections of both sides are cut where either begins.
fn sections(lanes: &Node, length: f64) -> Result<Vec<Section>, ReadError> {
    let mut all = Vec::new();
    for node in lanes.all("laneSection") {
        all.push(section(node)?);
    }
    if all.is_empty() {
        return Err(lanes.fail("no <laneSection> in it"));
    }
    all.sort_by(|a, b| a.section.from.total_cmp(&b.section.from));
    let mut cuts: Vec<f64> = all.iter().map(|r| r.section.from).collect();
    cuts.dedup_by(|a, b| (*a - *b).abs() < PLACE_TOLERANCE);
    let ends = cuts.iter().skip(1).copied().chain([length]);
    let pieces = cuts
        .iter()
        .zip(ends.collect::<Vec<_>>())
        .map(|(from, to)| piece(&all, *from, to.min(length)));
    Ok(pieces.collect())
}

/// Places nearer to each other are the same, metres.
const PLACE_TOLERANCE: f64 = 1e-9;

/// What sections tell of a stretch in which none begins.
fn piece(all: &[SectionInFile], from: f64, to: f64) -> Section {
    let mut lanes = Vec::new();
    let mut middle_mark = None;
    for (side, sign) in [(0, 1), (1, -1)] {
        let at = |s: f64| {
            let tells = |r: &SectionInFile| r.sides[side] && r.section.from <= s + PLACE_TOLERANCE;
            all.iter().rposition(tells)
        };
        let Some(place) = at(from) else {
            continue;
        };
        let section = &all[place].section;
        middle_mark = middle_mark.or_else(|| section.middle_mark.clone());
        let own = section.lanes.iter().filter(|l| l.id.signum() == sign);
        lanes.extend(own.cloned().map(|mut lane| {
            // Where it goes on beyond a cut it follows itself.
            if section.from < from - PLACE_TOLERANCE {
                lane.predecessors = vec![lane.id];
            }
            if all
                .last()
                .is_some_and(|last| last.section.from >= to - PLACE_TOLERANCE)
                && at(to) == Some(place)
            {
                lane.successors = vec![lane.id];
            }
            lane
        }));
    }
    Section {
        from,
        to,
        lanes,
        middle_mark,
    }
}

fn section(node: &Node) -> Result<SectionInFile, ReadError> {
    let mut lanes = Vec::new();
    let from = node.needed_number("s")?;
    let both = node.text("singleSide") != Some("true");
    let mut sides = [both; 2];
    for (name, tells) in ["left", "right"].into_iter().zip(&mut sides) {
        let side = node.child(name);
        *tells |= side.is_some();
        for lane in side.iter().flat_map(|s| s.all("lane")) {
            lanes.push(self::lane(lane, from)?);
        }
    }
    lanes.retain(|lane| lane.id != 0);
    lanes.sort_by_key(|lane| std::cmp::Reverse(lane.id));
    lanes.dedup_by_key(|lane| lane.id);
    let middle = node.at(&["center", "lane"]);
    if let Some(middle) = middle {
        // It is the line between both sides, whatever its type.
        middle.skip_attributes(&["id", "type"]);
    }
    let section = Section {
        from,
        to: from,
        lanes,
        middle_mark: middle.and_then(mark),
    };
    Ok(SectionInFile { section, sides })
}

fn mark(lane: &Node) -> Option<(String, String)> {
    let mark = lane.child("roadMark")?;
    let text = |name: &str| mark.text(name).unwrap_or_default().to_string();
    Some((text("type"), text("weight")))
}

fn lane(node: &Node, begins: f64) -> Result<Lane, ReadError> {
    let id = node.needed("id")?;
    let id: i64 = id
        .trim()
        .parse()
        .ok()
        .filter(|id: &i64| id.abs() < 1000)
        .ok_or_else(|| node.fail(format!("id=\"{id}\" is not a small whole number")))?;
    let cubics = |name: &str| -> Result<Vec<Cubic>, ReadError> {
        let all: Result<Vec<Cubic>, ReadError> =
            node.all(name).map(|c| Cubic::read(c, "sOffset")).collect();
        let mut all = all?;
        all.sort_by(|a, b| a.from.total_cmp(&b.from));
        Ok(all)
    };
    let links = |name: &str| -> Result<Vec<i64>, ReadError> {
        let all = node.child("link").into_iter().flat_map(|l| l.all(name));
        all.map(|l| Ok(l.needed_number("id")? as i64)).collect()
    };
    // One that begins later does not hold from here on.
    let mut limit = None;
    for told in node.all("speed") {
        if told.or_zero("sOffset")? <= PLACE_TOLERANCE {
            limit = limit.or(speed(told, "max", "unit")?);
        }
    }
    let user_data = |code: &str| {
        let mut all = node.all("userData");
        all.find(|d| d.text("code") == Some(code))?.text("value")
    };
    let direction = node.text("direction");
    Ok(Lane {
        id,
        kind: node.text("type").unwrap_or_default().to_string(),
        is_reversed: direction == Some("reversed"),
        is_both_ways: direction == Some("both"),
        begins,
        widths: cubics("width")?,
        borders: cubics("border")?,
        predecessors: links("predecessor")?,
        successors: links("successor")?,
        mark: mark(node),
        limit,
        lanelet: user_data(LANELET).and_then(|id| id.parse().ok()),
        kept: KeptLanelet::read(user_data),
        part_of: user_data(PART_OF).and_then(|id| id.parse().ok()),
    })
}

impl Lane {
    /// How far its outer border is from the middle of the road at a place, where its inner one is as far as this, metres.
    pub fn reaches(&self, inner: f64, s: f64) -> f64 {
        let at = s - self.begins;
        match (&self.widths[..], &self.borders[..]) {
            ([], [_, ..]) => value(&self.borders, at).abs(),
            _ => inner + value(&self.widths, at).max(0.0),
        }
    }

    /// Places at which the shape of its borders changes, metres.
    pub fn changes(&self) -> impl Iterator<Item = f64> {
        let all = self.widths.iter().chain(&self.borders);
        all.map(|c| self.begins + c.from)
    }
}
