// Samples under way, what they ask about the surfaces of the frame and what they are told: twin of
// shade/asking.rs. Each sample has two questions at most: for the first surface along its way, and
// whether something stands before a light.

// A ray in the world.
struct Question {
    origin: vec3f,
    t_max: f32,
    origin_low: vec3f,
    flags: u32,
    // Unit length.
    direction: vec3f,
    // The surface that its side is about; NONE: all.
    side_of: u32,
    direction_low: vec3f,
    time: f32,
}

// In `flags`.
const IS_ASKED: u32 = 1u;
// Its answer is there, and waits for that to the other question.
const IS_ANSWERED: u32 = 2u;
const SIDE_SHIFT: u32 = 2u;
const SIDE_UNKNOWN: u32 = 0u;
const SIDE_OUTSIDE: u32 = 1u;
const SIDE_INSIDE: u32 = 2u;

struct Answer {
    position: vec3f,
    t: f32,
    position_low: vec3f,
    // NONE: nothing.
    surface: u32,
    // Outward.
    normal: vec3f,
    blob: u32,
    // For shading, on the same side.
    shading: vec3f,
    // Where something else stands behind.
    next_t: f32,
    is_entering: u32,
    is_in_doubt: u32,
}

struct State {
    seed: vec2u,
    index: u32,
    // What the integrator waits for.
    phase: u32,
    radiance: vec3f,
    media: u32,
    throughput: vec3f,
    surfaces: u32,
    // Light that counts unless something stands before it.
    pending: vec3f,
    flags: u32,
    scattered_at: vec3f,
    density: f32,
    kinds: vec3u,
    sheets: u32,
    // Of the light that is asked about: what it shares with scattered rays, and the media on the way.
    light_weight: f32,
    light_media: u32,
}

// What the eye saw: as StagedSample.
struct Seen {
    radiance: vec3f,
    outcome: u32,
    position: vec3f,
    surface: u32,
    normal: vec3f,
    blob: u32,
}

const OUTCOME_IN_DOUBT: u32 = 0u;
const OUTCOME_NOTHING: u32 = 1u;
const OUTCOME_LAMP: u32 = 2u;
const OUTCOME_SURFACE: u32 = 3u;
const OUTCOME_ENTERING: u32 = 4u;

// `State::phase` of a sample that is done.
const DONE: u32 = 0xffffffffu;

@group(0) @binding(2) var<storage, read_write> states: array<State>;
// Those for first surfaces, then those for lights.
@group(0) @binding(3) var<storage, read_write> questions: array<Question>;
@group(0) @binding(4) var<storage, read_write> answers: array<Answer>;
@group(0) @binding(5) var<storage, read_write> seen: array<Seen>;
// Rays on their way (2), samples that go on, and rays by purpose.
@group(0) @binding(6) var<storage, read_write> counters: array<atomic<u32>>;

const COUNT_GOING_ON: u32 = 2u;
const COUNT_PRIMARY: u32 = 3u;
const COUNT_SHADOW: u32 = 4u;
const COUNT_REFLECTION: u32 = 5u;
const COUNT_REFRACTION: u32 = 6u;
const COUNT_AMBIENT_OCCLUSION: u32 = 7u;
const COUNT_DIFFUSE: u32 = 8u;

fn count(counter: u32) {
    atomicAdd(&counters[counter], 1u);
}

// Where the questions for lights begin.
fn lights_at() -> u32 {
    return arrayLength(&questions) / 2u;
}

fn nothing_there(t: f32) -> Answer {
    return Answer(vec3f(0.0), t, vec3f(0.0), NONE, vec3f(0.0), NONE, vec3f(0.0), FAR, 0u, 0u);
}

// A question from the place of an answer on.
fn question_from(answer: Answer, direction: vec3f, t_max: f32, side: u32, side_of: u32, time: f32) -> Question {
    return Question(
        answer.position, t_max, answer.position_low, IS_ASKED | (side << SIDE_SHIFT), direction, side_of,
        vec3f(0.0), time,
    );
}

fn number_of(group: vec3u, groups: vec3u, lane: u32) -> u32 {
    return (group.y * groups.x + group.x) * WORKGROUP + lane;
}
