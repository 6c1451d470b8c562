//! Filter expressions: which particles to keep.
//!
//! ```text
//! y > 0.2 && |velocity| < 3 && !(id == 7) && `my column`[2] <= max(x, 2 * z)
//! ```
//!
//! `x y z` are the position; every other name is what [`Particles::attribute`] finds: a column, a
//! component `v.x` or `v[0]`, a role such as `velocity`, a group of scalar columns. Names with other
//! characters than letters, digits and `_` stand in backticks or quotes. `|v|` is the length of a
//! vector or the absolute value of a number. By falling precedence: `^`; unary `-` and `!`; `* / %`;
//! `+ -`; comparisons `< <= > >= == !=`, which do not chain; the word `not`; `&&` (`and`); `||` (`or`). Functions:
//! `min max abs sqrt floor ceil exp log`. Every comparison with NaN is false, `!=` too.

mod evaluate;
mod lexer;
mod parser;

use super::Particles;
use std::ops::Range;

/// An expression that does not parse, or does not fit the particles.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilterError {
    /// The whole expression.
    pub expression: String,
    /// The bytes of it that are wrong; empty at the place where something is missing.
    pub span: Range<usize>,
    /// What is wrong and what was expected.
    pub problem: String,
    /// What to write instead, when that is known.
    pub help: Option<String>,
}

impl std::error::Error for FilterError {}

impl std::fmt::Display for FilterError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            expression,
            span,
            problem,
            help,
        } = self;
        write!(
            f,
            "filter `{expression}`, at byte {}: {problem}",
            span.start
        )?;
        match help {
            Some(help) => write!(f, " ({help})"),
            None => Ok(()),
        }
    }
}

/// What is wrong where; the expression is added on the way out.
#[derive(Debug)]
struct Problem {
    span: Range<usize>,
    problem: String,
    help: Option<String>,
}

impl Problem {
    fn new(span: Range<usize>, problem: impl Into<String>) -> Self {
        Self {
            span,
            problem: problem.into(),
            help: None,
        }
    }

    fn help(self, help: impl Into<String>) -> Self {
        Self {
            help: Some(help.into()),
            ..self
        }
    }

    fn within(self, expression: &str) -> FilterError {
        FilterError {
            expression: expression.to_owned(),
            span: self.span,
            problem: self.problem,
            help: self.help,
        }
    }
}

/// One step of the postfix program.
#[derive(Debug, Clone, PartialEq)]
enum Step {
    Number(f64),
    /// A name as [`Particles::attribute`] takes it.
    Name(String),
    Magnitude,
    Unary(Unary),
    Binary(Binary),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unary {
    Negate,
    Not,
    Abs,
    Sqrt,
    Floor,
    Ceil,
    Exp,
    Log,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Remainder,
    Power,
    Min,
    Max,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
    And,
    Or,
}

/// A parsed expression, ready for any particles.
#[derive(Debug, Clone, PartialEq)]
pub struct Filter {
    text: String,
    steps: Vec<(Step, Range<usize>)>,
}

impl Filter {
    /// Parses an expression.
    ///
    /// # Errors
    /// Where it is not one, with the bytes that are wrong.
    pub fn parse(text: &str) -> Result<Self, FilterError> {
        let steps = parser::parse(text).map_err(|problem| problem.within(text))?;
        Ok(Self {
            text: text.to_owned(),
            steps,
        })
    }

    /// The expression as it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// For each particle whether the expression holds.
    ///
    /// # Errors
    /// When a name is no column, or a vector, a number and a condition are mixed up.
    pub fn keep(&self, particles: &Particles) -> Result<Vec<bool>, FilterError> {
        evaluate::keep(&self.steps, particles).map_err(|problem| problem.within(&self.text))
    }

    /// Removes the particles for which the expression does not hold and says how many those were.
    ///
    /// # Errors
    /// As [`Filter::keep`]; the particles then stay as they are.
    pub fn apply(&self, particles: &mut Particles) -> Result<usize, FilterError> {
        let keep = self.keep(particles)?;
        particles.retain(|i| keep[i]);
        Ok(keep.len() - particles.len())
    }
}

#[cfg(test)]
mod tests;
