// Blobs that stand still.

const CLOSING_WORDS: u32 = 0u;

fn blob_center(at: u32, head: vec4u) -> vec3f {
    return bitcast<vec3f>(head.xyz);
}

// One of the six bounds of four children.
fn bounds_at(node: u32, row: u32) -> vec4f {
    return bitcast<vec4f>(heap(node + row));
}

fn blob_velocity(at: u32) -> vec3f {
    return vec3f(0.0);
}
