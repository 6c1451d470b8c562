// Ellipsoids that turn and stretch while the shutter is open, q = |A·N(t)·(x − p(t))|² with
// N(t) = I − tL + ½t²L²: twin of field/turning.rs and intersect/particles/turning.rs. Three more words behind
// those of the motion: the rows of L, the velocity gradient.

const TURN_AT: u32 = SHAPE_WORDS + 2u;

// tL of a blob by its rows, t from the frame's time on.
fn turn_of(at: u32) -> array<vec3f, 3> {
    let secs = params.middle_secs + ray.since_middle_secs;
    return array(
        bitcast<vec3f>(heap(at + TURN_AT).xyz) * secs,
        bitcast<vec3f>(heap(at + TURN_AT + 1u).xyz) * secs,
        bitcast<vec3f>(heap(at + TURN_AT + 2u).xyz) * secs,
    );
}

// N·d.
fn blob_turned(at: u32, d: vec3f) -> vec3f {
    let x = turn_of(at);
    let once = vec3f(dot(x[0], d), dot(x[1], d), dot(x[2], d));
    let twice = vec3f(dot(x[0], once), dot(x[1], once), dot(x[2], once));
    return (d - once) + 0.5 * twice;
}

// Nᵀ·y.
fn blob_turned_back(at: u32, y: vec3f) -> vec3f {
    let x = turn_of(at);
    let once = x[0] * y.x + x[1] * y.y + x[2] * y.z;
    let twice = x[0] * once.x + x[1] * once.y + x[2] * once.z;
    return (y - once) + 0.5 * twice;
}

// The gradient of the velocity of what is about a blob, −N⁻¹·N′ with N′ = tL² − L.
fn blob_gradient(at: u32) -> mat3x3f {
    let secs = params.middle_secs + ray.since_middle_secs;
    let l = transpose(mat3x3f(
        bitcast<vec3f>(heap(at + TURN_AT).xyz),
        bitcast<vec3f>(heap(at + TURN_AT + 1u).xyz),
        bitcast<vec3f>(heap(at + TURN_AT + 2u).xyz),
    ));
    let squared = l * l;
    let still = mat3x3f(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));
    let n = still - l * secs + squared * (0.5 * secs * secs);
    // Rows of the inverse, times the determinant.
    let back = transpose(mat3x3f(cross(n[1], n[2]), cross(n[2], n[0]), cross(n[0], n[1])));
    return back * (l - squared * secs) * (1.0 / determinant(n));
}
