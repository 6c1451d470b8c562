#!/usr/bin/env python3
"""Particles to a closed PNG with one hard shadow, against meshing and against POV-Ray's blobs.

  cargo build --release; apt-get install povray libembree-dev libpng-dev; pip install numpy pysplashsurf
  g++ -O3 -march=native -std=c++17 benches/embree_mesh.cpp -o embree_mesh -lembree3 -lpng -pthread
  python3 benches/whole_picture.py [--pov] ./embree_mesh FOLDER...

FOLDER as for against_embree.py. Everything is a process from start to end on two threads with a warm
file cache, 640x480, one sample a pixel; medians of interleaved rounds (POV-Ray once). The mesher's
mesh goes through a file to Embree, which writes the picture; both processes count.
"""

import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time

import numpy

ROUNDS, THREADS = 5, "2"
CELLS = ("1.0", "0.5")  # of a particle's radius


def seconds(commands, **options):
    start = time.perf_counter()
    for words in commands:
        subprocess.run(words, check=True, capture_output=True, **options)
    return time.perf_counter() - start


def ours(points, meta, out):
    camera = meta["cam"]
    flag = lambda vector: ",".join(str(x) for x in vector)
    words = ["target/release/meniscus", "render", points, "-o", f"{out}/picture.png", "-q", "--spp", "1"]
    words += ["--size", "640x480", "--support", str(meta["R"]), "-t", str(meta["T"])]
    words += ["--kernel", "quartic", "--weights", "unit", "--up", "z", "--fov", str(camera["vfov"])]
    words += ["--camera-eye", flag(camera["eye"]), "--camera-target", flag(camera["look"])]
    return words + ["--light", flag(meta["light"]), "--threads", THREADS]


def rendered(embree, meta, out):
    camera = meta["cam"]
    words = lambda vector: [str(x) for x in vector]
    view = [*words(camera["eye"]), *words(camera["look"]), *words(camera["up"]), str(camera["vfov"])]
    return [embree, f"{out}/mesh.ply", f"{out}/mesh.png", THREADS, *view, *words(meta["light"])]


def mesher(xyz, meta, cell, out):
    words = ["pysplashsurf", "reconstruct", xyz, "-q", "-o", f"{out}/mesh.ply", "-n", THREADS]
    return words + ["-r", str(0.5 * meta["h"]), "-l", "2.0", "-c", cell, "-t", "0.6"]


def pov_scene(positions, meta, path):
    camera = meta["cam"]
    vector = lambda v: "<" + ",".join(repr(float(x)) for x in v) + ">"
    angle = 2 * math.degrees(math.atan(math.tan(math.radians(camera["vfov"]) / 2) * 4 / 3))
    far = 1e4 * numpy.array(meta["light"])
    with open(path, "w") as file:
        file.write("#version 3.7; global_settings { assumed_gamma 1 }\n")
        file.write(f"camera {{ location {vector(camera['eye'])} sky <0,0,1> right -x*4/3 ")
        file.write(f"angle {angle!r} look_at {vector(camera['look'])} }}\n")
        file.write(f"light_source {{ {vector(far)} rgb 1 parallel point_at <0,0,0> }}\n")
        file.write(f"blob {{ threshold {meta['T']!r}\n")
        for position in positions:
            file.write(f"sphere {{ {vector(position)}, {meta['R']!r}, 1 }}\n")
        file.write("pigment { rgb 0.7 } }\n")


def compare(embree, folder, with_pov):
    with open(f"{folder}/meta.json") as file:
        meta = json.load(file)
    points = f"{folder}/points.npy"
    positions = numpy.load(points)
    with tempfile.TemporaryDirectory() as out:
        xyz = f"{out}/points.xyz"
        positions.astype("<f4").tofile(xyz)
        ways = {"meniscus": [ours(points, meta, out)]}
        if "h" in meta:
            for cell in CELLS:
                mesh = mesher(xyz, meta, cell, out)
                ways[f"splashsurf, cell {cell}, + Embree"] = [mesh, rendered(embree, meta, out)]
        times = {name: [] for name in ways}
        for commands in ways.values():
            seconds(commands)
        for _ in range(ROUNDS):
            for name, commands in ways.items():
                times[name].append(seconds(commands))
        medians = {name: statistics.median(list_of) for name, list_of in times.items()}
        if with_pov:
            pov_scene(positions, meta, f"{out}/scene.pov")
            words = ["povray", "+Iscene.pov", "+Opov.png", "+W640", "+H480", "-D", "-A", f"+WT{THREADS}"]
            medians["POV-Ray"] = seconds([words], cwd=out)
    print(folder)
    for name, secs in medians.items():
        print(f"  {name}: {secs:.3f} s, {secs / medians['meniscus']:.1f} times ours")


if __name__ == "__main__":
    paths = [os.path.abspath(word) for word in sys.argv[1:] if word != "--pov"]
    if len(paths) < 2:
        sys.exit(__doc__)
    for folder in paths[1:]:
        compare(paths[0], folder, "--pov" in sys.argv)
