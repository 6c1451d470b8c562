// Which balls may be seen in which group: counted, then written group by group. A ball's image lies in a
// rectangle of the film that is exact under perspective: its sides are the planes through the eye that
// touch the ball (Kanamori et al. 2008, appendix B, for any linear map to the film).

@group(0) @binding(7) var<storage, read_write> pairs: array<vec2u>;
@group(0) @binding(8) var<storage, read> starts: array<u32>;
// First group of each tile of the grid.
@group(0) @binding(9) var<storage, read> tiles: array<u32>;
// (x, y of its tile in the grid, next group of this tile, –).
@group(0) @binding(10) var<storage, read> groups: array<vec4u>;
@group(0) @binding(11) var<storage, read_write> counts: array<atomic<u32>>;

@compute @workgroup_size(256)
fn count(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) many: vec3u,
    @builtin(local_invocation_index) lane: u32) {
    let ball = (group.y * many.x + group.x) * 256u + lane;
    if ball >= params.balls {
        return;
    }
    let cover = tiles_of(image_of(balls[ball]));
    for (var y = cover.y; y < cover.w; y++) {
        for (var x = cover.x; x < cover.z; x++) {
            var seen = tiles[y * params.grid_size.x + x];
            while seen != NONE {
                atomicAdd(&counts[seen], 1u);
                seen = groups[seen].z;
            }
        }
    }
}

@compute @workgroup_size(256)
fn fill(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) many: vec3u,
    @builtin(local_invocation_index) lane: u32) {
    let ball = (group.y * many.x + group.x) * 256u + lane;
    if ball >= params.balls {
        return;
    }
    let image = image_of(balls[ball]);
    let cover = tiles_of(image);
    for (var y = cover.y; y < cover.w; y++) {
        for (var x = cover.x; x < cover.z; x++) {
            var seen = tiles[y * params.grid_size.x + x];
            while seen != NONE {
                let place = starts[seen] + atomicSub(&counts[seen], 1u) - 1u;
                if place < params.pairs {
                    pairs[place] = vec2u(bitcast<u32>(image.nearest), ball);
                }
                seen = groups[seen].z;
            }
        }
    }
}

// The tiles that an image meets: first x, first y, end x, end y.
fn tiles_of(image: Image) -> vec4u {
    let side = f32(TILE);
    let most = vec2f(params.grid_size);
    let first = (image.low - params.grid_at) / side;
    let last = (image.high - params.grid_at) / side;
    if !image.is_before || any(first >= most) || any(last < vec2f(0.0)) {
        return vec4u(0u);
    }
    let low = vec2u(floor(clamp(first, vec2f(0.0), most)));
    let high = vec2u(floor(clamp(last, vec2f(0.0), most - 1.0))) + 1u;
    return vec4u(low, high);
}
