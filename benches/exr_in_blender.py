#!/usr/bin/env python3
"""Opens the EXR files of every integrator in Blender: its image node must offer all passes by name, and
what its compositor hands on must be what the files hold.

  PYTHON_WITH_BPY -m pip install openexr
  PYTHON_WITH_BPY benches/exr_in_blender.py [--program target/release/meniscus]

Without bpy or OpenEXR it says so and does nothing.
"""

import argparse
import os
import subprocess
import tempfile

try:
    import bpy
    import numpy
    import OpenEXR
except ImportError as missing:
    print(f"skipped: {missing} (pip install bpy openexr)")
    raise SystemExit(0)

WIDTH, HEIGHT = 96, 64
SCENES = os.path.join(os.path.dirname(__file__), "../scenes")
# Integrator, scene, and columns to carry.
FILES = [
    ("path", "splash-water.toml", ["velocity"]),
    ("whitted", "pool-fresnel.toml", []),
    ("ao", "molecule-ao.toml", ["element"]),
    ("shaded", "splash.toml", ["velocity"]),
]
# Passes of Blender with their components, and our plain planes.
PASSES = {
    "Combined": ["R", "G", "B", "A"],
    "Depth": ["Z"],
    "Position": ["P.X", "P.Y", "P.Z"],
    "Normal": ["N.X", "N.Y", "N.Z"],
    "DiffCol": ["albedo.R", "albedo.G", "albedo.B"],
    "ParticleId": ["id"],
    "IndexOB": ["surface"],
    "Debug Sample Count": ["samples"],
    "velocity": ["velocity.X", "velocity.Y", "velocity.Z"],
    "element": ["element"],
}
COMPONENTS = {"VALUE": "V", "VECTOR": "XYZ", "RGBA": "RGBA"}
SOCKETS = {"VALUE": "FLOAT", "VECTOR": "VECTOR", "RGBA": "RGBA"}


def planes(path):
    parts = OpenEXR.File(path, separate_channels=True).parts
    channels = [channel for part in parts for channel in part.channels.items()]
    return {name: channel.pixels.astype(numpy.float64) for name, channel in channels}


def through_blender(path, folder):
    """What Blender's compositor makes of every pass of a file: name to planes, components in order."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    stage = bpy.context.scene
    stage.render.engine = "CYCLES"
    stage.cycles.samples = 1
    stage.render.resolution_x, stage.render.resolution_y = WIDTH, HEIGHT
    stage.render.resolution_percentage = 100
    stage.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    stage.collection.objects.link(stage.camera)
    tree = bpy.data.node_groups.new("passes", "CompositorNodeTree")
    stage.compositing_node_group = tree
    image = tree.nodes.new("CompositorNodeImage")
    image.image = bpy.data.images.load(path)
    assert image.image.type == "MULTILAYER", image.image.type
    sink = tree.nodes.new("CompositorNodeOutputFile")
    sink.directory, sink.file_name = folder, "passes"
    sink.format.file_format, sink.format.color_depth = "OPEN_EXR_MULTILAYER", "32"
    sink.save_as_render = False
    for output in image.outputs:
        sink.file_output_items.new(SOCKETS[output.type], output.name)
        tree.links.new(output, sink.inputs[output.name])
    bpy.ops.render.render()
    written = [name for name in os.listdir(folder) if name.startswith("passes")]
    found = planes(os.path.join(folder, written[0]))
    for name in written:
        os.remove(os.path.join(folder, name))
    passes = {}
    for output in image.outputs:
        # Blender names the planes PASS.R, PASS.X or PASS.V, with or without a layer before.
        ends = [f"{output.name}.{end}" for end in COMPONENTS[output.type]]
        own = [[plane for name, plane in found.items() if name.endswith(end)] for end in ends]
        passes[output.name] = [plane[0] for plane in own if plane]
    return passes


def check(program, integrator, scene, columns, folder):
    files = {style: f"{folder}/{integrator}_{style}.exr" for style in ("plain", "blender")}
    for style, path in files.items():
        words = [program, "render", f"{SCENES}/{scene}", "-o", path, "-q", "--aov-style", style]
        words += ["--integrator", integrator, "--size", f"{WIDTH}x{HEIGHT}", "--spp", "4"]
        for column in columns:
            words += ["-a", column]
        subprocess.run(words + ["--aov", ",".join(["all", *columns])], check=True)
    ours, theirs = planes(files["plain"]), through_blender(files["blender"], folder)
    wanted = {name: own for name, own in PASSES.items() if own[0] in ours}
    missing = [name for name in wanted if name not in theirs]
    assert not missing, f"{integrator}: Blender shows no {missing}, only {list(theirs)}"
    for name, own in wanted.items():
        assert len(theirs[name]) >= len(own), (integrator, name, len(theirs[name]))
        for component, plane in enumerate(own):
            a, b = ours[plane], theirs[name][component]
            # Blender's numbers are floats: indices of nothing, 2³² − 1, become 2³².
            same = numpy.isclose(a, b, rtol=1e-6, atol=1e-7) | (numpy.isinf(a) & (b >= 1e10))
            assert same.all(), f"{integrator}: {name} {plane}: {a[~same][:3]} became {b[~same][:3]}"
    covered = float(ours["A"].mean())
    print(f"{integrator}: {len(wanted)} passes by name and value, {covered:.0%} of the picture covered")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--program", default="target/release/meniscus")
    words = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for integrator, scene, columns in FILES:
            check(words.program, integrator, scene, columns, folder)


if __name__ == "__main__":
    main()
