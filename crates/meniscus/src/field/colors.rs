//! Attributes that are colours: of the particles themselves, or of their elements.

use super::build::atomic_number_of;
use crate::particles::elements::cpk_color;
use crate::particles::{ColumnData, Particles, Role};
use crate::scene::Color;
use crate::scene::attribute::{ELEMENT_COLOR, OWN_COLOR};
use crate::scene::color::linear_from_srgb;

/// Reflectance of white: no real surface reflects everything.
const ELEMENT_ALBEDO: f64 = 0.8;

type ColorOf<'a> = Box<dyn Fn(usize) -> [f32; 3] + 'a>;

/// The linear colour of each particle, where `name` stands for colours that there are:
/// [`ELEMENT_COLOR`] for those of the elements, [`OWN_COLOR`] for the particles' own, which are sRGB
/// where the file stores integers and linear otherwise. A column of exactly that name is an attribute
/// like any other, unless it is a colour itself.
pub(super) fn colors<'a>(particles: &'a Particles, name: &str) -> Option<ColorOf<'a>> {
    if name == ELEMENT_COLOR && particles.column(name).is_none() {
        let numbers = particles.column("atomic_number")?;
        let by_number = |number: usize| {
            let color = Color::from_srgb8(cpk_color(number as u8));
            color.0.map(|c| (c * ELEMENT_ALBEDO) as f32)
        };
        let table: Vec<[f32; 3]> = (0..=usize::from(u8::MAX)).map(by_number).collect();
        return Some(Box::new(move |i| {
            table[usize::from(atomic_number_of(numbers.get(i, 0)))]
        }));
    }
    if name != OWN_COLOR {
        return None;
    }
    let colors = particles.role(Role::Color)?;
    let is_encoded = colors
        .first_column()
        .is_some_and(|column| !matches!(column.data, ColumnData::F32(_) | ColumnData::F64(_)));
    Some(Box::new(move |i| {
        [0, 1, 2].map(|component| {
            let value = colors.get(i, component);
            let linear = if is_encoded {
                linear_from_srgb(value)
            } else {
                value
            };
            linear.clamp(0.0, 1.0) as f32
        })
    }))
}
