#!/usr/bin/env python3
"""A frame of water: traced directly by Meniscus, and meshed by splashsurf and traced by Blender's
Cycles. Both path tracers are unbiased to the same depth, with the same camera, water, ground, lights
and samples; both pictures are kept, linear and side by side.

  cargo build --release; pip install bpy (needs the Python that bpy names); pip install pysplashsurf
  PYTHON_WITH_BPY benches/against_cycles.py --out FOLDER [--program target/release/meniscus]
      [--splashsurf pysplashsurf] [--count 60000] [--size 1280x720] [--spp 64] [--cell 0.5] [--threads 2]
"""

import argparse
import json
import math
import os
import subprocess
import sys
import time
import tomllib

import bpy
import mathutils
import numpy

IOR, LEFT, DEPTH = 1.333, (0.13, 0.58, 0.72), 0.3  # of white light behind that depth of water
SUN, SKY, GROUND = 1.5, 0.5, 0.45  # radiance of white in the sun, of the sky; albedo
SUN_TOWARDS, SUN_DEGREES = (0.435541, 0.725901, 0.532327), 0.533
BOUNCES = 8


def run(*words):
    start = time.perf_counter()
    subprocess.run(words, check=True, capture_output=True)
    return time.perf_counter() - start


def scene_of(words):
    """The generated frame in the light that both can make; and its parts."""
    points = f"{words.out}/splash.vtk"
    if not os.path.exists(points):
        run(words.program, "generate", "splash", "-o", points, "--count", str(words.count), "-q")
    with open(points.replace(".vtk", ".toml"), "rb") as file:
        scene = tomllib.load(file)
    width, height = map(int, words.size.split("x"))
    scene["film"] = {"width": width, "height": height, "spp": words.spp, "background": "sky"}
    scene["integrator"] = {"type": "path", "depth": BOUNCES}
    scene.pop("ground", None)
    scene["plane"] = [{"point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor"}]
    scene["light"] = [
        {"type": "sun", "direction": SUN_TOWARDS, "angle": SUN_DEGREES, "intensity": SUN},
        {"type": "constant", "intensity": SKY},
    ]
    scene["material"] = {
        "water": {"type": "water", "ior": IOR, "absorption": LEFT, "absorption_depth": DEPTH},
        "floor": {"type": "diffuse", "color": [GROUND] * 3},
    }
    for surface in scene["surface"]:
        surface["material"] = "water"
    return scene, points


def ours(words, scene):
    path = f"{words.out}/splash.json"
    with open(path, "w") as file:
        json.dump(scene, file)
    stats = f"{words.out}/meniscus.json"
    secs = run(words.program, "render", path, "-o", f"{words.out}/meniscus.exr", "-q", "--stats", stats,
               "--threads", str(words.threads))
    with open(stats) as file:
        return secs, json.load(file)


def meshed(words, scene, points):
    mesh = f"{words.out}/mesh.ply"
    radius = scene["surface"][0]["radius"]
    secs = run(words.splashsurf, "reconstruct", points, "-q", "-o", mesh, "-n", str(words.threads),
               "-r", str(radius), "-l", "2.0", "-c", str(words.cell), "-t", "0.6", "--normals=on")
    return secs, mesh


def nodes_of(material):
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    return tree, tree.nodes.new("ShaderNodeOutputMaterial")


def water():
    material = bpy.data.materials.new("water")
    tree, output = nodes_of(material)
    glass = tree.nodes.new("ShaderNodeBsdfGlass")
    glass.inputs["IOR"].default_value = IOR
    glass.inputs["Roughness"].default_value = 0.0
    tree.links.new(glass.outputs[0], output.inputs["Surface"])
    coefficients = [-math.log(left) / DEPTH for left in LEFT]
    density = max(coefficients)
    absorption = tree.nodes.new("ShaderNodeVolumeAbsorption")
    absorption.inputs["Color"].default_value = (*(1 - c / density for c in coefficients), 1)
    absorption.inputs["Density"].default_value = density
    tree.links.new(absorption.outputs[0], output.inputs["Volume"])
    return material


def floor():
    material = bpy.data.materials.new("floor")
    tree, output = nodes_of(material)
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (GROUND, GROUND, GROUND, 1)
    tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    return material


def matrix(right, up, back, place):
    columns = (right, up, back, place)
    rows = [[column[i] for column in columns] for i in range(3)] + [[0, 0, 0, 1]]
    return mathutils.Matrix(rows)


def cycles(words, scene, mesh):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    stage = bpy.context.scene
    start = time.perf_counter()
    # The file's own axes: Blender must not turn them.
    bpy.ops.wm.ply_import(filepath=mesh, forward_axis="Y", up_axis="Z")
    import_secs = time.perf_counter() - start
    liquid = bpy.context.object
    liquid.data.materials.clear()
    liquid.data.materials.append(water())
    liquid.data.shade_smooth()
    far = 1e3
    ground = bpy.data.meshes.new("ground")
    corners = [(-far, 0, -far), (-far, 0, far), (far, 0, far), (far, 0, -far)]
    ground.from_pydata(corners, [], [(0, 1, 2, 3)])
    ground.materials.append(floor())
    stage.collection.objects.link(bpy.data.objects.new("ground", ground))

    vector = mathutils.Vector
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit, camera.angle = "VERTICAL", math.radians(scene["camera"]["fov"])
    camera.clip_start, camera.clip_end = 1e-3, 1e5
    eye, target = vector(scene["camera"]["eye"]), vector(scene["camera"]["target"])
    back = (eye - target).normalized()
    right = vector((0, 1, 0)).cross(back).normalized()
    stage.camera = bpy.data.objects.new("camera", camera)
    stage.camera.matrix_world = matrix(right, back.cross(right), back, eye)
    stage.collection.objects.link(stage.camera)

    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy, sun.angle = math.pi * SUN, math.radians(SUN_DEGREES)
    towards = vector(SUN_TOWARDS).normalized()
    side = towards.orthogonal().normalized()
    lamp = bpy.data.objects.new("sun", sun)
    lamp.matrix_world = matrix(side, towards.cross(side), towards, (0, 0, 0))
    stage.collection.objects.link(lamp)
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    background.inputs["Strength"].default_value = SKY
    stage.world = world

    stage.render.engine = "CYCLES"
    stage.render.resolution_x, stage.render.resolution_y = map(int, words.size.split("x"))
    stage.render.resolution_percentage = 100
    stage.render.threads_mode, stage.render.threads = "FIXED", words.threads
    settings = stage.cycles
    settings.device, settings.samples = "CPU", words.spp
    settings.use_adaptive_sampling = settings.use_denoising = False
    settings.max_bounces = settings.diffuse_bounces = settings.glossy_bounces = BOUNCES
    settings.transmission_bounces = settings.transparent_max_bounces = BOUNCES
    settings.caustics_reflective = settings.caustics_refractive = True
    settings.blur_glossy = settings.sample_clamp_direct = settings.sample_clamp_indirect = 0
    stage.render.image_settings.file_format = "OPEN_EXR"
    stage.render.filepath = f"{words.out}/cycles.exr"
    start = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    return import_secs, time.perf_counter() - start


def pixels(path):
    image = bpy.data.images.load(path)
    width, height = image.size
    return numpy.array(image.pixels[:], dtype=numpy.float32).reshape(height, width, 4)


def side_by_side(words):
    both = [pixels(f"{words.out}/{name}.exr")[:, :, :3] for name in ("meniscus", "cycles")]
    linear = numpy.clip(numpy.concatenate(both, axis=1), 0, 1)
    shown = numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    height, width, _ = shown.shape
    image = bpy.data.images.new("both", width, height)
    image.pixels = numpy.dstack([shown, numpy.ones((height, width))]).astype(numpy.float32).ravel()
    image.filepath_raw, image.file_format = f"{words.out}/side_by_side.png", "PNG"
    image.save()
    # Clipped: single paths that find the sun weigh more than all others together.
    return [float(numpy.clip(picture, 0, 1).mean()) for picture in both]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--program", default="target/release/meniscus")
    parser.add_argument("--splashsurf", default="pysplashsurf")
    parser.add_argument("--out", required=True)
    parser.add_argument("--count", type=int, default=60_000)
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--cell", default="0.5", help="of the mesh, in radii")
    parser.add_argument("--threads", type=int, default=2)
    words = parser.parse_args(sys.argv[1:])
    words.out = os.path.abspath(words.out)
    os.makedirs(words.out, exist_ok=True)
    scene, points = scene_of(words)
    ours_secs, stats = ours(words, scene)
    mesh_secs, mesh = meshed(words, scene, points)
    import_secs, render_secs = cycles(words, scene, mesh)
    means = side_by_side(words)
    theirs = mesh_secs + import_secs + render_secs
    print(f"{stats['particles']} particles, {words.size}, {words.spp} samples, depth {BOUNCES}, {words.threads} threads")
    print(f"  Meniscus: {ours_secs:.2f} s from start to end, {stats['render_secs']:.2f} s of it rendering")
    print(f"  splashsurf {mesh_secs:.2f} s + import {import_secs:.2f} s + Cycles {render_secs:.2f} s = {theirs:.2f} s, "
          f"{theirs / ours_secs:.2f} times ours")
    print(f"  mean radiance, clipped: {means[0]:.4f} and {means[1]:.4f}; pictures in {words.out}")


if __name__ == "__main__":
    main()
