//! What one lane is to another: its continuation, a neighbour, one that crosses it or joins it.

use std::cell::{OnceCell, RefCell};
use std::collections::{HashMap, HashSet, VecDeque};

use super::Lane;
use crate::scenario::{Adjacent, Lanelet, LaneletNetwork};
use nearmiss_base::geometry::{
    Bounds, BoxTree, Point, Pose, Vector, angle_between, distance_to_segment,
};

/// What the lane under one participant is to the lane under another, the closest relation first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LaneRelation {
    /// The same lanelet.
    Same,
    /// Where the lane leads, whichever way it branches.
    Ahead,
    /// From where the lane comes: straight on backwards, where several lead into it.
    Behind,
    /// Next to it on the left, in the same direction.
    Left,
    /// Next to it on the right, in the same direction.
    Right,
    /// More than one lane to the left, in the same direction.
    FurtherLeft,
    /// More than one lane to the right, in the same direction.
    FurtherRight,
    /// Beside it, in the opposite direction.
    Oncoming,
    /// It crosses the lane or what that leads to, or leads to what does.
    Crossing,
    /// It leads into the lane or into what that leads to.
    Merging,
    /// It comes from where the lane comes from.
    Diverging,
    /// None of these.
    OtherRoad,
}

impl LaneRelation {
    /// The words for it in descriptions.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Same => "same lane",
            Self::Ahead => "same lane ahead",
            Self::Behind => "same lane behind",
            Self::Left => "left neighbour lane",
            Self::Right => "right neighbour lane",
            Self::FurtherLeft => "lane further left",
            Self::FurtherRight => "lane further right",
            Self::Oncoming => "oncoming lane",
            Self::Crossing => "crossing lane",
            Self::Merging => "merging lane",
            Self::Diverging => "diverging lane",
            Self::OtherRoad => "another road",
        }
    }
}

/// How far a lane is followed, metres.
const REACH: f64 = 150.0;

/// How far a lane is followed to where it crosses another, metres.
const CROSSING_REACH: f64 = 60.0;

/// A lanelet within this angle of a participant's heading is driven in its direction, radians.
const SAME_WAY: f64 = std::f64::consts::FRAC_PI_4;

/// The relations of all lanes to those of one participant.
#[derive(Debug)]
pub struct LaneRelations<'n> {
    network: &'n LaneletNetwork,
    /// The lanelets that the lane consists of from the participant on.
    ahead: Vec<i64>,
    /// Of lanelets that are connected with them.
    connected: HashMap<i64, LaneRelation>,
    /// Their centre lines, made when they are first asked for.
    lines: OnceCell<CentreLines>,
    /// Whether a lanelet leads across them.
    crosses: RefCell<HashMap<i64, bool>>,
}

impl LaneletNetwork {
    /// The lanelets at a pose; where several lie over each other, those that are driven in its direction, if any are.
    #[must_use]
    pub fn lanelets_driven(&self, pose: &Pose) -> Vec<i64> {
        let all = self.lanelets_at(&pose.position);
        if all.len() < 2 {
            return all;
        }
        let same_way = |id: &i64| {
            let there = self
                .lanelet(*id)
                .and_then(|l| heading_at(l, &pose.position));
            there.is_some_and(|there| angle_between(there, pose.heading).abs() <= SAME_WAY)
        };
        let driven: Vec<i64> = all.iter().copied().filter(same_way).collect();
        if driven.is_empty() { all } else { driven }
    }

    /// The direction of the lane at a pose, radians, as it is driven there: of several over each other, that nearest to
    /// the pose's heading. `None` where none leads about that way.
    #[must_use]
    pub fn lane_heading(&self, pose: &Pose) -> Option<f64> {
        let turns = self
            .lanelets_at(&pose.position)
            .into_iter()
            .filter_map(|id| {
                let there = heading_at(self.lanelet(id)?, &pose.position)?;
                let turn = angle_between(pose.heading, there);
                // A lanelet may be driven against its direction.
                let back = turn - std::f64::consts::PI.copysign(turn);
                Some(if turn.abs() < back.abs() { turn } else { back })
            });
        let least = turns.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        (least.abs() <= SAME_WAY).then_some(pose.heading + least)
    }

    /// How far left of the middle of its lanelet a pose is, metres; where several lie over each other, of the nearest
    /// that is driven in its direction. `None` on no lanelet.
    #[must_use]
    pub fn lane_offset(&self, pose: &Pose) -> Option<f64> {
        let driven = self.lanelets_driven(pose).into_iter();
        let offsets = driven.filter_map(|id| {
            let lane = Lane::from_lanelet(self.lanelet(id)?)?;
            let along = lane.centre().project(&pose.position);
            let against = angle_between(lane.centre().pose_at(along.s).heading, pose.heading);
            Some(if against.abs() > std::f64::consts::FRAC_PI_2 {
                -along.d
            } else {
                along.d
            })
        });
        offsets.min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// The relations of all lanes to the lane that these lanelets are.
    #[must_use]
    pub fn lane_relations(&self, lanelets: &[i64]) -> LaneRelations<'_> {
        let ahead = self.followed(lanelets, |l| &l.successors, REACH);
        let behind = self.followed(lanelets, |l| self.comes_from(l), REACH);
        let mut connected = HashMap::new();
        let mut add = |ids: &[i64], relation| {
            for id in ids {
                connected.entry(*id).or_insert(relation);
            }
        };
        add(lanelets, LaneRelation::Same);
        add(&ahead, LaneRelation::Ahead);
        add(&behind, LaneRelation::Behind);
        let chain: Vec<i64> = ahead.iter().chain(&behind).copied().collect();
        let mut oncoming = Vec::new();
        for (left, next, further) in [
            (true, LaneRelation::Left, LaneRelation::FurtherLeft),
            (false, LaneRelation::Right, LaneRelation::FurtherRight),
        ] {
            for id in &chain {
                let beside = self.neighbours(*id, left);
                let same: Vec<i64> = with_direction(&beside, true);
                add(&same[..same.len().min(1)], next);
                add(&same[same.len().min(1)..], further);
                oncoming.extend(with_direction(&beside, false));
            }
        }
        add(&oncoming, LaneRelation::Oncoming);
        // Lanes that cross are told from these later: that takes the shapes of both.
        add(
            &self.followed(&ahead, |l| &l.predecessors, REACH),
            LaneRelation::Merging,
        );
        add(
            &self.followed(&behind, |l| &l.successors, REACH),
            LaneRelation::Diverging,
        );
        LaneRelations {
            network: self,
            ahead,
            connected,
            lines: OnceCell::new(),
            crosses: RefCell::default(),
        }
    }

    /// The lanelets from `starts` on, nearest first, the starts included, that begin within `reach` metres of their
    /// ends.
    fn followed(
        &self,
        starts: &[i64],
        next: impl for<'l> Fn(&'l Lanelet) -> &'l [i64],
        reach: f64,
    ) -> Vec<i64> {
        let mut found: Vec<i64> = starts.to_vec();
        let mut known: HashSet<i64> = starts.iter().copied().collect();
        let mut open: VecDeque<(i64, f64)> = starts.iter().map(|id| (*id, 0.0)).collect();
        while let Some((id, far)) = open.pop_front() {
            let Some(lanelet) = self.lanelet(id) else {
                continue;
            };
            for &id in next(lanelet) {
                let Some(after) = self.lanelet(id).filter(|_| known.insert(id)) else {
                    continue;
                };
                found.push(id);
                let far = far + length(after);
                if far <= reach {
                    open.push_back((id, far));
                }
            }
        }
        found
    }

    /// The lanelet that a lanelet continues: of several that lead into it, the one that turns least. Those that turn into
    /// it, as from a cross street, join it.
    fn comes_from<'l>(&self, lanelet: &'l Lanelet) -> &'l [i64] {
        let all = &lanelet.predecessors;
        if all.len() < 2 {
            return all;
        }
        let turns = all
            .iter()
            .map(|id| self.lanelet(*id).map_or(0.0, turn))
            .enumerate()
            .filter(|(_, turn)| *turn <= SAME_WAY);
        let least = turns.min_by(|a, b| a.1.total_cmp(&b.1));
        least.map_or(&[], |(place, _)| std::slice::from_ref(&all[place]))
    }

    /// The lanelets on one side of a lanelet, the nearest first, and whether they have its direction.
    fn neighbours(&self, id: i64, left: bool) -> Vec<(i64, bool)> {
        let mut found: Vec<(i64, bool)> = Vec::new();
        let (mut at, mut same) = (id, true);
        while let Some(Adjacent {
            id: next,
            same_direction,
        }) = self.lanelet(at).and_then(|l| {
            // Seen from an oncoming lane, the sides are the other way round.
            if left == same {
                l.adjacent_left
            } else {
                l.adjacent_right
            }
        }) {
            if next == id || found.iter().any(|(known, _)| *known == next) {
                break;
            }
            same = same == same_direction;
            found.push((next, same));
            at = next;
        }
        found
    }
}

impl LaneRelations<'_> {
    /// What the lane of a lanelet is to it.
    #[must_use]
    pub fn relation_to(&self, id: i64) -> LaneRelation {
        let known = self.connected.get(&id).copied();
        match known {
            None | Some(LaneRelation::Merging | LaneRelation::Diverging) if self.crosses(id) => {
                LaneRelation::Crossing
            }
            None => LaneRelation::OtherRoad,
            Some(relation) => relation,
        }
    }

    fn crosses(&self, id: i64) -> bool {
        if let Some(known) = self.crosses.borrow().get(&id) {
            return *known;
        }
        let network = self.network;
        let theirs = network.followed(&[id], |l| &l.successors, CROSSING_REACH);
        let ours = self
            .lines
            .get_or_init(|| CentreLines::new(network, &self.ahead));
        let mut not_ours = theirs.iter().filter(|id| !ours.lanelets.contains(id));
        let crosses = not_ours.any(|id| centre_line(network, *id).is_some_and(|l| ours.meet(&l)));
        self.crosses.borrow_mut().insert(id, crosses);
        crosses
    }
}

/// The middle of a lanelet; `None` where it has no length.
fn centre_line(network: &LaneletNetwork, id: i64) -> Option<Vec<Point>> {
    let lane = Lane::from_lanelet(network.lanelet(id)?)?;
    Some(lane.centre().points().to_vec())
}

/// The middles of lanelets, in pieces.
#[derive(Debug)]
struct CentreLines {
    lanelets: HashSet<i64>,
    pieces: Vec<[Point; 2]>,
    boxes: BoxTree,
}

impl CentreLines {
    fn new(network: &LaneletNetwork, lanelets: &[i64]) -> Self {
        let lines = lanelets.iter().filter_map(|id| centre_line(network, *id));
        let pieces: Vec<[Point; 2]> = lines.flat_map(|line| in_pieces(&line)).collect();
        Self {
            lanelets: lanelets.iter().copied().collect(),
            boxes: BoxTree::new(pieces.iter().map(bounds_of)),
            pieces,
        }
    }

    /// Whether a line crosses one of them.
    fn meet(&self, line: &[Point]) -> bool {
        in_pieces(line).iter().any(|s| {
            let crosses = |place: usize| pieces_cross(s, &self.pieces[place]);
            self.boxes.any_meeting(&bounds_of(s), crosses)
        })
    }
}

fn in_pieces(line: &[Point]) -> Vec<[Point; 2]> {
    line.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// The box around a piece.
fn bounds_of(piece: &[Point; 2]) -> Bounds {
    let [a, b] = piece.map(|p| Bounds { min: p, max: p });
    a.union(&b)
}

/// Sine of the least angle between lines that cross: where one joins the other, they have nearly the same direction.
const LEAST_SINE: f64 = 0.35;

/// Whether two pieces of lines cross, ends included, so that a corner on the other line counts.
fn pieces_cross(s: &[Point; 2], t: &[Point; 2]) -> bool {
    let (along, across) = (s[1] - s[0], t[1] - t[0]);
    let steep = along.perp(&across).abs() > LEAST_SINE * along.norm() * across.norm();
    let side = |p: &Point, of: &[Point; 2]| (of[1] - of[0]).perp(&(p - of[0]));
    steep && side(&s[0], t) * side(&s[1], t) <= 0.0 && side(&t[0], s) * side(&t[1], s) <= 0.0
}

fn with_direction(beside: &[(i64, bool)], same: bool) -> Vec<i64> {
    let of = beside.iter().filter(|(_, s)| *s == same);
    of.map(|(id, _)| *id).collect()
}

/// The direction of a lanelet beside a point, radians: that of the left border there.
fn heading_at(lanelet: &Lanelet, p: &Point) -> Option<f64> {
    let pieces = lanelet.left.points.windows(2);
    let far = |piece: &[Point]| distance_to_segment(p, &piece[0], &piece[1]);
    let nearest = pieces.min_by(|a, b| far(a).total_cmp(&far(b)))?;
    let along = nearest[1] - nearest[0];
    Some(along.y.atan2(along.x))
}

/// By how much a lanelet turns from its beginning to its end, radians; 0 without a length.
fn turn(lanelet: &Lanelet) -> f64 {
    let way = |pair: Option<&[Point]>| {
        let along: Vector = pair.map(|pair| pair[1] - pair[0])?;
        Some(along.y.atan2(along.x))
    };
    let mut pieces = lanelet.left.points.windows(2);
    let last = way(pieces.clone().next_back());
    let first = way(pieces.next());
    let turn = first
        .zip(last)
        .map(|(first, last)| angle_between(first, last));
    turn.map_or(0.0, f64::abs)
}

/// Roughly, metres: how far a lane is followed needs no more.
fn length(lanelet: &Lanelet) -> f64 {
    let points = lanelet.left.points.windows(2);
    points.map(|pair| (pair[1] - pair[0]).norm()).sum()
}
