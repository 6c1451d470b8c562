//! The postfix program over columns: checked once, then run on blocks of rows in parallel.

use super::{Binary, Problem, Step, Unary};
use crate::particles::{Attribute, Particles};
use rayon::prelude::*;
use std::ops::Range;

/// Rows per block: a few blocks of f64 stay in the nearest cache.
const BLOCK: usize = 512;

/// A step with its names looked up; conditions are 1 and 0.
enum Bound<'a> {
    Number(f64),
    Load(Attribute<'a>),
    Unary(Unary),
    Binary(Binary),
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Number,
    Condition,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Number => "a number",
            Self::Condition => "a condition",
        }
    }
}

/// For each particle whether the program's condition holds.
pub(super) fn keep(
    steps: &[(Step, Range<usize>)],
    particles: &Particles,
) -> Result<Vec<bool>, Problem> {
    let (program, depth) = bind(steps, particles)?;
    let mut keep = vec![false; particles.len()];
    keep.par_chunks_mut(BLOCK).enumerate().for_each_init(
        || vec![[0.0; BLOCK]; depth],
        |stack, (block, keep)| {
            run(&program, block * BLOCK, keep.len(), stack);
            for (keep, value) in keep.iter_mut().zip(&stack[0]) {
                *keep = *value != 0.0;
            }
        },
    );
    Ok(keep)
}

/// Looks up names, checks kinds, and finds how deep the stack gets.
fn bind<'a>(
    steps: &[(Step, Range<usize>)],
    particles: &'a Particles,
) -> Result<(Vec<Bound<'a>>, usize), Problem> {
    let mut program = Vec::with_capacity(steps.len());
    let mut kinds: Vec<(Kind, Range<usize>)> = Vec::new();
    let mut depth = 0;
    for (i, (step, span)) in steps.iter().enumerate() {
        let mut operand = |wanted: Kind| -> Result<Range<usize>, Problem> {
            // The parser puts every operand before its operator.
            let (kind, place) = kinds.pop().unwrap_or((wanted, span.clone()));
            if kind == wanted {
                return Ok(place);
            }
            let problem = format!("expected {}, found {}", wanted.name(), kind.name());
            Err(match wanted {
                Kind::Condition => Problem::new(place, problem).help("compare it: `… > 0`"),
                Kind::Number => Problem::new(place, problem),
            })
        };
        let (bound, kind, place) = match step {
            Step::Number(value) => (Bound::Number(*value), Kind::Number, span.clone()),
            Step::Name(name) => {
                let magnitude = matches!(steps.get(i + 1), Some((Step::Magnitude, _)));
                let attribute = named(particles, name, span, magnitude)?;
                (Bound::Load(attribute), Kind::Number, span.clone())
            }
            Step::Magnitude => {
                operand(Kind::Number)?;
                (Bound::Unary(Unary::Abs), Kind::Number, span.clone())
            }
            Step::Unary(operator) => {
                let kind = match operator {
                    Unary::Not => Kind::Condition,
                    _ => Kind::Number,
                };
                let place = operand(kind)?;
                (Bound::Unary(*operator), kind, joined(span, &place))
            }
            Step::Binary(operator) => {
                let (wanted, result) = kinds_of(*operator);
                let right = operand(wanted)?;
                let left = operand(wanted)?;
                (Bound::Binary(*operator), result, joined(&left, &right))
            }
        };
        program.push(bound);
        kinds.push((kind, place));
        depth = depth.max(kinds.len());
    }
    match kinds.pop() {
        Some((Kind::Condition, _)) => Ok((program, depth)),
        Some((Kind::Number, place)) => Err(Problem::new(
            place,
            "this is a number; a filter needs a condition",
        )
        .help("compare it: `… > 0`")),
        None => Err(Problem::new(0..0, "the expression is empty")),
    }
}

fn joined(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    a.start.min(b.start)..a.end.max(b.end)
}

fn kinds_of(operator: Binary) -> (Kind, Kind) {
    match operator {
        Binary::And | Binary::Or => (Kind::Condition, Kind::Condition),
        Binary::Less
        | Binary::LessEqual
        | Binary::Greater
        | Binary::GreaterEqual
        | Binary::Equal
        | Binary::NotEqual => (Kind::Number, Kind::Condition),
        Binary::Add
        | Binary::Subtract
        | Binary::Multiply
        | Binary::Divide
        | Binary::Remainder
        | Binary::Power
        | Binary::Min
        | Binary::Max => (Kind::Number, Kind::Number),
    }
}

fn named<'a>(
    particles: &'a Particles,
    name: &str,
    span: &Range<usize>,
    magnitude: bool,
) -> Result<Attribute<'a>, Problem> {
    let attribute = particles
        .attribute(name)
        .map_err(|missing| Problem::new(span.clone(), missing.problem()).help(missing.help()))?;
    match (attribute.components(), magnitude) {
        (1, _) => Ok(attribute),
        (_, true) => Ok(attribute.magnitude()),
        (components, false) => Err(Problem::new(
            span.clone(),
            format!("`{name}` has {components} components, and a number was expected"),
        )
        .help(format!("write `{name}.x` or `|{name}|`"))),
    }
}

/// Runs the program on `count` rows from `first` on; the result lies in `stack[0]`.
fn run(program: &[Bound<'_>], first: usize, count: usize, stack: &mut [[f64; BLOCK]]) {
    let mut top = 0;
    for step in program {
        match step {
            Bound::Number(value) => {
                stack[top][..count].fill(*value);
                top += 1;
            }
            Bound::Load(attribute) => {
                attribute.read(first, 0, &mut stack[top][..count]);
                top += 1;
            }
            Bound::Unary(operator) => unary(*operator, &mut stack[top - 1][..count]),
            Bound::Binary(operator) => {
                top -= 1;
                let (left, right) = stack.split_at_mut(top);
                binary(*operator, &mut left[top - 1][..count], &right[0][..count]);
            }
        }
    }
}

fn unary(operator: Unary, values: &mut [f64]) {
    let mut each = |f: fn(f64) -> f64| values.iter_mut().for_each(|v| *v = f(*v));
    match operator {
        Unary::Negate => each(|v| -v),
        Unary::Not => each(|v| truth(v == 0.0)),
        Unary::Abs => each(f64::abs),
        Unary::Sqrt => each(f64::sqrt),
        Unary::Floor => each(f64::floor),
        Unary::Ceil => each(f64::ceil),
        Unary::Exp => each(f64::exp),
        Unary::Log => each(f64::ln),
    }
}

fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

fn binary(operator: Binary, left: &mut [f64], right: &[f64]) {
    fn each(left: &mut [f64], right: &[f64], f: impl Fn(f64, f64) -> f64) {
        for (a, b) in left.iter_mut().zip(right) {
            *a = f(*a, *b);
        }
    }
    match operator {
        Binary::Add => each(left, right, |a, b| a + b),
        Binary::Subtract => each(left, right, |a, b| a - b),
        Binary::Multiply => each(left, right, |a, b| a * b),
        Binary::Divide => each(left, right, |a, b| a / b),
        Binary::Remainder => each(left, right, |a, b| a % b),
        Binary::Power => each(left, right, f64::powf),
        Binary::Min => each(left, right, |a, b| if b < a || b.is_nan() { b } else { a }),
        Binary::Max => each(left, right, |a, b| if b > a || b.is_nan() { b } else { a }),
        Binary::Less => each(left, right, |a, b| truth(a < b)),
        Binary::LessEqual => each(left, right, |a, b| truth(a <= b)),
        Binary::Greater => each(left, right, |a, b| truth(a > b)),
        Binary::GreaterEqual => each(left, right, |a, b| truth(a >= b)),
        Binary::Equal => each(left, right, |a, b| truth(a == b)),
        Binary::NotEqual => each(left, right, |a, b| {
            truth(a.partial_cmp(&b).is_some_and(std::cmp::Ordering::is_ne))
        }),
        Binary::And => each(left, right, |a, b| truth(a != 0.0 && b != 0.0)),
        Binary::Or => each(left, right, |a, b| truth(a != 0.0 || b != 0.0)),
    }
}
