//! References between the elements of a road, and what is left of them where elements are gone.

use std::collections::HashSet;

use super::{Intersection, Lanelet, Sign, TrafficLight};

/// Ids that the elements of a road can refer to.
#[derive(Debug, Clone, Default)]
pub struct Referable {
    lanelets: HashSet<i64>,
    signs: HashSet<i64>,
    lights: HashSet<i64>,
}

impl Referable {
    /// Those of these elements.
    #[must_use]
    pub fn new(lanelets: &[Lanelet], signs: &[Sign], lights: &[TrafficLight]) -> Self {
        Self {
            lanelets: lanelets.iter().map(|l| l.id).collect(),
            signs: signs.iter().map(|s| s.id).collect(),
            lights: lights.iter().map(|l| l.id).collect(),
        }
    }
}

/// Keeps the references to what is there.
fn keep(ids: &mut Vec<i64>, known: &HashSet<i64>, from: &str, gone: &mut impl FnMut(String)) {
    ids.retain(|id| {
        let there = known.contains(id);
        if !there {
            gone(format!("{from}: the reference to {id} was left out"));
        }
        there
    });
}

impl Lanelet {
    /// Keeps the references to what is there; each other one is told in a sentence.
    pub fn keep_references(&mut self, known: &Referable, gone: &mut impl FnMut(String)) {
        let name = format!("lanelet {}", self.id);
        keep(&mut self.predecessors, &known.lanelets, &name, gone);
        keep(&mut self.successors, &known.lanelets, &name, gone);
        keep(&mut self.signs, &known.signs, &name, gone);
        keep(&mut self.lights, &known.lights, &name, gone);
        if let Some(line) = &mut self.stop_line {
            keep(&mut line.signs, &known.signs, &name, gone);
            keep(&mut line.lights, &known.lights, &name, gone);
        }
        for neighbour in [&mut self.adjacent_left, &mut self.adjacent_right] {
            if let Some(missing) = neighbour.take_if(|n| !known.lanelets.contains(&n.id)) {
                gone(format!("{name}: the neighbour {} was left out", missing.id));
            }
        }
    }

    /// Signs that it or its stop line refers to.
    pub(super) fn all_signs(&self) -> impl Iterator<Item = i64> {
        let line = self.stop_line.iter().flat_map(|line| &line.signs);
        self.signs.iter().chain(line).copied()
    }

    /// Lights that it or its stop line refers to.
    pub(super) fn all_lights(&self) -> impl Iterator<Item = i64> {
        let line = self.stop_line.iter().flat_map(|line| &line.lights);
        self.lights.iter().chain(line).copied()
    }
}

impl Intersection {
    /// Keeps the references to what is there, and the roads that still lead in; each other one is told in a sentence.
    pub fn keep_references(&mut self, known: &Referable, gone: &mut impl FnMut(String)) {
        let name = format!("intersection {}", self.id);
        for road in &mut self.incomings {
            for ids in [
                &mut road.lanelets,
                &mut road.right,
                &mut road.straight,
                &mut road.left,
            ] {
                keep(ids, &known.lanelets, &name, gone);
            }
        }
        self.incomings.retain(|road| {
            let leads_in = !road.lanelets.is_empty();
            if !leads_in {
                gone(format!(
                    "{name}: incoming {} has no lanelet and was left out",
                    road.id
                ));
            }
            leads_in
        });
        let roads: HashSet<i64> = self.incomings.iter().map(|r| r.id).collect();
        for road in &mut self.incomings {
            if let Some(missing) = road.is_left_of.take_if(|id| !roads.contains(id)) {
                gone(format!("{name}: `isLeftOf` {missing} was left out"));
            }
        }
        keep(&mut self.crossings, &known.lanelets, &name, gone);
    }
}
