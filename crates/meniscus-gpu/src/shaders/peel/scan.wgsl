// Where each group's pairs begin: the running sum of their counts.

@group(0) @binding(8) var<storage, read_write> starts: array<u32>;
@group(0) @binding(11) var<storage, read> counts: array<u32>;
// Vertices, instances, first vertex, first instance: all pairs that there is room for.
@group(0) @binding(16) var<storage, read_write> drawing: array<u32>;

const LANES: u32 = 256u;

var<workgroup> sums: array<u32, LANES>;

@compute @workgroup_size(LANES)
fn scan(@builtin(local_invocation_index) lane: u32) {
    let each = (params.groups + LANES - 1u) / LANES;
    let first = min(lane * each, params.groups);
    let last = min(first + each, params.groups);
    var sum = 0u;
    for (var group = first; group < last; group++) {
        sum += counts[group];
    }
    sums[lane] = sum;
    workgroupBarrier();
    var before = 0u;
    for (var other = 0u; other < lane; other++) {
        before += sums[other];
    }
    for (var group = first; group < last; group++) {
        starts[group] = before;
        before += counts[group];
    }
    if lane == LANES - 1u {
        starts[params.groups] = before;
        drawing[0] = 6u;
        drawing[1] = min(before, params.pairs);
        drawing[2] = 0u;
        drawing[3] = 0u;
    }
}
