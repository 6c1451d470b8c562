// Walks a group's sorted list stretch by stretch: what intersect/particles.wgsl does by the tree.

@group(0) @binding(7) var<storage, read> pairs: array<vec2u>;
@group(0) @binding(8) var<storage, read> starts: array<u32>;

// llvmpipe ends any loop after 65535 rounds.
const MOST_BALLS: u32 = 60000u;
// By how much f32 may see a ball at the limit of what it resolves wider than it is, in its support.
const FINE_ROUNDING: f32 = 6e-5;

// Pairs before this one lie behind the ray.
var<private> cursor: u32;
var<private> list_end: u32;

fn prepare() {
    cursor = min(starts[ray.group], params.pairs);
    list_end = starts[ray.group + 1u];
}

// Gathers what reaches the ray in the stretch that begins with the first support behind `from_at`. The
// list is sorted by where supports may begin at the earliest, so it is done where that lies behind the
// stretch's end.
fn gather(from_at: f32, reach: f32) {
    count = 0u;
    base = from_at;
    stretch_start = ray.length;
    stretch_end = ray.length;
    trouble = MISS;
    if list_end > params.pairs {
        trouble = NO_LIST;
        return;
    }
    if list_end - cursor > MOST_BALLS {
        trouble = IN_DOUBT;
        return;
    }
    var all_passed = true;
    for (var i = cursor; i < list_end; i++) {
        let pair = pairs[i];
        let earliest = bitcast<f32>(pair.x) - ray.eye_distance;
        if earliest > stretch_end {
            return;
        }
        let ball = balls[pair.y];
        // The margins of `nearest` are taken twice the way back.
        let latest = earliest + (2.0 + 1e-4) / ball.w + 1e-5 * (ray.eye_distance + ray.length);
        if latest < from_at {
            if all_passed {
                cursor = i + 1u;
            }
            continue;
        }
        all_passed = false;
        let line = ball_on_ray(ball, base).line;
        if line.beta >= params.fine_beta {
            // Too small for f32.
            let steepness = sqrt(line.beta / params.fine_beta);
            let limit = 1.0 + FINE_ROUNDING * steepness;
            if 1.0 - line.g0 < limit * limit {
                trouble = IN_DOUBT;
                return;
            }
        }
        let away = clamp(line.c, from_at - base, stretch_end - base) - line.c;
        if !(line.g0 - line.beta * away * away > 0.0) {
            continue;
        }
        var c = line.c;
        if count == 0u {
            // Count from here.
            base = max(from_at, base + (c - sqrt(line.g0 / line.beta)));
            c = ball_on_ray(ball, base).line.c;
        }
        if count == params.capacity {
            make_room(from_at);
            if trouble != MISS {
                return;
            }
        }
        keep(count, vec4f(c, line.beta, line.g0, traits[pair.y].x), pair.y);
        count++;
        let enter = base + (c - sqrt(line.g0 / line.beta));
        stretch_start = min(stretch_start, max(enter, from_at));
        stretch_end = min(stretch_end, stretch_start + reach);
    }
}

fn blob_there(ball: u32, along: f32) -> BlobThere {
    let shape = balls[ball];
    let met = ball_on_ray(shape, base);
    let y = (ray.direction * (along - met.line.c) - met.aside) * shape.w;
    let g = 1.0 - dot(y, y);
    return BlobThere(g, traits[ball].x, ball, y * shape.w);
}
