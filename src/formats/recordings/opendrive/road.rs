//! Roads as OpenDRIVE tells them: reference line, lane sections, lanes, links.

use super::geometry::{Cubic, Piece, pose, value};
use super::tree::Node;
use crate::formats::commonroad::ReadError;
use crate::formats::opendrive::user_data::{KeptLanelet, LANELET, PART_OF};
use crate::geometry::{Point, Pose};

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
    /// The type of road and its limit, m/s.
    pub kind: String,
    pub limit: Option<f64>,
    pub signals: Vec<Signal>,
    pub has_heights: bool,
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
    Junction,
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
pub struct Lane {
    /// Positive to the left of the reference line.
    pub id: i64,
    pub kind: String,
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

/// A sign or a light.
pub struct Signal {
    pub id: String,
    pub s: f64,
    pub t: f64,
    pub kind: String,
    pub subtype: String,
    pub is_dynamic: bool,
    /// In m/s where it is a speed.
    pub value: Option<f64>,
    /// Ids of lanes; all where none is named.
    pub lanes: Vec<(i64, i64)>,
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
    let value = node.number(name)?.filter(|v| *v > 0.0);
    Ok(value.map(|v| match node.text(unit) {
        Some("km/h") => v / 3.6,
        Some("mph") => v * 0.447_04,
        _ => v,
    }))
}

fn contact(node: &Node) -> End {
    match node.text("contactPoint") {
        Some("end") => End::End,
        _ => End::Start,
    }
}

/// Reads a `<road>`.
pub fn read(node: &Node) -> Result<Road, ReadError> {
    let mut pieces = Vec::new();
    for geometry in node
        .child("planView")
        .iter()
        .flat_map(|p| p.all("geometry"))
    {
        pieces.push(Piece::read(geometry)?);
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
    let mut sections = Vec::new();
    for section in lanes.all("laneSection") {
        sections.push(self::section(section)?);
    }
    if sections.is_empty() {
        return Err(lanes.fail("no <laneSection> in it"));
    }
    sections.sort_by(|a, b| a.from.total_cmp(&b.from));
    for i in 0..sections.len() {
        sections[i].to = sections
            .get(i + 1)
            .map_or(length, |next| next.from.min(length));
    }
    let link = |name: &str| -> Result<Option<RoadLink>, ReadError> {
        let Some(link) = node.at(&["link", name]) else {
            return Ok(None);
        };
        if link.text("elementType") == Some("junction") {
            return Ok(Some(RoadLink::Junction));
        }
        let id = link.needed("elementId")?.to_string();
        Ok(Some(RoadLink::Road(id, contact(link))))
    };
    let kind = node.child("type");
    let limit = kind.and_then(|k| k.child("speed"));
    let limit = limit.map(|l| speed(l, "max", "unit")).transpose()?;
    let mut signals = Vec::new();
    for signal in node.child("signals").iter().flat_map(|s| s.all("signal")) {
        signals.push(self::signal(signal)?);
    }
    let elevations = node
        .child("elevationProfile")
        .map(|p| p.all("elevation").collect::<Vec<_>>());
    let mut has_heights = false;
    for elevation in elevations.into_iter().flatten() {
        has_heights |= Cubic::read(elevation, "s")?.of != [0.0; 4];
    }
    Ok(Road {
        id: node.needed("id")?.to_string(),
        length,
        pieces,
        offset,
        sections,
        links: [link("predecessor")?, link("successor")?],
        is_connecting: node
            .text("junction")
            .is_some_and(|j| j != "-1" && !j.is_empty()),
        left_hand: node.text("rule") == Some("LHT"),
        kind: kind
            .and_then(|k| k.text("type"))
            .unwrap_or_default()
            .to_string(),
        limit: limit.flatten(),
        signals,
        has_heights,
    })
}

fn signal(node: &Node) -> Result<Signal, ReadError> {
    let mut lanes = Vec::new();
    for validity in node.all("validity") {
        let id = |name: &str| Ok::<i64, ReadError>(validity.or_zero(name)? as i64);
        lanes.push((id("fromLane")?, id("toLane")?));
    }
    Ok(Signal {
        id: node.text("id").unwrap_or_default().to_string(),
        s: node.or_zero("s")?,
        t: node.or_zero("t")?,
        kind: node.text("type").unwrap_or_default().to_string(),
        subtype: node.text("subtype").unwrap_or_default().to_string(),
        is_dynamic: node.text("dynamic") == Some("yes"),
        value: speed(node, "value", "unit")?,
        lanes,
    })
}

fn section(node: &Node) -> Result<Section, ReadError> {
    let mut lanes = Vec::new();
    for side in ["left", "right"] {
        for lane in node.child(side).iter().flat_map(|s| s.all("lane")) {
            lanes.push(self::lane(lane)?);
        }
    }
    lanes.retain(|lane| lane.id != 0);
    lanes.sort_by_key(|lane| std::cmp::Reverse(lane.id));
    lanes.dedup_by_key(|lane| lane.id);
    let middle = node.at(&["center", "lane"]);
    let from = node.needed_number("s")?;
    Ok(Section {
        from,
        to: from,
        lanes,
        middle_mark: middle.and_then(mark),
    })
}

fn mark(lane: &Node) -> Option<(String, String)> {
    let mark = lane.child("roadMark")?;
    let text = |name: &str| mark.text(name).unwrap_or_default().to_string();
    Some((text("type"), text("weight")))
}

fn lane(node: &Node) -> Result<Lane, ReadError> {
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
    let limit = node
        .child("speed")
        .map(|s| speed(s, "max", "unit"))
        .transpose()?;
    let user_data = |code: &str| {
        let mut all = node.all("userData");
        all.find(|d| d.text("code") == Some(code))?.text("value")
    };
    Ok(Lane {
        id,
        kind: node.text("type").unwrap_or_default().to_string(),
        widths: cubics("width")?,
        borders: cubics("border")?,
        predecessors: links("predecessor")?,
        successors: links("successor")?,
        mark: mark(node),
        limit: limit.flatten(),
        lanelet: user_data(LANELET).and_then(|id| id.parse().ok()),
        kept: KeptLanelet::read(user_data),
        part_of: user_data(PART_OF).and_then(|id| id.parse().ok()),
    })
}

impl Road {
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
        let at = s - section.from;
        let outer = |lane: &Lane, inner: f64| match (&lane.widths[..], &lane.borders[..]) {
            ([], [_, ..]) => value(&lane.borders, at).abs(),
            _ => inner + value(&lane.widths, at).max(0.0),
        };
        let side = |lanes: &mut dyn Iterator<Item = &Lane>, sign: f64| -> Vec<f64> {
            let mut reached = 0.0;
            let all = lanes.map(|lane| {
                reached = outer(lane, reached);
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
    /// between them are within `tolerance` metres.
    pub fn places(&self, section: &Section, tolerance: f64) -> Vec<f64> {
        let mut fixed = vec![section.from, section.to];
        fixed.extend(self.pieces.iter().map(|p| p.s));
        fixed.extend(self.offset.iter().map(|c| c.from));
        for lane in &section.lanes {
            let all = lane.widths.iter().chain(&lane.borders);
            fixed.extend(all.map(|c| section.from + c.from));
        }
        fixed.retain(|s| (section.from..=section.to).contains(s));
        fixed.sort_by(f64::total_cmp);
        fixed.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let mut all = Vec::new();
        for pair in fixed.windows(2) {
            all.push(pair[0]);
            self.between(section, (pair[0], pair[1]), tolerance, DEEPEST, &mut all);
        }
        all.extend(fixed.last());
        all
    }

    /// The points across the road at a place, without the jump to what begins there.
    fn across(&self, section: &Section, s: f64) -> Vec<Point> {
        let all = self.borders(section, s).into_iter();
        all.map(|t| self.point(s, t)).collect()
    }

    fn between(
        &self,
        section: &Section,
        (from, to): (f64, f64),
        tolerance: f64,
        deeper: usize,
        all: &mut Vec<f64>,
    ) {
        if deeper == 0 || to - from < 0.05 {
            return;
        }
        let middle = f64::midpoint(from, to);
        let quarter = f64::midpoint(from, middle);
        let (a, b) = (self.across(section, from), self.across(section, to - 1e-7));
        let off = |s: f64| {
            let points = self.across(section, s);
            let each = points.iter().zip(a.iter().zip(&b));
            let away = each.map(|(p, (a, b))| crate::geometry::distance_to_segment(p, a, b));
            away.fold(0.0, f64::max)
        };
        if off(middle).max(off(quarter)) > tolerance {
            self.between(section, (from, middle), tolerance, deeper - 1, all);
            all.push(middle);
            self.between(section, (middle, to), tolerance, deeper - 1, all);
        }
    }
}

/// Halvings of a stretch at most.
const DEEPEST: usize = 12;
