// Integrator `ao`: twin of shade/integrator/ao.rs. A state's kinds are the rays asked and those that met
// something.

@compute @workgroup_size(WORKGROUP)
fn shade(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if !has_surface(index) {
        return;
    }
    let hit = answers[index];
    let direction = questions[index].direction;
    if states[index].phase == 0u {
        questions[index].flags = 0u;
        states[index].phase = 1u;
    } else if answers[lights_at() + index].surface != NONE {
        states[index].kinds.y += 1u;
    }
    let asked = states[index].kinds.x;
    let total = picture.ao_samples;
    if asked < total {
        count(COUNT_AMBIENT_OCCLUSION);
        let sampler = PixelSampler(states[index].seed, states[index].index);
        let normal = select(-hit.normal, hit.normal, hit.is_entering != 0u);
        let outwards = cosine_hemisphere(normal, draw_2d_of(sampler, 1u, total, asked));
        let side = select(SIDE_INSIDE, SIDE_OUTSIDE, hit.is_entering != 0u);
        questions[lights_at() + index] =
            question_from(hit, outwards, picture.reach, side, hit.surface, questions[index].time);
        states[index].kinds.x = asked + 1u;
        return;
    }
    let open = f32(total - states[index].kinds.y) / f32(total);
    finish_on_surface(index, material_at(index).color * open, hit, direction);
}
