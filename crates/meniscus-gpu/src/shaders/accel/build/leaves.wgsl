// Leaves of sixteen blobs that follow each other on the curve, with their boxes when the shutter opens
// and closes: twin of accel/particles/fit.rs.

struct LeavesParams {
    blobs: u32,
    leaves: u32,
    // Word of the first leaf.
    leaves_at: u32,
    // How much wider boxes are than blobs.
    pad: f32,
    // No leaf counts as smaller when it is asked what is too small for f32.
    least_extent: f32,
    // Too small is what is below the extent over this.
    finest_part: f32,
    half_shutter_secs: f32,
}

@group(0) @binding(0) var<uniform> params: LeavesParams;
@group(0) @binding(1) var<storage, read> order: array<u32>;
// Boxes of leaves, then of nodes: (lower corner, areas of all boxes below), (upper corner, –), and
// where blobs move both corners when the shutter closes.
@group(0) @binding(2) var<storage, read_write> boxes: array<vec4f>;

const LANES: u32 = 16u;
const LEAF_HEADER_WORDS: u32 = 2u;
const BLOB_WORDS: u32 = SHAPE_WORDS + RATE_WORDS;
const LEAF_WORDS: u32 = LEAF_HEADER_WORDS + LANES * BLOB_WORDS;
const LARGEST: f32 = 3.4028234e38;
// Roundings of a place that is reckoned in f32, relative to its parts: eight halves of 2⁻²³, doubled.
const PLACE_ROUNDING: f32 = 1e-6;

struct Box {
    low: vec3f,
    high: vec3f,
}

var<workgroup> lows: array<vec3f, WORKGROUP>;
var<workgroup> highs: array<vec3f, WORKGROUP>;
var<workgroup> steepnesses: array<f32, WORKGROUP>;

// The box around those of a leaf's lanes, in all of its lanes.
fn around(lane: u32, own: Box) -> Box {
    lows[lane] = own.low;
    highs[lane] = own.high;
    for (var step = LANES / 2u; step > 0u; step >>= 1u) {
        workgroupBarrier();
        if lane % LANES < step {
            lows[lane] = min(lows[lane], lows[lane + step]);
            highs[lane] = max(highs[lane], highs[lane + step]);
        }
    }
    workgroupBarrier();
    let first = lane - lane % LANES;
    let all = Box(lows[first] - vec3f(params.pad), highs[first] + vec3f(params.pad));
    workgroupBarrier();
    return all;
}

// |A|², no less than β along any ray.
fn steepness_of(at: u32) -> f32 {
    let first = bitcast<f32>(raw(at).w);
    if !ELLIPSOIDS {
        return first * first;
    }
    let rest = bitcast<vec4f>(raw(at + 1u));
    let last = bitcast<f32>(raw(at + 2u).x);
    return first * first + dot(rest, rest) + last * last;
}

// The support's box when the shutter opens (−1) or closes (1), such that those between hold it at all
// times between.
fn support_at(at: u32, center: vec3f, half: vec3f, end: f32) -> Box {
    if !MOVES {
        return Box(center - half, center + half);
    }
    let way = bitcast<vec3f>(raw(at + SHAPE_WORDS).xyz) * params.half_shutter_secs;
    let square = params.half_shutter_secs * params.half_shutter_secs;
    let bend = bitcast<vec3f>(raw(at + SHAPE_WORDS + 1u).xyz) * square;
    let there = center + way * end;
    let rounding = PLACE_ROUNDING * (abs(center) + abs(way) + abs(bend) + half);
    return Box(
        there + min(bend, vec3f(0.0)) - half - rounding,
        there + max(bend, vec3f(0.0)) + half + rounding,
    );
}

@compute @workgroup_size(WORKGROUP)
fn fit_leaves(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let slot = lane % LANES;
    let leaf = ((group.y * groups.x + group.x) * WORKGROUP + lane) / LANES;
    let place = leaf * LANES + slot;
    let is_blob = place < params.blobs;
    var at = 0u;
    var head = vec4u(0u);
    var open = Box(vec3f(LARGEST), vec3f(-LARGEST));
    var close = open;
    var steepness = 0.0;
    if is_blob {
        at = order[place] * RAW_WORDS;
        head = raw(at);
        let center = bitcast<vec3f>(head.xyz);
        let half = bitcast<vec3f>(raw(at + EXTENT_AT).xyz);
        open = support_at(at, center, half, -1.0);
        close = support_at(at, center, half, 1.0);
        steepness = steepness_of(at);
    }
    open = around(lane, open);
    if MOVES {
        close = around(lane, close);
    } else {
        close = open;
    }
    steepnesses[lane] = steepness;
    for (var step = LANES / 2u; step > 0u; step >>= 1u) {
        workgroupBarrier();
        if slot < step {
            steepnesses[lane] = max(steepnesses[lane], steepnesses[lane + step]);
        }
    }
    workgroupBarrier();
    if leaf >= params.leaves {
        return;
    }
    let low = min(open.low, close.low);
    let high = max(open.high, close.high);
    let center = (low + high) * 0.5;
    let first = params.leaves_at + leaf * LEAF_WORDS;
    if slot == 0u {
        let size = high - low;
        let extent = max(max(size.x, size.y), max(size.z, params.least_extent));
        let finest = params.finest_part / extent;
        let limit = finest * finest;
        let fine_beta = select(LARGEST, limit, steepnesses[lane] >= limit);
        let blobs = min(params.blobs - leaf * LANES, LANES);
        put(first, vec4u(bitcast<vec3u>(center), blobs));
        put(first + 1u, vec4u(bitcast<u32>(fine_beta), 0u, 0u, 0u));
        let box_at = leaf * BOX_WORDS;
        boxes[box_at] = vec4f(open.low, 0.0);
        boxes[box_at + 1u] = vec4f(open.high, 0.0);
        if MOVES {
            boxes[box_at + 2u] = vec4f(close.low, 0.0);
            boxes[box_at + 3u] = vec4f(close.high, 0.0);
        }
    }
    if is_blob {
        let to = first + LEAF_HEADER_WORDS + slot * BLOB_WORDS;
        var offset = bitcast<vec3f>(head.xyz) - center;
        if MOVES {
            // What one f32 could not hold of the place.
            offset += bitcast<vec3f>(raw(at + EXTENT_AT + 1u).xyz);
        }
        put(to, vec4u(bitcast<vec3u>(offset), head.w));
        for (var word = 1u; word < BLOB_WORDS; word++) {
            put(to + word, raw(at + word));
        }
    }
}
