//! Engine `particles` against the float64 oracle.

meniscus_testing::engine_suite!(particles, meniscus::accel::Engine::Particles);
