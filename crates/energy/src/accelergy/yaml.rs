//! YAML as a tree that knows its lines. Depth and aliases are bounded; keys are texts.

use std::collections::HashMap;

use granit_parser::{Event, Parser, ScalarStyle};

/// Lists and mappings inside of each other, at most.
const DEPTH_MAX: usize = 64;
/// Nodes of a document, each alias counted as what it stands for.
const NODES_MAX: usize = 1 << 18;

/// A value and where it stands.
#[derive(Debug, Clone)]
pub(super) struct YamlNode {
    kind: YamlKind,
    line: usize,
    column: usize,
}

#[derive(Debug, Clone)]
enum YamlKind {
    /// A text; `plain` without quotes.
    Text {
        text: String,
        plain: bool,
    },
    List(Vec<YamlNode>),
    Map(Vec<(String, YamlNode)>),
}

/// A list or mapping that has not ended, with its anchor and the key that waits for its value.
struct Open {
    node: YamlNode,
    anchor: usize,
    key: Option<String>,
}

/// The one document of a text.
///
/// # Errors
/// What is wrong, after its line and column.
pub(super) fn parse(text: &str) -> Result<YamlNode, String> {
    let mut open: Vec<Open> = Vec::new();
    let mut anchors: HashMap<usize, (YamlNode, usize)> = HashMap::new();
    let mut root: Option<YamlNode> = None;
    let mut count = 0;
    for next in Parser::new_from_str(text) {
        let (event, span) = next.map_err(|e| {
            format!("line {} column {}: {}", e.marker().line(), e.marker().col() + 1, e.info())
        })?;
        let (line, column) = (span.start.line(), span.start.col() + 1);
        let at = |kind| YamlNode { kind, line, column };
        let wrong = |what: &str| Err(format!("line {line} column {column}: {what}"));
        let (node, anchor) = match event {
            Event::SequenceStart(_, anchor, _) => {
                open.push(Open { node: at(YamlKind::List(Vec::new())), anchor, key: None });
                if open.len() > DEPTH_MAX {
                    return wrong("too deep");
                }
                continue;
            }
            Event::MappingStart(_, anchor, _) => {
                open.push(Open { node: at(YamlKind::Map(Vec::new())), anchor, key: None });
                if open.len() > DEPTH_MAX {
                    return wrong("too deep");
                }
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => {
                let Some(Open { node, anchor, .. }) = open.pop() else { continue };
                (node, anchor)
            }
            Event::Scalar(value, style, anchor, _) => {
                let plain = matches!(style, ScalarStyle::Plain);
                (at(YamlKind::Text { text: value.into_owned(), plain }), anchor)
            }
            Event::Alias(anchor) => match anchors.get(&anchor) {
                Some((node, nodes)) => {
                    count += nodes;
                    if count > NODES_MAX {
                        return wrong("too many aliases");
                    }
                    (node.clone(), 0)
                }
                None => return wrong("an alias inside of its own anchor"),
            },
            Event::DocumentStart(..) if root.is_some() => {
                return wrong("multiple YAML documents detected");
            }
            _ => continue,
        };
        count += 1;
        if anchor != 0 {
            anchors.insert(anchor, (node.clone(), node.nodes()));
        }
        let Some(parent) = open.last_mut() else {
            root = Some(node);
            continue;
        };
        match (&mut parent.node.kind, parent.key.take()) {
            (YamlKind::List(items), _) => items.push(node),
            (YamlKind::Map(pairs), Some(key)) => pairs.push((key, node)),
            (YamlKind::Map(pairs), None) => match node.kind {
                YamlKind::Text { text, .. } if pairs.iter().any(|(key, _)| *key == text) => {
                    return wrong(&format!("duplicate mapping key: {text}"));
                }
                YamlKind::Text { text, .. } => parent.key = Some(text),
                _ => return wrong("a key that is not text"),
            },
            (YamlKind::Text { .. }, _) => {}
        }
    }
    root.ok_or_else(|| "unexpected end of input at line 1, column 1".into())
}

impl YamlNode {
    /// Itself and what is inside.
    fn nodes(&self) -> usize {
        1 + match &self.kind {
            YamlKind::Text { .. } => 0,
            YamlKind::List(items) => items.iter().map(YamlNode::nodes).sum(),
            YamlKind::Map(pairs) => pairs.iter().map(|(_, node)| node.nodes()).sum::<usize>(),
        }
    }

    fn wrong(&self, what: &str) -> String {
        format!("line {} column {}: {what}", self.line, self.column)
    }

    /// The value of a key of a mapping, or of the one that is merged into it, if it is there.
    pub(crate) fn find(&self, key: &str) -> Result<Option<&YamlNode>, String> {
        match &self.kind {
            YamlKind::Map(pairs) => {
                let of = |key: &str| pairs.iter().find(|(name, _)| name == key).map(|(_, n)| n);
                match (of(key), of("<<")) {
                    (None, Some(merged)) if key != "<<" => merged.find(key),
                    (found, _) => Ok(found),
                }
            }
            _ => Err(self.wrong("expected mapping start")),
        }
    }

    /// The value of a key of a mapping.
    pub(crate) fn get(&self, key: &str) -> Result<&YamlNode, String> {
        self.find(key)?.ok_or_else(|| self.wrong(&format!("missing field `{key}`")))
    }

    /// The values of a list.
    pub(crate) fn list(&self) -> Result<&[YamlNode], String> {
        match &self.kind {
            YamlKind::List(items) => Ok(items),
            _ => Err(self.wrong("expected sequence start")),
        }
    }

    /// Whether nothing is there, or `~` or `null`.
    pub(crate) fn is_null(&self) -> bool {
        let nulls = ["", "~", "null", "Null", "NULL"];
        matches!(&self.kind, YamlKind::Text { text, plain: true } if nulls.contains(&text.as_str()))
    }

    pub(crate) fn text(&self) -> Result<&str, String> {
        match &self.kind {
            _ if self.is_null() => Err(self.wrong("expected a text, not nothing")),
            YamlKind::Text { text, .. } => Ok(text),
            _ => Err(self.wrong("expected a text")),
        }
    }

    /// A number without quotes or with them.
    pub(crate) fn number(&self) -> Result<f64, String> {
        let YamlKind::Text { text, .. } = &self.kind else {
            return Err(self.wrong("expected a number"));
        };
        let (sign, size) = match text.strip_prefix('-') {
            Some(size) => (-1.0, size),
            None => (1.0, text.strip_prefix('+').unwrap_or(text)),
        };
        match size {
            ".inf" | ".Inf" | ".INF" => Ok(sign * f64::INFINITY),
            ".nan" | ".NaN" | ".NAN" => Ok(f64::NAN),
            _ if size.starts_with(|c: char| c.is_ascii_digit() || c == '.') => size
                .parse()
                .map(|size: f64| sign * size)
                .map_err(|_| self.wrong("invalid floating point")),
            _ => Err(self.wrong("invalid floating point")),
        }
    }

    /// A text, or a number written in the shortest way.
    pub(crate) fn label(&self) -> Result<String, String> {
        match &self.kind {
            YamlKind::Text { plain: true, .. } => {
                self.number().map(|n| n.to_string()).or_else(|_| self.text().map(str::to_owned))
            }
            _ => self.text().map(str::to_owned),
        }
    }
}
