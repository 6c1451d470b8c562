// The eye's rays: twin of render/cpu.rs.

// The offset from the pixel centre for a number in [0, 1): twin of PixelFilter.
fn filter_offset(u: f32) -> f32 {
    let position = u * f32(FILTER_STEPS - 1u);
    let below = min(u32(position), FILTER_STEPS - 2u);
    let a = number(picture.filter_at, below);
    let b = number(picture.filter_at, below + 1u);
    return a + (b - a) * (position - f32(below));
}

// Side of the blocks of pixels that share strata of time, and what sets their numbers apart.
const TIME_BLOCK: u32 = 4u;
const PIXEL_SEED: u32 = 0x5bd1e995u;
const BLOCK_SEED: u32 = 0x1b873593u;

// How much of the shutter's time is over: twin of math/sampling/shutter.rs.
fn part_of_shutter(pixel: vec2u, sample: u32) -> f32 {
    let own = draw_unordered(pixel_sampler(pixel, sample, picture.seed ^ PIXEL_SEED), 0u);
    let block = pixel_sampler(pixel / TIME_BLOCK, sample, picture.seed ^ BLOCK_SEED);
    return (floor(draw_1d(block, 0u) * picture.time_strata) + own) / picture.time_strata;
}

@compute @workgroup_size(WORKGROUP)
fn begin(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if index >= picture.count {
        return;
    }
    let region = picture.region;
    let pixels = region.z * region.w;
    let place = picture.first_pixel + index;
    let sample = picture.first_sample + place / pixels;
    let in_picture = place % pixels;
    let strip = in_picture / (STRIP_ROWS * region.z);
    let rows = min(STRIP_ROWS, region.w - strip * STRIP_ROWS);
    let in_strip = in_picture % (STRIP_ROWS * region.z);
    let pixel = region.xy + vec2u(in_strip / rows, strip * STRIP_ROWS + in_strip % rows);
    let sampler = pixel_sampler(pixel, sample, picture.seed);
    var offset = vec2f(0.0);
    if picture.spp != 1u {
        let u = draw_2d(sampler, 0u);
        offset = vec2f(filter_offset(u.x), filter_offset(u.y));
    }
    var part = 0.0;
    if picture.shutter_secs > 0.0 {
        part = part_of_shutter(pixel, sample);
    }
    let time = picture.shutter_open + picture.shutter_secs * part;
    let view = view_at(part);
    let direction = direction_through(view, pixel, offset);
    questions[index] = Question(
        view.eye.high, FAR, view.eye.low, IS_ASKED | (picture.eye_side << SIDE_SHIFT), direction.high,
        NONE, direction.low, time,
    );
    questions[lights_at() + index].flags = 0u;
    if antialiases() {
        differentials[index] = eye_differential(view, pixel, offset, part);
    }
    states[index] = State(
        sampler.seed, sampler.index, 0u, vec3f(0.0), picture.media, vec3f(1.0), 0u, vec3f(0.0), 0u,
        vec3f(0.0), FAR, vec3u(0u), 0u, 0.0, 0u,
    );
    if !view.is_sure {
        questions[index].flags = 0u;
        states[index].phase = DONE;
        seen[index] = Seen(vec3f(0.0), OUTCOME_IN_DOUBT, vec3f(0.0), NONE, vec3f(0.0), NONE);
    }
}
