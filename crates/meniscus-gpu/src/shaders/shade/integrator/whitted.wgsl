// Integrator `whitted`: twin of shade/integrator/whitted.rs. A branch at a time: its ray, then a ray for each
// light at the surface that it meets; branches that leave there wait on a stack. What a branch counts in
// the picture is a product, so each adds its light by itself. Of a state: `throughput` and `density` are
// what the branch counts, by colour and at most; `kinds` are the next light, how often it was turned, and
// how many branches wait; `sheets` are surfaces that it went straight through.

const LEAST_WEIGHT: f32 = 1e-3;
const MAX_STRAIGHT: u32 = 64u;
const WIDENS_MIRRORS: bool = false;

struct Branch {
    question: Question,
    throughput: vec3f,
    weight: f32,
    media: u32,
    level: u32,
}

@group(0) @binding(11) var<storage, read_write> branches: array<Branch>;

fn surroundings_or_backdrop(direction: vec3f) -> vec3f {
    if picture.background == BACKGROUND_SKY {
        return backdrop(direction);
    }
    return surroundings(direction);
}

fn branch_place(index: u32, height: u32) -> u32 {
    return height * lights_at() + index;
}

// Behind those of the samples.
fn differential_place(index: u32, height: u32) -> u32 {
    return branch_place(index, height + 1u);
}

// Goes on with a branch that waits; false where there is none.
fn next_branch(index: u32, state: ptr<function, State>) -> bool {
    if (*state).kinds.z == 0u {
        questions[index].flags = 0u;
        return false;
    }
    (*state).kinds.z -= 1u;
    let branch = branches[branch_place(index, (*state).kinds.z)];
    questions[index] = branch.question;
    if antialiases() {
        differentials[index] = differentials[differential_place(index, (*state).kinds.z)];
    }
    (*state).throughput = branch.throughput;
    (*state).density = branch.weight;
    (*state).media = branch.media;
    (*state).kinds.y = branch.level;
    (*state).sheets = 0u;
    return true;
}

// Lets a branch wait that leaves in a direction from which `part` of the light arrives.
fn follow(
    index: u32,
    state: ptr<function, State>,
    answer: Answer,
    point: Point,
    local: vec3f,
    part: vec3f,
    beyond: u32,
) {
    let weight = (*state).density * max(max(part.x, part.y), part.z);
    if weight < LEAST_WEIGHT {
        return;
    }
    let on_viewers_side = local.z > 0.0;
    let level = (*state).kinds.y + 1u;
    let direction = to_world(point, local);
    if level >= picture.depth {
        // A mirror in the open shows what it would if nothing were in its way.
        if on_viewers_side && filling((*state).media) == NONE {
            (*state).radiance += (*state).throughput * part * surroundings_or_backdrop(direction);
        }
        return;
    }
    if !agrees(answer, direction, on_viewers_side) {
        return;
    }
    let height = (*state).kinds.z;
    if branch_place(index, height) >= arrayLength(&branches) {
        (*state).flags |= IN_DOUBT;
        return;
    }
    count(select(COUNT_REFRACTION, COUNT_REFLECTION, on_viewers_side));
    branches[branch_place(index, height)] = Branch(
        leaving(answer, direction, FAR, on_viewers_side, questions[index].time),
        (*state).throughput * part, weight, select(beyond, (*state).media, on_viewers_side), level,
    );
    if antialiases() {
        differentials[differential_place(index, height)] =
            differential_behind(index, point, !on_viewers_side, point.bsdf.eta);
    }
    (*state).kinds.z = height + 1u;
}

// The surface that the branch has met.
struct Meeting {
    material: Material,
    point: Point,
    beyond: u32,
    // What is left of its look; less than 1 on the ground far away.
    opacity: f32,
}

fn meeting_at(index: u32, state: State) -> Meeting {
    let answer = answers[index];
    let question = questions[index];
    let material = material_at(index);
    let contact = contact_of(answer, material, state.media, question.origin);
    let indices = vec2f(ior_in(state.media), ior_in(contact.beyond));
    let point = point_of(index, answer, material, 0.0, indices);
    var opacity = 1.0;
    if state.kinds.y > 0u {
        opacity = opacity_of(answer.surface, answer.position);
    }
    return Meeting(material, point, contact.beyond, opacity);
}

// Looks at the answer to the branch's ray; true where there is a surface to be lit, else the branch is over
// or goes on.
fn arrive(index: u32, state: ptr<function, State>) -> bool {
    let question = questions[index];
    let answer = answers[index];
    let direction = question.direction;
    let is_hit = answer.surface != NONE;
    let lamp = light_met(question.origin, direction, select(FAR, answer.t, is_hit));
    (*state).throughput *= absorbed(index, (*state).media, lamp.t);
    if lamp.emitter != NONE {
        let light = emitter_of(lamp.emitter).radiance * emission_scale((*state).media);
        (*state).radiance += (*state).throughput * light;
        (*state).flags |= select(0u, IS_COVERED, (*state).kinds.y == 0u);
        next_branch(index, state);
        return false;
    }
    if !is_hit {
        let is_first = (*state).kinds.y == 0u && !has(*state, HAS_FIRST);
        var light = surroundings_or_backdrop(direction);
        if is_first {
            light = behind(direction);
        }
        (*state).radiance += (*state).throughput * light;
        next_branch(index, state);
        return false;
    }
    if (*state).sheets == MAX_STRAIGHT {
        next_branch(index, state);
        return false;
    }
    let contact = contact_of(answer, material_of(answer.surface), (*state).media, question.origin);
    if contact.is_in_doubt {
        (*state).flags |= IN_DOUBT;
        return false;
    }
    if !contact.is_boundary {
        (*state).media = contact.beyond;
        (*state).sheets += 1u;
        questions[index] = passed(question, answer, FAR);
        advance_differential(index, answer.t);
        return false;
    }
    if !has(*state, HAS_FIRST) {
        (*state).flags |= HAS_FIRST | IS_COVERED;
        remember_first(index, answer, direction);
    }
    (*state).kinds.x = 0u;
    return true;
}

// Asks about the next light; false where there is none.
fn ask_light(index: u32, state: ptr<function, State>, meeting: Meeting) -> bool {
    let point = meeting.point;
    if !is_spread(point.bsdf) {
        return false;
    }
    let answer = answers[index];
    for (var i = (*state).kinds.x; i < picture.emitter_count; i++) {
        let light = hard_light(emitter_of(i), answer.position);
        if !light.is_there {
            continue;
        }
        let local = to_local(point, light.towards);
        let scattered = bsdf_evaluate(point.bsdf, point.view, local);
        if all(scattered == vec3f(0.0)) {
            continue;
        }
        let on_viewers_side = local.z > 0.0;
        if !agrees(answer, light.towards, on_viewers_side) {
            continue;
        }
        count(COUNT_SHADOW);
        (*state).pending = (*state).throughput * meeting.opacity * scattered * light.weight;
        (*state).light_weight = 1.0;
        (*state).light_media = select(meeting.beyond, (*state).media, on_viewers_side);
        (*state).flags &= ~(LIGHT_WENT_THROUGH | (0xffffu << CROSSINGS_SHIFT));
        (*state).flags |= LIGHT_STRAIGHT;
        (*state).kinds.x = i + 1u;
        questions[lights_at() + index] =
            leaving(answer, light.towards, light.distance, on_viewers_side, questions[index].time);
        return true;
    }
    return false;
}

// Light from all around, and the branches that leave a surface; then goes on with one of them.
fn leave(index: u32, state: ptr<function, State>, meeting: Meeting) {
    let answer = answers[index];
    let question = questions[index];
    let point = meeting.point;
    let beyond = meeting.beyond;
    let cosine = point.view.z;
    let mirror = mirrored(point.view);
    let whole = (*state).throughput;
    if meeting.opacity < 1.0 {
        (*state).radiance +=
            whole * surroundings_or_backdrop(question.direction) * (1.0 - meeting.opacity);
        (*state).throughput *= meeting.opacity;
    }
    var diffuse = vec3f(0.0);
    var through = vec3f(0.0);
    switch meeting.material.scattering {
        case SHEET: {
            let sheet = sheet_at(answer, meeting.material, question.direction, (*state).media);
            through = sheet.transmitted;
            follow(index, state, answer, point, mirror, sheet.reflected, beyond);
        }
        case CONDUCTOR: {
            follow(index, state, answer, point, mirror, schlick(point.bsdf.color, cosine), beyond);
        }
        case COATED: {
            let coat = coat_facet(point.bsdf, cosine);
            diffuse = point.bsdf.color * (1.0 - coat);
            follow(index, state, answer, point, mirror, vec3f(coat), beyond);
        }
        case CLEAR: {
            let eta = point.bsdf.eta;
            let fresnel = dielectric_reflectance(cosine, eta);
            follow(index, state, answer, point, mirror, vec3f(fresnel.x), beyond);
            if fresnel.y >= 0.0 {
                let onward = vec3f(-eta * point.view.xy, -fresnel.y);
                follow(index, state, answer, point, onward, vec3f(1.0 - fresnel.x), beyond);
            }
        }
        default: {
            diffuse = point.bsdf.color;
        }
    }
    (*state).radiance += (*state).throughput * diffuse * ambient(point.normal);
    (*state).throughput = whole * through;
    if any(through > vec3f(0.0)) {
        count(COUNT_REFRACTION);
        (*state).sheets += 1u;
        questions[index] = passed(question, answer, FAR);
        advance_differential(index, answer.t);
        return;
    }
    next_branch(index, state);
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
    if state.phase == 0u {
        state.phase = 1u;
        state.density = 1.0;
    }
    if hear_light(index, &state) && !has(state, IN_DOUBT) {
        var is_lit = (questions[index].flags & IS_ANSWERED) != 0u;
        if !is_lit {
            questions[index].flags &= ~IS_ASKED;
            is_lit = arrive(index, &state);
        }
        if is_lit {
            questions[index].flags |= IS_ANSWERED;
            let meeting = meeting_at(index, state);
            if !ask_light(index, &state, meeting) {
                questions[index].flags &= ~IS_ANSWERED;
                leave(index, &state, meeting);
            }
        }
    }
    if has(state, IN_DOUBT) {
        finish_in_doubt(index);
        return;
    }
    if (questions[index].flags & (IS_ASKED | IS_ANSWERED)) == 0u {
        finish_gathered(index, state);
        return;
    }
    states[index] = state;
    count(COUNT_GOING_ON);
}
