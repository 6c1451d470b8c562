// Integrator `shaded`: twin of shade/integrator/shaded.rs. The eye's ray, then one ray per light, light by
// light. A state's throughput is the sum of diffuse light, its radiance that of highlights, its first kind
// the light that is asked about.

const WALL_TRANSMISSION: f32 = 0.6;

fn faces(hit: Answer, light: LightSample) -> bool {
    return light.is_there && dot(hit.shading, light.towards) > 0.0 && dot(hit.normal, light.towards) > 0.0;
}

// Asks about the next light from number `first` on; false where there is none.
fn ask_light(index: u32, hit: Answer, first: u32, time: f32) -> bool {
    for (var i = first; i < picture.emitter_count; i++) {
        let light = hard_light(emitter_of(i), hit.position);
        if faces(hit, light) {
            count(COUNT_SHADOW);
            states[index].kinds.x = i;
            questions[lights_at() + index] =
                question_from(hit, light.towards, light.distance, SIDE_OUTSIDE, NONE, time);
            return true;
        }
    }
    return false;
}

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
    let material = material_at(index);
    let towards_eye = -direction;
    let from_inside = dot(hit.normal, towards_eye) < 0.0;
    // It may turn away from the eye where the face does not.
    let normal = hit.shading;
    var facing = dot(normal, towards_eye);
    if !from_inside {
        facing = max(facing, 1e-3);
    }
    let has_gloss = material.gloss.z > 0.0 && !from_inside;
    var next_light = 0u;
    if states[index].phase == 0u {
        // The first surface is known from here on.
        questions[index].flags = 0u;
        states[index].phase = 1u;
        states[index].throughput = vec3f(0.0);
    } else {
        let asked = states[index].kinds.x;
        next_light = asked + 1u;
        if answers[lights_at() + index].surface == NONE {
            let light = hard_light(emitter_of(asked), hit.position);
            let nl = dot(normal, light.towards);
            let radiance = light.weight * FRAC_1_PI;
            states[index].throughput += radiance * nl;
            if has_gloss {
                let half = normalize(light.towards + towards_eye);
                let nh = max(dot(normal, half), 0.0);
                let vh = max(dot(towards_eye, half), 0.0);
                var shine = highlight(material.gloss, nl, facing, nh, vh);
                let spread = spread_of(normal, direction, changes_at(index, hit, questions[index]));
                if spread.is_there {
                    let frame = mat3x3f(spread.x, spread.y, normal);
                    let to_light = vec3f((light.towards * frame).xy, nl);
                    let to_eye = vec3f((towards_eye * frame).xy, facing);
                    let to_half = vec3f((half * frame).xy, nh);
                    shine = widened_highlight(material.gloss, spread.added, to_light, to_eye, to_half, vh);
                }
                states[index].radiance += radiance * shine;
            }
        }
    }
    if ask_light(index, hit, next_light, questions[index].time) {
        return;
    }
    let diffuse = material.color * (states[index].throughput + ambient(normal));
    if from_inside {
        finish_on_surface(index, diffuse * WALL_TRANSMISSION, hit, direction);
        return;
    }
    var coat = 0.0;
    if has_gloss {
        coat = coat_reflectance(material.gloss, facing);
    }
    let mirrored = direction - normal * (2.0 * dot(normal, direction));
    let specular = states[index].radiance + surroundings(mirrored) * coat;
    finish_on_surface(index, diffuse * (1.0 - coat) + specular, hit, direction);
}
