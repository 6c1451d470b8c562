//! Engine `cells` against the float64 oracle.

meniscus_testing::engine_suite!(cells, meniscus::accel::Engine::Cells; ordinary_rays shadow_rays
    grazing_rays inside_rays bundles evil_rays evil_sets_within_f32 any_hit all_crossings
    same_for_any_number_of_threads);
