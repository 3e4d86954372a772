//! The syntax of Liberty: groups with arguments, attributes and groups inside.

use super::LibertyError;

/// Groups inside groups: real libraries have six levels.
const MAX_LEVELS: usize = 32;

/// `name (arguments) { ... }`.
#[derive(Debug, Default)]
pub struct Group<'a> {
    /// Its kind: `cell`, `pin`, `timing`.
    pub name: &'a str,
    /// What stands in brackets.
    pub arguments: Vec<&'a str>,
    /// `name : value;` and `name (values);`, in order.
    pub attributes: Vec<Attribute<'a>>,
    /// Groups inside, in order.
    pub groups: Vec<Group<'a>>,
    /// Line of its name, from 1.
    pub line: usize,
}

/// `name : value;` or `name (values);`.
#[derive(Debug)]
pub struct Attribute<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its values, without quotation marks.
    pub values: Vec<&'a str>,
    /// Line of its name, from 1.
    pub line: usize,
}

impl<'a> Group<'a> {
    /// The attribute `name`; the first, if there are several.
    pub fn attribute(&self, name: &str) -> Option<&Attribute<'a>> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// The first value of attribute `name`.
    pub fn value(&self, name: &str) -> Option<&'a str> {
        self.attribute(name)?.values.first().copied()
    }

    /// Groups of kind `name`.
    pub fn of(&self, name: &'a str) -> impl Iterator<Item = &Group<'a>> {
        self.groups.iter().filter(move |group| group.name == name)
    }
}

/// Reads the `library` group that `text` is.
///
/// # Errors
/// Names the line where the text stops being Liberty: brackets that are not closed (a truncated
/// file), groups nested too deep, characters out of place.
pub fn parse<'a>(file: &str, text: &'a str) -> Result<Group<'a>, LibertyError> {
    let mut parser = Parser { file, text: text.as_bytes(), source: text, at: 0, line: 1 };
    let Some(token) = parser.next()? else {
        return Err(parser.refuse("empty: no Liberty file".to_owned()));
    };
    let Token::Word("library") = token else {
        return Err(parser.refuse("does not begin with `library`: no Liberty file".to_owned()));
    };
    let line = parser.line;
    parser.expect_mark(b'(')?;
    let arguments = parser.list()?;
    parser.expect_mark(b'{')?;
    parser.body("library", arguments, line, 1)
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Token<'a> {
    Word(&'a str),
    Quoted(&'a str),
    Mark(u8),
}

struct Parser<'a, 'f> {
    file: &'f str,
    text: &'a [u8],
    source: &'a str,
    at: usize,
    line: usize,
}

impl<'a> Parser<'a, '_> {
    fn refuse(&self, reason: String) -> LibertyError {
        LibertyError { file: self.file.to_owned(), line: self.line, reason }
    }

    fn truncated(&self) -> LibertyError {
        self.refuse("the text ends inside a group: the file is truncated; fetch it again".into())
    }

    /// Skips white space, comments and continued lines.
    fn skip(&mut self) -> Result<(), LibertyError> {
        while let Some(&byte) = self.text.get(self.at) {
            match byte {
                b'\n' => self.line += 1,
                b' ' | b'\t' | b'\r' | b'\\' => {}
                b'/' if self.text.get(self.at + 1) == Some(&b'*') => {
                    let Some(length) = self.source[self.at + 2..].find("*/") else {
                        return Err(self.refuse("a comment is not closed".to_owned()));
                    };
                    let comment = &self.text[self.at..self.at + 2 + length];
                    self.line += comment.iter().filter(|&&byte| byte == b'\n').count();
                    self.at += length + 3;
                }
                b'/' if self.text.get(self.at + 1) == Some(&b'/') => {
                    while self.text.get(self.at + 1).is_some_and(|&byte| byte != b'\n') {
                        self.at += 1;
                    }
                }
                _ => return Ok(()),
            }
            self.at += 1;
        }
        Ok(())
    }

    fn next(&mut self) -> Result<Option<Token<'a>>, LibertyError> {
        self.skip()?;
        let Some(&byte) = self.text.get(self.at) else { return Ok(None) };
        let start = self.at;
        if b"(){}:;,".contains(&byte) {
            self.at += 1;
            return Ok(Some(Token::Mark(byte)));
        }
        if byte == b'"' {
            let Some(length) = self.source[start + 1..].find('"') else {
                return Err(self.refuse("a quotation mark is not closed".to_owned()));
            };
            self.at = start + length + 2;
            let text = &self.source[start + 1..start + 1 + length];
            self.line += text.bytes().filter(|&byte| byte == b'\n').count();
            return Ok(Some(Token::Quoted(text)));
        }
        while self.text.get(self.at).is_some_and(|byte| !b" \t\r\n\\(){}:;,\"".contains(byte)) {
            self.at += 1;
        }
        Ok(Some(Token::Word(&self.source[start..self.at])))
    }

    fn expect_mark(&mut self, mark: u8) -> Result<(), LibertyError> {
        match self.next()? {
            Some(Token::Mark(found)) if found == mark => Ok(()),
            Some(_) => Err(self.refuse(format!("`{}` is expected here", char::from(mark)))),
            None => Err(self.truncated()),
        }
    }

    /// Values up to the closing bracket.
    fn list(&mut self) -> Result<Vec<&'a str>, LibertyError> {
        let mut values = Vec::new();
        loop {
            match self.next()? {
                Some(Token::Word(value) | Token::Quoted(value)) => values.push(value),
                Some(Token::Mark(b',' | b':')) => {}
                Some(Token::Mark(b')')) => return Ok(values),
                Some(Token::Mark(mark)) => {
                    let reason = format!("`{}` inside brackets", char::from(mark));
                    return Err(self.refuse(reason));
                }
                None => return Err(self.truncated()),
            }
        }
    }

    /// The value behind a colon: up to a semicolon, or to the end of the line without one.
    fn value(&mut self) -> Result<Vec<&'a str>, LibertyError> {
        let mut values = Vec::new();
        loop {
            let (at, line) = (self.at, self.line);
            self.skip()?;
            let ended = self.line != line && !values.is_empty();
            if ended || self.text.get(self.at) == Some(&b'}') {
                (self.at, self.line) = (at, line);
                return Ok(values);
            }
            match self.next()? {
                Some(Token::Mark(b';')) => return Ok(values),
                Some(Token::Word(value) | Token::Quoted(value)) => values.push(value),
                Some(Token::Mark(_)) => {}
                None => return Err(self.truncated()),
            }
        }
    }

    /// What is in a group, up to its closing bracket.
    fn body(
        &mut self,
        name: &'a str,
        arguments: Vec<&'a str>,
        line: usize,
        level: usize,
    ) -> Result<Group<'a>, LibertyError> {
        if level > MAX_LEVELS {
            return Err(self.refuse(format!("groups nested deeper than {MAX_LEVELS}")));
        }
        let mut group = Group { name, arguments, line, ..Group::default() };
        loop {
            let name = match self.next()? {
                Some(Token::Word(name) | Token::Quoted(name)) => name,
                Some(Token::Mark(b';')) => continue,
                Some(Token::Mark(b'}')) => return Ok(group),
                Some(Token::Mark(mark)) => {
                    return Err(self.refuse(format!("`{}` out of place", char::from(mark))));
                }
                None => return Err(self.truncated()),
            };
            let line = self.line;
            match self.next()? {
                Some(Token::Mark(b':')) => {
                    let values = self.value()?;
                    group.attributes.push(Attribute { name, values, line });
                }
                Some(Token::Mark(b'(')) => {
                    let values = self.list()?;
                    let at = (self.at, self.line);
                    if self.next()? == Some(Token::Mark(b'{')) {
                        group.groups.push(self.body(name, values, line, level + 1)?);
                    } else {
                        (self.at, self.line) = at;
                        group.attributes.push(Attribute { name, values, line });
                    }
                }
                Some(_) => {
                    let name: String = name.chars().take(40).collect();
                    return Err(self.refuse(format!("`:` or `(` is expected behind `{name}`")));
                }
                None => return Err(self.truncated()),
            }
        }
    }
}
