//! Sentences with the two marks that all formats have: code and emphasis.

/// Part of a sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Span {
    /// Words as they are.
    Plain(String),
    /// A name that can be typed: a key, a file, a command.
    Code(String),
    /// What must not be missed.
    Strong(String),
    /// Words with the address of what they name.
    Link(String, String),
}

/// A sentence or a few.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Text {
    /// Its parts, in order.
    pub spans: Vec<Span>,
}

impl Text {
    /// Our own words with `` `code` `` and `**emphasis**` marked. Never for text from a file: that
    /// is plain.
    pub fn marked(text: &str) -> Text {
        let mut spans = Vec::new();
        for (i, part) in text.split('`').enumerate() {
            if i % 2 == 1 {
                spans.push(Span::Code(part.to_owned()));
                continue;
            }
            for (k, words) in part.split("**").enumerate().filter(|(_, words)| !words.is_empty()) {
                let words = words.to_owned();
                spans.push(if k % 2 == 1 { Span::Strong(words) } else { Span::Plain(words) });
            }
        }
        Text { spans }
    }

    /// A message in which names stand between backticks, as in all of ours: they become code. A
    /// backtick without a partner stays, and nothing else is a mark.
    pub fn named(message: &str) -> Text {
        let mut spans = Vec::new();
        let mut rest = message;
        while let Some((before, (name, after))) =
            rest.split_once('`').and_then(|(before, rest)| Some((before, rest.split_once('`')?)))
        {
            spans.push(Span::Plain(before.to_owned()));
            spans.push(Span::Code(name.to_owned()));
            rest = after;
        }
        spans.push(Span::Plain(rest.to_owned()));
        spans.retain(|span| !span.words().is_empty());
        Text { spans }
    }

    /// A name that can be typed.
    pub fn code(name: impl Into<String>) -> Text {
        Text { spans: vec![Span::Code(name.into())] }
    }

    /// Names that can be typed, with commas between them.
    pub fn codes<'a>(names: impl IntoIterator<Item = &'a str>) -> Text {
        let mut text = Text::default();
        for name in names {
            if !text.is_empty() {
                text = text.then(", ");
            }
            text.spans.push(Span::Code(name.to_owned()));
        }
        text
    }

    /// Words that lead to an address, where there is one.
    pub fn link(words: impl Into<String>, address: Option<String>) -> Text {
        let words = words.into();
        let span = match address {
            Some(address) => Span::Link(words, address),
            None => Span::Plain(words),
        };
        Text { spans: vec![span] }
    }

    /// What must not be missed.
    pub fn strong(words: impl Into<String>) -> Text {
        Text { spans: vec![Span::Strong(words.into())] }
    }

    /// This, then more.
    pub fn then(mut self, more: impl Into<Text>) -> Text {
        self.spans.extend(more.into().spans);
        self
    }

    /// Whether there is nothing to read.
    pub fn is_empty(&self) -> bool {
        self.spans.iter().all(|span| span.words().is_empty())
    }

    /// The words without marks.
    pub fn plain(&self) -> String {
        self.spans.iter().map(Span::words).collect()
    }
}

impl Span {
    /// The words without marks.
    pub fn words(&self) -> &str {
        match self {
            Span::Plain(words) | Span::Code(words) | Span::Strong(words) | Span::Link(words, _) => {
                words
            }
        }
    }
}

impl From<&str> for Text {
    fn from(words: &str) -> Text {
        Text { spans: vec![Span::Plain(words.to_owned())] }
    }
}

impl From<String> for Text {
    fn from(words: String) -> Text {
        Text { spans: vec![Span::Plain(words)] }
    }
}
