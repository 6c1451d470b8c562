// Which clear media a ray is in: twin of shade/medium.rs. A stack names surfaces by four bits each (number
// + 1), the first entered lowest.

const MEDIA: u32 = 8u;

fn medium(stack: u32, place: u32) -> u32 {
    return (stack >> (4u * place)) & 15u;
}

// The stack behind a clear surface.
fn crossed(stack: u32, surface: u32, is_entering: bool) -> u32 {
    let name = surface + 1u;
    for (var place = 0u; place < MEDIA; place++) {
        let here = medium(stack, place);
        if here == name {
            if is_entering {
                return stack;
            }
            let below = stack & ((1u << (4u * place)) - 1u);
            // A shift by 32 bits is none.
            let above = select((stack >> (4u * place + 4u)) << (4u * place), 0u, place == MEDIA - 1u);
            return below | above;
        }
        if here == 0u {
            return select(stack, stack | (name << (4u * place)), is_entering);
        }
    }
    return stack;
}

// The surface whose medium fills the place; NONE: none.
fn filling(stack: u32) -> u32 {
    var best = NONE;
    var priority = 0.0;
    for (var place = 0u; place < MEDIA; place++) {
        let here = medium(stack, place);
        if here == 0u {
            break;
        }
        let own = material_of(here - 1u).priority;
        if best == NONE || own > priority {
            best = here - 1u;
            priority = own;
        }
    }
    return best;
}

fn ior_in(stack: u32) -> f32 {
    let surface = filling(stack);
    if surface == NONE {
        return 1.0;
    }
    return material_of(surface).ior;
}

// Radiance of a light over what it is transported as.
fn emission_scale(stack: u32) -> f32 {
    let ior = ior_in(stack);
    return 1.0 / (ior * ior);
}

// What is left of light behind a question's way through what fills the place (Beer and Lambert).
fn absorbed(place: u32, stack: u32, distance: f32) -> vec3f {
    let surface = filling(stack);
    if surface == NONE {
        return vec3f(1.0);
    }
    let material = material_of(surface);
    var coefficients = material.absorption;
    if (material.varies & ABSORPTION_VARIES) != 0u {
        coefficients = looks[place].along;
    }
    let left = exp(-coefficients * distance);
    return select(vec3f(1.0), left, coefficients > vec3f(0.0));
}
