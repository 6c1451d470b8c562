//! From a scene and its fields to a frame.

use super::colors::{base_color, scaling};
use super::looks::{Absorption, BaseColor, GroundLook, Light, Material};
use super::{Blobs, Environment, EnvironmentError, Frame, Geometry, Instance};
use super::{MeshSurface, Plane, Sphere};
use crate::accel::Engine;
use crate::field::BlobField;
use crate::math::simd::Level;
use crate::scene::camera::horizontal_axes;
use crate::scene::{self, EngineSettings, LightKind, Scene, Surface};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// How a frame's surfaces are traced.
#[derive(Debug, Clone, Copy)]
pub struct FrameSettings {
    /// The engine.
    pub engine: Engine,
    /// Its switches; [`Scene::engine`] holds what the scene says.
    pub switches: EngineSettings,
    /// The SIMD level.
    pub level: Level,
}

impl Default for FrameSettings {
    fn default() -> Self {
        Self {
            engine: Engine::default(),
            switches: EngineSettings::default(),
            level: Level::new(),
        }
    }
}

/// A scene that does not fit its fields.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// One field per surface is needed.
    #[error("the scene has {surfaces} surfaces, but {fields} fields were given")]
    FieldCount {
        /// Surfaces of the scene.
        surfaces: usize,
        /// Fields given.
        fields: usize,
    },
    /// One mesh per `[[mesh]]` is needed.
    #[error("the scene has {wanted} meshes, but {given} were given")]
    MeshCount {
        /// Meshes of the scene.
        wanted: usize,
        /// Meshes given.
        given: usize,
    },
    /// A surface looks as an attribute says that its field does not carry.
    #[error("there is no attribute `{name}` to colour by; there are: {known}")]
    UnknownAttribute {
        /// The attribute as written.
        name: String,
        /// The attributes that the field carries.
        known: String,
    },
    /// A component beyond the attribute's last.
    #[error("attribute `{name}` has {components} components, so `{written}` does not exist")]
    NoSuchComponent {
        /// The attribute.
        name: String,
        /// How many components it has.
        components: usize,
        /// The reference as written.
        written: String,
    },
    /// An engine that was asked for by name and knows still blobs only.
    #[error(
        "engine {engine} traces still particles only; particles, interval and sweep trace moving ones"
    )]
    StandsStill {
        /// Its name.
        engine: &'static str,
    },
    /// A name that the scene does not define; [`Scene::validate`] reports it with its place.
    #[error("the scene defines no {kind} `{name}`")]
    UnknownName {
        /// Material or surface.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// An environment image that cannot be used.
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
}

impl Frame {
    /// The frame of a scene without meshes: [`Frame::build_with_meshes`].
    ///
    /// # Errors
    /// As there.
    pub fn build(
        scene: &Scene,
        fields: Vec<BlobField>,
        settings: &FrameSettings,
    ) -> Result<Self, FrameError> {
        Self::build_with_meshes(scene, fields, Vec::new(), settings)
    }

    /// The frame of `scene` with one field per surface and one mesh per `[[mesh]]`, in the scene's
    /// order.
    ///
    /// Instances come in this order: for each surface its `[[instance]]`s (or itself once), then the
    /// meshes, the spheres, the planes, the ground.
    ///
    /// # Errors
    /// When a surface's colour, material or instance refers to something that is not there.
    pub fn build_with_meshes(
        scene: &Scene,
        fields: Vec<BlobField>,
        meshes: Vec<MeshSurface>,
        settings: &FrameSettings,
    ) -> Result<Self, FrameError> {
        if meshes.len() != scene.meshes.len() {
            return Err(FrameError::MeshCount {
                wanted: scene.meshes.len(),
                given: meshes.len(),
            });
        }
        if fields.len() != scene.surfaces.len() {
            return Err(FrameError::FieldCount {
                surfaces: scene.surfaces.len(),
                fields: fields.len(),
            });
        }
        let up = scene.camera.up.vector();
        let mut frame = Self {
            lights: resolved_lights(scene, up)?,
            up,
            background: scene.film.background,
            clips: scene.clips.iter().map(clip_plane).collect(),
            ..Self::default()
        };
        for (surface, field) in scene.surfaces.iter().zip(fields) {
            frame.add_surface(scene, surface, field, settings)?;
        }
        check_instances(scene)?;
        let material = |name| plain_material(scene, name, scene::Material::default);
        for (placed, mesh) in scene.meshes.iter().zip(meshes) {
            let material = material(placed.material.as_deref())?;
            frame.add_solid(Geometry::Mesh(Box::new(mesh)), placed.matrix.0, material);
        }
        for sphere in &scene.spheres {
            let material = material(sphere.material.as_deref())?;
            let geometry = Geometry::Sphere(Sphere {
                center: sphere.center,
                radius: sphere.radius,
            });
            frame.add_solid(geometry, DAffine3::IDENTITY, material);
        }
        for plane in &scene.planes {
            let material = plain_material(scene, plane.material.as_deref(), ground_material)?;
            let normal = plane.normal.unwrap_or(up).normalize_or(up);
            frame.add_plane(plane.point, normal, material);
        }
        if let Some(ground) = &scene.ground {
            let material = plain_material(scene, ground.material.as_deref(), ground_material)?;
            frame.add_ground(ground.height, material);
        }
        frame.set_absorption_depths();
        Ok(frame)
    }

    fn add_surface(
        &mut self,
        scene: &Scene,
        surface: &Surface,
        field: BlobField,
        settings: &FrameSettings,
    ) -> Result<(), FrameError> {
        if field.motion.is_some()
            && matches!(settings.engine, Engine::MetaballBvh | Engine::FittedBvh)
        {
            return Err(FrameError::StandsStill {
                engine: settings.engine.name(),
            });
        }
        let base = match surface.color_by.as_deref() {
            None => None,
            Some(color_by) => base_color(color_by, surface, &field)?,
        };
        let scaling = |by: &Option<String>, range: Option<[f64; 2]>| {
            by.as_deref()
                .map(|by| scaling(by, range.unwrap_or([0.0, 1.0]), &field))
                .transpose()
        };
        let roughness_by = scaling(&surface.roughness_by, surface.roughness_range)?;
        let density = scaling(&surface.absorption_by, surface.absorption_range)?;
        let material_of = |name: Option<&str>| -> Result<Material, FrameError> {
            let mut material = plain_material(scene, name, scene::Material::default)?;
            if let Some(base) = &base {
                material.base = base.clone();
                material.absorption.left = material.base.clone();
            }
            material.roughness_by.clone_from(&roughness_by);
            material.absorption.density.clone_from(&density);
            Ok(material)
        };
        let placements: Vec<_> = scene
            .instances
            .iter()
            .filter(|instance| Some(&instance.surface) == surface.name.as_ref())
            .collect();
        let geometry = self.geometries.len() as u32;
        let own_material = self.materials.len() as u32;
        self.materials
            .push(material_of(surface.material.as_deref())?);
        if placements.is_empty() {
            let here = Instance::new(geometry, DAffine3::IDENTITY, own_material);
            self.instances.push(here);
        }
        for placement in placements {
            let material = match placement.material.as_deref() {
                None => own_material,
                Some(name) => {
                    self.materials.push(material_of(Some(name))?);
                    self.materials.len() as u32 - 1
                }
            };
            self.instances.push(match &placement.keys[..] {
                [] => Instance::new(geometry, placement.matrix.0, material),
                keys => {
                    let motion = &scene.motion;
                    let shutter = motion.shutter_secs();
                    Instance::moving(geometry, keys, motion.time, shutter, material)
                }
            });
        }
        let blobs = Blobs::build_with(field, settings.engine, settings.switches, settings.level);
        self.geometries.push(Geometry::Blobs(Box::new(blobs)));
        Ok(())
    }

    /// Gives clear materials that state no depth one that suits what the frame shows.
    fn set_absorption_depths(&mut self) {
        let is_open = |material: &Material| material.absorption.depth == 0.0;
        if !self
            .materials
            .iter()
            .any(|m| m.kind.is_clear() && is_open(m))
        {
            return;
        }
        let size = self.framing_bounds().size().max_element();
        let depth = if size.is_finite() && size > 0.0 {
            0.5 * size
        } else {
            1.0
        };
        for material in &mut self.materials {
            if is_open(material) {
                material.absorption.depth = depth;
            }
        }
    }

    fn add_plane(&mut self, point: DVec3, normal: DVec3, material: Material) {
        let plane = Geometry::Plane(Plane { point, normal });
        self.add_solid(plane, DAffine3::IDENTITY, material);
    }

    fn add_solid(&mut self, geometry: Geometry, matrix: DAffine3, material: Material) {
        let index = self.geometries.len() as u32;
        let own_material = self.materials.len() as u32;
        self.geometries.push(geometry);
        self.materials.push(material);
        self.instances
            .push(Instance::new(index, matrix, own_material));
    }

    /// A plane under the middle of [`Frame::framing_bounds`].
    fn add_ground(&mut self, height: Option<f64>, material: Material) {
        let bounds = self.framing_bounds();
        let (center, half) = if bounds.is_empty() {
            (DVec3::ZERO, DVec3::ZERO)
        } else {
            (bounds.center(), bounds.size() * 0.5)
        };
        let lowest = center.dot(self.up) - half.dot(self.up.abs());
        let height = height.unwrap_or(lowest);
        let foot = center + self.up * (height - center.dot(self.up));
        let radius = 2.0 * half.length();
        self.ground = Some(GroundLook {
            surface: self.instances.len() as u32,
            center: foot,
            radius: if radius > 0.0 { radius } else { 1.0 },
        });
        self.add_plane(foot, self.up, material);
    }
}

fn clip_plane(clip: &scene::Clip) -> Plane {
    Plane {
        point: clip.point,
        normal: clip.normal.normalize_or(DVec3::Y),
    }
}

fn check_instances(scene: &Scene) -> Result<(), FrameError> {
    let known = |name: &String| scene.surfaces.iter().any(|s| s.name.as_ref() == Some(name));
    match scene.instances.iter().find(|i| !known(&i.surface)) {
        None => Ok(()),
        Some(instance) => Err(FrameError::UnknownName {
            kind: "surface",
            name: instance.surface.clone(),
        }),
    }
}

/// What planes and the ground are made of where the scene does not say: pale and without highlight.
fn ground_material() -> scene::Material {
    scene::Material::diffuse(scene::Color([0.45, 0.445, 0.435]))
}

fn plain_material(
    scene: &Scene,
    name: Option<&str>,
    default: impl Fn() -> scene::Material,
) -> Result<Material, FrameError> {
    let material = match name {
        None => default(),
        Some(name) => {
            scene
                .materials
                .get(name)
                .cloned()
                .ok_or_else(|| FrameError::UnknownName {
                    kind: "material",
                    name: name.to_owned(),
                })?
        }
    };
    Ok(Material {
        kind: material.kind,
        base: BaseColor::Constant(material.effective_color().to_f32()),
        specular: material.effective_specular() as f32,
        roughness: material.effective_roughness() as f32,
        roughness_by: None,
        ior: material.effective_ior(),
        absorption: Absorption {
            left: BaseColor::Constant(material.effective_absorption().to_f32()),
            // 0 until `Frame::set_absorption_depths`.
            depth: match material.is_thin() {
                true => 1.0,
                false => material.absorption_depth.unwrap_or(0.0),
            },
            density: None,
        },
        thin: material.is_thin(),
        priority: material.effective_priority(),
        translucency: material.effective_translucency() as f32,
    })
}

fn resolved_lights(scene: &Scene, up: DVec3) -> Result<Vec<Light>, FrameError> {
    let defaults;
    let lights = if scene.lights.is_empty() {
        defaults = scene::Light::defaults(up);
        &defaults
    } else {
        &scene.lights
    };
    lights
        .iter()
        .map(|light| {
            let color = light.color.unwrap_or(scene::Color::WHITE).0;
            let radiance = color.map(|c| (c * light.intensity) as f32);
            let center = light.position.unwrap_or(DVec3::ZERO);
            Ok(match light.kind {
                LightKind::Sun => {
                    let angle = light.angle.unwrap_or(scene::Light::DEFAULT_ANGLE);
                    Light::Sun {
                        towards: light.direction.unwrap_or(up).normalize_or(up),
                        radiance,
                        half_angle: 0.5 * angle.to_radians(),
                    }
                }
                LightKind::Sky => Light::Sky { radiance },
                LightKind::Constant => Light::Constant { radiance },
                LightKind::Point => Light::Point {
                    position: center,
                    radiance,
                },
                LightKind::Sphere => Light::Sphere {
                    center,
                    radius: light.radius.unwrap_or(1.0),
                    radiance,
                },
                LightKind::Rectangle => Light::Rectangle {
                    center,
                    edges: light.edges.unwrap_or([DVec3::X, DVec3::Y]),
                    radiance,
                },
                LightKind::Environment => {
                    let [right, back] = horizontal_axes(up);
                    let path = light.file.clone().unwrap_or_default();
                    let rotation = light.rotation.unwrap_or(0.0).to_radians();
                    Light::Environment {
                        environment: Arc::new(Environment::read(
                            &path,
                            [right, up, -back],
                            rotation,
                        )?),
                        scale: radiance,
                    }
                }
            })
        })
        .collect()
}
