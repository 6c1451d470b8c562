// Blobs that move while the shutter is open, p + (v + a′s)s with s seconds after its middle: twin of
// intersect/particles/pool.rs and accel/particles/frontier.rs. Two more words: (v, –), (a′, –).

const CLOSING_WORDS: u32 = 12u;

fn blob_center(at: u32, head: vec4u) -> vec3f {
    let velocity = bitcast<vec3f>(heap(at + SHAPE_WORDS).xyz);
    let half_acceleration = bitcast<vec3f>(heap(at + SHAPE_WORDS + 1u).xyz);
    let secs = ray.since_middle_secs;
    return bitcast<vec3f>(head.xyz) + (velocity + half_acceleration * secs) * secs;
}

fn blob_velocity(at: u32) -> vec3f {
    let velocity = bitcast<vec3f>(heap(at + SHAPE_WORDS).xyz);
    let half_acceleration = bitcast<vec3f>(heap(at + SHAPE_WORDS + 1u).xyz);
    return velocity + half_acceleration * (2.0 * ray.since_middle_secs);
}

// One of the six bounds of four children at the ray's time, from those when the shutter opens and
// closes.
fn bounds_at(node: u32, row: u32) -> vec4f {
    let open = bitcast<vec4f>(heap(node + row));
    let close = bitcast<vec4f>(heap(node + CHILDREN_AT + 2u + row));
    return (close - open) * ray.elapsed + open;
}
