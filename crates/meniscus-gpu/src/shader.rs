//! Shaders are put together from files, one per subject and named as their CPU twins; what varies is
//! which kernel, which primitive, whether blobs move, and some numbers in front.

use meniscus::kernel::Kernel;

/// Rays that one workgroup traces.
pub(crate) const WORKGROUP: u32 = 64;

/// What a shader is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ShaderKind {
    /// Kernel of the field.
    pub kernel: Kernel,
    /// Ellipsoids, else balls.
    pub ellipsoids: bool,
    /// Whether blobs move while the shutter is open.
    pub moves: bool,
    /// Storage buffers that hold the field.
    pub chunks: u32,
    /// Words (16 bytes) per full buffer, as a power of two.
    pub chunk_bits: u32,
    /// References that a ray may keep for later.
    pub stack: u32,
}

/// The formula of a kernel.
pub(crate) fn kernel_source(kernel: Kernel) -> &'static str {
    match kernel {
        Kernel::Quartic => include_str!("shaders/kernel/quartic.wgsl"),
        Kernel::Sextic => include_str!("shaders/kernel/sextic.wgsl"),
        Kernel::Octic => include_str!("shaders/kernel/octic.wgsl"),
        Kernel::Wyvill => include_str!("shaders/kernel/wyvill.wgsl"),
    }
}

/// The whole text of a tracing shader.
pub fn sources(kind: &ShaderKind) -> String {
    let kernel = kernel_source(kind.kernel);
    let primitive = match kind.ellipsoids {
        false => include_str!("shaders/primitive/ball.wgsl"),
        true => include_str!("shaders/primitive/ellipsoid.wgsl"),
    };
    let motion = match kind.moves {
        false => include_str!("shaders/field/still.wgsl"),
        true => include_str!("shaders/field/moving.wgsl"),
    };
    [
        &numbers(kind),
        &heap(kind.chunks, kind.chunk_bits),
        include_str!("shaders/math/two_floats.wgsl"),
        include_str!("shaders/field/blobs.wgsl"),
        kernel,
        primitive,
        motion,
        include_str!("shaders/accel/particles.wgsl"),
        include_str!("shaders/intersect/solve.wgsl"),
        include_str!("shaders/intersect/hit.wgsl"),
        include_str!("shaders/intersect/particles.wgsl"),
        include_str!("shaders/intersect/stretches.wgsl"),
    ]
    .join("\n")
}

fn numbers(kind: &ShaderKind) -> String {
    let stack = kind.stack;
    format!("const WORKGROUP: u32 = {WORKGROUP}u;\nconst STACK: u32 = {stack}u;\n")
}

/// First binding of the field's buffers.
pub(crate) const FIRST_CHUNK: u32 = 5;

/// The field as one array of words over several buffers, since a binding has a largest size.
fn heap(chunks: u32, chunk_bits: u32) -> String {
    let mut text = String::new();
    for chunk in 0..chunks {
        let binding = FIRST_CHUNK + chunk;
        text += &format!(
            "@group(0) @binding({binding}) var<storage, read> chunk{chunk}: array<vec4u>;\n"
        );
    }
    text += "\nfn heap(word: u32) -> vec4u {\n";
    if chunks == 1 {
        text += "    return chunk0[word];\n";
    } else {
        let mask = (1_u32 << chunk_bits) - 1;
        text += &format!("    let place = word & {mask}u;\n    switch word >> {chunk_bits}u {{\n");
        for chunk in 0..chunks - 1 {
            text += &format!("        case {chunk}u: {{ return chunk{chunk}[place]; }}\n");
        }
        text += &format!(
            "        default: {{ return chunk{}[place]; }}\n    }}\n",
            chunks - 1
        );
    }
    text += "}\n";
    text
}
