//! Reads descriptions back: what is said of whom at which time, in both forms under the titles of the table.

use std::collections::BTreeMap;

/// What is said of one participant at one time.
#[derive(Debug, Default)]
pub struct Row {
    /// Seconds, relative to the end of the window.
    pub t: f64,
    /// The obstacle; `None` for the ego.
    pub id: Option<i64>,
    /// Values by title of their column; none for what has no value.
    pub values: BTreeMap<String, String>,
    /// The sentence of the prose.
    pub sentence: Option<String>,
}

impl Row {
    /// The text of a value.
    pub fn text(&self, title: &str) -> Option<&str> {
        self.values.get(title).map(String::as_str)
    }

    /// A number.
    pub fn number(&self, title: &str) -> Option<f64> {
        self.text(title).map(|text| text.parse().unwrap())
    }
}

/// The worst values of one obstacle: title, value and time of each.
pub type Worst = (i64, Vec<(String, Option<(String, f64)>)>);

/// A description that was read.
#[derive(Debug, Default)]
pub struct Parsed {
    pub rows: Vec<Row>,
    /// The times at which it is said that nobody is near.
    pub nobody: Vec<f64>,
    pub worst: Vec<Worst>,
}

const WORST: [(&str, &str); 4] = [
    ("min distance [m]", "smallest distance "),
    ("min ttc [s]", "smallest time to collision "),
    ("max drac [m/s²]", "largest deceleration needed "),
    ("min risk", "lowest risk score "),
];

/// Columns whose value follows words of the prose, up to the next blank or mark.
const PHRASES: [(&str, &str); 14] = [
    ("distance [m]", "distance "),
    ("gap long [m]", "gap longitudinal "),
    ("v rel long [m/s]", "relative velocity longitudinal "),
    ("a rel long [m/s²]", "relative acceleration longitudinal "),
    ("ttc long [s]", "time to close the gap longitudinal "),
    ("ttc [s]", "time to collision "),
    ("time gap [s]", "time gap "),
    ("drac [m/s²]", "deceleration needed "),
    ("risk", "risk score "),
    ("v [m/s]", " velocity "),
    ("a [m/s²]", " acceleration "),
    ("heading [rad]", "heading "),
    ("x [m]", "at ("),
    ("heading [°]", "heading "),
];

/// Columns whose value follows "lateral " behind these words.
const LATERAL: [(&str, &str); 4] = [
    ("gap lat [m]", "gap longitudinal "),
    ("v rel lat [m/s]", "relative velocity longitudinal "),
    ("a rel lat [m/s²]", "relative acceleration longitudinal "),
    ("ttc lat [s]", "time to close the gap longitudinal "),
];

/// The id in a name such as `car 301`; `None` for the ego.
fn id(name: &str) -> Option<i64> {
    name.rsplit(' ').next().unwrap().parse().ok()
}

fn word(text: &str) -> String {
    let end = text.find([' ', ',', ';', '°', ')']).unwrap_or(text.len());
    text[..end].trim_end_matches('.').to_string()
}

pub fn compact(text: &str) -> Parsed {
    let mut parsed = Parsed::default();
    let mut lines = text
        .lines()
        .skip_while(|line| !line.starts_with("t [s],who"));
    let titles: Vec<&str> = lines.next().unwrap().split(',').collect();
    for line in lines.by_ref().take_while(|line| !line.is_empty()) {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), titles.len(), "{line}");
        let values = titles.iter().zip(&cells).skip(2);
        let known = values.filter(|(_, cell)| **cell != "-");
        parsed.rows.push(Row {
            t: cells[0].parse().unwrap(),
            id: id(cells[1]),
            values: known.map(|(t, c)| (t.to_string(), c.to_string())).collect(),
            sentence: None,
        });
    }
    for line in lines.skip(2) {
        let cells: Vec<&str> = line.split(',').collect();
        let of = WORST.iter().enumerate().map(|(place, (title, _))| {
            let [value, time] = [cells[1 + 2 * place], cells[2 + 2 * place]];
            let told = (value != "-").then(|| (value.to_string(), time.parse().unwrap()));
            (title.to_string(), told)
        });
        parsed.worst.push((id(cells[0]).unwrap(), of.collect()));
    }
    parsed
}

pub fn prose(text: &str) -> Parsed {
    let mut parsed = Parsed::default();
    let mut t = f64::NAN;
    let mut worst = false;
    let lines = text.lines().skip(2).filter(|line| !line.is_empty());
    for line in lines.filter(|line| !line.starts_with("Not described: ")) {
        if let Some(time) = line.strip_prefix("t = ") {
            t = time.strip_suffix(" s:").unwrap().parse().unwrap();
        } else if line.starts_with("Worst values") {
            worst = true;
        } else if worst {
            parsed.worst.push(worst_of(line));
        } else if line.starts_with("  No obstacle") {
            parsed.nobody.push(t);
        } else {
            parsed.rows.push(Row { t, ..row(line) });
        }
    }
    parsed
}

fn worst_of(line: &str) -> Worst {
    let (name, values) = line.trim().split_once(": ").unwrap();
    let of = WORST.iter().map(|(title, words)| {
        let from = values.find(words).unwrap() + words.len();
        let told = word(&values[from..]);
        let time = || {
            let at = values[from..].find("t = ").unwrap() + from + 4;
            word(&values[at..]).parse().unwrap()
        };
        (title.to_string(), (told != "none").then(|| (told, time())))
    });
    (id(name).unwrap(), of.collect())
}

fn row(line: &str) -> Row {
    let mut row = Row::default();
    let (head, body) = line.trim().split_once(": ").unwrap();
    let mut body = format!(" {body}");
    let name = head.split(" (").next().unwrap();
    row.id = (!name.eq_ignore_ascii_case("the ego"))
        .then(|| id(name))
        .flatten();
    if let Some((_, places)) = head.split_once(" (") {
        let mut places = places.trim_end_matches(')').splitn(2, ", ");
        row.values
            .insert("direction".into(), places.next().unwrap().into());
        if let Some(lane) = places.next() {
            row.values.insert("lane".into(), lane.into());
        }
        // The sentence follows the last value.
        if let Some((values, sentence)) = body.split_once(". ") {
            row.sentence = Some(sentence.to_string());
            body = values.to_string();
        }
    } else if let Some((_, lane)) = body.rsplit_once("m/s², ") {
        row.values
            .insert("lane".into(), lane.trim_end_matches('.').into());
    }
    let map = body.contains(" rad");
    for (title, words) in PHRASES {
        let degrees = title == "heading [°]";
        let Some(at) = body.find(words) else { continue };
        // The Cartesian frame has radians, the ego's degrees.
        if title.starts_with("heading") && degrees == map {
            continue;
        }
        // Not those of the ego's own motion.
        if words.starts_with(' ') && body.contains("relative velocity") {
            continue;
        }
        let mut told = word(&body[at + words.len()..]);
        if degrees && body.contains("° to the right") {
            told = format!("-{told}");
        }
        if told != "none" {
            row.values.insert(title.into(), told);
        }
    }
    for (title, words) in LATERAL {
        let Some(at) = body.find(words) else { continue };
        let from = at + body[at..].find("lateral ").unwrap() + "lateral ".len();
        let told = word(&body[from..]);
        if told != "none" {
            row.values.insert(title.into(), told);
        }
    }
    if let Some(at) = body.find("at (") {
        let y = body[at..].split(", ").nth(1).unwrap();
        row.values.insert("y [m]".into(), word(y));
    }
    row
}
