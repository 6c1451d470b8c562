// A light that is asked about, and what a state remembers: what integrators share that hear of lights while
// their rays go on.

const MAX_CROSSINGS: u32 = 64u;

// `State::flags`.
const HAS_FIRST: u32 = 1u;
const IS_COVERED: u32 = 2u;
const IS_SPREAD: u32 = 4u;
const IS_LAST: u32 = 8u;
const IN_DOUBT: u32 = 16u;
// Of the light that is asked about: it may be clamped; it goes straight through clear surfaces; it did.
const LIGHT_CLAMPS: u32 = 32u;
const LIGHT_STRAIGHT: u32 = 64u;
const LIGHT_WENT_THROUGH: u32 = 128u;
const CROSSINGS_SHIFT: u32 = 16u;

fn has(state: State, flag: u32) -> bool {
    return (state.flags & flag) != 0u;
}

fn clamped(light: vec3f, may_be: bool) -> vec3f {
    let largest = max(max(light.x, light.y), light.z);
    if may_be && picture.clamp >= 0.0 && largest > picture.clamp {
        return light * (picture.clamp / largest);
    }
    return light;
}

// Hears what stands before the light; false while it is on its way.
fn hear_light(index: u32, state: ptr<function, State>) -> bool {
    let at = lights_at() + index;
    if (questions[at].flags & IS_ASKED) == 0u {
        return true;
    }
    let given = Reach((*state).pending, (*state).light_media, has(*state, LIGHT_WENT_THROUGH), REACH_BLOCKED);
    let reach = reach_step(index, given, has(*state, LIGHT_STRAIGHT));
    if reach.outcome == REACH_IN_DOUBT {
        (*state).flags |= IN_DOUBT;
    }
    if reach.outcome == REACH_WALKS {
        (*state).pending = reach.part;
        (*state).light_media = reach.media;
        (*state).flags |= select(0u, LIGHT_WENT_THROUGH, reach.went_through);
        (*state).flags += 1u << CROSSINGS_SHIFT;
        if ((*state).flags >> CROSSINGS_SHIFT) < MAX_CROSSINGS {
            return false;
        }
    }
    if reach.outcome == REACH_ARRIVED {
        // Behind clear surfaces scattered rays do not count, so nothing shares with this one.
        let weight = select((*state).light_weight, 1.0, reach.went_through);
        (*state).radiance += clamped(reach.part * weight, has(*state, LIGHT_CLAMPS));
    }
    questions[at].flags = 0u;
    return true;
}

// What is seen first: with what shows behind it where it fades.
fn remember_first(index: u32, answer: Answer, direction: vec3f) -> f32 {
    let opacity = opacity_of(answer.surface, answer.position);
    var shown = vec3f(0.0);
    if picture.background != BACKGROUND_TRANSPARENT && opacity < 1.0 {
        shown = behind(direction) * (1.0 - opacity);
    }
    let outcome = OUTCOME_SURFACE | select(0u, OUTCOME_ENTERING, answer.is_entering != 0u);
    seen[index] = Seen(shown, outcome, answer.position, answer.surface, answer.shading, answer.blob);
    return opacity;
}

// Ends a sample whose state holds the light that it gathered.
fn finish_gathered(index: u32, state: State) {
    if !has(state, HAS_FIRST) {
        let outcome = select(OUTCOME_NOTHING, OUTCOME_LAMP, has(state, IS_COVERED));
        finish_without_surface(index, state.radiance, outcome);
        return;
    }
    count(COUNT_PRIMARY);
    var record = seen[index];
    var opacity = 1.0;
    if picture.background != BACKGROUND_TRANSPARENT {
        opacity = opacity_of(record.surface, record.position);
    }
    record.radiance += state.radiance * opacity;
    finish(index, record);
}
