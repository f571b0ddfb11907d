//! Rows of tables and of comma-separated values: every cell is a sentence under its title.

use super::Claim;
use super::above::Above;
use super::clauses::Spoken;
use super::find::{MentionContext, lowered};
use super::mentions::Mention;
use super::number::{MentionedTime, Number, Unit, numbers};
use super::reading::read;
use super::tokens::has_word;

/// What parts the cells of a line: that of a table, or of comma-separated values below a row of names.
pub fn separator(line: &str, titles: &[String]) -> Option<char> {
    let bare = line.trim();
    if bare.starts_with('|') && bare.len() > 1 {
        return Some('|');
    }
    let count = bare.split(',').count();
    let is_name = |cell: &str| {
        let cell = cell.trim();
        let mut letters = cell.chars();
        letters.next().is_some_and(char::is_alphabetic)
            && letters.all(|c| c.is_alphanumeric() || "_/()[]".contains(c))
    };
    let is_head = count > 1
        && bare.split(',').all(is_name)
        && (bare.contains('_') || bare.to_lowercase().starts_with("id,"));
    let is_row = titles.len() > 1 && titles.len() == count && !bare.contains(", ");
    (is_head || is_row).then_some(',')
}

/// A cell: its place in the line, and its text.
type Cell<'a> = (usize, &'a str);

/// The cells of a row with the places where they begin.
fn cells(line: &str, separator: char) -> Vec<Cell<'_>> {
    let mut at = 0;
    let pieces = line.split(separator).map(move |piece| {
        let from = at;
        at += piece.len() + 1;
        (from, piece)
    });
    let skipped = usize::from(separator == '|');
    pieces
        .skip(skipped)
        .filter(|(_, piece)| !piece.is_empty())
        .collect()
}

/// The only obstacle that a text is the id of.
fn id(text: &str, world: &MentionContext<'_>) -> Option<i64> {
    let [number] = numbers(text).try_into().ok()?;
    number.as_integer().filter(|id| world.ids.contains(id))
}

/// A row of a table.
pub fn row(
    (line, separator, start): (&str, char, usize),
    world: &MentionContext<'_>,
    above: &mut Above,
    found: &mut Vec<Claim>,
) {
    let cells = cells(line, separator);
    if above.titles.is_empty() {
        above.titles = cells.iter().map(|(_, cell)| lowered(cell)).collect();
        return;
    }
    if above.time == MentionedTime::Unclear {
        return;
    }
    let title = |i: usize| above.titles.get(i).map_or("", String::as_str);
    let heads: Vec<Option<i64>> = (0..cells.len()).map(|i| id(title(i), world)).collect();
    // "| Measure | 7 | 8 |": what is measured stands at the beginning of the row.
    if heads.len() > 1 && heads[1..].iter().all(Option::is_some) {
        let label = lowered(cells[0].1);
        for (cell, obstacle) in cells.iter().zip(&heads).skip(1) {
            if let Some(obstacle) = obstacle {
                self::cell(
                    *cell,
                    &label,
                    (*obstacle, above.time, start),
                    (world, found),
                );
            }
        }
        return;
    }
    let of_obstacles = |i: usize| {
        let words = ["obstacle", "id", "vehicle"];
        i == 0 || words.iter().any(|word| title(i).contains(word))
    };
    let mut named: Vec<i64> = { cells.iter().enumerate() }
        .filter(|(i, _)| of_obstacles(*i))
        .filter_map(|(_, (_, cell))| id(cell, world))
        .collect();
    named.dedup();
    let [obstacle] = named.as_slice() else {
        return;
    };
    for (i, one) in cells.iter().enumerate() {
        let is_name = numbers(one.1)
            .iter()
            .any(|n| n.as_integer() == Some(*obstacle));
        if !is_name {
            cell(
                *one,
                title(i),
                (*obstacle, above.time, start),
                (world, found),
            );
        }
    }
}

/// A cell: the value of a field that its title names.
fn cell(
    (from, cell): Cell<'_>,
    title: &str,
    (obstacle, when, start): (i64, MentionedTime, usize),
    (world, found): (&MentionContext<'_>, &mut Vec<Claim>),
) {
    // The unit may stand in the title.
    let titled = numbers(&title.replace(['(', '[', ',', '_'], " 1 "));
    let unit = titled.iter().map(|n| n.unit).find(|u| *u != Unit::None);
    let label = title.split(['(', '[', ',']).next().unwrap_or(title);
    let label = label.trim_matches([' ', '*', ':']);
    let is_time = has_word(label, "time") && !title.contains("collision");
    if label.is_empty() || is_time {
        return;
    }
    let lower = format!("{label}: {}", lowered(cell).trim());
    let mut all: Vec<Number> = numbers(&lower);
    all.retain(|number| number.span.start > label.len());
    for number in &mut all {
        if number.unit == Unit::None && !title.contains("risk") && !title.contains("score") {
            number.unit = unit.unwrap_or(Unit::None);
        }
    }
    const NO_ONE: &[Mention] = &[];
    let (mut claims, _) = read(
        (&lower, &all, NO_ONE, 0),
        (&[], when, &Spoken::of(obstacle)),
        ("", false),
        world,
    );
    for claim in &mut claims {
        let begin = start + from + (cell.len() - cell.trim_start().len());
        claim.span = begin..start + from + cell.trim_end().len().max(1);
        claim.named = true;
    }
    found.extend(claims);
}
