//! Engine `sweep` against the float64 oracle.

meniscus_testing::engine_suite!(sweep, meniscus::accel::Engine::Sweep);
