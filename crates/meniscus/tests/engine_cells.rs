//! Engine `cells` against the float64 oracle.

meniscus_testing::engine_suite!(cells, meniscus::accel::Engine::Cells);
