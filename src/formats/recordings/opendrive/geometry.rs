//! Reference lines of roads: lines, arcs, spirals, cubics.

use super::tree::Node;
use crate::commonroad::ReadError;
use nearmiss_base::geometry::{Point, Pose, Vector};
use nearmiss_scene::scenario::plausibility::refused_coordinate;

/// A cubic from an offset on.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cubic {
    /// Where it begins, metres.
    pub from: f64,
    /// Its coefficients.
    pub of: [f64; 4],
}

impl Cubic {
    /// Reads one; `from` names the attribute of its beginning.
    pub fn read(node: &Node, from: &str) -> Result<Self, ReadError> {
        let mut of = [0.0; 4];
        for (value, name) in of.iter_mut().zip(["a", "b", "c", "d"]) {
            *value = node.or_zero(name)?;
        }
        Ok(Self {
            from: node.or_zero(from)?,
            of,
        })
    }

    /// Its value at a distance from its beginning.
    fn value(&self, x: f64) -> f64 {
        let [a, b, c, d] = self.of;
        a + x * (b + x * (c + x * d))
    }

    fn slope(&self, x: f64) -> f64 {
        let [_, b, c, d] = self.of;
        b + x * (2.0 * c + x * 3.0 * d)
    }
}

/// The value of cubics in order at a place; 0 before the first.
pub fn value(of: &[Cubic], at: f64) -> f64 {
    let place = of.partition_point(|c| c.from <= at + 1e-9);
    let cubic = place.checked_sub(1).and_then(|i| of.get(i));
    cubic.map_or(0.0, |c| c.value(at - c.from))
}

/// How the header of a file moves all its roads: first by x and y, then by a turn about the origin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Offset {
    /// Metres.
    by: Vector,
    /// Radians.
    turn: f64,
}

impl Offset {
    /// That of a header; none where it has none.
    pub fn read(header: Option<&Node>) -> Result<Self, ReadError> {
        let Some(node) = header.and_then(|h| h.child("offset")) else {
            return Ok(Self::default());
        };
        Ok(Self {
            by: Vector::new(node.or_zero("x")?, node.or_zero("y")?),
            turn: node.or_zero("hdg")?,
        })
    }

    /// A pose of the file where it is in the world.
    pub fn apply(&self, pose: Pose) -> Pose {
        let moved = pose.position + self.by;
        let world = Pose::new(0.0, 0.0, self.turn).to_world(&moved);
        Pose {
            position: world,
            heading: pose.heading + self.turn,
        }
    }

    /// What it does, in words; nothing where it does nothing.
    pub fn text(&self) -> Option<String> {
        (*self != Self::default()).then(|| {
            format!(
                "the offset of the header moves the roads by {} m, {} m and turns them by {} rad",
                self.by.x, self.by.y, self.turn
            )
        })
    }
}

/// The shape of a piece of a reference line.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Line,
    Arc(f64),
    /// Curvatures at its ends.
    Spiral(f64, f64),
    /// To the left, over the distance straight ahead.
    Poly3(Cubic),
    /// Ahead and to the left, over a parameter that ends at a value.
    ParamPoly3(Cubic, Cubic, f64),
}

impl Kind {
    /// Reads the shape of a piece.
    fn read(node: &Node, length: f64) -> Result<Self, ReadError> {
        Ok(match node.name.as_str() {
            "arc" => Self::Arc(node.needed_number("curvature")?),
            "spiral" => {
                // Files leave out curvatures of 0.
                let (from, to) = (node.or_zero("curvStart")?, node.or_zero("curvEnd")?);
                let turn = from.abs().max(to.abs()) * length;
                if turn > MOST_TURN {
                    return Err(node.fail(format!(
                        "it may turn by {turn:.0} rad; no road does: is a curvature or the length wrong?"
                    )));
                }
                Self::Spiral(from, to)
            }
            "poly3" => Self::Poly3(Cubic::read(node, "")?),
            "paramPoly3" => {
                let cubic = |axis: &str| -> Result<Cubic, ReadError> {
                    let mut of = [0.0; 4];
                    for (value, name) in of.iter_mut().zip(["a", "b", "c", "d"]) {
                        *value = node.or_zero(&format!("{name}{axis}"))?;
                    }
                    Ok(Cubic { from: 0.0, of })
                };
                let end = match node.text("pRange") {
                    Some("arcLength") => length,
                    _ => 1.0,
                };
                Self::ParamPoly3(cubic("U")?, cubic("V")?, end)
            }
            _ => Self::Line,
        })
    }
}

/// A piece of a reference line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Where it begins, metres.
    pub s: f64,
    start: Pose,
    /// Metres.
    pub length: f64,
    kind: Kind,
}

/// No piece is longer, metres.
const LONGEST: f64 = 1e6;

/// No piece turns by more, radians: some thirty times.
const MOST_TURN: f64 = 200.0;

/// The elements that tell the shape of a piece.
const SHAPES: [&str; 5] = ["line", "arc", "spiral", "poly3", "paramPoly3"];

impl Piece {
    /// Reads a `<geometry>` of a file that is moved so.
    pub fn read(node: &Node, moved: &Offset) -> Result<Self, ReadError> {
        let number = |name: &str| node.needed_number(name);
        let length = number("length")?;
        if !(0.0..=LONGEST).contains(&length) {
            return Err(node.fail(format!("length=\"{length}\" is not from 0 to {LONGEST}")));
        }
        let shape = node
            .first(|c| SHAPES.contains(&c.name.as_str()))
            .ok_or_else(|| node.fail("no line, arc, spiral, poly3 or paramPoly3 in it"))?;
        let start = moved.apply(Pose::new(number("x")?, number("y")?, number("hdg")?));
        for value in [start.position.x, start.position.y] {
            if let Some(why) = refused_coordinate(value) {
                return Err(node.fail(format!("moved by the offset of the header: {why}")));
            }
        }
        Ok(Self {
            s: number("s")?,
            start,
            length,
            kind: Kind::read(shape, length)?,
        })
    }

    /// Its first pose.
    pub fn start(&self) -> Pose {
        self.start
    }

    /// The pose after so many metres. Behind its end a line or arc goes on as it is, all else straight ahead.
    pub fn at(&self, along: f64) -> Pose {
        let goes_on = matches!(self.kind, Kind::Line | Kind::Arc(_));
        let beyond = if goes_on { 0.0 } else { along - self.length };
        if beyond > 0.0 {
            let end = self.at(self.length);
            return Pose {
                position: end.to_world(&Point::new(beyond, 0.0)),
                ..end
            };
        }
        let (x, y, turn) = match &self.kind {
            Kind::Line => (along, 0.0, 0.0),
            Kind::Arc(k) => turned(*k, along),
            Kind::Spiral(from, to) => {
                let change = if self.length > 0.0 {
                    (to - from) / self.length
                } else {
                    0.0
                };
                spiral(*from, change, along)
            }
            Kind::Poly3(cubic) => {
                let x = ahead(cubic, along);
                (x, cubic.value(x), cubic.slope(x).atan())
            }
            Kind::ParamPoly3(u, v, end) => {
                let share = if self.length > 0.0 {
                    along / self.length
                } else {
                    0.0
                };
                let p = share * end;
                let (du, dv) = (u.slope(p), v.slope(p));
                let turn = if du == 0.0 && dv == 0.0 {
                    0.0
                } else {
                    dv.atan2(du)
                };
                (u.value(p), v.value(p), turn)
            }
        };
        let position = self.start.to_world(&Point::new(x, y));
        Pose {
            position,
            heading: self.start.heading + turn,
        }
    }
}

fn turned(k: f64, s: f64) -> (f64, f64, f64) {
    let half = k * s / 2.0;
    let chord = if half == 0.0 {
        s
    } else {
        s * half.sin() / half
    };
    (chord * half.cos(), chord * half.sin(), k * s)
}

/// A curve whose curvature changes evenly: integrated in short steps with five points each.
fn spiral(k: f64, change: f64, s: f64) -> (f64, f64, f64) {
    const POINTS: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    let angle = |u: f64| k * u + change * u * u / 2.0;
    let bend = (k.abs() + (change * s).abs()) * s.abs();
    let steps = bend.ceil().clamp(1.0, 2000.0);
    let half = s / steps / 2.0;
    let mut sum = Vector::zeros();
    for i in 0..steps as usize {
        let middle = (2.0 * i as f64 + 1.0) * half;
        for (x, weight) in POINTS {
            let a = angle(middle + half * x);
            sum += Vector::new(a.cos(), a.sin()) * (weight * half);
        }
    }
    (sum.x, sum.y, angle(s))
}

/// How far ahead a cubic is after so many metres of its own length.
fn ahead(cubic: &Cubic, along: f64) -> f64 {
    let steps = (along / 0.5).ceil().clamp(1.0, 2000.0);
    let step = along / steps;
    let rate = |x: f64| 1.0 / cubic.slope(x).hypot(1.0);
    let mut x = 0.0;
    for _ in 0..steps as usize {
        // Runge and Kutta's way.
        let a = rate(x);
        let b = rate(x + step / 2.0 * a);
        let c = rate(x + step / 2.0 * b);
        let d = rate(x + step * c);
        x += step / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    x
}

/// The pose of a reference line at an arc length; the last piece goes on behind its end.
pub fn pose(pieces: &[Piece], s: f64) -> Pose {
    let place = pieces.partition_point(|p| p.s <= s + 1e-9).max(1) - 1;
    let is_last = place + 1 == pieces.len();
    match pieces.get(place) {
        Some(piece) if is_last => piece.at((s - piece.s).max(0.0)),
        Some(piece) => piece.at((s - piece.s).clamp(0.0, piece.length)),
        None => Pose::new(0.0, 0.0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(kind: Kind, length: f64) -> Piece {
        Piece {
            s: 0.0,
            start: Pose::new(0.0, 0.0, 0.0),
            length,
            kind,
        }
    }

    #[test]
    fn arcs_spirals_and_cubics_end_where_formulas_say() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let arc = piece(Kind::Arc(0.1), 10.0 * quarter).at(10.0 * quarter);
        assert!((arc.position - Point::new(10.0, 10.0)).norm() < 1e-9);
        assert!((arc.heading - quarter).abs() < 1e-12);
        // A spiral without change is an arc.
        let same = piece(Kind::Spiral(0.1, 0.1), 10.0 * quarter).at(10.0 * quarter);
        assert!((same.position - arc.position).norm() < 1e-9);
        // Fresnel's integrals at 1: C = 0.779893, S = 0.438259, for an angle of πs²/2.
        let pi = std::f64::consts::PI;
        let fresnel = piece(Kind::Spiral(0.0, pi), 1.0).at(1.0);
        assert!(
            (fresnel.position.x - 0.779_893_4).abs() < 1e-6,
            "{fresnel:?}"
        );
        assert!((fresnel.position.y - 0.438_259_1).abs() < 1e-6);
        // v = u is as long as √2 u.
        let slope = Cubic {
            from: 0.0,
            of: [0.0, 1.0, 0.0, 0.0],
        };
        let poly = piece(Kind::Poly3(slope), 10.0).at(10.0);
        assert!((poly.position - Point::new(50f64.sqrt(), 50f64.sqrt())).norm() < 1e-9);
        let ahead = Cubic {
            from: 0.0,
            of: [0.0, 4.0, 0.0, 0.0],
        };
        let side = Cubic {
            from: 0.0,
            of: [0.0, 0.0, 3.0, 0.0],
        };
        let end = piece(Kind::ParamPoly3(ahead, side, 1.0), 5.0).at(5.0);
        assert_eq!(end.position, Point::new(4.0, 3.0));
        assert!((end.heading - 6f64.atan2(4.0)).abs() < 1e-12);
    }

    #[test]
    fn cubics_hold_from_their_offset_on() {
        let all = [
            Cubic {
                from: 0.0,
                of: [3.0, 0.0, 0.0, 0.0],
            },
            Cubic {
                from: 10.0,
                of: [3.0, 0.5, 0.0, 0.0],
            },
        ];
        assert_eq!([value(&all, 5.0), value(&all, 12.0)], [3.0, 4.0]);
        assert_eq!(value(&all, 10.0), 3.0);
    }
}
