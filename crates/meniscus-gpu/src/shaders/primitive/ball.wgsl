// The ball: A = I/R; twin of primitive/ball.rs. Its words: (x, y, z, 1/R), (weight, index, –, –).

const SHAPE_WORDS: u32 = 2u;

fn blob_along(at: u32, head: vec4u, w: vec3f, d: vec3f) -> AlongLine {
    let a = bitcast<f32>(head.w);
    let beta = a * a;
    let c = dot(w, d);
    // The perpendicular vector: |w|² − c² would cancel.
    let e = w - c * d;
    return AlongLine(c, beta, 1.0 - beta * dot(e, e));
}

fn blob_weight(at: u32) -> f32 {
    return bitcast<f32>(heap(at + 1u).x);
}

fn blob_index(at: u32) -> u32 {
    return heap(at + 1u).y;
}

fn blob_transform(at: u32, head: vec4u, d: vec3f) -> vec3f {
    return d * bitcast<f32>(head.w);
}

fn blob_transform_transposed(at: u32, head: vec4u, y: vec3f) -> vec3f {
    return y * bitcast<f32>(head.w);
}
