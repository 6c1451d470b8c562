// Particles' attributes blended by their part in the field, where the looks of this field's surface follow
// them: at the answers, and along ways through it. Twin of shade/attributes.rs and the rest of
// World::coefficients.

// f32 in bits, COLUMNS for each particle.
@group(0) @binding(13) var<storage, read> columns: array<u32>;

// A sum of weights this much smaller than the sum of their sizes has too few digits.
const CANCELLED: f32 = 1e-4;
// Points along a way through a medium at which its absorption is looked at.
const ABSORPTION_STEPS: u32 = 8u;

// Of each column: sums of weighted numbers and weights, then the same by the sizes of the weights.
var<private> parts: array<vec4f, COLUMNS>;

fn add_blob(at: u32, head: vec4u, d: vec3f, y: vec3f, g: f32) {
    let weight = blob_weight(at) * kernel_of_g(vec4f(g)).x;
    let numbers = blob_index(at) * COLUMNS;
    for (var column = 0u; column < COLUMNS; column++) {
        let bits = columns[numbers + column];
        if bits != NO_NUMBER {
            let value = bitcast<f32>(bits);
            parts[column] += vec4f(weight * value, weight, abs(weight) * value, abs(weight));
        }
    }
}

fn forget_parts() {
    for (var column = 0u; column < COLUMNS; column++) {
        parts[column] = vec4f(0.0);
    }
}

// A column's number at the point that was gathered last.
fn blended(column: u32) -> f32 {
    let sums = parts[column];
    if sums.w == 0.0 {
        return 0.0;
    }
    is_sure = is_sure && abs(sums.y) > CANCELLED * sums.w;
    return sums.x / sums.y;
}

// The number of a source: (first column, number of columns, –, –).
fn number_of_source(source: vec4f) -> f32 {
    let first = u32(source.x);
    let total = u32(source.y);
    if total == 1u {
        return blended(first);
    }
    var sum = 0.0;
    for (var i = 0u; i < total; i++) {
        let part = blended(first + i);
        sum += part * part;
    }
    return sqrt(sum);
}

// The colour of a source: its kind and its map's table in `kind`.
fn color_of(kind: vec2f, source: vec4f, constant: vec3f) -> vec3f {
    if kind.x == 0.0 {
        return constant;
    }
    let first = u32(source.x);
    if kind.x == 2.0 {
        return vec3f(blended(first), blended(first + 1u), blended(first + 2u));
    }
    var t = 0.5;
    if source.w > source.z {
        t = (number_of_source(source) - source.z) / (source.w - source.z);
    }
    let position = clamp(t, 0.0, 1.0) * f32(MAP_ENTRIES - 1u);
    let below = min(u32(position), MAP_ENTRIES - 2u);
    let table = u32(kind.y) + below;
    return mix(words[table].xyz, words[table + 1u].xyz, position - f32(below));
}

// Absorption at the point that was gathered last, per world unit.
fn coefficients(sources: u32) -> vec3f {
    let depth = words[sources + 5u];
    let left = color_of(words[sources].zw, words[sources + 3u], depth.xyz);
    let density = words[sources + 4u];
    var scale = 1.0;
    if density.y > 0.0 {
        scale = max((number_of_source(density) - density.z) / (density.w - density.z), 0.0);
    }
    return -log(clamp(left, vec3f(1e-6), vec3f(1.0))) / depth.w * scale;
}

fn look_at(place: u32, sources: u32) {
    let answer = answers[place];
    forget_parts();
    gather(in_field(answer.position, answer.position_low));
    let material = material_of(field_place.surface);
    var look = Look(material.color, material.roughness, material.absorption, vec3f(0.0));
    look.color = color_of(words[sources].xy, words[sources + 1u], material.color);
    let roughness = words[sources + 2u];
    if roughness.y > 0.0 {
        let t = (number_of_source(roughness) - roughness.z) / (roughness.w - roughness.z);
        look.roughness = clamp(t, 0.0, 1.0);
    }
    if (material.varies & ABSORPTION_VARIES) != 0u {
        look.absorption = coefficients(sources);
    }
    looks[place].color = look.color;
    looks[place].roughness = look.roughness;
    looks[place].absorption = look.absorption;
}

// Mean absorption along a question's way of a length.
fn look_along(place: u32, sources: u32, distance: f32) {
    var sum = vec3f(0.0);
    if !is_far(distance) {
        let question = questions[place];
        for (var step = 0u; step < ABSORPTION_STEPS; step++) {
            let along = distance * (f32(step) + 0.5) / f32(ABSORPTION_STEPS);
            let point = two_sum(question.origin, question.direction * along);
            forget_parts();
            gather(in_field(point.high, point.low + question.origin_low));
            sum += coefficients(sources);
        }
    }
    looks[place].along = sum / f32(ABSORPTION_STEPS);
}

// Looks at one of a sample's answers. Lamps end ways but those towards a light.
fn look(place: u32, media: u32, meets_lamps: bool) {
    let question = questions[place];
    let answer = answers[place];
    if (question.flags & IS_ASKED) == 0u || answer.is_in_doubt != 0u {
        return;
    }
    stand_at(question.time);
    let sources = material_word(field_place.surface) + 5u;
    let own = material_of(field_place.surface);
    if answer.surface == field_place.surface {
        look_at(place, sources);
    }
    let absorbs = (own.varies & ABSORPTION_VARIES) != 0u;
    if absorbs && filling(media) == field_place.surface {
        var end = select(question.t_max, answer.t, answer.surface != NONE);
        if meets_lamps {
            end = light_met(question.origin, question.direction, end).t;
        }
        look_along(place, sources, end);
    }
    if !is_sure || !is_whole() {
        answers[place].is_in_doubt = 1u;
    }
}

@compute @workgroup_size(WORKGROUP)
fn attributes(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if index >= picture.count {
        return;
    }
    look(index, states[index].media, true);
    // What stands before a light matters only where light may go on through it.
    if picture.light_walks != 0u || answers[lights_at() + index].surface == NONE {
        look(lights_at() + index, states[index].light_media, false);
    }
}
