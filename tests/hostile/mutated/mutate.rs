//! Mutations of a scenario's file, drawn from a seed.

use std::fmt::Write;
use std::ops::Range;

use fastrand::Rng;

use super::markup::Markup;

/// What stands where a number stood.
const NUMBERS: [&str; 26] = [
    "0",
    "-1",
    "1",
    "0.5",
    "-0",
    "1e308",
    "-1e308",
    "NaN",
    "inf",
    "-inf",
    "1e-320",
    "1e9",
    "-1e9",
    "1e15",
    "5e7",
    "90",
    "500",
    "1e400",
    "9223372036854775807",
    "18446744073709551616",
    "",
    "abc",
    "0x10",
    "1,5",
    "1e6",
    "٣",
];

const MUTATIONS: [fn(&mut Rng, &mut String); 20] = [
    number,
    number,
    number,
    every_number_of_a_name,
    every_number_of_a_name,
    delete_element,
    delete_element,
    delete_all_of_a_name,
    delete_all_of_a_name,
    duplicate_element,
    move_element,
    equal_ids,
    reference,
    reference,
    flat_polygon,
    time_step_size,
    swap_bounds,
    nest,
    entity,
    cut_text,
];

/// A file made of a scenario by a few mutations, mostly one: what the reader refuses tests no more than the reader.
pub fn mutated(rng: &mut Rng, scenario: &str) -> Vec<u8> {
    let mut text = scenario.to_owned();
    for _ in 0..[1, 1, 1, 2, 2, 3, 5][rng.usize(..7)] {
        MUTATIONS[rng.usize(..MUTATIONS.len())](rng, &mut text);
    }
    match rng.usize(..24) {
        0 => encoded(rng, &text),
        1 => flipped(rng, text.into_bytes()),
        2 => rearranged(rng, text.into_bytes()),
        _ => text.into_bytes(),
    }
}

fn pick<T: Clone>(rng: &mut Rng, of: &[T]) -> Option<T> {
    (!of.is_empty()).then(|| of[rng.usize(..of.len())].clone())
}

fn number(rng: &mut Rng, text: &mut String) {
    if let Some(place) = pick(rng, &Markup::of(text).numbers) {
        text.replace_range(place, NUMBERS[rng.usize(..NUMBERS.len())]);
    }
}

/// All x, times or widths at once, scaled, moved or replaced.
fn every_number_of_a_name(rng: &mut Rng, text: &mut String) {
    const NAMES: [&str; 12] = [
        "x",
        "y",
        "time",
        "velocity",
        "orientation",
        "length",
        "width",
        "acceleration",
        "intervalEnd",
        "intervalStart",
        "radius",
        "duration",
    ];
    const FACTORS: [f64; 10] = [0.0, -1.0, 1e-12, 1e-3, 57.3, 1e3, 1e7, 1e12, 1e300, 1e-320];
    let name = NAMES[rng.usize(..NAMES.len())];
    let markup = Markup::of(text);
    let inside = markup.named(text, name);
    let (factor, offset) = if rng.bool() {
        (FACTORS[rng.usize(..FACTORS.len())], 0.0)
    } else {
        (1.0, [1.0, 1e6, 1e9, 1e14][rng.usize(..4)])
    };
    for place in markup.numbers.iter().rev() {
        let hit = inside
            .iter()
            .any(|i| i.start < place.start && place.end < i.end);
        if hit && let Ok(value) = text[place.clone()].parse::<f64>() {
            let value = (value * factor + offset).to_string();
            text.replace_range(place.clone(), &value);
        }
    }
}

fn delete_element(rng: &mut Rng, text: &mut String) {
    if let Some(place) = pick(rng, &Markup::of(text).elements) {
        text.replace_range(place, "");
    }
}

/// No obstacles, no lanelets, no planning problem, no velocities.
fn delete_all_of_a_name(rng: &mut Rng, text: &mut String) {
    const NAMES: [&str; 14] = [
        "dynamicObstacle",
        "staticObstacle",
        "lanelet",
        "planningProblem",
        "trafficSign",
        "trafficLight",
        "intersection",
        "velocity",
        "orientation",
        "trajectory",
        "state",
        "initialState",
        "shape",
        "successor",
    ];
    let name = NAMES[rng.usize(..NAMES.len())];
    let mut places = Markup::of(text).named(text, name);
    places.sort_by_key(|place| place.start);
    // Some are left now and then.
    let keep = if rng.bool() { 0 } else { rng.usize(..2) };
    for place in places.into_iter().skip(keep).rev() {
        if text.get(place.clone()).is_some_and(|t| t.starts_with('<')) {
            text.replace_range(place, "");
        }
    }
}

fn duplicate_element(rng: &mut Rng, text: &mut String) {
    if let Some(place) = pick(rng, &Markup::of(text).elements) {
        let copy = text[place.clone()].repeat([1, 2, 50][rng.usize(..3)]);
        text.insert_str(place.end, &copy);
    }
}

fn move_element(rng: &mut Rng, text: &mut String) {
    let Some(place) = pick(rng, &Markup::of(text).elements) else {
        return;
    };
    let element = text[place.clone()].to_owned();
    text.replace_range(place, "");
    if let Some(to) = pick(rng, &Markup::of(text).elements) {
        text.insert_str(to.start, &element);
    }
}

fn equal_ids(rng: &mut Rng, text: &mut String) {
    let ids = Markup::of(text).ids;
    if let (Some(from), Some(to)) = (pick(rng, &ids), pick(rng, &ids)) {
        let id = text[from].to_owned();
        text.replace_range(to, &id);
    }
}

/// A reference to something else, to itself, to nothing; or a circle.
fn reference(rng: &mut Rng, text: &mut String) {
    let markup = Markup::of(text);
    let Some(place) = pick(rng, &markup.references) else {
        return;
    };
    let own = markup.ids.iter().rfind(|id| id.end < place.start);
    let id = match rng.usize(..3) {
        0 => own.map(|id| text[id.clone()].to_owned()),
        1 => pick(rng, &markup.ids).map(|id| text[id].to_owned()),
        _ => Some("987654".to_owned()),
    };
    text.replace_range(place, &id.unwrap_or_default());
}

/// Points of one element on a line, in one place, reversed, or only one.
fn flat_polygon(rng: &mut Rng, text: &mut String) {
    const NAMES: [&str; 3] = ["polygon", "leftBound", "rightBound"];
    let markup = Markup::of(text);
    let name = NAMES[rng.usize(..NAMES.len())];
    let Some(polygon) = pick(rng, &markup.named(text, name)) else {
        return;
    };
    let within = |place: &Range<usize>| polygon.start < place.start && place.end <= polygon.end;
    let points = markup.named(text, "point");
    let points: Vec<_> = points.into_iter().filter(within).collect();
    let mut copies: Vec<String> = points.iter().map(|p| text[p.clone()].to_owned()).collect();
    match rng.usize(..3) {
        0 => copies.reverse(),
        1 => {
            let first = copies.first().cloned().unwrap_or_default();
            copies.fill(first);
        }
        _ => copies.iter_mut().skip(1).for_each(String::clear),
    }
    for (point, copy) in points.iter().zip(copies).rev() {
        text.replace_range(point.clone(), &copy);
    }
}

fn time_step_size(rng: &mut Rng, text: &mut String) {
    const SIZES: [&str; 12] = [
        "1e-6", "1e-4", "0.001", "0.0009", "10", "10.1", "1e9", "0", "-0.1", "NaN", "1e-320", "1",
    ];
    if let Some(at) = text.find("timeStepSize=\"0.1\"") {
        let size = SIZES[rng.usize(..SIZES.len())];
        text.replace_range(at..at + 18, &format!("timeStepSize=\"{size}\""));
    }
}

fn swap_bounds(_: &mut Rng, text: &mut String) {
    *text = text
        .replace("leftBound", "middle")
        .replace("rightBound", "leftBound")
        .replace("middle", "rightBound");
}

fn nest(rng: &mut Rng, text: &mut String) {
    let Some(place) = pick(rng, &Markup::of(text).elements) else {
        return;
    };
    let tag = &text[place.start + 1..];
    let name: String = tag
        .chars()
        .take_while(char::is_ascii_alphanumeric)
        .collect();
    let times = [3, 300, 30_000][rng.usize(..3)];
    text.insert_str(place.end, &format!("</{name}>").repeat(times));
    text.insert_str(place.start, &format!("<{name}>").repeat(times));
}

fn entity(rng: &mut Rng, text: &mut String) {
    const ENTITIES: [&str; 8] = [
        "&boom;",
        "&#0;",
        "&#xD800;",
        "&#x1F600;",
        "&",
        "<![CDATA[1]]>",
        "<!-- -- -->",
        "\u{0}",
    ];
    if rng.bool() {
        let mut bomb = String::from("<!DOCTYPE x [<!ENTITY a0 \"1\">");
        for i in 1..30 {
            let _ = write!(bomb, "<!ENTITY a{i} \"&a{0};&a{0};\">", i - 1);
        }
        let at = text.find("?>").map_or(0, |i| i + 2);
        text.insert_str(at, &(bomb + "]>"));
        *text = text.replacen("<y>0", "<y>&a29;", 1);
        return;
    }
    if let Some(place) = pick(rng, &Markup::of(text).numbers) {
        text.insert_str(place.start, ENTITIES[rng.usize(..ENTITIES.len())]);
    }
}

fn cut_text(rng: &mut Rng, text: &mut String) {
    // Rarely, as little is left to do after it.
    if rng.usize(..4) == 0 {
        let at = text.floor_char_boundary(rng.usize(..=text.len()));
        text.truncate(at);
    }
}

/// The text in another encoding, or in one that it does not say, with byte order marks at the start or anywhere.
fn encoded(rng: &mut Rng, text: &str) -> Vec<u8> {
    let little = || text.encode_utf16().flat_map(u16::to_le_bytes);
    let big = || text.encode_utf16().flat_map(u16::to_be_bytes);
    match rng.usize(..7) {
        0 => [0xff, 0xfe].into_iter().chain(little()).collect(),
        1 => [0xfe, 0xff].into_iter().chain(big()).collect(),
        2 => little().collect(),
        3 => {
            let latin = text.replacen("UTF-8", "ISO-8859-1", 1);
            latin
                .replacen("author=\"a\"", "author=\"\u{e9}\"", 1)
                .chars()
                .map(|c| c as u8)
                .collect()
        }
        4 => {
            let marks = "\u{feff}".repeat(rng.usize(1..4));
            (marks + text).into_bytes()
        }
        5 => {
            let mut bytes = text.as_bytes().to_vec();
            for _ in 0..rng.usize(1..4) {
                let at = rng.usize(..=bytes.len());
                bytes.splice(at..at, [0xef, 0xbb, 0xbf]);
            }
            bytes
        }
        _ => {
            let mut bytes = text.as_bytes().to_vec();
            let at = rng.usize(..=bytes.len());
            bytes.splice(at..at, [0xc3, 0x28, 0xff, 0x00]);
            bytes
        }
    }
}

fn flipped(rng: &mut Rng, mut bytes: Vec<u8>) -> Vec<u8> {
    for _ in 0..rng.usize(1..12) {
        if !bytes.is_empty() {
            let at = rng.usize(..bytes.len());
            bytes[at] ^= 1 << rng.u8(..8);
        }
    }
    bytes
}

/// Bytes left out, doubled, or moved.
fn rearranged(rng: &mut Rng, mut bytes: Vec<u8>) -> Vec<u8> {
    let begin = rng.usize(..=bytes.len());
    let end = (begin + rng.usize(..400)).min(bytes.len());
    let piece = bytes[begin..end].to_vec();
    match rng.usize(..3) {
        0 => drop(bytes.drain(begin..end)),
        1 => drop(bytes.splice(begin..begin, piece)),
        _ => {
            bytes.drain(begin..end);
            let to = rng.usize(..=bytes.len());
            bytes.splice(to..to, piece);
        }
    }
    bytes
}
