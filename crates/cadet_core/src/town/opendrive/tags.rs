//! Start tags of an XML text, with their lines: enough to look over a text before it is parsed.

/// Start tags, one after the other; comments and character data are passed over.
pub(in crate::town) struct Tags<'a> {
    text: &'a str,
    at: usize,
    line: usize,
}

/// A start tag.
pub(in crate::town) struct Tag<'a> {
    /// From 1.
    pub line: usize,
    pub name: &'a str,
    attributes: &'a str,
}

impl<'a> Tags<'a> {
    pub fn of(text: &'a str) -> Self {
        Self { text, at: 0, line: 1 }
    }

    /// Goes on behind the next `mark`.
    fn pass_to(&mut self, mark: &str) -> Option<()> {
        let length = self.text[self.at..].find(mark)?;
        self.pass(length + mark.len());
        Some(())
    }

    fn pass(&mut self, length: usize) {
        let passed = &self.text.as_bytes()[self.at..self.at + length];
        self.line += passed.iter().filter(|b| **b == b'\n').count();
        self.at += length;
    }
}

impl<'a> Iterator for Tags<'a> {
    type Item = Tag<'a>;

    fn next(&mut self) -> Option<Tag<'a>> {
        loop {
            self.pass_to("<")?;
            let rest = &self.text[self.at..];
            let skipped = [("!--", "-->"), ("![CDATA[", "]]>"), ("?", "?>"), ("!", ">"), ("/", ">")];
            if let Some((_, end)) = skipped.into_iter().find(|(start, _)| rest.starts_with(start)) {
                self.pass_to(end)?;
                continue;
            }
            let line = self.line;
            let mut quote = None;
            let length = rest.find(|c| match quote {
                Some(q) => {
                    if c == q {
                        quote = None;
                    }
                    false
                }
                None => {
                    if c == '"' || c == '\'' {
                        quote = Some(c);
                    }
                    c == '>'
                }
            })?;
            self.pass(length + 1);
            let tag = &rest[..length];
            let name = tag.split(|c: char| c.is_whitespace() || c == '/').next().unwrap_or("");
            let attributes = &tag[name.len()..];
            // A namespace's prefix says nothing here.
            return Some(Tag { line, name: name.rsplit(':').next().unwrap_or(name), attributes });
        }
    }
}

impl<'a> Tag<'a> {
    /// The value of an attribute, a part of the text itself.
    pub fn value(&self, key: &str) -> Option<&'a str> {
        let mut rest = self.attributes;
        while let Some((name, behind)) = rest.split_once('=') {
            let behind = behind.trim_start();
            let quote = behind.chars().next().filter(|c| *c == '"' || *c == '\'')?;
            let (value, next) = behind[1..].split_once(quote)?;
            if name.trim() == key {
                return Some(value);
            }
            rest = next;
        }
        None
    }

    /// The number that an attribute is.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.value(key)?.trim().parse().ok()
    }
}
