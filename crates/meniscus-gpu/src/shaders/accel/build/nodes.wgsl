// Nodes over eight nodes or leaves that follow each other, level by level from below: twin of
// accel/particles/fit.rs.

struct NodesParams {
    // Nodes of this level.
    count: u32,
    // The first of them.
    first: u32,
    // Items of the level below, and the reference of the first of them.
    below: u32,
    below_reference: u32,
    // The boxes of the first item below, and of the first node here.
    below_boxes: u32,
    boxes_at: u32,
}

@group(0) @binding(0) var<uniform> params: NodesParams;
@group(0) @binding(1) var<storage, read_write> boxes: array<vec4f>;

const NONE: u32 = 0xffffffffu;
const CHILDREN_AT: u32 = 12u;
const CLOSING_AT: u32 = CHILDREN_AT + 2u;
const NODE_WORDS: u32 = CLOSING_AT + select(0u, CHILDREN_AT, MOVES);
const LARGEST: f32 = 3.4028234e38;

fn half_area(low: vec3f, high: vec3f) -> f32 {
    let size = high - low;
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

// Writes the boxes of a node's children at one end of the shutter, and its own.
fn fit_node(index: u32, corner: u32, to: u32) {
    var all_low = vec3f(LARGEST);
    var all_high = vec3f(-LARGEST);
    var areas = 0.0;
    for (var half = 0u; half < 2u; half++) {
        var x = array<vec4f, 2>();
        var y = array<vec4f, 2>();
        var z = array<vec4f, 2>();
        for (var slot = 0u; slot < 4u; slot++) {
            let child = index * 8u + half * 4u + slot;
            if child >= params.below {
                break;
            }
            let at = (params.below_boxes + child) * BOX_WORDS + corner;
            let low = boxes[at];
            let high = boxes[at + 1u].xyz;
            x[0][slot] = low.x;
            y[0][slot] = low.y;
            z[0][slot] = low.z;
            x[1][slot] = high.x;
            y[1][slot] = high.y;
            z[1][slot] = high.z;
            all_low = min(all_low, low.xyz);
            all_high = max(all_high, high);
            areas += half_area(low.xyz, high) + low.w;
        }
        for (var side = 0u; side < 2u; side++) {
            put(to + side * 6u + half, bitcast<vec4u>(x[side]));
            put(to + side * 6u + 2u + half, bitcast<vec4u>(y[side]));
            put(to + side * 6u + 4u + half, bitcast<vec4u>(z[side]));
        }
    }
    let own = (params.boxes_at + index) * BOX_WORDS + corner;
    boxes[own] = vec4f(all_low, areas);
    boxes[own + 1u] = vec4f(all_high, 0.0);
}

@compute @workgroup_size(WORKGROUP)
fn fit_nodes(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = (group.y * groups.x + group.x) * WORKGROUP + lane;
    if index >= params.count {
        return;
    }
    let at = (params.first + index) * NODE_WORDS;
    fit_node(index, 0u, at);
    if MOVES {
        fit_node(index, 2u, at + CLOSING_AT);
    }
    for (var half = 0u; half < 2u; half++) {
        var children = vec4u(NONE);
        for (var slot = 0u; slot < 4u; slot++) {
            let child = index * 8u + half * 4u + slot;
            if child < params.below {
                children[slot] = params.below_reference + child;
            }
        }
        put(at + CHILDREN_AT + half, children);
    }
}
