//! What is told to people, before it has a format: headings, sentences, tables with column kinds,
//! charts. One writer each makes it a terminal's text, Markdown, HTML, JSON or CSV, so that a page
//! is built once.

mod designs;
mod html;
mod json;
mod latex;
mod markdown;
mod table;
mod terminal;
mod text;

pub use designs::{DesignColumn, DesignOffer, DesignReplay, DesignValue, PageDesigns};
pub use table::{Cell, Column, Kind, Table};
pub use text::{Span, Text};

use powergs_chart::Chart;
use powergs_pixels::RgbImage;

/// Which writers show a block or a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shown {
    /// All.
    #[default]
    Everywhere,
    /// The terminal, which has room for little.
    Terminal,
    /// Markdown and HTML.
    Page,
    /// HTML, which can answer.
    Screen,
    /// Markdown and HTML of a folder, whose files it names.
    Folder,
}

impl Shown {
    fn on_terminal(self) -> bool {
        matches!(self, Shown::Everywhere | Shown::Terminal)
    }

    fn on_page(self) -> bool {
        matches!(self, Shown::Everywhere | Shown::Page | Shown::Folder)
    }

    fn on_screen(self) -> bool {
        self.on_page() || self == Shown::Screen
    }
}

/// A part of a document.
#[derive(Debug, Clone)]
pub enum Block {
    /// What the document is about.
    Title(Text),
    /// Begins a section.
    Heading(Text),
    /// Sentences.
    Paragraph(Text),
    /// What somebody else said, such as the question that a sweep answers.
    Quote(Text),
    /// Points, one line each.
    List(Vec<Text>),
    /// Names and what they are, without a head.
    Facts(Vec<(String, Text)>),
    /// Lines that keep their breaks and blanks.
    Verbatim(String),
    /// A table.
    Table(Table),
    /// A chart; terminals leave it out.
    Chart(Chart),
    /// Designs to look at one by one; on screens alone.
    Designs(PageDesigns),
    /// Two pictures of the same, before and after; on screens alone.
    BeforeAfter(Box<[RgbImage; 2]>),
}

/// Blocks in reading order.
#[derive(Debug, Clone, Default)]
pub struct Document {
    blocks: Vec<(Shown, Block)>,
}

impl Document {
    /// An empty document.
    pub fn new() -> Document {
        Document::default()
    }

    /// Adds a block for all writers.
    pub fn add(&mut self, block: Block) {
        self.on(Shown::Everywhere, block);
    }

    /// Adds a block for some writers. Lists, facts and tables without a row are left out.
    pub fn on(&mut self, shown: Shown, block: Block) {
        let is_empty = match &block {
            Block::List(items) => items.is_empty(),
            Block::Facts(facts) => facts.is_empty(),
            Block::Table(table) => table.rows.is_empty(),
            Block::Paragraph(text) => text.is_empty(),
            _ => false,
        };
        if !is_empty {
            self.blocks.push((shown, block));
        }
    }

    /// Adds the title.
    pub fn title(&mut self, text: impl Into<Text>) {
        self.add(Block::Title(text.into()));
    }

    /// Begins a section.
    pub fn heading(&mut self, text: impl Into<Text>) {
        self.add(Block::Heading(text.into()));
    }

    /// Adds sentences.
    pub fn paragraph(&mut self, text: impl Into<Text>) {
        self.add(Block::Paragraph(text.into()));
    }

    /// Adds names and what they are.
    pub fn facts<N: Into<String>, V: Into<Text>>(
        &mut self,
        facts: impl IntoIterator<Item = (N, V)>,
    ) {
        let facts = facts.into_iter().map(|(name, value)| (name.into(), value.into()));
        self.add(Block::Facts(facts.collect()));
    }

    /// Adds a table.
    pub fn table(&mut self, table: Table) {
        self.add(Block::Table(table));
    }

    /// Begins a section of a page that terminals do not name.
    pub fn page_heading(&mut self, text: impl Into<Text>) {
        self.on(Shown::Page, Block::Heading(text.into()));
    }

    /// Adds sentences that only pages have.
    pub fn page_paragraph(&mut self, text: impl Into<Text>) {
        self.on(Shown::Page, Block::Paragraph(text.into()));
    }

    /// Adds the charts.
    pub fn charts(&mut self, charts: &[Chart]) {
        for chart in charts {
            self.add(Block::Chart(chart.clone()));
        }
    }

    /// Adds everything of another document.
    pub fn extend(&mut self, other: Document) {
        self.blocks.extend(other.blocks);
    }

    /// The tables, in order.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.blocks.iter().filter_map(|(_, block)| match block {
            Block::Table(table) => Some(table),
            _ => None,
        })
    }
}
