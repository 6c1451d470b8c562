//! The clipping rules of the papers, as they stand there: what they lose is counted, not mended.
//!
//! Both search a polynomial over [0, 1] in Bézier form, nearest piece first, and take the middle of a
//! piece that has become narrow for the root.

use super::bezier::{Bezier, Piece};
use crate::intersect::Counters;

/// Pieces narrower than this are roots for Nishita's rule. The choice is ours: t is then far within
/// the oracle's tolerance.
const NISHITA_NARROW: f64 = 1e-6;
/// A clip that leaves more than this is followed by halving (Nishita, Sederberg & Kakimoto 1990: the
/// clip has to take away a fifth).
const NISHITA_SLOW: f64 = 0.8;
/// Clips and halvings after which Nishita's rule gives up.
const NISHITA_LIMIT: u32 = 100;
/// Pieces narrower than this are roots for Kanamori's rule (§5.4: 10e−4).
const KANAMORI_NARROW: f64 = 1e-3;
/// Pieces that wait on Kanamori's stack at most (§5.4).
const KANAMORI_STACK: usize = 3;

/// The first change of sign by Nishita's rule: clip to the stretch where the hull of the control points
/// meets the axis; where that takes too little away, halve.
pub(super) fn nishita(
    curve: &Bezier,
    pieces: &mut Vec<Piece>,
    counters: &mut Counters,
) -> Option<f64> {
    pieces.clear();
    pieces.push(Piece::whole(*curve));
    let mut left = NISHITA_LIMIT;
    while let Some(piece) = pieces.pop() {
        if piece.curve.sign_changes() == 0 {
            continue;
        }
        if piece.width() <= NISHITA_NARROW {
            return Some(piece.middle());
        }
        if left == 0 {
            counters.clip_failures += 1;
            return None;
        }
        left -= 1;
        counters.clip_iterations += 1;
        let (from, to) = piece.curve.hull_on_axis(0.0);
        if to - from <= NISHITA_SLOW {
            pieces.push(piece.part(from, to));
        } else {
            pieces.extend([piece.part(0.5, 1.0), piece.part(0.0, 0.5)]);
        }
    }
    None
}

/// The first change of sign by Kanamori's rule: where the control values change sign more than once,
/// halve at once; where they do so once, clip. The stack is short: what does not fit is lost.
pub(super) fn kanamori(
    curve: &Bezier,
    pieces: &mut Vec<Piece>,
    counters: &mut Counters,
) -> Option<f64> {
    pieces.clear();
    let mut current = Some(Piece::whole(*curve));
    while let Some(piece) = current.take().or_else(|| pieces.pop()) {
        let changes = piece.curve.sign_changes();
        if changes == 0 {
            continue;
        }
        if piece.width() <= KANAMORI_NARROW {
            return Some(piece.middle());
        }
        counters.clip_iterations += 1;
        if changes == 1 {
            let (from, to) = piece.curve.hull_on_axis(0.0);
            current = Some(piece.part(from, to));
            continue;
        }
        let second = piece.part(0.5, 1.0);
        // Only what may hold a root is kept waiting.
        if second.curve.sign_changes() > 0 {
            if pieces.len() < KANAMORI_STACK {
                pieces.push(second);
            } else {
                counters.clip_failures += 1;
            }
        }
        current = Some(piece.part(0.0, 0.5));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intersect::sweep::bezier::{MAX_COEFFICIENTS, binomial};

    /// Π (u − rootᵢ), negative at 0.
    fn with_roots(roots: &[f64]) -> Bezier {
        let mut power = [0.0; MAX_COEFFICIENTS];
        power[0] = if roots.len().is_multiple_of(2) {
            -1.0
        } else {
            1.0
        };
        for (degree, root) in roots.iter().enumerate() {
            let before = power;
            for i in 0..=degree + 1 {
                power[i] = -root * before[i] + if i > 0 { before[i - 1] } else { 0.0 };
            }
        }
        let degree = roots.len();
        let mut c = [0.0; MAX_COEFFICIENTS];
        for i in 0..=degree {
            c[i] = (0..=i)
                .map(|k| power[k] * binomial(i, k) / binomial(degree, k))
                .sum();
        }
        Bezier { c, degree }
    }

    #[test]
    fn both_rules_find_roots_to_their_accuracy() {
        let mut counters = Counters::default();
        let mut pieces = Vec::new();
        for roots in [&[0.3, 1.7, 2.0][..], &[0.2, 0.6, 0.9, 1.5], &[0.9, 3.0]] {
            let curve = with_roots(roots);
            let first = nishita(&curve, &mut pieces, &mut counters).unwrap();
            assert!((first - roots[0]).abs() <= NISHITA_NARROW, "{first}");
            let first = kanamori(&curve, &mut pieces, &mut counters).unwrap();
            assert!((first - roots[0]).abs() <= KANAMORI_NARROW, "{first}");
        }
        assert!(counters.clip_iterations > 6 && counters.clip_failures == 0);
        let none = with_roots(&[1.5, 2.0]);
        assert_eq!(nishita(&none, &mut pieces, &mut counters), None);
        assert_eq!(kanamori(&none, &mut pieces, &mut counters), None);
    }

    #[test]
    fn a_full_stack_is_counted() {
        let mut counters = Counters::default();
        // Many changes of sign on the right keep one piece waiting per halving towards the left.
        let roots = [0.001, 0.002, 0.16, 0.3, 0.4, 0.6, 0.8, 0.9];
        let curve = with_roots(&roots);
        kanamori(&curve, &mut Vec::new(), &mut counters);
        assert!(counters.clip_failures > 0);
    }
}
