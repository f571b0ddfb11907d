//! Tables as LaTeX: with the rules of booktabs, to include in a paper.

use crate::captioned::{CaptionedTable, one_line};

impl CaptionedTable {
    /// The table as a float over the whole page, with its notes beneath; it needs booktabs and graphicx.
    #[must_use]
    pub fn latex(&self) -> String {
        let sides = self
            .columns
            .iter()
            .map(|(_, is_number)| if *is_number { 'r' } else { 'l' });
        let line = |cells: &mut dyn Iterator<Item = &String>| {
            let cells: Vec<String> = cells.map(|cell| escaped(cell)).collect();
            format!("  {} \\\\\n", cells.join(" & "))
        };
        let mut text = format!(
            "\n\\begin{{table*}}[t]\n\\centering\n\\caption{{{}}}\n\\label{{tab:{}}}\n{FITTED}{{%\n\
             \\begin{{tabular}}{{@{{}}{}@{{}}}}\n  \\toprule\n",
            escaped(&self.caption),
            self.name,
            sides.collect::<String>()
        );
        text += &line(&mut self.columns.iter().map(|(title, _)| title));
        text += "  \\midrule\n";
        for row in &self.rows {
            text += &line(&mut row.iter());
        }
        text += "  \\bottomrule\n\\end{tabular}}\n";
        text += &notes(&self.notes);
        text + "\\end{table*}\n"
    }
}

/// Words as comments.
#[must_use]
pub fn comment(words: &str) -> String {
    let words = one_line(words);
    let lines = textwrap::wrap(&words, 110).into_iter();
    lines.map(|line| format!("% {line}\n")).collect()
}

/// Tables that are wider than the page are made smaller, others stay as they are.
const FITTED: &str = "\\resizebox{\\ifdim\\width>\\textwidth\\textwidth\\else\\width\\fi}{!}";

/// Notes beneath a table, one paragraph each.
fn notes(notes: &[String]) -> String {
    if notes.is_empty() {
        return String::new();
    }
    let mut text =
        String::from("\\par\\medskip\n\\begin{minipage}{\\textwidth}\\footnotesize\\raggedright\n");
    for (i, note) in notes.iter().enumerate() {
        let begin = if i == 0 { "\\emph{Notes.} " } else { "\\par " };
        text += &format!("{begin}{}\n", escaped(note));
    }
    text + "\\end{minipage}\n"
}

/// Text that means nothing to LaTeX; signs that its usual fonts lack are written as mathematics, or by their number.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    let text = one_line(text);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            // A sign, not a hyphen.
            '-' if rest.peek().is_some_and(char::is_ascii_digit)
                && (escaped.is_empty() || escaped.ends_with([' ', '['])) =>
            {
                escaped += "$-$";
            }
            // After the end of a row they would be an argument of it.
            '[' | '*' if escaped.is_empty() => escaped += &format!("{{{c}}}"),
            // Two of them would be a dash, as in `--truth`.
            '-' if escaped.ends_with('-') => escaped += "{}-",
            '\\' => escaped += "\\textbackslash{}",
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => {
                escaped.push('\\');
                escaped.push(c);
            }
            '~' => escaped += "\\textasciitilde{}",
            '^' => escaped += "\\textasciicircum{}",
            '`' => escaped += "\\textasciigrave{}",
            '<' => escaped += "$<$",
            '>' => escaped += "$>$",
            '|' => escaped += "$|$",
            '"' => escaped += "''",
            '–' => escaped += "--",
            '·' => escaped += "$\\cdot$",
            'κ' => escaped += "$\\kappa$",
            'χ' => escaped += "$\\chi$",
            '²' => escaped += "$^2$",
            '≤' => escaped += "$\\leq$",
            '≥' => escaped += "$\\geq$",
            '−' => escaped += "$-$",
            '×' => escaped += "$\\times$",
            '√' => escaped += "$\\surd$",
            '…' => escaped += "\\ldots{}",
            // Those of Latin-1 that are letters can be typeset, and stop no compilation.
            _ if c.is_ascii() || matches!(c, 'À'..='ÿ') => escaped.push(c),
            _ => escaped += &format!("{{\\ttfamily U+{:04X}}}", u32::from(c)),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::escaped;

    #[test]
    fn nothing_is_obeyed() {
        assert_eq!(
            escaped("a_b & 5% of $x^2$ {\\input{/etc}} ~#"),
            "a\\_b \\& 5\\% of \\$x\\textasciicircum{}2\\$ \\{\\textbackslash{}input\\{/etc\\}\\} \\textasciitilde{}\\#"
        );
        assert_eq!(escaped("[5cm] *"), "{[}5cm] *");
        assert_eq!(
            escaped("`--truth` é 中 ␛"),
            "\\textasciigrave{}-{}-truth\\textasciigrave{} é {\\ttfamily U+4E2D} {\\ttfamily U+241B}"
        );
        assert_eq!(
            escaped("-0.12 [-0.20, −0.03] b-1"),
            "$-$0.12 [$-$0.20, $-$0.03] b-1"
        );
        assert_eq!(escaped("κ ≤ 1 – χ²"), "$\\kappa$ $\\leq$ 1 -- $\\chi$$^2$");
    }
}
