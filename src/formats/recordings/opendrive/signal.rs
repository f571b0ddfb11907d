//! Signs and lights beside a road.

use super::lane::speed;
use super::tree::Node;
use crate::commonroad::ReadError;

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
pub fn read(node: &Node) -> Result<Signal, ReadError> {
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
