// The ellipsoid: q = |Ad|² with A upper triangular, behind what turns and stretches it; twin of primitive/ellipsoid.rs. Its words:
// (x, y, z, a00), (a01, a02, a11, a12), (a22, weight, index, –).

const SHAPE_WORDS: u32 = 3u;

fn blob_transform(at: u32, head: vec4u, given: vec3f) -> vec3f {
    let d = blob_turned(at, given);
    let a00 = bitcast<f32>(head.w);
    let rest = bitcast<vec4f>(heap(at + 1u));
    let a22 = bitcast<f32>(heap(at + 2u).x);
    return vec3f(
        a00 * d.x + rest.x * d.y + rest.y * d.z,
        rest.z * d.y + rest.w * d.z,
        a22 * d.z,
    );
}

fn blob_transform_transposed(at: u32, head: vec4u, y: vec3f) -> vec3f {
    let a00 = bitcast<f32>(head.w);
    let rest = bitcast<vec4f>(heap(at + 1u));
    let a22 = bitcast<f32>(heap(at + 2u).x);
    let pull = vec3f(
        a00 * y.x,
        rest.x * y.x + rest.z * y.y,
        rest.y * y.x + rest.w * y.y + a22 * y.z,
    );
    return blob_turned_back(at, pull);
}

fn blob_along(at: u32, head: vec4u, w: vec3f, d: vec3f) -> AlongLine {
    let y = blob_transform(at, head, w);
    let v = blob_transform(at, head, d);
    let beta = dot(v, v);
    let c = dot(y, v) / beta;
    let e = y - c * v;
    return AlongLine(c, beta, 1.0 - dot(e, e));
}

fn blob_weight(at: u32) -> f32 {
    return bitcast<f32>(heap(at + 2u).y);
}

fn blob_index(at: u32) -> u32 {
    return heap(at + 2u).z;
}
