// Places along a Hilbert curve (Skilling 2004), two octaves of size parted first: twin of
// accel/particles/curve.rs, with a curve whose neighbours always touch. Sixteen blobs that follow each
// other become a leaf wherever they lie, and a Morton curve jumps.

struct CurveParams {
    low: vec3f,
    // Cells per length.
    scale: f32,
    blobs: u32,
}

@group(0) @binding(0) var<uniform> params: CurveParams;
@group(0) @binding(1) var<storage, read_write> codes: array<vec2u>;
@group(0) @binding(2) var<storage, read_write> order: array<u32>;

// Bits per axis: 57 for the place, above them six of the class.
const BITS: u32 = 19u;
const LOW_BITS: u32 = 10u;

// Bit i of the lowest 10 to bit 3i.
fn spread(bits: u32) -> u32 {
    var x = bits & 0x3ffu;
    x = (x | (x << 16u)) & 0x030000ffu;
    x = (x | (x << 8u)) & 0x0300f00fu;
    x = (x | (x << 4u)) & 0x030c30c3u;
    return (x | (x << 2u)) & 0x09249249u;
}

fn interleaved(x: u32, y: u32, z: u32) -> u32 {
    return (spread(x) << 2u) | (spread(y) << 1u) | spread(z);
}

// The coordinates whose bits in turn are the place along the curve.
fn along_curve(cell: vec3u) -> vec3u {
    var x = cell.x;
    var y = cell.y;
    var z = cell.z;
    for (var bit = 1u << (BITS - 1u); bit > 1u; bit >>= 1u) {
        let below = bit - 1u;
        if (x & bit) != 0u {
            x ^= below;
        }
        if (y & bit) != 0u {
            x ^= below;
        } else {
            let swap = (x ^ y) & below;
            x ^= swap;
            y ^= swap;
        }
        if (z & bit) != 0u {
            x ^= below;
        } else {
            let swap = (x ^ z) & below;
            x ^= swap;
            z ^= swap;
        }
    }
    y ^= x;
    z ^= y;
    var turned = 0u;
    for (var bit = 1u << (BITS - 1u); bit > 1u; bit >>= 1u) {
        if (z & bit) != 0u {
            turned ^= bit - 1u;
        }
    }
    return vec3u(x, y, z) ^ vec3u(turned);
}

@compute @workgroup_size(WORKGROUP)
fn place(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = (group.y * groups.x + group.x) * WORKGROUP + lane;
    if index >= params.blobs {
        return;
    }
    let at = index * RAW_WORDS;
    let center = bitcast<vec3f>(raw(at).xyz);
    let size_class = raw(at + EXTENT_AT).w;
    let last = (1u << BITS) - 1u;
    let cell = min(vec3u(max((center - params.low) * params.scale, vec3f(0.0))), vec3u(last));
    let axes = along_curve(cell);
    let low = interleaved(axes.x, axes.y, axes.z);
    let upper = axes >> vec3u(LOW_BITS);
    let high = interleaved(upper.x, upper.y, upper.z);
    codes[index] = vec2u(low | (high << 30u), (high >> 2u) | (size_class << 25u));
    order[index] = index;
}
