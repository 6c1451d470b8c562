//! `meniscus info`: what a particle file or scene holds.

use crate::args::info::InfoArgs;
use crate::exit::{Failure, Outcome};
use crate::job::engine::EngineChoice;
use crate::job::input::{self, FrameInput, Inputs};
use crate::job::scene::{apply_camera, apply_surface, scene_failure};
use crate::progress::Reporter;
use meniscus::field::BlobField;
use meniscus::frame::MeshSurface;
use meniscus::math::DVec3;
use meniscus::math::aabb::DAabb;
use meniscus::mesh;
use meniscus::particles::io::{self, ParticleFile};
use meniscus::particles::{Column, spacing};
use meniscus::scene::{BlobSettings, Scene, Surface, Weights};
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// What `info --json` prints: the keys of the contract, and a few more.
#[derive(Debug, Serialize)]
struct Info {
    file: String,
    format: &'static str,
    particles: usize,
    frames: usize,
    columns: Vec<ColumnInfo>,
    bounds: Option<Bounds>,
    spacing: Option<f64>,
    /// The radius that the support comes from; null where the supports come from elsewhere.
    radius: Option<f64>,
    /// The largest support radius.
    support: Option<f64>,
    support_min: Option<f64>,
    /// Mean number of particles within the support of one, itself not counted.
    neighbours_per_support: Option<f64>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct ColumnInfo {
    name: String,
    #[serde(rename = "type")]
    kind: &'static str,
    components: usize,
    /// Smallest finite number; of vectors over all components.
    min: Option<f64>,
    max: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Bounds {
    min: [f64; 3],
    max: [f64; 3],
}

/// What is said of a `[[mesh]]`.
#[derive(Debug, Serialize)]
struct MeshInfo {
    file: String,
    format: &'static str,
    vertices: usize,
    triangles: usize,
    /// Whether it encloses something.
    closed: bool,
    bounds: Option<Bounds>,
    warnings: Vec<String>,
}

/// The contract's object, one per surface where a scene has several, and what else stands in it.
#[derive(Debug, Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    first: Option<&'a Info>,
    #[serde(skip_serializing_if = "<[Info]>::is_empty")]
    surfaces: &'a [Info],
    #[serde(skip_serializing_if = "<[MeshInfo]>::is_empty")]
    meshes: &'a [MeshInfo],
}

/// Runs the command.
pub(crate) fn run(args: &InfoArgs) -> Outcome {
    let reporter = Reporter::new(&args.messages);
    EngineChoice::new(&args.engine)?;
    let edit = |scene: &mut Scene| {
        apply_surface(&args.surface, scene)?;
        apply_camera(&args.camera, scene)?;
        scene.validate().map_err(scene_failure)
    };
    let inputs = input::resolve(std::slice::from_ref(&args.input), None, &edit)?;
    let first = inputs.first();
    let mut all = Vec::new();
    for (surface, path) in first.scene.surfaces.iter().zip(&first.files) {
        all.push(info(surface, path, &inputs)?);
    }
    let meshes: Vec<MeshInfo> = (first.scene.meshes.iter())
        .map(|mesh| mesh_info(&mesh.file))
        .collect::<Outcome<_>>()?;
    if all.is_empty() && meshes.is_empty() {
        return Err(Failure::wrong("the scene has no surface and no mesh"));
    }
    let text = if args.json {
        let printed = Printed {
            first: all.first(),
            surfaces: if all.len() > 1 { &all } else { &[] },
            meshes: &meshes,
        };
        serde_json::to_string_pretty(&printed).map_err(|error| Failure::work(error.to_string()))?
    } else {
        let surfaces = all.iter().map(described);
        let texts: Vec<String> = surfaces.chain(meshes.iter().map(described_mesh)).collect();
        texts.join("\n")
    };
    if args.json {
        let of_meshes = meshes.iter().flat_map(|mesh| &mesh.warnings);
        for warning in all.iter().flat_map(|info| &info.warnings).chain(of_meshes) {
            reporter.note(&format!("warning: {warning}"));
        }
    }
    writeln!(std::io::stdout(), "{text}")
        .map_err(|error| Failure::work(format!("cannot print: {error}")))
}

fn info(surface: &Surface, path: &Path, inputs: &Inputs) -> Outcome<Info> {
    let FrameInput { step, .. } = *inputs.first();
    let file = io::read(path, step).map_err(|error| Failure::work(error.to_string()))?;
    let settings = surface.settings(&BlobSettings::of_format(file.format));
    let mut warnings = file.warnings.clone();
    let built = BlobField::from_particles(&file.particles, &settings);
    let (radius, support, support_min, neighbours, gap) = match &built {
        Ok(built) => {
            let report = &built.report;
            warnings.extend(report.warnings.iter().cloned());
            (
                radius(&settings, report.support_max),
                Some(report.support_max),
                Some(report.support_min),
                neighbours(&built.field),
                report.spacing,
            )
        }
        Err(error) => {
            warnings.push(error.to_string());
            let finite = file.particles.positions.iter().filter(|p| p.is_finite());
            let finite: Vec<DVec3> = finite.copied().collect();
            (None, None, None, None, spacing::median_spacing(&finite))
        }
    };
    Ok(Info {
        file: path.display().to_string(),
        format: file.format.name(),
        particles: file.particles.len(),
        frames: frames(inputs, &file),
        columns: columns(&file),
        bounds: bounds(&file.particles.positions),
        spacing: gap,
        radius,
        support,
        support_min,
        neighbours_per_support: neighbours,
        warnings,
    })
}

fn mesh_info(path: &Path) -> Outcome<MeshInfo> {
    let file = mesh::io::read(path).map_err(|error| Failure::wrong(error.to_string()))?;
    let (surface, notes) = MeshSurface::build(&file.mesh);
    Ok(MeshInfo {
        file: path.display().to_string(),
        format: file.format.name(),
        vertices: file.mesh.positions.len(),
        triangles: file.mesh.triangles.len(),
        closed: surface.is_closed,
        bounds: bounds(&file.mesh.positions),
        warnings: file.warnings.into_iter().chain(notes).collect(),
    })
}

fn described_mesh(mesh: &MeshInfo) -> String {
    let mut text = format!(
        "{}: {} mesh, {} vertices, {} triangles, {}",
        mesh.file,
        mesh.format,
        mesh.vertices,
        mesh.triangles,
        if mesh.closed { "closed" } else { "open" },
    );
    if let Some(bounds) = &mesh.bounds {
        let corner = |corner: [f64; 3]| corner.map(shown).join(", ");
        let (min, max) = (corner(bounds.min), corner(bounds.max));
        text += &format!("\n  bounds   {min}\n        to {max}");
    }
    for warning in &mesh.warnings {
        text += &format!("\n  warning: {warning}");
    }
    text
}

fn frames(inputs: &Inputs, file: &ParticleFile) -> usize {
    if inputs.is_sequence {
        inputs.frames.len()
    } else {
        file.frames.max(1)
    }
}

fn bounds(positions: &[DVec3]) -> Option<Bounds> {
    let finite = positions.iter().filter(|p| p.is_finite());
    let bounds = finite.fold(DAabb::EMPTY, |bounds, &p| bounds.including(p));
    (!bounds.is_empty()).then(|| Bounds {
        min: bounds.min.to_array(),
        max: bounds.max.to_array(),
    })
}

fn columns(file: &ParticleFile) -> Vec<ColumnInfo> {
    let info = |column: &Column| {
        let numbers = (0..column.data.len()).map(|i| column.data.get(i));
        let range = numbers.filter(|number| number.is_finite()).fold(
            None,
            |range: Option<(f64, f64)>, number| {
                let (low, high) = range.unwrap_or((number, number));
                Some((low.min(number), high.max(number)))
            },
        );
        ColumnInfo {
            name: column.name.clone(),
            kind: column.data.type_name(),
            components: column.components,
            min: range.map(|(low, _)| low),
            max: range.map(|(_, high)| high),
        }
    };
    file.particles.columns.iter().map(info).collect()
}

/// The radius behind the largest support: R over the factor of its rule.
fn radius(settings: &BlobSettings, support: f64) -> Option<f64> {
    if settings.support.is_some() {
        return None;
    }
    match settings.weights {
        Weights::Volume | Weights::BallVolume => Some(support / settings.smoothing),
        Weights::Unit | Weights::Column(_) => {
            let q = settings.kernel.q_at(settings.threshold)?;
            Some(support * q.sqrt())
        }
    }
}

/// Mean number of other particles in whose support a particle lies: with equal supports, those within
/// its own.
fn neighbours(field: &BlobField) -> Option<f64> {
    if field.is_empty() {
        return None;
    }
    let mut found = 0u64;
    for i in 0..field.len() {
        field.for_each_blob_at(field.center(i).as_dvec3(), |j, _, _| {
            found += u64::from(j != i)
        });
    }
    Some(found as f64 / field.len() as f64)
}

fn described(info: &Info) -> String {
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), shown);
    let mut text = format!(
        "{}: {}, {} particles, {} {}\n",
        info.file,
        info.format,
        info.particles,
        info.frames,
        if info.frames == 1 { "frame" } else { "frames" },
    );
    if let Some(bounds) = &info.bounds {
        let corner = |corner: [f64; 3]| corner.map(shown).join(", ");
        text += &format!(
            "  bounds   {}\n        to {}\n",
            corner(bounds.min),
            corner(bounds.max)
        );
    }
    text += &format!(
        "  spacing {}, radius {}, support {}, {} neighbours per support\n",
        number(info.spacing),
        number(info.radius),
        number(info.support),
        number(info.neighbours_per_support),
    );
    for column in &info.columns {
        let kind = match column.components {
            1 => column.kind.to_owned(),
            n => format!("{n} x {}", column.kind),
        };
        text += &format!(
            "  column {:<16} {kind:<8} {} to {}\n",
            column.name,
            number(column.min),
            number(column.max)
        );
    }
    for warning in &info.warnings {
        text += &format!("  warning: {warning}\n");
    }
    text.trim_end().to_owned()
}

/// Six digits, without noise.
fn shown(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let digits = if value == 0.0 {
            0.0
        } else {
            value.abs().log10().floor()
        };
        let decimals = (5.0 - digits).clamp(0.0, 8.0) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') {
            return text.trim_end_matches('0').trim_end_matches('.').to_owned();
        }
        return text;
    }
    format!("{value:.4e}")
}
