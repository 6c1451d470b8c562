//! The words of a CIF file (S. R. Hall, F. H. Allen, I. D. Brown, Acta Cryst. A47 (1991) 655; syntax
//! of version 1.1).

/// A word and where it stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Token<'a> {
    /// Its text without quotes.
    pub(super) text: &'a [u8],
    /// Line, counted from 1.
    pub(super) line: u64,
    /// Whether it stood without quotes, so that it may be a tag, a keyword, `.` or `?`.
    pub(super) is_bare: bool,
}

impl<'a> Token<'a> {
    /// The value; `None` for `.` and `?`.
    pub(super) fn value(self) -> Option<&'a [u8]> {
        let is_missing = self.is_bare && matches!(self.text, b"." | b"?");
        (!is_missing).then_some(self.text)
    }

    pub(super) fn is_tag(self) -> bool {
        self.is_bare && self.text.first() == Some(&b'_')
    }

    pub(super) fn is_loop(self) -> bool {
        self.is_bare && self.text.eq_ignore_ascii_case(b"loop_")
    }

    pub(super) fn is_data_block(self) -> bool {
        self.is_bare && starts_with(self.text, b"data_")
    }

    /// Whether it ends a table.
    pub(super) fn ends_values(self) -> bool {
        let keywords: [&[u8]; 4] = [b"data_", b"save_", b"global_", b"stop_"];
        self.is_tag()
            || self.is_loop()
            || self.is_bare && keywords.iter().any(|word| starts_with(self.text, word))
    }
}

fn starts_with(text: &[u8], word: &[u8]) -> bool {
    text.get(..word.len())
        .is_some_and(|start| start.eq_ignore_ascii_case(word))
}

/// The words of a file in order; comments and blanks are left out.
#[derive(Debug, Clone)]
pub(super) struct Tokens<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            line: 1,
        }
    }

    /// Moves on by `count` bytes, counting lines.
    fn advance(&mut self, count: usize) {
        let passed = &self.bytes[self.at..self.at + count];
        self.line += passed.iter().filter(|&&byte| byte == b'\n').count() as u64;
        self.at += count;
    }

    /// A text between lines that start with a semicolon.
    fn text_field(&mut self) -> Token<'a> {
        let line = self.line;
        let body = &self.bytes[self.at + 1..];
        let end = body.windows(2).position(|pair| pair == b"\n;");
        let text = &body[..end.unwrap_or(body.len())];
        self.advance(1 + text.len() + if end.is_some() { 2 } else { 0 });
        Token {
            text,
            line,
            is_bare: false,
        }
    }

    /// A word in quotes, which end before a blank only.
    fn quoted(&mut self, quote: u8) -> Token<'a> {
        let line = self.line;
        let body = &self.bytes[self.at + 1..];
        let end = (0..body.len()).find(|&i| {
            body[i] == b'\n'
                || body[i] == quote && body.get(i + 1).is_none_or(u8::is_ascii_whitespace)
        });
        let text = &body[..end.unwrap_or(body.len())];
        let is_closed = end.is_some_and(|end| body[end] == quote);
        self.advance(1 + text.len() + usize::from(is_closed));
        Token {
            text,
            line,
            is_bare: false,
        }
    }
}

impl<'a> Iterator for Tokens<'a> {
    type Item = Token<'a>;

    fn next(&mut self) -> Option<Token<'a>> {
        loop {
            let rest = &self.bytes[self.at..];
            let blanks = rest.iter().take_while(|byte| byte.is_ascii_whitespace());
            let blanks = blanks.count();
            self.advance(blanks);
            let rest = &self.bytes[self.at..];
            let first = *rest.first()?;
            let starts_line = self.at == 0 || self.bytes[self.at - 1] == b'\n';
            match first {
                b'#' => {
                    let end = rest.iter().position(|&byte| byte == b'\n');
                    self.advance(end.unwrap_or(rest.len()));
                }
                b';' if starts_line => return Some(self.text_field()),
                b'\'' | b'"' => return Some(self.quoted(first)),
                _ => {
                    let end = rest.iter().position(u8::is_ascii_whitespace);
                    let text = &rest[..end.unwrap_or(rest.len())];
                    self.at += text.len();
                    return Some(Token {
                        text,
                        line: self.line,
                        is_bare: true,
                    });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_quotes_texts_and_comments_are_told_apart() {
        let text = b"data_X # comment\n_a 'it's' \"a 'b'\"\n;long\n; ; text\n;\nloop_ ? '?' a#b";
        let found: Vec<(&[u8], u64, bool)> = Tokens::new(text)
            .map(|token| (token.text, token.line, token.is_bare))
            .collect();
        let expected: [(&[u8], u64, bool); 8] = [
            (b"data_X", 1, true),
            (b"_a", 2, true),
            (b"it's", 2, false),
            (b"a 'b'", 2, false),
            (b"long", 3, false),
            (b";", 4, true),
            (b"text", 4, true),
            (b"\nloop_ ? '?' a#b", 5, false),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn missing_values_are_bare() {
        let values: Vec<Option<&[u8]>> = Tokens::new(b". ? '.' -1")
            .map(|token| token.value())
            .collect();
        assert_eq!(values, [None, None, Some(&b"."[..]), Some(b"-1")]);
        assert!(Tokens::new(b"'unclosed\n_tag").nth(1).unwrap().is_tag());
    }
}
