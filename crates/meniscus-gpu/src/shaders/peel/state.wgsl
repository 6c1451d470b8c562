// What is known of each slot between passes.
struct SlotState {
    // Depth and number of the last event: the support of pair n is entered at event 2n and left at 2n + 1.
    depth: f32,
    event: u32,
    // Where it is along the ray.
    solved: f32,
    // No surface is first seen behind this place.
    end: f32,
    // Balls in the slot's list.
    count: u32,
    is_done: u32,
    // There is a surface at `end` for sure.
    has_end: u32,
    passes: u32,
}

const NO_EVENT: u32 = 0xffffffffu;

fn depth_of(along: f32) -> f32 {
    return along / params.reach;
}
