//! A report as LaTeX: tables with the rules of booktabs, ready to be included in a paper.

use super::document::{Align, Block, Document, Table, clean};

impl Document {
    /// The tables as LaTeX, for `\input`; figures are left out, and headings and paragraphs are comments.
    #[must_use]
    pub fn latex(&self) -> String {
        let comment = |words: &str| {
            let lines = textwrap::wrap(words, 110).into_iter();
            lines.map(|line| format!("% {line}\n")).collect::<String>()
        };
        let mut text = comment(&clean(&self.title));
        text += "% \\usepackage{booktabs,graphicx}\n";
        for block in &self.blocks {
            match block {
                Block::Heading(words) => text += &format!("\n%\n{}", comment(&clean(words))),
                Block::Text(words) => text += &comment(&clean(words)),
                Block::Table(table) => text += &latex(table),
                Block::Figures(..) => {}
            }
        }
        text
    }
}

fn latex(table: &Table) -> String {
    let sides: String = table
        .columns
        .iter()
        .map(|(_, align)| match align {
            Align::Left => 'l',
            Align::Right => 'r',
        })
        .collect();
    let line = |cells: &mut dyn Iterator<Item = &String>| {
        let cells: Vec<String> = cells.map(|cell| escaped(cell)).collect();
        format!("  {} \\\\\n", cells.join(" & "))
    };
    let mut text = format!(
        "\n\\begin{{table*}}[t]\n\\centering\n\\caption{{{}}}\n\\label{{tab:{}}}\n\\resizebox{{\\textwidth}}{{!}}{{%\n\
         \\begin{{tabular}}{{@{{}}{sides}@{{}}}}\n  \\toprule\n",
        escaped(&table.caption),
        table.name
    );
    text += &line(&mut table.columns.iter().map(|(title, _)| title));
    text += "  \\midrule\n";
    for row in &table.rows {
        text += &line(&mut row.iter());
    }
    text += "  \\bottomrule\n\\end{tabular}}\n\\end{table*}\n";
    text
}

/// Text that means nothing to LaTeX; signs that its usual fonts lack are written as mathematics.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in clean(text).chars() {
        match c {
            // After the end of a row they would be an argument of it.
            '[' | '*' if escaped.is_empty() => escaped += &format!("{{{c}}}"),
            '\\' => escaped += "\\textbackslash{}",
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => {
                escaped.push('\\');
                escaped.push(c);
            }
            '~' => escaped += "\\textasciitilde{}",
            '^' => escaped += "\\textasciicircum{}",
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
            _ => escaped.push(c),
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
        assert_eq!(escaped("κ ≤ 1 – χ²"), "$\\kappa$ $\\leq$ 1 -- $\\chi$$^2$");
    }
}
