//! HTML: one file that needs no network, prints well, and answers where scripts run.

use super::{Block, Document, PageDesigns, Shown, Span, Table, Text};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use powergs_chart::{Chart, DrawError, Sheet, Style, dark_declarations};
use powergs_pixels::RgbImage;
use sha2::{Digest, Sha256};

const STYLE: &str = include_str!("html.css");
const SCRIPT: &str = include_str!("page.js");

impl Document {
    /// The page, with the charts inside; its title names the window.
    ///
    /// # Errors
    /// [`DrawError`], which would be a mistake of ours.
    pub fn html(&self) -> Result<String, DrawError> {
        let titles = self.blocks.iter().find_map(|(_, block)| match block {
            Block::Title(text) => Some(text.plain()),
            _ => None,
        });
        let title = escaped(&titles.unwrap_or_else(|| "powergs-sim".into()));
        let made_by = escaped(&powergs_base::build::line());
        let (policy, dark) = (policy(), dark_declarations());
        // A page that is printed is light.
        let dark =
            format!("@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}");
        let mut page = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta \
             http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n<meta \
             name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta \
             name=\"generator\" content=\"{made_by}\">\n<link rel=\"icon\" \
             href=\"data:,\">\n<title>{title}</title>\n<style>\n{STYLE}{dark}\n</style>\n</head>\n\
             <body>\n<main>\n"
        );
        page += &self.body(|shown| shown.on_screen())?;
        Ok(page + "</main>\n<script>" + &script() + "</script>\n</body>\n</html>\n")
    }

    /// What stands in the page, without head and style, and without what names files of a folder:
    /// for a page of the caller, such as a notebook.
    ///
    /// # Errors
    /// As [`Document::html`].
    pub fn fragment(&self) -> Result<String, DrawError> {
        self.body(|shown| shown.on_screen() && shown != Shown::Folder)
    }

    fn body(&self, keep: impl Fn(Shown) -> bool) -> Result<String, DrawError> {
        let shown = self.blocks.iter().filter(|(shown, _)| keep(*shown));
        // Regions that can be scrolled have different names.
        let (mut section, mut tables) = (String::new(), 0);
        let mut block = |(_, block): &(_, Block)| {
            match block {
                Block::Title(text) | Block::Heading(text) => (section, tables) = (text.plain(), 0),
                Block::Table(_) => tables += 1,
                _ => {}
            }
            let label = match tables {
                1 => section.clone(),
                n => format!("{section}, table {n}"),
            };
            html(block, &label)
        };
        shown.map(&mut block).collect()
    }
}

/// The text of the script, as it stands in its element.
fn script() -> String {
    format!("\n{SCRIPT}")
}

/// What a browser lets the page do: run its own script and show what is in it, and nothing else. It
/// opens no address, so the page needs no network whatever is written in it.
fn policy() -> String {
    let hash = STANDARD.encode(Sha256::digest(script().as_bytes()));
    format!(
        "default-src 'none'; script-src 'sha256-{hash}'; style-src 'unsafe-inline'; img-src data:; \
         base-uri 'none'; form-action 'none'"
    )
}

fn html(block: &Block, label: &str) -> Result<String, DrawError> {
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
        Block::Table(table) => table.html(label),
        Block::Chart(chart) => figure(chart)?,
        Block::Designs(designs) => explorer(designs),
        Block::BeforeAfter(pictures) => {
            let [before, after] = pictures.as_ref();
            let picture = |image: &RgbImage, what: &str| {
                let png = image.png().unwrap_or_default();
                let (w, h) = (image.width(), image.height());
                let data = STANDARD.encode(png);
                format!(
                    "<img alt=\"{what}\" width=\"{w}\" height=\"{h}\" class=\"{what}\" \
                     src=\"data:image/png;base64,{data}\">"
                )
            };
            let both = picture(before, "before") + &picture(after, "after");
            format!("<div class=\"before-after\">{both}</div>\n")
        }
    })
}

/// A chart, and the same for narrow screens.
fn figure(chart: &Chart) -> Result<String, DrawError> {
    let title = escaped(&chart.title);
    let wide = chart.page_svg(Style::default())?;
    let narrow = chart.page_svg(Style { sheet: Sheet::Column, ..Style::default() })?;
    Ok(format!(
        "<figure role=\"img\" aria-label=\"{title}\">\n<div class=\"wide\">{wide}</div><div \
         class=\"narrow\">{narrow}</div>\n</figure>\n"
    ))
}

/// Designs as data, and the place where a script shows them.
fn explorer(designs: &PageDesigns) -> String {
    format!(
        "<noscript><p>A filter, a scatter of any two columns and the settings of each design \
         need scripts; charts and tables do not.</p></noscript>\n<section class=\"explorer\" \
         aria-label=\"designs\" hidden></section>\n<script type=\"application/json\" \
         id=\"designs\">{}</script>\n",
        designs.json()
    )
}

impl Table {
    /// The table, in HTML, under a name that no other one of the page has.
    fn html(&self, label: &str) -> String {
        let label = escaped(label);
        let cells = |tag: &str, of: &dyn Fn(usize) -> Text| {
            let shown = self.columns.iter().enumerate().filter(|(_, c)| c.shown.on_page());
            let cell = |(i, column): (usize, &super::Column)| {
                let class = if column.is_number() { "" } else { " class=\"text\"" };
                let (words, is_head) = (words(&of(i)), tag == "th");
                // A head without words is none.
                let tag = if is_head && words.is_empty() { "td" } else { tag };
                let scope = if tag == "th" { " scope=\"col\"" } else { "" };
                format!("<{tag}{class}{scope}>{words}</{tag}>")
            };
            shown.map(cell).collect::<String>()
        };
        let head = cells("th", &|i| self.columns[i].page_head().into());
        let row = |row: &Vec<super::Cell>| {
            format!("<tr>{}</tr>\n", cells("td", &|i| self.columns[i].words(&row[i])))
        };
        let rows: String = self.rows.iter().map(row).collect();
        format!(
            "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{label}\"><table>\n\
             <thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n"
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
        Span::Link(words, address) => {
            format!("<a href=\"{}\">{}</a>", escaped(address), escaped(words))
        }
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
