// All derivatives of the field at the answers to first questions whose rays carry differentials: twin of field/derivatives.rs, and of Frame::level_set for particles.

// In the place of hits: one for each sample.
@group(0) @binding(10) var<storage, read_write> level_sets: array<LevelSet>;

var<private> sum: LevelSet;

fn add_blob(at: u32, head: vec4u, d: vec3f, y: vec3f, g: f32) {
    let weight = blob_weight(at);
    // By 1 − g.
    let slope = -2.0 * weight * kernel_slope(g);
    let bend = 4.0 * weight * kernel_curvature(g);
    let m = blob_transform_transposed(at, head, y);
    let metric = mat3x3f(
        blob_metric(at, head, vec3f(1.0, 0.0, 0.0)),
        blob_metric(at, head, vec3f(0.0, 1.0, 0.0)),
        blob_metric(at, head, vec3f(0.0, 0.0, 1.0)),
    );
    sum.gradient += m * slope;
    sum.hessian += mat3x3f(m * m.x, m * m.y, m * m.z) * bend + metric * slope;
    let gradient = blob_gradient(at);
    let velocity = blob_velocity(at) + gradient * d;
    let along = dot(m, velocity);
    sum.rate -= slope * along;
    sum.gradient_rate -= m * (bend * along) + (metric * velocity + m * gradient) * slope;
}

fn blob_metric(at: u32, head: vec4u, d: vec3f) -> vec3f {
    return blob_transform_transposed(at, head, blob_transform(at, head, d));
}

@compute @workgroup_size(WORKGROUP)
fn derivatives(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if index >= picture.count {
        return;
    }
    let question = questions[index];
    let answer = answers[index];
    let is_asked = (question.flags & IS_ASKED) != 0u && answer.is_in_doubt == 0u;
    if !is_asked || answer.surface != field_place.surface || differentials[index].is_there == 0u {
        return;
    }
    stand_at(question.time);
    sum = LevelSet(vec3f(0.0), 0.0, vec3f(0.0), mat3x3f());
    let local = in_field(answer.position, answer.position_low);
    gather(local);
    let way = way_of(field_place.surface);
    if way.y > 0u {
        let rate = placement_rate(way, question.time);
        let x = point_from_pivot(placement, answer);
        sum = seen_through(sum, placement.linear, rate.linear, drift_of(placement, rate, x));
    }
    level_sets[index] = sum;
    if !is_sure || !is_whole() {
        answers[index].is_in_doubt = 1u;
    }
}
