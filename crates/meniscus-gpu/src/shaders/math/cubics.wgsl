// Ways as cubics piece by piece: twin of math/cubics.rs. A piece's words: (start, 1/length, whether it is
// close, –), then of each vector c₀, its low part, c₁, c₂, c₃.

const CUBIC_WORDS: u32 = 5u;

// A piece, and the part of it that is over.
struct PieceThere {
    at: u32,
    over: f32,
    is_close: bool,
}

// The piece of a way of so many vectors when `part` of the time is over.
fn piece_there(first: u32, pieces: u32, vectors: u32, part: f32) -> PieceThere {
    let stride = 1u + vectors * CUBIC_WORDS;
    var low = 0u;
    var high = pieces;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if words[first + middle * stride].x <= part {
            low = middle;
        } else {
            high = middle;
        }
    }
    let at = first + low * stride;
    let head = words[at];
    return PieceThere(at, clamp((part - head.x) * head.y, 0.0, 1.0), head.z > 0.5);
}

// One of its vectors.
fn vector_there(there: PieceThere, vector: u32) -> TwoVec3 {
    let at = there.at + 1u + vector * CUBIC_WORDS;
    let u = there.over;
    let way = (words[at + 2u].xyz + (words[at + 3u].xyz + words[at + 4u].xyz * u) * u) * u;
    let sum = two_sum(words[at].xyz, way);
    return TwoVec3(sum.high, sum.low + words[at + 1u].xyz);
}

// How one of its vectors changes by the part of the time that is over.
fn vector_change(there: PieceThere, vector: u32) -> vec3f {
    let at = there.at + 1u + vector * CUBIC_WORDS;
    let u = there.over;
    let slope = words[at + 2u].xyz + (2.0 * words[at + 3u].xyz + 3.0 * words[at + 4u].xyz * u) * u;
    return slope * words[there.at].y;
}
