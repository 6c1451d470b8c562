//! Which columns the surfaces have to carry.

use meniscus::film::CHANNELS;
use meniscus::particles::Particles;
use meniscus::scene::attribute::ELEMENT_COLOR;
use meniscus::scene::{BlobSettings, Surface};

/// Most components of a column that `--aov all` carries along.
const MAX_COMPONENTS: usize = 9;

/// Adds to `settings` what the surface's colour and the channels `aov` need.
pub(crate) fn carry(
    settings: &mut BlobSettings,
    surface: &Surface,
    aov: &[String],
    particles: &Particles,
) {
    let mut add = |name: &str| {
        if !settings.attributes.iter().any(|known| known == name) {
            settings.attributes.push(name.to_owned());
        }
    };
    if let Some(color_by) = &surface.color_by {
        // Surfaces without elements keep their material's colour.
        let has_elements = ["atomic_number", ELEMENT_COLOR]
            .iter()
            .any(|name| particles.column(name).is_some());
        if color_by != ELEMENT_COLOR || has_elements {
            add(color_by);
        }
    }
    for name in [&surface.roughness_by, &surface.absorption_by]
        .into_iter()
        .flatten()
    {
        add(name);
    }
    for name in aov.iter().map(|name| name.trim()) {
        if name == "all" {
            let columns = particles.columns.iter();
            for column in columns.filter(|column| column.components <= MAX_COMPONENTS) {
                add(&column.name);
            }
        } else if is_attribute(name) {
            add(name);
        }
    }
}

/// Whether a name asked for with `--aov` is a column rather than a channel. Channels that cannot be
/// had yet are left to the film, which says so.
fn is_attribute(name: &str) -> bool {
    !name.is_empty()
        && !["motion", "curvature"].contains(&name)
        && !CHANNELS.iter().any(|channel| channel.name == name)
}
