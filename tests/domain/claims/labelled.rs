//! Claims that were labelled by hand, see `tests/claims/README.md`: how many are found, and decided as the label says.

use std::collections::BTreeMap;

use nearmiss::evaluation::claims::{
    CheckedClaim, ClaimedValue, Judgement, Quantity, Subject, TimeOrigin, checked,
};
use nearmiss::paper;
use nearmiss::store::Run;

use super::{scenes, support::recorded::folder};

const LABELS: &str = include_str!("labels.csv");
const ANSWERS: &str = include_str!("answers.txt");

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Holds {
    True,
    False,
    Undecidable,
}

/// A labelled claim: where it stands, and what it says.
#[derive(Debug)]
struct Label {
    answer: usize,
    line: usize,
    hash: u64,
    obstacle: i64,
    quantity: String,
    /// The number or the place; empty for a contact.
    value: String,
    holds: Holds,
}

impl Label {
    fn read(row: &str) -> Self {
        let cells: Vec<&str> = row.split(',').collect();
        let [answer, line, hash, obstacle, quantity, value, _step, holds] = cells[..] else {
            panic!("{row}");
        };
        Self {
            answer: answer.parse().unwrap(),
            line: line.parse().unwrap(),
            hash: u64::from_str_radix(hash, 16).unwrap(),
            obstacle: obstacle.parse().unwrap(),
            quantity: quantity.into(),
            value: value.into(),
            holds: match holds {
                "true" => Holds::True,
                "false" => Holds::False,
                "undecidable" => Holds::Undecidable,
                other => panic!("{other}"),
            },
        }
    }

    /// Whether a claim that was found says what was labelled. A time to collision need not name its axis.
    fn is(&self, found: &CheckedClaim) -> bool {
        let claim = &found.claim;
        let name = claim.quantity.name();
        let length = ["distance", "gap longitudinal", "gap lateral"];
        let same_quantity = name == self.quantity
            || claim.quantity == Quantity::Ttc && self.quantity.starts_with("TTC")
            || name.starts_with("TTC") && self.quantity == "TTC"
            || claim.quantity == Quantity::Distance && length.contains(&&*self.quantity);
        let same_value = match claim.stated {
            ClaimedValue::Number { value, .. } => self
                .value
                .parse::<f64>()
                .is_ok_and(|said| said == value || (said.abs() - value.abs()).abs() < 1e-9),
            ClaimedValue::Side(side) => side.to_string() == self.value,
            ClaimedValue::Contact => true,
            // The labels are of the other kinds.
            _ => false,
        };
        claim.obstacle == self.obstacle && same_quantity && same_value
    }
}

/// Whether a claim is of a kind that was labelled: numbers, directions, and contact at a step.
fn is_of_labelled_kind(found: &CheckedClaim, ego: i64) -> bool {
    use ClaimedValue::{Contact, Number, Side};
    let was_not = [
        Quantity::LeastDistance,
        Quantity::MinDistance,
        Quantity::Heading,
        Quantity::ClosingSpeed,
        Quantity::Headway,
    ];
    matches!(found.claim.stated, Number { .. } | Side(_) | Contact)
        && !was_not.contains(&found.claim.quantity)
        && found.claim.obstacle != ego
}

/// How many answers were labelled first; the others were added later.
const FIRST: usize = 36;

/// What was found of labelled claims.
#[derive(Debug, Default)]
struct Tally {
    /// Labels whose claim was found.
    seen: usize,
    /// Claims that the program calls right or wrong.
    decided: usize,
    /// Those of them that the labels call the same.
    agree: usize,
    /// Labels that are true or false.
    checkable: usize,
    /// Those of them that the program calls the same.
    recalled: usize,
}

impl Tally {
    fn plus(&self, other: &Self) -> Self {
        Self {
            seen: self.seen + other.seen,
            decided: self.decided + other.decided,
            agree: self.agree + other.agree,
            checkable: self.checkable + other.checkable,
            recalled: self.recalled + other.recalled,
        }
    }

    fn precision(&self) -> f64 {
        self.agree as f64 / self.decided as f64
    }

    fn recall(&self) -> f64 {
        self.recalled as f64 / self.checkable as f64
    }

    fn print(&self, of: &str) {
        println!(
            "{of}: {} found; precision {:.3} ({} of {}), recall {:.3} ({} of {})",
            self.seen,
            self.precision(),
            self.agree,
            self.decided,
            self.recall(),
            self.recalled,
            self.checkable,
        );
    }
}

/// FNV-1a, 64 bits: shows that a line is the one that was labelled, without quoting it.
fn hash(line: &str) -> u64 {
    line.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// The line of a byte, from 1.
fn line_of(text: &str, byte: usize) -> usize {
    text[..byte].matches('\n').count() + 1
}

#[test]
fn labelled_claims_are_found_and_decided_as_people_do() {
    let Some(root) = folder() else { return };
    let scenes = scenes(&root);
    let (runs, _) = paper::runs(&root, 0);
    let by_source: BTreeMap<&str, &Run> = runs
        .iter()
        .filter_map(|run| Some((run.source.as_deref()?, run)))
        .collect();
    let labels: Vec<Label> = LABELS.lines().skip(1).map(Label::read).collect();
    assert!(labels.len() >= 200);
    let (mut first, mut added) = (Tally::default(), Tally::default());
    for (answer, source) in ANSWERS.lines().enumerate() {
        let run = by_source
            .get(source)
            .unwrap_or_else(|| panic!("{source} is missing"));
        let key = (
            run.question.scenario.clone(),
            run.question.scenario_hash.clone().unwrap_or_default(),
        );
        let subject = Subject::new(
            &scenes[&key],
            TimeOrigin::from_messages(&run.question.messages),
            run.question.window,
        );
        let mut found = checked(&run.answer, &subject);
        found.retain(|one| is_of_labelled_kind(one, subject.scene.ego.id));
        let tally = if answer < FIRST {
            &mut first
        } else {
            &mut added
        };
        let mut taken = vec![false; found.len()];
        for label in labels.iter().filter(|label| label.answer == answer) {
            let line = run.answer.split('\n').nth(label.line - 1).unwrap();
            assert_eq!(hash(line), label.hash, "{source}, line {}", label.line);
            let place = found.iter().enumerate().position(|(i, one)| {
                !taken[i]
                    && line_of(&run.answer, one.claim.span.start) == label.line
                    && label.is(one)
            });
            let judgement = place.map(|place| {
                taken[place] = true;
                found[place].judgement
            });
            let said = match judgement {
                Some(Judgement::Right) => Some(Holds::True),
                Some(Judgement::Wrong) => Some(Holds::False),
                Some(Judgement::Unknown(_)) => Some(Holds::Undecidable),
                None => None,
            };
            tally.seen += usize::from(said.is_some());
            if matches!(said, Some(Holds::True | Holds::False)) {
                tally.decided += 1;
                tally.agree += usize::from(said == Some(label.holds));
            }
            if label.holds != Holds::Undecidable {
                tally.checkable += 1;
                tally.recalled += usize::from(said == Some(label.holds));
            }
            if said != Some(label.holds) {
                let shown = place.map(|place| found[place].line());
                println!("label {label:?}\n   program {judgement:?} {shown:?}");
            }
        }
        // What nobody labelled is a mistake of the finder where it is called right or wrong.
        // One that says again what was labelled is none.
        let again = |one: &CheckedClaim| {
            let line = line_of(&run.answer, one.claim.span.start);
            let mut own = labels.iter().filter(|label| label.answer == answer);
            own.any(|label| label.line == line && label.is(one))
        };
        let others = found.iter().zip(&taken).filter(|(_, taken)| !**taken);
        for (one, _) in others.filter(|(one, _)| !again(one)) {
            let line = line_of(&run.answer, one.claim.span.start);
            println!(
                "not labelled: answer {answer}, line {line}: {:?} {}",
                one.judgement,
                one.line()
            );
            tally.decided += usize::from(!matches!(one.judgement, Judgement::Unknown(_)));
        }
    }
    first.print("the first 36 answers");
    added.print("the twelve added later");
    let all = first.plus(&added);
    all.print("all");
    for tally in [&first, &all] {
        assert!(tally.precision() >= 0.95, "{tally:?}");
        assert!(tally.recall() >= 0.8, "{tally:?}");
    }
}
