// What becomes of a ray.

struct HitRecord {
    status: u32,
    // t is the sum of both, counted from where the ray enters the box of its field.
    base: f32,
    along: f32,
    strongest: u32,
    // −∇F.
    outward: vec3f,
    // 1: it enters; with AT_CUT: where the field is cut open.
    is_entering: u32,
}

@group(0) @binding(1) var<storage, read> rays: array<LocalRay>;
@group(0) @binding(2) var<storage, read_write> hits: array<HitRecord>;

const MISS: u32 = 0u;
const HIT: u32 = 1u;
// f32 cannot tell: the CPU answers.
const IN_DOUBT: u32 = 2u;
// More blobs overlap than the list has room for.
const NO_ROOM: u32 = 3u;
// The list of blobs that may be met is not whole: engine peel only.
const NO_LIST: u32 = 4u;

// llvmpipe lets all loops of an invocation together run 65535 rounds, then leaves each after its first:
// sums lack parts, and nothing says so. A loop whose rounds are known does.
fn if_whole(record: HitRecord) -> HitRecord {
    var rounds = 0u;
    for (var i = 0u; i < params.capacity; i++) {
        rounds++;
    }
    if rounds != params.capacity {
        return nothing(IN_DOUBT);
    }
    return record;
}

fn nothing(status: u32) -> HitRecord {
    return HitRecord(status, 0.0, 0.0, NONE, vec3f(0.0), 0u);
}
