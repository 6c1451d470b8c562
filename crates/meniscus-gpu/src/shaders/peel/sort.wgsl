// Sorts each group's pairs by the least distance from the eye, then by ball, so that what comes first
// does not depend on which thread was first. A bitonic network for any number: places behind the end count
// as larger than all, and every exchange goes upwards.

@group(0) @binding(7) var<storage, read_write> pairs: array<vec2u>;
@group(0) @binding(8) var<storage, read> starts: array<u32>;

const LANES: u32 = 256u;

var<workgroup> span: vec2u;

fn comes_before(a: vec2u, b: vec2u) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

fn exchange(first: u32, count: u32, lane: u32, mask: u32) {
    for (var i = lane; i < count; i += LANES) {
        let partner = i ^ mask;
        if partner > i && partner < count {
            let low = pairs[first + i];
            let high = pairs[first + partner];
            if comes_before(high, low) {
                pairs[first + i] = high;
                pairs[first + partner] = low;
            }
        }
    }
}

@compute @workgroup_size(LANES)
fn sort(@builtin(workgroup_id) id: vec3u, @builtin(num_workgroups) many: vec3u,
    @builtin(local_invocation_index) lane: u32) {
    if lane == 0u {
        let group = min(id.y * many.x + id.x, params.groups - 1u);
        let is_here = id.y * many.x + id.x < params.groups;
        let end = min(starts[group + 1u], params.pairs);
        let first = min(starts[group], params.pairs);
        span = vec2u(first, select(0u, end - first, is_here));
    }
    let sorted = workgroupUniformLoad(&span);
    for (var side = 2u; side < 2u * sorted.y; side <<= 1u) {
        exchange(sorted.x, sorted.y, lane, side - 1u);
        storageBarrier();
        for (var step = side >> 2u; step > 0u; step >>= 1u) {
            exchange(sorted.x, sorted.y, lane, step);
            storageBarrier();
        }
    }
}
