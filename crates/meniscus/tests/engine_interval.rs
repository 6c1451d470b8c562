//! Engine `interval` against the float64 oracle.

meniscus_testing::engine_suite!(interval, meniscus::accel::Engine::Interval);
