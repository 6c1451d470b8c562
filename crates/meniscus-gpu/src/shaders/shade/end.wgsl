// A sample's end: twin of what shade/integrator/mod.rs adds to what integrators gathered.

fn finish(index: u32, record: Seen) {
    seen[index] = record;
    states[index].phase = DONE;
    questions[index].flags = 0u;
    questions[lights_at() + index].flags = 0u;
}

fn finish_in_doubt(index: u32) {
    finish(index, Seen(vec3f(0.0), OUTCOME_IN_DOUBT, vec3f(0.0), NONE, vec3f(0.0), NONE));
}

fn finish_without_surface(index: u32, radiance: vec3f, outcome: u32) {
    count(COUNT_PRIMARY);
    finish(index, Seen(radiance, outcome, vec3f(0.0), NONE, vec3f(0.0), NONE));
}

// Light from a first surface, with what shows behind it where it fades. The eye's direction is a finite
// one's: that of the ray that found the surface.
fn finish_on_surface(index: u32, radiance: vec3f, first: Answer, direction: vec3f) {
    count(COUNT_PRIMARY);
    let opacity = opacity_of(first.surface, first.position);
    var all = radiance;
    if picture.background != BACKGROUND_TRANSPARENT && opacity < 1.0 {
        all = radiance * opacity + behind(direction) * (1.0 - opacity);
    }
    let outcome = OUTCOME_SURFACE | select(0u, OUTCOME_ENTERING, first.is_entering != 0u);
    finish(index, Seen(all, outcome, first.position, first.surface, first.shading, first.blob));
}

// Whether one of a sample's rays has no sure answer; its unasked questions have none.
fn is_in_doubt(index: u32) -> bool {
    let first = (questions[index].flags & IS_ASKED) != 0u && answers[index].is_in_doubt != 0u;
    let at = lights_at() + index;
    return first || ((questions[at].flags & IS_ASKED) != 0u && answers[at].is_in_doubt != 0u);
}

// Whether an integrator has something to do for a sample: it is under way, and its answers are sure.
fn goes_on(index: u32) -> bool {
    if index >= picture.count || states[index].phase == DONE {
        return false;
    }
    if is_in_doubt(index) {
        finish_in_doubt(index);
        return false;
    }
    return true;
}

// The same where light from a first surface is all that counts: without one the sample ends.
fn has_surface(index: u32) -> bool {
    if !goes_on(index) {
        return false;
    }
    if answers[index].surface == NONE {
        finish_without_surface(index, behind(questions[index].direction), OUTCOME_NOTHING);
        return false;
    }
    return true;
}
