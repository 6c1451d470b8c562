//! Smooth functions of time as cubics piece by piece, for machines with neither keys nor float64.

use glam::{DVec3, Vec3};

/// How often a piece is halved at most.
const MOST_HALVINGS: u32 = 10;
/// Where a cubic through four even places is farthest from what it stands for, and in the middle.
const CHECKS: [f64; 3] = [0.127, 0.5, 0.873];

/// A piece of the way of `N` vectors.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece<const N: usize> {
    /// Which part of the whole time is over when it begins.
    pub start: f64,
    /// Which part of the whole time it takes.
    pub length: f64,
    /// c₀ + u(c₁ + u(c₂ + u c₃)) of each vector, u the part of the piece that is over.
    pub cubics: [[DVec3; 4]; N],
    /// Whether they keep to the tolerances: not where the way has a jump.
    pub is_close: bool,
}

impl<const N: usize> Piece<N> {
    fn new(start: f64, end: f64, at: &impl Fn(f64) -> [DVec3; N]) -> Self {
        let length = end - start;
        let [p, q, r, s] =
            [0.0, 1.0, 2.0, 3.0].map(|third: f64| at(start + length * (third / 3.0)));
        Self {
            start,
            length,
            cubics: std::array::from_fn(|n| {
                let [p, q, r, s] = [p[n], q[n], r[n], s[n]];
                [
                    p,
                    (q * 18.0 - p * 11.0 - r * 9.0 + s * 2.0) * 0.5,
                    (p * 2.0 - q * 5.0 + r * 4.0 - s) * 4.5,
                    (q * 3.0 - p - r * 3.0 + s) * 4.5,
                ]
            }),
            is_close: true,
        }
    }

    /// The vectors where the part `u` of the piece is over.
    pub fn at(&self, u: f64) -> [DVec3; N] {
        self.cubics
            .map(|[a, b, c, d]| a + (b + (c + d * u) * u) * u)
    }

    /// As shaders read it: (start, 1/length, whether it is close, –), then of each vector c₀, its low part,
    /// c₁, c₂, c₃.
    pub fn words(&self) -> Vec<[f32; 4]> {
        let word = |v: Vec3| [v.x, v.y, v.z, 0.0];
        let is_close = f32::from(u8::from(self.is_close));
        let mut words = vec![[self.start as f32, self.length.recip() as f32, is_close, 0.0]];
        for [first, rest @ ..] in self.cubics {
            let high = first.as_vec3();
            let low = (first - high.as_dvec3()).as_vec3();
            words.extend([high, low].map(word));
            words.extend(rest.map(|c| word(c.as_vec3())));
        }
        words
    }

    fn keeps(&self, tolerances: &[f64; N], at: &impl Fn(f64) -> [DVec3; N]) -> bool {
        CHECKS.into_iter().all(|u| {
            let (ours, exact) = (self.at(u), at(self.start + self.length * u));
            (0..N).all(|n| ours[n].distance(exact[n]) <= tolerances[n])
        })
    }
}

/// The pieces of a way, in order, from 0 to 1. `at` says where the vectors are when that part of the time
/// is over; it is smooth but at `cuts`, which rise.
pub fn pieces<const N: usize>(
    cuts: impl IntoIterator<Item = f64>,
    tolerances: [f64; N],
    at: impl Fn(f64) -> [DVec3; N],
) -> Vec<Piece<N>> {
    let mut found = Vec::new();
    let mut start = 0.0;
    let inside = cuts.into_iter().filter(|cut| *cut > 0.0 && *cut < 1.0);
    for end in inside.chain([1.0]) {
        // The rest of the stretch, the nearest last.
        let mut waiting = vec![(start, end, 0)];
        while let Some((from, to, halvings)) = waiting.pop() {
            let mut piece = Piece::new(from, to, &at);
            piece.is_close = piece.keeps(&tolerances, &at);
            if piece.is_close || halvings == MOST_HALVINGS {
                found.push(piece);
                continue;
            }
            let middle = 0.5 * (from + to);
            waiting.push((middle, to, halvings + 1));
            waiting.push((from, middle, halvings + 1));
        }
        start = end;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_follow_a_turn_and_own_up_to_a_jump() {
        let turning = |t: f64| {
            let (sin, cos) = (2.5 * t).sin_cos();
            [DVec3::new(sin, cos, t * t * t), DVec3::splat(1e3 * t)]
        };
        let tolerance = 1e-7;
        let ways = pieces([0.25], [tolerance; 2], turning);
        assert!(ways.len() > 4 && ways.len() < 64, "{}", ways.len());
        assert!(ways.iter().any(|piece| piece.start == 0.25));
        let mut end = 0.0;
        for piece in &ways {
            assert_eq!(piece.start, end);
            end = piece.start + piece.length;
            assert!(piece.is_close);
            for step in 0..=20 {
                let u = f64::from(step) / 20.0;
                let exact = turning(piece.start + piece.length * u);
                for (ours, exact) in piece.at(u).into_iter().zip(exact) {
                    assert!(ours.distance(exact) < 2.0 * tolerance);
                }
            }
        }
        assert_eq!(end, 1.0);
        let jumping = |t: f64| [if t < 0.3 { DVec3::ZERO } else { DVec3::X }];
        let ways = pieces([], [tolerance], jumping);
        let (close, far): (Vec<_>, Vec<_>) = ways.into_iter().partition(|piece| piece.is_close);
        let open: f64 = far.iter().map(|piece| piece.length).sum();
        assert!(open > 0.0 && open < 0.01, "{open}");
        for piece in close {
            let [way] = piece.at(0.5);
            assert_eq!(way, jumping(piece.start)[0]);
        }
    }
}
