// Looks that follow particles' attributes, as stages/attributes left them for a question's answer: twin of
// World::look and World::coefficients.

struct Look {
    color: vec3f,
    roughness: f32,
    // At the answer.
    absorption: vec3f,
    // Mean along the way there through what fills the place.
    along: vec3f,
}

// In the place of rays, which integrators do not read.
@group(0) @binding(8) var<storage, read_write> looks: array<Look>;

// The material of the surface that a question met.
fn material_at(place: u32) -> Material {
    var material = material_of(answers[place].surface);
    if (material.varies & LOOK_VARIES) != 0u {
        material.color = looks[place].color;
        material.roughness = looks[place].roughness;
    }
    if (material.varies & ABSORPTION_VARIES) != 0u {
        material.absorption = looks[place].absorption;
    }
    return material;
}
