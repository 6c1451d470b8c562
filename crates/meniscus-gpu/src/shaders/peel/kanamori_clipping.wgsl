// The clipping rule of Kanamori et al. 2008, §5.4, as it stands there: twin of
// intersect/sweep/clipping.rs. What it loses is counted, not mended.

// Parts narrower than this are roots.
const NARROW: f32 = 1e-3;
// Parts that wait at most.
const PENDING: u32 = 3u;
// Parts that are looked at.
const MOST_PARTS: u32 = 400u;

// The first crossing between two neighbouring events; negative: there is none.
fn first_crossing(from_at: f32, to_at: f32) -> f32 {
    if listed == 0u || !(to_at > from_at) {
        return -1.0;
    }
    if listed == 1u {
        return alone(from_at, to_at);
    }
    expand(from_at, to_at);
    let root = first_change();
    return select(-1.0, from_at + (to_at - from_at) * root, root >= 0.0);
}

// A ball alone has a ball for its surface (§3.1).
fn alone(from_at: f32, to_at: f32) -> f32 {
    let ball = ball_in_list(0u);
    let line = ball_on_ray(balls[ball], from_at).line;
    let above = line.g0 - traits[ball].y;
    if !(above > 0.0) {
        return -1.0;
    }
    let half = sqrt(above / line.beta);
    let along = line.c + select(-half, half, is_inside);
    return select(-1.0, from_at + along, along >= 0.0 && along <= to_at - from_at);
}

fn first_change() -> f32 {
    var pending: array<vec2f, PENDING>;
    var height = 0u;
    var now = vec2f(0.0, 1.0);
    var has_now = true;
    for (var round = 0u; (has_now || height > 0u) && round < MOST_PARTS; round++) {
        if !has_now {
            height--;
            now = pending[height];
        }
        has_now = false;
        take_part(now.x, now.y);
        let changes = sign_changes();
        if changes == 0u {
            continue;
        }
        let width = now.y - now.x;
        if width <= NARROW {
            return 0.5 * (now.x + now.y);
        }
        has_now = true;
        if changes == 1u {
            let hull = hull_on_axis();
            now = vec2f(now.x + width * hull.x, now.x + width * hull.y);
            continue;
        }
        let middle = 0.5 * (now.x + now.y);
        take_part(middle, now.y);
        // Only what may hold a root waits.
        if sign_changes() > 0u && height < PENDING {
            pending[height] = vec2f(middle, now.y);
            height++;
        }
        now = vec2f(now.x, middle);
    }
    return -1.0;
}

// Where the list is full, the event is taken for the surface (§7).
fn full_list(at: f32) -> HitRecord {
    return surface_at(at);
}
