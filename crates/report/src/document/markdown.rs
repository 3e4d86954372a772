//! Markdown, as GitHub and Pandoc read it.

use powergs_chart::Format;

use super::{Block, Document, Span, Table, Text};

impl Document {
    /// The page, with links to the charts as files of a kind in the same folder.
    pub fn markdown(&self, charts: Format) -> String {
        let shown = self.blocks.iter().filter(|(shown, _)| shown.on_page());
        let blocks: Vec<String> = shown.map(|(_, block)| markdown(block, charts)).collect();
        blocks.join("\n")
    }
}

fn markdown(block: &Block, charts: Format) -> String {
    match block {
        Block::Title(text) => format!("# {}\n", words(text)),
        Block::Heading(text) => format!("## {}\n", words(text)),
        Block::Paragraph(text) => format!("{}\n", words(text)),
        Block::Quote(text) => format!("> {}\n", words(text)),
        Block::List(items) => items.iter().map(|item| format!("- {}\n", words(item))).collect(),
        Block::Facts(facts) => {
            let row =
                |(name, text): &(String, Text)| format!("| {} | {} |\n", escaped(name), cell(text));
            format!("| | |\n|---|---|\n{}", facts.iter().map(row).collect::<String>())
        }
        Block::Verbatim(text) => {
            let fence = fence(text);
            format!("{fence}\n{}\n{fence}\n", text.trim_end())
        }
        Block::Table(table) => table.markdown(),
        Block::Chart(chart) => {
            format!("![{}]({}.{})\n", escaped(&chart.title), chart.name, charts.ending())
        }
        Block::Designs(_) | Block::BeforeAfter(_) => String::new(),
    }
}

/// What stands around a text that is shown as it is: more back quotes than it has anywhere.
fn fence(text: &str) -> String {
    let longest = text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    "`".repeat(longest.max(2) + 1)
}

impl Table {
    /// The table, in Markdown.
    pub fn markdown(&self) -> String {
        let shown: Vec<usize> =
            (0..self.columns.len()).filter(|&i| self.columns[i].shown.on_page()).collect();
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let head = shown.iter().map(|&i| escaped(&self.columns[i].page_head())).collect();
        let rules: String = shown
            .iter()
            .map(|&i| if self.columns[i].is_number() { "--:|" } else { "---|" })
            .collect();
        let row = |row: &Vec<super::Cell>| {
            line(shown.iter().map(|&i| cell(&self.columns[i].words(&row[i]))).collect())
        };
        let rows: String = self.rows.iter().map(row).collect();
        format!("{}|{rules}\n{rows}", line(head))
    }
}

fn words(text: &Text) -> String {
    let span = |span: &Span| match span {
        Span::Plain(words) => escaped(words),
        Span::Code(words) => format!("`{}`", clean(&words.replace('`', "'"))),
        Span::Strong(words) => format!("**{}**", escaped(words)),
        Span::Link(words, address) => format!("[{}](<{}>)", escaped(words), clean(address)),
    };
    text.spans.iter().map(span).collect()
}

/// Text in a cell: bars would end it, also in code.
fn cell(text: &Text) -> String {
    let span = |span: &Span| match span {
        Span::Code(words) => Span::Code(words.replace('|', "/")),
        other => other.clone(),
    };
    words(&Text { spans: text.spans.iter().map(span).collect() })
}

fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}

/// Names from files must not end a table cell or start markup. What Markdown takes for itself in
/// its place stays readable: `vru_busy`, `<1`, `at #12`.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    let mut before = None;
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        let next = rest.peek().copied();
        let is_word = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
        let is_markup = match c {
            '|' | '*' | '`' | '[' | ']' | '\\' => true,
            '_' => !(is_word(before) && is_word(next)),
            '<' => next.is_some_and(|c| c.is_alphabetic() || "/!?".contains(c)),
            '#' | '>' => before.is_none(),
            _ => false,
        };
        if is_markup {
            out.push('\\');
        }
        out.push(if c.is_control() { '?' } else { c });
        before = Some(c);
    }
    out
}
