//! What colours and scales a surface: its attributes, by the names that a scene gives them.

use super::FrameError;
use super::looks::{BaseColor, Coloring, Scaling};
use crate::field::{BlobField, FieldAttribute};
use crate::scene::Surface;
use crate::scene::attribute::{AttributeRef, Component, ELEMENT_COLOR, OWN_COLOR};

/// The base colour that `color_by` stands for; `None` where the material's stays.
pub(super) fn base_color(
    color_by: &str,
    surface: &Surface,
    field: &BlobField,
) -> Result<Option<BaseColor>, FrameError> {
    let found = field.attributes.iter().position(|a| a.name == color_by);
    if [ELEMENT_COLOR, OWN_COLOR].contains(&color_by) {
        match found {
            Some(index) if field.attributes[index].components == 3 => {
                return Ok(Some(BaseColor::Direct(index)));
            }
            None if color_by == ELEMENT_COLOR => return Ok(None),
            _ => {}
        }
    }
    let coloring = coloring(color_by, surface, field)?;
    Ok(Some(BaseColor::Attribute(Box::new(coloring))))
}

/// The attribute and the number of it that `reference` names.
fn attribute_number(reference: &str, field: &BlobField) -> Result<(usize, Component), FrameError> {
    let position = |name: &str| field.attributes.iter().position(|a| a.name == name);
    let unknown = || FrameError::UnknownAttribute {
        name: reference.to_owned(),
        known: field
            .attributes
            .iter()
            .map(|attribute| attribute.name.as_str())
            .collect::<Vec<_>>()
            .join(", "),
    };
    let found =
        AttributeRef::parse(reference, |name| position(name).is_some()).ok_or_else(unknown)?;
    let index = position(&found.column).ok_or_else(unknown)?;
    let attribute = &field.attributes[index];
    if let Component::Index(component) = found.component
        && component >= attribute.components
    {
        return Err(FrameError::NoSuchComponent {
            name: found.column,
            components: attribute.components,
            written: reference.to_owned(),
        });
    }
    Ok((index, found.component))
}

pub(super) fn scaling(
    reference: &str,
    range: [f64; 2],
    field: &BlobField,
) -> Result<Scaling, FrameError> {
    let (attribute, component) = attribute_number(reference, field)?;
    Ok(Scaling {
        attribute,
        component,
        range: range.map(|end| end as f32),
    })
}

fn coloring(color_by: &str, surface: &Surface, field: &BlobField) -> Result<Coloring, FrameError> {
    let (index, component) = attribute_number(color_by, field)?;
    let attribute = &field.attributes[index];
    let range = match surface.color_range {
        Some(range) => range.map(|end| end as f32),
        None => value_range(attribute, component),
    };
    Ok(Coloring {
        attribute: index,
        component,
        range,
        table: surface.color_map.unwrap_or_default().table(),
        label: color_by.to_owned(),
    })
}

/// Part of the finite values left beyond each end of an automatic colour range, so that a few stray
/// particles do not take the colours from all others.
const RANGE_TAIL: f64 = 0.01;

/// The finite values without [`RANGE_TAIL`] at either end; 0 and 1 if there is none.
fn value_range(attribute: &FieldAttribute, component: Component) -> [f32; 2] {
    let mut values: Vec<f32> = attribute
        .data
        .chunks_exact(attribute.components.max(1))
        .map(|value| component.of(value))
        .filter(|number| number.is_finite())
        .collect();
    if values.is_empty() {
        return [0.0, 1.0];
    }
    let last = values.len() - 1;
    let tail = (RANGE_TAIL * last as f64) as usize;
    [tail, last - tail].map(|rank| *values.select_nth_unstable_by(rank, f32::total_cmp).1)
}
