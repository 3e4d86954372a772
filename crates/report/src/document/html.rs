//! HTML: one file that needs no network and prints well.

use super::{Block, Document, Span, Table, Text};
use powergs_chart::{DrawError, Style};

const STYLE: &str = include_str!("html.css");

impl Document {
    /// The page, with the charts inside; `title` names the window.
    ///
    /// # Errors
    /// [`DrawError`], which would be a mistake of ours.
    pub fn html(&self, title: &str) -> Result<String, DrawError> {
        let title = escaped(title);
        let mut page = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta \
             name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n"
        );
        page += &self.fragment()?;
        Ok(page + "</body>\n</html>\n")
    }

    /// What stands in the page, without head and style: for a page of somebody else.
    ///
    /// # Errors
    /// As [`Document::html`].
    pub fn fragment(&self) -> Result<String, DrawError> {
        let shown = self.blocks.iter().filter(|(shown, _)| shown.on_page());
        shown.map(|(_, block)| html(block)).collect()
    }
}

fn html(block: &Block) -> Result<String, DrawError> {
    Ok(match block {
        Block::Title(text) => element("h1", text),
        Block::Heading(text) => element("h2", text),
        Block::Paragraph(text) => element("p", text),
        Block::Quote(text) => element("blockquote", text),
        Block::List(items) => {
            format!("<ul>\n{}</ul>\n", items.iter().map(|i| element("li", i)).collect::<String>())
        }
        Block::Facts(facts) => {
            let pair = |(name, text): &(String, Text)| {
                format!("<dt>{}</dt>{}", escaped(name), element("dd", text))
            };
            format!("<dl>\n{}</dl>\n", facts.iter().map(pair).collect::<String>())
        }
        Block::Verbatim(text) => format!("<pre>{}</pre>\n", escaped(text)),
        Block::Table(table) => table.html(),
        Block::Chart(chart) => {
            let title = escaped(&chart.title);
            let svg = chart.svg(Style::default())?;
            format!("<figure role=\"img\" aria-label=\"{title}\">\n{svg}\n</figure>\n")
        }
    })
}

impl Table {
    /// The table, in HTML.
    fn html(&self) -> String {
        let cells = |tag: &str, of: &dyn Fn(usize) -> Text| {
            let shown = self.columns.iter().enumerate().filter(|(_, c)| c.shown.on_page());
            let cell = |(i, column): (usize, &super::Column)| {
                let class = if column.is_number() { "" } else { " class=\"text\"" };
                format!("<{tag}{class}>{}</{tag}>", words(&of(i)))
            };
            shown.map(cell).collect::<String>()
        };
        let head = cells("th", &|i| self.columns[i].page_head().into());
        let row = |row: &Vec<super::Cell>| {
            format!("<tr>{}</tr>\n", cells("td", &|i| self.columns[i].words(&row[i])))
        };
        let rows: String = self.rows.iter().map(row).collect();
        format!(
            "<div class=\"scroll\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\
             </tbody>\n</table></div>\n"
        )
    }
}

fn element(tag: &str, text: &Text) -> String {
    format!("<{tag}>{}</{tag}>\n", words(text))
}

fn words(text: &Text) -> String {
    let span = |span: &Span| match span {
        Span::Plain(words) => escaped(words),
        Span::Code(words) => format!("<code>{}</code>", escaped(words)),
        Span::Strong(words) => format!("<strong>{}</strong>", escaped(words)),
    };
    text.spans.iter().map(span).collect()
}

/// Text that stands for itself in HTML.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            '\'' => safe += "&#x27;",
            other => safe.push(other),
        }
    }
    safe
}
