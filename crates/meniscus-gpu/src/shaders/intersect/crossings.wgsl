// Every crossing of a ray: twin of Blobs::crossings. A record each, then one that says why there are no
// more; where there is none of that the ray goes on, from its last crossing.

@compute @workgroup_size(WORKGROUP)
fn crossings(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = number_of(group, groups, lane);
    if index >= params.rays {
        return;
    }
    ray = rays[index];
    first_met = (index - lane) * params.capacity + lane;
    var start = start_of_ray();
    start.must_show = start.is_own && !start.side_is_proven && !start.asks_side;
    for (var i = 0u; i < CROSSINGS; i++) {
        let record = if_whole(first_behind(start, false));
        hits[index * CROSSINGS + i] = record;
        if record.status != HIT {
            break;
        }
        start = start_behind(record);
    }
}
