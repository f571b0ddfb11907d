//! Divides the dev scenarios: a part whose wrong answers are shown, and a part on which templates are compared.

use std::collections::BTreeMap;

use nearmiss_scene::scenario::identity;
use nearmiss_study::evaluation::statistics::SplitMix;

/// A part of the dev split.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DevPart {
    /// Wrong answers of it are shown to the reflecting model.
    Feedback,
    /// Templates are compared on it.
    Selection,
}

impl DevPart {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Feedback => "feedback",
            Self::Selection => "selection",
        }
    }
}

/// The part of each scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Division {
    /// In the order of the scenarios.
    pub parts: Vec<DevPart>,
    /// Whether scenarios on the same map are in the same part; with fewer than two maps of a kind they are not.
    pub by_map: bool,
}

/// Share of the scenarios that is shown.
const SHOWN: f64 = 0.4;

impl Division {
    /// Divides scenarios, each with its name and whether one of its windows is dangerous: both parts get dangerous and
    /// safe ones, by a seed.
    ///
    /// # Errors
    /// There are too few of a kind.
    pub fn new(scenarios: &[(&str, bool)], seed: u64) -> Result<Self, String> {
        let family = |name: &str| identity::family(name).to_string();
        if let Some(parts) = divided(scenarios, seed, family) {
            let by_map = true;
            return Ok(Self { parts, by_map });
        }
        let alone = divided(scenarios, seed, |name| name.to_string());
        let by_map = false;
        alone.map(|parts| Self { parts, by_map }).ok_or_else(|| {
            let dangerous = scenarios.iter().filter(|(_, dangerous)| *dangerous).count();
            format!(
                "the dev split has {dangerous} dangerous and {} safe scenarios; tuning needs at least two of each: change \
                 the share or the seed of the split, or add scenarios",
                scenarios.len() - dangerous
            )
        })
    }
}

/// The parts, where scenarios of one unit stay together; `None` where a kind has fewer than two units.
fn divided(
    scenarios: &[(&str, bool)],
    seed: u64,
    unit_of: impl Fn(&str) -> String,
) -> Option<Vec<DevPart>> {
    let mut units: BTreeMap<String, (Vec<usize>, bool)> = BTreeMap::new();
    for (place, (name, dangerous)) in scenarios.iter().enumerate() {
        let unit = units.entry(unit_of(name)).or_default();
        unit.0.push(place);
        unit.1 |= dangerous;
    }
    let mut parts = vec![DevPart::Selection; scenarios.len()];
    for kind in [true, false] {
        let mut of_kind: Vec<(u64, &Vec<usize>)> = units
            .iter()
            .filter(|(_, (_, dangerous))| *dangerous == kind)
            .map(|(name, (places, _))| (order(seed, name), places))
            .collect();
        if of_kind.len() < 2 {
            return None;
        }
        of_kind.sort_unstable();
        let all: usize = of_kind.iter().map(|(_, places)| places.len()).sum();
        let wanted = (all as f64 * SHOWN).round().max(1.0) as usize;
        let mut shown = 0;
        // The last one is for the selection.
        for (_, places) in &of_kind[..of_kind.len() - 1] {
            if shown >= wanted {
                break;
            }
            shown += places.len();
            for place in *places {
                parts[*place] = DevPart::Feedback;
            }
        }
    }
    Some(parts)
}

/// A number for a name that another seed makes another one: FNV-1a, mixed.
fn order(seed: u64, name: &str) -> u64 {
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    SplitMix(hash ^ SplitMix(seed).draw()).draw()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn names(maps: usize) -> Vec<(String, bool)> {
        let name = |map: usize, number: usize| format!("DEU_Town-{map}_{number}_T-1");
        let of_map = |map| (1..=2).map(move |number| (name(map, number), map % 2 == 0));
        (1..=maps).flat_map(of_map).collect()
    }

    fn divide(all: &[(String, bool)], seed: u64) -> Result<Division, String> {
        let all: Vec<(&str, bool)> = all.iter().map(|(n, d)| (n.as_str(), *d)).collect();
        Division::new(&all, seed)
    }

    #[test]
    fn both_parts_have_both_kinds_and_maps_stay_together() {
        let all = names(20);
        let found = divide(&all, 1).unwrap();
        assert!(found.by_map);
        for part in [DevPart::Feedback, DevPart::Selection] {
            for kind in [true, false] {
                let of = all.iter().zip(&found.parts);
                let count = of.filter(|((_, d), p)| *d == kind && **p == part).count();
                assert_eq!(count, if part == DevPart::Feedback { 8 } else { 12 });
            }
        }
        for pair in found.parts.chunks(2) {
            assert_eq!(pair[0], pair[1]);
        }
        assert_eq!(divide(&all, 1).unwrap(), found);
        assert_ne!(divide(&all, 2).unwrap(), found);
    }

    #[test]
    fn few_maps_are_divided_by_scenario_and_too_few_scenarios_not_at_all() {
        let two = names(2);
        let found = divide(&two, 1).unwrap();
        assert!(!found.by_map);
        assert_eq!(
            found
                .parts
                .iter()
                .filter(|p| **p == DevPart::Feedback)
                .count(),
            2
        );
        let why = divide(&two[..3], 1).unwrap_err();
        assert!(why.contains("1 dangerous and 2 safe"), "{why}");
    }
}
