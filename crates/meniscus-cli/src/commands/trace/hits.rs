//! Hits to an NPZ file.

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::job::device::{Tracing, trace_failure};
use crate::progress::Reporter;
use meniscus::film::{FilmError, write_aside};
use meniscus::frame::{Blobs, Frame, Instance};
use meniscus::intersect::{Crossing, Hit, Scratch, TraceError};
use meniscus::math::DVec3;
use meniscus::math::ray::Ray;
use meniscus::shade::frame_attributes;
use npyz::WriterBuilder;
use npyz::npz::NpzWriter;
use rayon::prelude::*;
use std::io::{Seek, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// Rays that one task traces with the same buffers.
const CHUNK: usize = 4096;

/// What to ask each ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Question {
    /// The first crossing.
    Closest,
    /// Whether there is one.
    Any,
    /// Every crossing.
    All,
}

/// What the rays answered, as arrays.
pub(crate) enum Answers {
    /// The first crossing of each ray.
    Closest {
        /// NaN-free; infinite on a miss.
        t: Vec<f64>,
        /// Outward normals, 0 on a miss.
        normal: Vec<[f32; 3]>,
        /// Row of the strongest particle, −1 on a miss and beside particles.
        id: Vec<i64>,
        /// Index of the surface, −1 on a miss.
        surface: Vec<i32>,
        /// Whether the ray starts inside.
        inside: Vec<bool>,
        /// Name, components and numbers of each attribute.
        attributes: Vec<(String, usize, Vec<f32>)>,
    },
    /// Whether each ray is blocked.
    Any(Vec<bool>),
    /// Every crossing, ray by ray.
    All {
        /// Index of the ray.
        ray: Vec<i64>,
        /// Where.
        t: Vec<f64>,
        /// From outside to inside.
        entering: Vec<bool>,
    },
}

/// One ray's first hit.
struct Closest {
    hit: Option<Hit>,
    id: i64,
    inside: bool,
    attributes: Vec<f32>,
}

impl Answers {
    /// Traces all rays.
    pub(crate) fn of(
        question: Question,
        frame: &Frame,
        tracing: &Tracing<'_>,
        rays: &[Ray],
        reporter: &Reporter,
    ) -> Outcome<Self> {
        match question {
            Question::Any => {
                let occluded = match tracing {
                    Tracing::Cpu => traced(rays, reporter, |ray, scratch| {
                        ray.is_traceable() && frame.any_hit(ray, scratch)
                    })?,
                    Tracing::Gpu(_) | Tracing::Peel(_) => {
                        traced_together(rays, tracing, reporter, |rays, scratch| {
                            let mut hits = vec![false; rays.len()];
                            let asked = only_traceable(rays);
                            tracing.any_hits(frame, &asked, &mut hits, scratch)?;
                            Ok(hits)
                        })?
                    }
                };
                Ok(Self::Any(occluded))
            }
            Question::All => {
                let found = match tracing {
                    Tracing::Cpu => traced(rays, reporter, |ray, scratch| {
                        let mut crossings = Vec::new();
                        frame.crossings(ray, scratch, &mut crossings);
                        crossings
                    })?,
                    Tracing::Gpu(_) | Tracing::Peel(_) => {
                        traced_together(rays, tracing, reporter, |rays, scratch| {
                            let mut crossings = vec![Vec::new(); rays.len()];
                            tracing.crossings(frame, rays, &mut crossings, scratch)?;
                            Ok(crossings)
                        })?
                    }
                };
                Ok(Self::all(&found))
            }
            Question::Closest => {
                let layout = frame_attributes(frame);
                let found = match tracing {
                    Tracing::Cpu => traced(rays, reporter, |ray, scratch| {
                        let traceable = ray.is_traceable();
                        let hit = traceable.then(|| frame.closest_hit(ray, scratch)).flatten();
                        closest(frame, &layout, ray, hit, scratch)
                    })?,
                    Tracing::Gpu(_) | Tracing::Peel(_) => {
                        traced_together(rays, tracing, reporter, |rays, scratch| {
                            let mut hits = vec![None; rays.len()];
                            let asked = only_traceable(rays);
                            tracing.closest_hits(frame, &asked, &mut hits, scratch)?;
                            let answers = rays.iter().zip(hits);
                            Ok(answers
                                .map(|(ray, hit)| closest(frame, &layout, ray, hit, scratch))
                                .collect())
                        })?
                    }
                };
                Ok(Self::closest(&found, layout))
            }
        }
    }

    fn all(found: &[Vec<Crossing>]) -> Self {
        let (mut ray, mut t, mut entering) = (Vec::new(), Vec::new(), Vec::new());
        for (index, crossings) in found.iter().enumerate() {
            for crossing in crossings {
                ray.push(index as i64);
                t.push(crossing.t);
                entering.push(crossing.entering);
            }
        }
        Self::All { ray, t, entering }
    }

    fn closest(found: &[Closest], layout: Vec<(String, usize)>) -> Self {
        let mut offset = 0;
        let attributes = layout.into_iter().map(|(name, components)| {
            let place = offset..offset + components;
            offset += components;
            let numbers = found
                .iter()
                .flat_map(|one| one.attributes[place.clone()].iter());
            (name, components, numbers.copied().collect())
        });
        let attributes = attributes.collect();
        let hits = || found.iter().map(|one| one.hit.as_ref());
        Self::Closest {
            t: hits()
                .map(|hit| hit.map_or(f64::INFINITY, |hit| hit.t))
                .collect(),
            normal: hits()
                .map(|hit| hit.map_or([0.0; 3], |hit| hit.normal.as_vec3().to_array()))
                .collect(),
            id: found.iter().map(|one| one.id).collect(),
            surface: hits()
                .map(|hit| hit.map_or(-1, |hit| hit.surface as i32))
                .collect(),
            inside: found.iter().map(|one| one.inside).collect(),
            attributes,
        }
    }

    /// Writes the arrays, aside first.
    pub(crate) fn write(&self, path: &Path) -> Outcome {
        write_aside(path, |out| {
            let mut archive = NpzWriter::new(out);
            self.write_arrays(&mut archive)
                .map_err(|source| FilmError::Write {
                    path: path.to_owned(),
                    source,
                })
        })
        .map_err(|error| Failure::work(error.to_string()))
    }

    fn write_arrays<W: Write + Seek>(&self, archive: &mut NpzWriter<W>) -> std::io::Result<()> {
        match self {
            Self::Any(occluded) => array(archive, "occluded", &[], occluded),
            Self::All { ray, t, entering } => {
                array(archive, "ray", &[], ray)?;
                array(archive, "t", &[], t)?;
                array(archive, "entering", &[], entering)
            }
            Self::Closest {
                t,
                normal,
                id,
                surface,
                inside,
                attributes,
            } => {
                array(archive, "t", &[], t)?;
                array(archive, "normal", &[3], normal.as_flattened())?;
                array(archive, "id", &[], id)?;
                array(archive, "surface", &[], surface)?;
                array(archive, "inside", &[], inside)?;
                for (name, components, numbers) in attributes {
                    // The fixed names keep their meaning.
                    let taken = ["t", "normal", "id", "surface", "inside"].contains(&name.as_str());
                    let name = if taken {
                        format!("attribute.{name}")
                    } else {
                        name.clone()
                    };
                    let shape: &[u64] = match components {
                        1 => &[],
                        _ => &[*components as u64],
                    };
                    array(archive, &name, shape, numbers)?;
                }
                Ok(())
            }
        }
    }
}

/// Writes one array of shape (n, ..tail).
fn array<T: npyz::AutoSerialize + Copy, W: Write + Seek>(
    archive: &mut NpzWriter<W>,
    name: &str,
    tail: &[u64],
    values: &[T],
) -> std::io::Result<()> {
    let per_row: u64 = tail.iter().product();
    let mut shape = vec![values.len() as u64 / per_row.max(1)];
    shape.extend(tail);
    let options = Default::default();
    let mut writer = archive
        .array::<T>(name, options)?
        .default_dtype()
        .shape(&shape)
        .begin_nd()?;
    writer.extend(values.iter().copied())?;
    writer.finish()
}

/// Asks every ray, in parallel, in order.
fn traced<T: Send>(
    rays: &[Ray],
    reporter: &Reporter,
    ask: impl Fn(&Ray, &mut Scratch) -> T + Sync,
) -> Outcome<Vec<T>> {
    let done = AtomicU64::new(0);
    let chunks: Vec<Vec<T>> = rays
        .par_chunks(CHUNK)
        .map_init(Scratch::default, |scratch, chunk| {
            if interrupt::check().is_err() {
                return Vec::new();
            }
            let answers = chunk.iter().map(|ray| ask(ray, scratch)).collect();
            let before = done.fetch_add(chunk.len() as u64, Ordering::Relaxed);
            reporter.advance(before + chunk.len() as u64, rays.len() as u64);
            answers
        })
        .collect();
    interrupt::check()?;
    Ok(chunks.into_iter().flatten().collect())
}

/// Asks rays many at a time, in parallel, in order.
fn traced_together<T: Send>(
    rays: &[Ray],
    tracing: &Tracing<'_>,
    reporter: &Reporter,
    ask: impl Fn(&[Ray], &mut Scratch) -> Result<Vec<T>, TraceError> + Sync,
) -> Outcome<Vec<T>> {
    let done = AtomicU64::new(0);
    let chunks: Vec<Vec<T>> = rays
        .par_chunks(tracing.together(CHUNK))
        .map_init(Scratch::default, |scratch, chunk| {
            interrupt::check()?;
            let answers = ask(chunk, scratch).map_err(|error| trace_failure(&error))?;
            let before = done.fetch_add(chunk.len() as u64, Ordering::Relaxed);
            reporter.advance(before + chunk.len() as u64, rays.len() as u64);
            Ok(answers)
        })
        .collect::<Outcome<_>>()?;
    Ok(chunks.into_iter().flatten().collect())
}

/// The rays, with those that are none replaced by some that hit nothing.
fn only_traceable(rays: &[Ray]) -> Vec<Ray> {
    let nothing = Ray::new(DVec3::ZERO, DVec3::X).with_range(0.0, -1.0);
    let replaced = |ray: &Ray| if ray.is_traceable() { *ray } else { nothing };
    rays.iter().map(replaced).collect()
}

fn blobs_of(frame: &Frame, surface: usize) -> Option<(&Blobs, &Instance)> {
    let instance = &frame.instances[surface];
    let blobs = frame.geometries[instance.geometry as usize].blobs()?;
    Some((blobs, instance))
}

/// All that is asked about a ray's first hit.
fn closest(
    frame: &Frame,
    layout: &[(String, usize)],
    ray: &Ray,
    hit: Option<Hit>,
    scratch: &mut Scratch,
) -> Closest {
    let numbers = layout.iter().map(|(_, components)| components).sum();
    let mut attributes = vec![0.0; numbers];
    let blobs = hit.and_then(|hit| Some((hit, blobs_of(frame, hit.surface as usize)?)));
    let mut id = -1;
    if let Some((hit, (blobs, instance))) = blobs {
        let field = &blobs.field;
        let row = hit.blob.and_then(|blob| field.rows.get(blob as usize));
        id = row.map_or(-1, |&row| i64::from(row));
        let object_from_world = instance.at(ray.time).object_from_world;
        let local = object_from_world.transform_point3(hit.position) - field.origin;
        for (index, attribute) in field.attributes.iter().enumerate() {
            let mut offset = 0;
            for (name, components) in layout {
                if *name == attribute.name {
                    let value = field.attribute(index, local);
                    for (to, from) in attributes[offset..offset + components]
                        .iter_mut()
                        .zip(value)
                    {
                        *to = from as f32;
                    }
                }
                offset += components;
            }
        }
    }
    Closest {
        inside: ray.is_traceable() && frame.starts_inside(ray, scratch),
        hit,
        id,
        attributes,
    }
}
