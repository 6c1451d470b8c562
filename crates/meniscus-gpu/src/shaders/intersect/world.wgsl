// The first plane, sphere or mesh that a question meets, before fields are asked: twin of intersect/world.rs.

// Whether another surface is met at about the same place: of those that one plane cuts the processor knows
// which counts.
fn is_next_to(t: f32, answer: Answer) -> bool {
    return answer.surface != NONE && abs(t - answer.t) <= NEXT_TO * t;
}

@compute @workgroup_size(WORKGROUP)
fn solids(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if index >= picture.count {
        return;
    }
    for (var kind = 0u; kind < 2u; kind++) {
        let place = kind * lights_at() + index;
        let question = questions[place];
        if (question.flags & IS_ASKED) == 0u {
            continue;
        }
        let span = span_of(question);
        var answer = nothing_there(question.t_max);
        for (var surface = 0u; surface < picture.surface_count; surface++) {
            let shape = u32(words[surface_word(surface)].x);
            var crossing = no_crossing(false);
            if shape == PLANE {
                crossing = plane_crossing(question, surface);
            } else if shape == SPHERE {
                crossing = sphere_crossing(question, surface, span);
            } else if shape == MESH {
                crossing = mesh_crossing(question, surface, span, answer.t);
            }
            let coincides = crossing.is_cut && is_next_to(crossing.t, answer);
            answer.is_in_doubt |= u32(crossing.is_in_doubt || coincides);
            if crossing.t < 0.0 || crossing.t > answer.t {
                if crossing.t >= 0.0 {
                    answer.next_t = min(answer.next_t, crossing.t);
                }
                continue;
            }
            if answer.surface != NONE {
                answer.next_t = answer.t;
            }
            answer.position = crossing.position.high;
            answer.position_low = crossing.position.low;
            answer.t = crossing.t;
            answer.surface = surface;
            answer.is_entering = u32(crossing.is_entering);
            answer.normal = crossing.normal;
            answer.shading = crossing.shading;
            answer.blob = crossing.triangle;
            answer.next_t = min(answer.next_t, crossing.next_t);
        }
        // As in `if_whole`: llvmpipe cuts loops short.
        var rounds = 0u;
        for (var surface = 0u; surface < picture.surface_count; surface++) {
            rounds++;
        }
        answer.is_in_doubt |= u32(rounds != picture.surface_count);
        answers[place] = answer;
    }
}
