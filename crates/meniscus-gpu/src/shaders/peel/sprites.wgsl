// One sprite per ball and group: a rectangle that fits the ball's image, cut to the group's tile, where
// slots are pixels of a texture, group beside group (Kanamori et al. 2008, §5.1 and §5.3).

@group(0) @binding(1) var<storage, read> rays: array<LocalRay>;
@group(0) @binding(7) var<storage, read> pairs: array<vec2u>;
@group(0) @binding(8) var<storage, read> starts: array<u32>;
@group(0) @binding(10) var<storage, read> groups: array<vec4u>;
@group(0) @binding(12) var<storage, read> states: array<SlotState>;
// Slots of each group whose ray is answered.
@group(0) @binding(14) var<storage, read> finished: array<u32>;
// Whether any of a sprite may be seen before what is proven solid.
@group(0) @binding(15) var<storage, read_write> seen: array<u32>;
@group(0) @binding(19) var<storage, read> visible: array<u32>;

struct Sprite {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) pair: u32,
    @location(1) @interpolate(flat) group: u32,
}

fn group_of(pair: u32) -> u32 {
    var low = 0u;
    var high = params.groups;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if starts[middle] <= pair {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

fn corner_of(vertex: u32, pair: u32, group: u32) -> Sprite {
    let image = image_of(balls[pairs[pair].y]);
    let tile = params.grid_at + vec2f(groups[group].xy * TILE);
    let low = clamp(image.low - tile, vec2f(0.0), vec2f(f32(TILE)));
    let high = clamp(image.high - tile, vec2f(0.0), vec2f(f32(TILE)));
    let cell = vec2f(vec2u(group % params.groups_across, group / params.groups_across) * TILE);
    // Two triangles, 0 1 2 and 2 1 3, of corners whose bits say right and down.
    let corner = select(vertex, vec3u(2u, 1u, 3u)[vertex % 3u], vertex > 2u);
    let is_right = (corner & 1u) == 1u;
    let is_down = (corner & 2u) == 2u;
    let place = cell + vec2f(select(low.x, high.x, is_right), select(low.y, high.y, is_down));
    let clip = vec2f(2.0, -2.0) * place / vec2f(params.atlas) + vec2f(-1.0, 1.0);
    return Sprite(vec4f(clip, 0.0, 1.0), pair, group);
}

fn nowhere() -> Sprite {
    return Sprite(vec4f(2.0, 2.0, 0.0, 1.0), 0u, 0u);
}

@vertex
fn every_sprite(@builtin(vertex_index) vertex: u32, @builtin(instance_index) pair: u32) -> Sprite {
    return corner_of(vertex, pair, group_of(pair));
}

@vertex
fn visible_sprite(
    @builtin(vertex_index) vertex: u32,
    @builtin(instance_index) pair: u32,
) -> Sprite {
    let group = group_of(pair);
    if visible[pair] == 0u || finished[group] == SLOTS_PER_GROUP {
        return nowhere();
    }
    return corner_of(vertex, pair, group);
}

fn slot_at(position: vec4f, group: u32) -> u32 {
    let place = vec2u(position.xy) % TILE;
    return group * SLOTS_PER_GROUP + place.y * TILE + place.x;
}

// Where the ray enters the ball that is solid by itself: the kernel sphere.
@fragment
fn kernel_sphere(sprite: Sprite) -> @builtin(frag_depth) f32 {
    ray = rays[slot_at(sprite.position, sprite.group)];
    let ball = pairs[sprite.pair].y;
    let line = ball_on_ray(balls[ball], 0.0).line;
    let above = line.g0 - traits[ball].y;
    if !(above > 0.0) || ray.length < 0.0 {
        discard;
    }
    let enter = line.c - sqrt(above / line.beta);
    if enter < 0.0 || enter > ray.length {
        discard;
    }
    return depth_of(enter);
}

// Marks sprites of which something is seen before that.
@fragment
fn mark(sprite: Sprite) {
    let slot = slot_at(sprite.position, sprite.group);
    let state = states[slot];
    ray = rays[slot];
    let line = ball_on_ray(balls[pairs[sprite.pair].y], 0.0).line;
    let half = sqrt(max(line.g0, 0.0) / line.beta);
    if state.is_done == 0u && line.g0 > 0.0 && line.c + half > 0.0 && line.c - half <= state.end {
        seen[sprite.pair] = 1u;
    }
}

struct Event {
    @builtin(frag_depth) depth: f32,
    @location(0) event: u32,
}

// The ball's first event behind the slot's last one. Of events at one depth the first drawn stays, which
// is the one of the lower number, and the others come in the passes to follow: none is lost.
@fragment
fn next_event(sprite: Sprite) -> Event {
    let slot = slot_at(sprite.position, sprite.group);
    let state = states[slot];
    ray = rays[slot];
    let line = ball_on_ray(balls[pairs[sprite.pair].y], 0.0).line;
    if state.is_done == 1u || !(line.g0 > 0.0) {
        discard;
    }
    let half = sqrt(line.g0 / line.beta);
    let enter = max(line.c - half, 0.0);
    let leave = line.c + half;
    if leave <= 0.0 || enter > state.end {
        discard;
    }
    if comes_after(depth_of(enter), 2u * sprite.pair, state) {
        return Event(depth_of(enter), 2u * sprite.pair);
    }
    if leave > state.end || !comes_after(depth_of(leave), 2u * sprite.pair + 1u, state) {
        discard;
    }
    return Event(depth_of(leave), 2u * sprite.pair + 1u);
}

fn comes_after(depth: f32, event: u32, state: SlotState) -> bool {
    return state.event == NO_EVENT || depth > state.depth
        || (depth == state.depth && event > state.event);
}
