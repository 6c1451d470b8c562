//! Text to tokens.

use super::{Binary, Problem};
use std::ops::Range;

/// A word of the language.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Token {
    Number(f64),
    /// A name with its component suffix, if it has one, in the form `name.suffix`.
    Name(String),
    /// A name in quotes or backticks, which is never a function or keyword.
    Quoted(String),
    Binary(Binary),
    Not,
    Open,
    Close,
    Comma,
    Bar,
    End,
}

/// Splits `text` into tokens with the bytes they cover; the last is [`Token::End`].
pub(super) fn tokens(text: &str) -> Result<Vec<(Token, Range<usize>)>, Problem> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        if first.is_whitespace() {
            at += first.len_utf8();
            continue;
        }
        let (token, length) = token(text, at, first)?;
        tokens.push((token, at..at + length));
        at += length;
    }
    tokens.push((Token::End, at..at));
    Ok(tokens)
}

fn token(text: &str, at: usize, first: char) -> Result<(Token, usize), Problem> {
    let rest = &text[at..];
    let second = rest[first.len_utf8()..].chars().next();
    if first.is_ascii_digit() || (first == '.' && second.is_some_and(|c| c.is_ascii_digit())) {
        return number(rest, at);
    }
    if is_name_start(first) {
        let length = name_length(rest);
        let name = rest[..length].to_owned();
        return Ok(with_suffix(rest, name, length, Token::Name));
    }
    if matches!(first, '`' | '"' | '\'') {
        let Some(end) = rest[1..].find(first) else {
            return Err(Problem::new(
                at..text.len(),
                format!("the name in quotes does not end: expected another {first}"),
            ));
        };
        let name = rest[1..=end].to_owned();
        return Ok(with_suffix(rest, name, end + 2, Token::Quoted));
    }
    let double = match (first, second) {
        ('&', Some('&')) => Some(Token::Binary(Binary::And)),
        ('|', Some('|')) => Some(Token::Binary(Binary::Or)),
        ('<', Some('=')) => Some(Token::Binary(Binary::LessEqual)),
        ('>', Some('=')) => Some(Token::Binary(Binary::GreaterEqual)),
        ('=', Some('=')) => Some(Token::Binary(Binary::Equal)),
        ('!', Some('=')) => Some(Token::Binary(Binary::NotEqual)),
        _ => None,
    };
    if let Some(token) = double {
        return Ok((token, 2));
    }
    let single = match first {
        '+' => Token::Binary(Binary::Add),
        '-' => Token::Binary(Binary::Subtract),
        '*' => Token::Binary(Binary::Multiply),
        '/' => Token::Binary(Binary::Divide),
        '%' => Token::Binary(Binary::Remainder),
        '^' => Token::Binary(Binary::Power),
        '<' => Token::Binary(Binary::Less),
        '>' => Token::Binary(Binary::Greater),
        '!' => Token::Not,
        '(' => Token::Open,
        ')' => Token::Close,
        ',' => Token::Comma,
        '|' => Token::Bar,
        '=' => {
            return Err(Problem::new(at..at + 1, "`=` alone means nothing").help("write `==`"));
        }
        '&' => {
            return Err(Problem::new(at..at + 1, "`&` alone means nothing").help("write `&&`"));
        }
        other => {
            return Err(Problem::new(
                at..at + other.len_utf8(),
                format!("unexpected character `{}`", other.escape_debug()),
            )
            .help("names with such characters stand in backticks"));
        }
    };
    Ok((single, first.len_utf8()))
}

fn is_name_start(c: char) -> bool {
    c == '_' || c.is_alphabetic()
}

/// Bytes of the letters, digits and underscores that `text` starts with.
fn name_length(text: &str) -> usize {
    text.find(|c: char| c != '_' && !c.is_alphanumeric())
        .unwrap_or(text.len())
}

/// Takes `.x`, `.0` or `[0]` after a name into its token.
fn with_suffix(
    rest: &str,
    name: String,
    length: usize,
    token: impl Fn(String) -> Token,
) -> (Token, usize) {
    let tail = &rest[length..];
    if let Some(tail) = tail.strip_prefix('.') {
        let suffix = name_length(tail);
        if suffix > 0 {
            let name = format!("{name}.{}", &tail[..suffix]);
            return (token(name), length + 1 + suffix);
        }
    }
    if let Some((index, _)) = tail.strip_prefix('[').and_then(|tail| tail.split_once(']')) {
        let name = format!("{name}.{}", index.trim());
        return (token(name), length + index.len() + 2);
    }
    (token(name), length)
}

fn number(rest: &str, at: usize) -> Result<(Token, usize), Problem> {
    let digits = |from: usize| {
        rest[from..]
            .find(|c: char| !c.is_ascii_digit())
            .map_or(rest.len(), |n| from + n)
    };
    let mut end = digits(0);
    if rest[end..].starts_with('.') {
        end = digits(end + 1);
    }
    if rest[end..].starts_with(['e', 'E']) {
        let sign = usize::from(rest[end + 1..].starts_with(['+', '-']));
        let exponent = digits(end + 1 + sign);
        if exponent > end + 1 + sign {
            end = exponent;
        }
    }
    // `2x` or `1.2.3`: more of a word follows.
    let tail = rest[end..]
        .find(|c: char| c != '_' && c != '.' && !c.is_alphanumeric())
        .map_or(rest.len(), |n| end + n);
    rest[..tail]
        .parse()
        .map(|value| (Token::Number(value), tail))
        .map_err(|_| {
            Problem::new(
                at..at + tail,
                format!("`{}` is not a number", &rest[..tail]),
            )
            .help("multiplication needs a `*`; a name that starts with a digit stands in backticks")
        })
}
