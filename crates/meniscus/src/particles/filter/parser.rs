//! Tokens to a postfix program, by recursive descent with a bound on the depth.

use super::lexer::{Token, tokens};
use super::{Binary, Problem, Step, Unary};
use std::ops::Range;

/// Nesting beyond this is refused, so that no expression exhausts the stack.
const MAX_DEPTH: usize = 128;

type Steps = Vec<(Step, Range<usize>)>;

/// Parses a whole expression.
pub(super) fn parse(text: &str) -> Result<Steps, Problem> {
    let mut parser = Parser {
        tokens: tokens(text)?,
        at: 0,
        depth: 0,
        steps: Vec::new(),
    };
    parser.binary(0)?;
    match parser.peek() {
        Token::End => Ok(parser.steps),
        _ => Err(parser.unexpected("an operator or the end")),
    }
}

struct Parser {
    tokens: Vec<(Token, Range<usize>)>,
    at: usize,
    depth: usize,
    steps: Steps,
}

/// Operators by rising precedence; one level per row.
const LEVELS: [&[Binary]; 5] = [
    &[Binary::Or],
    &[Binary::And],
    &[
        Binary::Less,
        Binary::LessEqual,
        Binary::Greater,
        Binary::GreaterEqual,
        Binary::Equal,
        Binary::NotEqual,
    ],
    &[Binary::Add, Binary::Subtract],
    &[Binary::Multiply, Binary::Divide, Binary::Remainder],
];
const COMPARISONS: usize = 2;
const SUMS: usize = 3;

impl Parser {
    fn peek(&self) -> &Token {
        &self.tokens[self.at].0
    }

    fn span(&self) -> Range<usize> {
        self.tokens[self.at].1.clone()
    }

    fn advance(&mut self) {
        // The last token is `End`, which nothing consumes.
        self.at = (self.at + 1).min(self.tokens.len() - 1);
    }

    fn unexpected(&self, expected: &str) -> Problem {
        let problem = match self.peek() {
            Token::End => format!("the expression ends where {expected} was expected"),
            Token::Not => format!("expected {expected}, found `!`"),
            _ => format!("expected {expected}"),
        };
        Problem::new(self.span(), problem)
    }

    /// The binary operator that comes next; `and` and `or` are words for `&&` and `||`.
    fn operator(&self) -> Option<Binary> {
        match self.peek() {
            Token::Binary(operator) => Some(*operator),
            Token::Name(name) if name == "and" => Some(Binary::And),
            Token::Name(name) if name == "or" => Some(Binary::Or),
            _ => None,
        }
    }

    fn binary(&mut self, level: usize) -> Result<(), Problem> {
        let Some(operators) = LEVELS.get(level) else {
            return self.unary();
        };
        if level == COMPARISONS && *self.peek() == Token::Name("not".to_owned()) {
            return self.not();
        }
        self.binary(level + 1)?;
        let mut compared = false;
        while let Some(operator) = self.operator().filter(|found| operators.contains(found)) {
            if compared {
                return Err(Problem::new(self.span(), "comparisons do not chain")
                    .help("write `0 < x && x < 1` for `0 < x < 1`"));
            }
            compared = level == COMPARISONS;
            let span = self.span();
            self.advance();
            self.binary(level + 1)?;
            self.steps.push((Step::Binary(operator), span));
        }
        Ok(())
    }

    /// The word `not` takes a whole comparison, unlike `!`.
    fn not(&mut self) -> Result<(), Problem> {
        self.descend()?;
        let span = self.span();
        self.advance();
        self.binary(COMPARISONS)?;
        self.steps.push((Step::Unary(Unary::Not), span));
        self.depth -= 1;
        Ok(())
    }

    fn descend(&mut self) -> Result<(), Problem> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            let problem = format!("nested more than {MAX_DEPTH} deep");
            return Err(Problem::new(self.span(), problem));
        }
        Ok(())
    }

    fn unary(&mut self) -> Result<(), Problem> {
        self.descend()?;
        let span = self.span();
        let prefix = match self.peek() {
            Token::Not => Some(Some(Unary::Not)),
            Token::Binary(Binary::Subtract) => Some(Some(Unary::Negate)),
            Token::Binary(Binary::Add) => Some(None),
            _ => None,
        };
        if let Some(operator) = prefix {
            self.advance();
            self.unary()?;
            let step = operator.map(|operator| (Step::Unary(operator), span));
            self.steps.extend(step);
        } else {
            self.power()?;
        }
        self.depth -= 1;
        Ok(())
    }

    /// `a ^ b ^ c` is `a ^ (b ^ c)`, and `-a ^ b` is `-(a ^ b)`.
    fn power(&mut self) -> Result<(), Problem> {
        self.primary()?;
        if self.operator() == Some(Binary::Power) {
            let span = self.span();
            self.advance();
            self.unary()?;
            self.steps.push((Step::Binary(Binary::Power), span));
        }
        Ok(())
    }

    fn primary(&mut self) -> Result<(), Problem> {
        let span = self.span();
        match self.peek().clone() {
            Token::Number(value) => {
                self.advance();
                self.steps.push((Step::Number(value), span));
                Ok(())
            }
            Token::Name(name) => {
                self.advance();
                if *self.peek() == Token::Open {
                    return self.call(&name, span);
                }
                self.steps.push((Step::Name(name), span));
                Ok(())
            }
            Token::Quoted(name) => {
                self.advance();
                self.steps.push((Step::Name(name), span));
                Ok(())
            }
            Token::Open => {
                self.advance();
                self.binary(0)?;
                self.expect(&Token::Close, "`)`")
            }
            Token::Bar => self.magnitude(span),
            Token::Binary(Binary::Or) => {
                self.split_bars();
                self.magnitude(span.start..span.start + 1)
            }
            _ => Err(self.unexpected("a number, a name, `(` or `|`")),
        }
    }

    /// `|…|`: a sum cannot hold `||`, so what looks like one closes two magnitudes.
    fn magnitude(&mut self, open: Range<usize>) -> Result<(), Problem> {
        self.advance();
        self.binary(SUMS)?;
        if *self.peek() == Token::Binary(Binary::Or) {
            self.split_bars();
        }
        let end = self.span().end;
        self.expect(&Token::Bar, "`|`")?;
        self.steps.push((Step::Magnitude, open.start..end));
        Ok(())
    }

    /// Turns the `||` that comes next into two bars.
    fn split_bars(&mut self) {
        let Range { start, end } = self.span();
        self.tokens[self.at] = (Token::Bar, start..start + 1);
        self.tokens
            .insert(self.at + 1, (Token::Bar, start + 1..end));
    }

    fn expect(&mut self, token: &Token, name: &str) -> Result<(), Problem> {
        if self.peek() != token {
            return Err(self.unexpected(name));
        }
        self.advance();
        Ok(())
    }

    fn call(&mut self, name: &str, span: Range<usize>) -> Result<(), Problem> {
        let step = match name {
            "min" => Step::Binary(Binary::Min),
            "max" => Step::Binary(Binary::Max),
            "abs" => Step::Unary(Unary::Abs),
            "sqrt" => Step::Unary(Unary::Sqrt),
            "floor" => Step::Unary(Unary::Floor),
            "ceil" => Step::Unary(Unary::Ceil),
            "exp" => Step::Unary(Unary::Exp),
            "log" => Step::Unary(Unary::Log),
            _ => {
                return Err(Problem::new(span, format!("no function `{name}`"))
                    .help("the functions are min max abs sqrt floor ceil exp log"));
            }
        };
        self.advance();
        let many = matches!(step, Step::Binary(_));
        let mut arguments = 0;
        loop {
            self.binary(SUMS)?;
            arguments += 1;
            if arguments > 1 {
                self.steps.push((step.clone(), span.clone()));
            }
            if !many || *self.peek() != Token::Comma {
                break;
            }
            self.advance();
        }
        if many && arguments < 2 {
            let problem = format!("`{name}` takes two arguments or more");
            return Err(Problem::new(span, problem));
        }
        if !many {
            self.steps.push((step, span));
        }
        self.expect(&Token::Close, if many { "`,` or `)`" } else { "`)`" })
    }
}
