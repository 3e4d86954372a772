//! Tables for papers: `booktabs` of LaTeX.

use super::{Cell, Table, Text};

impl Table {
    /// The table as `tabular` with the rules of the package `booktabs`.
    pub fn latex(&self) -> String {
        let shown: Vec<usize> =
            (0..self.columns.len()).filter(|&i| self.columns[i].shown.on_page()).collect();
        let line = |cells: Vec<String>| format!("{} \\\\\n", cells.join(" & "));
        let columns: String =
            shown.iter().map(|&i| if self.columns[i].is_number() { 'r' } else { 'l' }).collect();
        let head = shown.iter().map(|&i| escaped(&self.columns[i].page_head())).collect();
        let row = |row: &Vec<Cell>| {
            line(shown.iter().map(|&i| words(&self.columns[i].words(&row[i]))).collect())
        };
        let rows: String = self.rows.iter().map(row).collect();
        format!(
            "\\begin{{tabular}}{{{columns}}}\n\\toprule\n{}\\midrule\n{rows}\\bottomrule\n\
             \\end{{tabular}}\n",
            line(head)
        )
    }
}

fn words(text: &Text) -> String {
    escaped(&text.plain())
}

/// Text with what LaTeX takes for itself written so that it prints.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', c]),
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '\\' => out.push_str("\\textbackslash{}"),
            '<' => out.push_str("\\textless{}"),
            '>' => out.push_str("\\textgreater{}"),
            '²' => out.push_str("\\textsuperscript{2}"),
            'α' => out.push_str("$\\alpha$"),
            '…' => out.push_str("\\ldots{}"),
            c if c.is_control() => out.push('?'),
            c => out.push(c),
        }
    }
    out
}
