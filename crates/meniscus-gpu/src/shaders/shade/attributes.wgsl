// Particles' attributes blended by their part in the field, where the looks of this field's surface follow
// them: at the answers, and along ways through it. Twin of shade/attributes.rs and the rest of
// World::coefficients.

// f32 in bits, COLUMNS for each particle.
@group(0) @binding(13) var<storage, read> columns: array<u32>;

// A sum of weights this much smaller than the sum of their sizes has too few digits.
const CANCELLED: f32 = 1e-4;
// By how much boxes are wider, for rounding, in coordinates.
const BOX_ROUNDING: f32 = 1e-6;
// Points along a way through a medium at which its absorption is looked at.
const ABSORPTION_STEPS: u32 = 8u;

var<private> pending: array<u32, STACK>;
// Of each column: sums of weighted numbers and weights, then the same by the sizes of the weights.
var<private> parts: array<vec4f, COLUMNS>;
var<private> is_sure: bool;

fn add_leaf(reference: u32, point: TwoVec3) {
    let first = params.leaves_at + (reference & ~LEAF) * LEAF_WORDS;
    let header = heap(first);
    let from_center = two_sum(point.high, -bitcast<vec3f>(header.xyz));
    let local = from_center.high + (from_center.low + point.low);
    for (var lane = 0u; lane < header.w; lane++) {
        let at = first + LEAF_HEADER_WORDS + lane * BLOB_WORDS;
        let head = heap(at);
        let y = blob_transform(at, head, local - blob_center(at, head));
        let g = 1.0 - dot(y, y);
        if !(g > 0.0) {
            continue;
        }
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
}

// Sums up all blobs that reach a local point.
fn gather_parts(point: TwoVec3) {
    for (var column = 0u; column < COLUMNS; column++) {
        parts[column] = vec4f(0.0);
    }
    let margin = BOX_ROUNDING * size_of(point.high);
    let lower = point.high - margin;
    let upper = point.high + margin;
    pending[0] = 0u;
    var height = 1u;
    while height > 0u {
        height--;
        let reference = pending[height];
        if (reference & LEAF) != 0u {
            add_leaf(reference, point);
            continue;
        }
        let node = reference * NODE_WORDS;
        for (var half = 0u; half < 2u; half++) {
            let children = heap(node + CHILDREN_AT + half);
            if children.x == NONE {
                break;
            }
            var holds = vec4<bool>(true);
            for (var axis = 0u; axis < 3u; axis++) {
                holds &= bounds_at(node, axis * 2u + half) <= vec4f(upper[axis]);
                holds &= bounds_at(node, axis * 2u + 6u + half) >= vec4f(lower[axis]);
            }
            for (var slot = 0u; slot < 4u; slot++) {
                if children[slot] == NONE || !holds[slot] {
                    continue;
                }
                if height == STACK {
                    is_sure = false;
                    return;
                }
                pending[height] = children[slot];
                height++;
            }
        }
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

// Where the field stands at the question's time, if it has a way.
var<private> placement: Placement;

// A point in the field's space, from one in the stages'.
fn in_field(high: vec3f, low: vec3f) -> TwoVec3 {
    if way_of(field_place.surface).y > 0u {
        return point_in_object(placement, TwoVec3(high, low));
    }
    let moved = two_sum(high, -field_place.offset);
    return two_sum(moved.high, moved.low + (low - field_place.offset_low));
}

fn look_at(place: u32, sources: u32) {
    let answer = answers[place];
    gather_parts(in_field(answer.position, answer.position_low));
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
            gather_parts(in_field(point.high, point.low + question.origin_low));
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
    let time = clamp(question.time, field_place.open, field_place.close);
    ray.since_middle_secs = time - 0.5 * (field_place.open + field_place.close);
    ray.elapsed = 0.0;
    if field_place.close > field_place.open {
        ray.elapsed = (time - field_place.open) / (field_place.close - field_place.open);
    }
    let way = way_of(field_place.surface);
    if way.y > 0u {
        placement = placement_at(way, question.time);
    }
    let sources = material_word(field_place.surface) + 5u;
    let own = material_of(field_place.surface);
    is_sure = true;
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
    // As in intersect/hit.wgsl.
    var rounds = 0u;
    for (var i = 0u; i < params.capacity; i++) {
        rounds++;
    }
    if !is_sure || rounds != params.capacity {
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
