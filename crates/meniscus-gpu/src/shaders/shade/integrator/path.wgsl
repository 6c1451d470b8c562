// Integrator `path`: twin of shade/integrator/path.rs. In each round a sample hears of its next surface and
// of what stands before the light that it drew at the last one. A state's phase counts boundaries that are
// none.

const DRAWS: u32 = 5u;
const LIGHT_DRAW: u32 = 0u;
const CHOICE_DRAW: u32 = 2u;
const SURVIVAL_DRAW: u32 = 3u;
const DIRECTION_DRAW: u32 = 4u;
const SURE_SURFACES: u32 = 4u;
const MOST_SURVIVAL: f32 = 0.95;
const BLURRED_ROUGHNESS: f32 = 0.5;
const MAX_FALSE_BOUNDARIES: u32 = 256u;
const MAX_SHEETS: u32 = 256u;
const WIDENS_MIRRORS: bool = true;

fn power_heuristic(density: f32, other: f32) -> f32 {
    if is_far(density) {
        return 1.0;
    }
    let ratio = other / density;
    return 1.0 / (1.0 + ratio * ratio);
}

fn add(state: ptr<function, State>, radiance: vec3f) {
    (*state).radiance += clamped((*state).throughput * radiance, (*state).surfaces > 1u);
}

// Adds a light that the path ran into.
fn add_found(state: ptr<function, State>, emitter: Emitter, radiance: vec3f, direction: vec3f) {
    var weight = 1.0;
    if is_far((*state).density) {
        let is_left_out = picture.has_caustics == 0u && has(*state, IS_SPREAD) && is_drawn(emitter);
        weight = select(1.0, 0.0, is_left_out);
    } else {
        let other = drawn_density(emitter, (*state).scattered_at, direction);
        weight = power_heuristic((*state).density, other);
    }
    add(state, radiance * (weight * emission_scale((*state).media)));
}

// Adds what surrounds the scene.
fn add_escaped(state: ptr<function, State>, direction: vec3f) {
    let is_first = (*state).surfaces + (*state).sheets == 0u;
    if is_first && picture.background != BACKGROUND_SKY {
        return;
    }
    for (var i = 0u; i < picture.emitter_count; i++) {
        let emitter = emitter_of(i);
        let radiance = escaped(emitter, direction);
        if any(radiance != vec3f(0.0)) {
            add_found(state, emitter, radiance, direction);
        }
    }
    let shows_default_sky = picture.background == BACKGROUND_SKY && picture.has_surroundings == 0u;
    if shows_default_sky && !has(*state, IS_SPREAD) {
        add(state, backdrop(direction));
    }
}

// Draws a light and asks what stands before it.
fn ask_light(index: u32, state: ptr<function, State>, answer: Answer, point: Point, beyond: u32, first: u32) {
    if !is_spread(point.bsdf) {
        return;
    }
    let sampler = PixelSampler((*state).seed, (*state).index);
    let choice = draw_1d(sampler, first + LIGHT_DRAW);
    let drawn = draw_light(answer.position, choice, draw_2d(sampler, first + LIGHT_DRAW + 1u));
    let light = drawn.sample;
    if !light.is_there {
        return;
    }
    let local = to_local(point, light.towards);
    let on_viewers_side = local.z > 0.0;
    let is_lit_from_there = on_viewers_side || is_two_sided(point.bsdf);
    if !(is_lit_from_there && agrees(answer, light.towards, on_viewers_side)) {
        return;
    }
    let scattered = bsdf_evaluate(point.bsdf, point.view, local);
    if all(scattered == vec3f(0.0)) {
        return;
    }
    count(COUNT_SHADOW);
    let straight = picture.has_caustics == 0u && is_drawn(emitter_of(drawn.emitter));
    (*state).pending = (*state).throughput * scattered * light.weight;
    (*state).light_weight = power_heuristic(light.density, bsdf_density(point.bsdf, point.view, local));
    (*state).light_media = select(beyond, (*state).media, on_viewers_side);
    (*state).flags &= ~(LIGHT_CLAMPS | LIGHT_STRAIGHT | LIGHT_WENT_THROUGH | (0xffffu << CROSSINGS_SHIFT));
    (*state).flags |= select(0u, LIGHT_CLAMPS, (*state).surfaces > 1u) | select(0u, LIGHT_STRAIGHT, straight);
    questions[lights_at() + index] =
        leaving(answer, light.towards, light.distance, on_viewers_side, questions[index].time);
}

// Sends the path on in a drawn direction, if it survives.
fn turn(
    index: u32,
    state: ptr<function, State>,
    answer: Answer,
    point: Point,
    sample: BsdfSample,
    beyond: u32,
    first: u32,
) -> bool {
    (*state).throughput *= sample.weight;
    let largest = max(max((*state).throughput.x, (*state).throughput.y), (*state).throughput.z);
    if !sample.is_there || largest <= 0.0 {
        return false;
    }
    let limits = vec3u(picture.diffuse_depth, picture.glossy_depth, picture.transmission_depth);
    let kind = sample.scattering;
    (*state).kinds[kind] += 1u;
    (*state).flags &= ~IS_LAST;
    if (*state).surfaces >= picture.depth || (*state).kinds[kind] > limits[kind] {
        (*state).flags |= IS_LAST;
    }
    if (*state).surfaces >= SURE_SURFACES {
        let probability = min(largest, MOST_SURVIVAL);
        let sampler = PixelSampler((*state).seed, (*state).index);
        if draw_1d(sampler, first + SURVIVAL_DRAW) >= probability {
            return false;
        }
        (*state).throughput /= probability;
    }
    let on_viewers_side = sample.light.z > 0.0;
    if !on_viewers_side {
        (*state).media = beyond;
    }
    let direction = to_world(point, sample.light);
    if !agrees(answer, direction, on_viewers_side) {
        return false;
    }
    (*state).scattered_at = answer.position;
    (*state).density = sample.density;
    if !is_far(sample.density) {
        (*state).flags |= IS_SPREAD;
    }
    switch sample.scattering {
        case SCATTERED: { count(COUNT_DIFFUSE); }
        case REFLECTED: { count(COUNT_REFLECTION); }
        default: { count(COUNT_REFRACTION); }
    }
    // A lobe counts as a mirror, and what is spread over the hemisphere has no footprint.
    if antialiases() {
        var behind_it = no_differential();
        if sample.scattering == REFLECTED || (sample.scattering == REFRACTED && point.bsdf.kind == CLEAR) {
            let is_refracted = sample.scattering == REFRACTED;
            behind_it = differential_behind(index, point, is_refracted, point.bsdf.eta);
        }
        differentials[index] = behind_it;
    }
    questions[index] = leaving(answer, direction, FAR, on_viewers_side, questions[index].time);
    return true;
}

// Sends the path on straight through a thin sheet, or mirrored.
fn meet_sheet(
    index: u32,
    state: ptr<function, State>,
    answer: Answer,
    point: Point,
    sheet: Sheet,
    first: u32,
) -> bool {
    var sample = sheet_through(sheet, point.view);
    if !has(*state, IS_LAST) {
        let sampler = PixelSampler((*state).seed, (*state).index);
        sample = sheet_sample(sheet, point.view, draw_1d(sampler, first + CHOICE_DRAW));
    }
    if sample.scattering == REFLECTED {
        (*state).surfaces += 1u;
        return turn(index, state, answer, point, sample, (*state).media, first);
    }
    (*state).throughput *= sample.weight;
    questions[index] = passed(questions[index], answer, FAR);
    advance_differential(index, answer.t);
    (*state).sheets += 1u;
    count(COUNT_REFRACTION);
    return (*state).sheets <= MAX_SHEETS && any((*state).throughput > vec3f(0.0));
}

// Goes on from the answer to the last question; false where the path ends.
fn advance(index: u32, state: ptr<function, State>) -> bool {
    let question = questions[index];
    let answer = answers[index];
    let direction = question.direction;
    let is_hit = answer.surface != NONE;
    let end = select(FAR, answer.t, is_hit);
    let lamp = light_met(question.origin, direction, end);
    (*state).throughput *= absorbed(index, (*state).media, lamp.t);
    if lamp.emitter != NONE {
        let emitter = emitter_of(lamp.emitter);
        add_found(state, emitter, emitter.radiance, direction);
        (*state).flags |= IS_COVERED;
        return false;
    }
    if !is_hit {
        add_escaped(state, direction);
        return false;
    }
    (*state).flags |= IS_COVERED;
    let material = material_at(index);
    let contact = contact_of(answer, material, (*state).media, question.origin);
    if contact.is_in_doubt {
        (*state).flags |= IN_DOUBT;
        return false;
    }
    if !contact.is_boundary {
        (*state).phase += 1u;
        (*state).media = contact.beyond;
        questions[index] = passed(question, answer, FAR);
        advance_differential(index, answer.t);
        return (*state).phase <= MAX_FALSE_BOUNDARIES;
    }
    if !has(*state, HAS_FIRST) {
        (*state).flags |= HAS_FIRST;
        let opacity = remember_first(index, answer, direction);
        if opacity == 0.0 && picture.background != BACKGROUND_TRANSPARENT {
            return false;
        }
    } else {
        let opacity = opacity_of(answer.surface, answer.position);
        if opacity < 1.0 {
            add(state, surroundings(direction) * (1.0 - opacity));
            (*state).throughput *= opacity;
        }
        if opacity <= 0.0 {
            return false;
        }
    }
    let is_blurred = has(*state, IS_SPREAD) && picture.has_caustics == 0u;
    let indices = vec2f(ior_in((*state).media), ior_in(contact.beyond));
    let point = point_of(index, answer, material, select(0.0, BLURRED_ROUGHNESS, is_blurred), indices);
    let first = 1u + ((*state).surfaces + (*state).sheets) * DRAWS;
    if material.scattering == SHEET {
        let sheet = sheet_at(answer, material, direction, (*state).media);
        return meet_sheet(index, state, answer, point, sheet, first);
    }
    if has(*state, IS_LAST) {
        return false;
    }
    (*state).surfaces += 1u;
    ask_light(index, state, answer, point, contact.beyond, first);
    let sampler = PixelSampler((*state).seed, (*state).index);
    let choice = draw_1d(sampler, first + CHOICE_DRAW);
    var u = vec2f(0.5);
    if is_spread(point.bsdf) {
        u = draw_2d(sampler, first + DIRECTION_DRAW);
    }
    let sample = bsdf_sample(point.bsdf, point.view, choice, u);
    return turn(index, state, answer, point, sample, contact.beyond, first);
}

@compute @workgroup_size(WORKGROUP)
fn shade(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if !goes_on(index) {
        return;
    }
    var state = states[index];
    // A light on its way through clear surfaces has the path wait for it.
    let is_heard = hear_light(index, &state);
    let is_waiting = (questions[index].flags & (IS_ASKED | IS_ANSWERED)) != 0u;
    if is_heard && is_waiting && !has(state, IN_DOUBT) {
        questions[index].flags &= ~(IS_ASKED | IS_ANSWERED);
        let is_alive = advance(index, &state);
        if !is_alive {
            questions[index].flags = 0u;
        }
    } else if is_waiting {
        questions[index].flags &= ~IS_ASKED;
        questions[index].flags |= IS_ANSWERED;
    }
    if has(state, IN_DOUBT) {
        finish_in_doubt(index);
        return;
    }
    let open = questions[index].flags | questions[lights_at() + index].flags;
    if (open & (IS_ASKED | IS_ANSWERED)) == 0u {
        finish_gathered(index, state);
        return;
    }
    states[index] = state;
    count(COUNT_GOING_ON);
}
