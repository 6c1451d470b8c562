// Slots between the sprites' passes: the list of balls whose supports overlap the interval between two
// events is kept up to date, and the interval is solved (Kanamori et al. 2008, §4.2 and §4.3).

@group(0) @binding(7) var<storage, read> pairs: array<vec2u>;
@group(0) @binding(8) var<storage, read> starts: array<u32>;
@group(0) @binding(12) var<storage, read_write> states: array<SlotState>;
// Balls of each slot, lane after lane, so that a workgroup's accesses lie side by side.
@group(0) @binding(13) var<storage, read_write> lists: array<u32>;
@group(0) @binding(14) var<storage, read_write> finished: array<atomic<u32>>;
@group(0) @binding(17) var depths: texture_depth_2d;
@group(0) @binding(18) var events: texture_2d<u32>;

const LANES: u32 = 64u;

var<private> first_listed: u32;
var<private> listed: u32;
var<private> is_inside: bool;

fn ball_in_list(index: u32) -> u32 {
    return lists[first_listed + index * LANES];
}

fn place_of(slot: u32) -> vec2u {
    let group = slot / SLOTS_PER_GROUP;
    let pixel = slot % SLOTS_PER_GROUP;
    let cell = vec2u(group % params.groups_across, group / params.groups_across);
    return cell * TILE + vec2u(pixel % TILE, pixel / TILE);
}

fn finish(slot: u32, hit: HitRecord) {
    hits[slot] = hit;
    states[slot].is_done = 1u;
    atomicAdd(&finished[slot / SLOTS_PER_GROUP], 1u);
}

fn number_of(group: vec3u, groups: vec3u, lane: u32) -> u32 {
    return (group.y * groups.x + group.x) * LANES + lane;
}

// After the kernel spheres are drawn: how far each slot has to look.
@compute @workgroup_size(LANES)
fn begin(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32) {
    let slot = number_of(group, groups, lane);
    if slot >= params.rays {
        return;
    }
    ray = rays[slot];
    let depth = textureLoad(depths, place_of(slot), 0);
    // Who starts inside looks for the way out, and kernel spheres do not stand in it.
    let has_end = depth < 1.0 && (ray.flags & STARTS_INSIDE) == 0u;
    let end = select(ray.length, depth * params.reach, has_end);
    states[slot] = SlotState(0.0, NO_EVENT, 0.0, end, 0u, 0u, u32(has_end), 0u);
    if ray.length < 0.0 {
        finish(slot, nothing(MISS));
    } else if starts[ray.group + 1u] > params.pairs {
        finish(slot, nothing(NO_LIST));
    } else {
        // As long as nothing better is known.
        hits[slot] = nothing(IN_DOUBT);
    }
}

// −∇F and the strongest ball at a place.
fn surface_at(along: f32) -> HitRecord {
    var outward = vec3f(0.0);
    var strongest = NONE;
    var strength = -1.0;
    for (var i = 0u; i < listed; i++) {
        let ball = ball_in_list(i);
        let shape = balls[ball];
        let met = ball_on_ray(shape, along);
        let y = (ray.direction * -met.line.c - met.aside) * shape.w;
        let g = max(1.0 - dot(y, y), 0.0);
        let weight = traits[ball].x;
        let part = abs(weight * kernel_of_g(vec4f(g)).x);
        outward += (2.0 * weight * kernel_slope(g) * shape.w) * y;
        if part > strength || (part == strength && ball < strongest) {
            strength = part;
            strongest = ball;
        }
    }
    return HitRecord(HIT, 0.0, along, strongest, outward, select(1u, 0u, is_inside));
}

@compute @workgroup_size(LANES)
fn advance(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32) {
    let slot = number_of(group, groups, lane);
    if slot >= params.rays || states[slot].is_done == 1u {
        return;
    }
    let state = states[slot];
    ray = rays[slot];
    listed = state.count;
    first_listed = (slot - lane) * params.capacity + lane;
    is_inside = (ray.flags & STARTS_INSIDE) != 0u;
    let depth = textureLoad(depths, place_of(slot), 0);
    if depth == 1.0 {
        // No event is left.
        let root = first_crossing(state.solved, state.end);
        if root >= 0.0 {
            finish(slot, surface_at(root));
        } else if state.has_end == 1u {
            finish(slot, surface_at(state.end));
        } else {
            finish(slot, nothing(MISS));
        }
        return;
    }
    let event = textureLoad(events, place_of(slot), 0).x;
    let ball = pairs[event / 2u].y;
    let line = ball_on_ray(balls[ball], 0.0).line;
    let half = sqrt(max(line.g0, 0.0) / line.beta);
    let is_entry = (event & 1u) == 0u;
    let at = clamp(select(line.c + half, line.c - half, is_entry), state.solved, state.end);
    let root = first_crossing(state.solved, at);
    if root >= 0.0 {
        finish(slot, surface_at(root));
        return;
    }
    if is_entry {
        if line.beta >= params.fine_beta {
            finish(slot, nothing(IN_DOUBT));
            return;
        }
        if listed == params.capacity {
            finish(slot, full_list(at));
            return;
        }
        lists[first_listed + listed * LANES] = ball;
        listed++;
    } else {
        var kept = 0u;
        for (var i = 0u; i < listed; i++) {
            let other = ball_in_list(i);
            if other != ball {
                lists[first_listed + kept * LANES] = other;
                kept++;
            }
        }
        listed = kept;
    }
    states[slot].depth = depth;
    states[slot].event = event;
    states[slot].solved = at;
    states[slot].count = listed;
    states[slot].passes = state.passes + 1u;
}
