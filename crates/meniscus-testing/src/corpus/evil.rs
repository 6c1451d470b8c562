//! Degenerate and extreme scenes.

use super::{Recipe, Scene, Shape, Weighting, points};
use crate::random::Stream;
use glam::DVec3;
use meniscus::kernel::Kernel;

/// Sets that break assumptions: none, one, two blobs, all at one point, on a line, on an exact lattice,
/// radii a million-fold apart, coordinates around a million, a threshold that is never reached,
/// weights that never reach any.
pub fn evil() -> Vec<Scene> {
    let recipe = |positions: Vec<DVec3>, radius: f64, threshold: f64| Recipe {
        shape: Shape::Balls(vec![radius; positions.len()]),
        positions,
        weights: Weighting::Unit,
        kernel: Kernel::Quartic,
        threshold,
    };
    let line = |n: usize, step: DVec3| (0..n).map(|i| step * i as f64).collect::<Vec<_>>();
    let far = DVec3::new(1.0e6, -2.0e6, 0.5e6);
    let mut pool = points::pool(300);
    pool.positions.iter_mut().for_each(|p| *p = *p * 0.02 + far);
    pool.shape = Shape::Balls(vec![0.002; pool.positions.len()]);
    let lattice = (0..343)
        .map(|i| DVec3::new((i % 7) as f64, (i / 7 % 7) as f64, (i / 49) as f64))
        .collect();
    let mut giant = recipe(vec![DVec3::ZERO], 1.0, 0.3);
    let mut radii = vec![1.0];
    let surface = giant.kernel.q_at(giant.threshold).unwrap_or(0.5).sqrt();
    for i in 0..300 {
        let mut random = Stream::new(8, i);
        let radius = random.log_range(1e-6, 3e-6);
        let near = if i % 2 == 0 {
            random.direction()
        } else {
            DVec3::X
        };
        let offset = random.direction() * random.range(0.0, 4e-6);
        giant.positions.push(near * surface + offset);
        radii.push(radius);
    }
    giant.shape = Shape::Balls(radii);
    let mut all_negative = points::negative(40);
    all_negative.weights = Weighting::Given(vec![-1.0; 40]);
    let mut cancelling = recipe(vec![DVec3::ZERO; 2], 1.0, 0.3);
    cancelling.weights = Weighting::Given(vec![1.0, -1.0]);
    vec![
        Scene::new("none", &recipe(Vec::new(), 1.0, 0.3)),
        Scene::new("one", &recipe(line(1, DVec3::X), 1.0, 0.3)),
        Scene::new("two", &recipe(line(2, DVec3::X * 0.9), 1.0, 0.3)),
        Scene::new("one point", &recipe(vec![DVec3::ONE; 40], 1.0, 8.0)),
        Scene::new("on an axis", &recipe(line(60, DVec3::X * 0.5), 1.0, 0.4)),
        Scene::new("on a diagonal", &recipe(line(60, DVec3::ONE), 1.5, 0.4)),
        Scene::new("lattice", &recipe(lattice, 1.0, 0.4)),
        Scene::new("million-fold radii", &giant),
        Scene::new("far away", &pool),
        Scene::new(
            "never reached",
            &recipe(line(30, DVec3::X * 0.5), 1.0, 100.0),
        ),
        Scene::new("all negative", &all_negative),
        Scene::new("cancelling", &cancelling),
    ]
}
