// Blobs that keep their shapes.

fn blob_turned(at: u32, d: vec3f) -> vec3f {
    return d;
}

fn blob_turned_back(at: u32, y: vec3f) -> vec3f {
    return y;
}

fn blob_gradient(at: u32) -> mat3x3f {
    return mat3x3f();
}
