#!/usr/bin/env python3
"""Meniscus against Embree on the same spheres, interleaved: the table in BENCHMARKS.md.

  cargo build --release
  g++ -O3 -march=native -std=c++17 benches/embree_spheres.cpp -o embree_spheres -lembree3 -pthread
  python3 benches/against_embree.py ./embree_spheres FOLDER...

FOLDER holds points.npy ((N, 3) float32) and meta.json: R, T, light, cam {eye, look, up, vfov}.
Prints the median of the ratio over interleaved rounds, and the last round's figures.
"""

import json
import re
import statistics
import subprocess
import sys

ROUNDS, THREADS = 5, "2"


def run(words):
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


def compare(embree, folder):
    with open(f"{folder}/meta.json") as file:
        meta = json.load(file)
    points, radius, camera, light = f"{folder}/points.npy", str(meta["R"]), meta["cam"], meta["light"]
    words = lambda vector: [str(x) for x in vector]
    theirs = [embree, points, radius, THREADS, "5", *words(camera["eye"]), *words(camera["look"])]
    theirs += [*words(camera["up"]), str(camera["vfov"]), *words(light)]
    flag = lambda vector: ",".join(words(vector))
    ours = ["target/release/meniscus", "bench", points, "--json", "-q", "--repeats", "3"]
    ours += ["--support", radius, "-t", str(meta["T"]), "--kernel", "quartic", "--weights", "unit"]
    ours += ["--up", "z", "--camera-eye", flag(camera["eye"]), "--camera-target", flag(camera["look"])]
    ours += ["--fov", str(camera["vfov"]), "--light", flag(light), "--threads", THREADS]
    ratios = {"primary": [], "shadow": []}
    builds = []
    for _ in range(ROUNDS):
        text, report = run(theirs), json.loads(run(ours))
        for kind, list_of in ratios.items():
            rate = float(re.search(kind + r" ([\d.]+)", text)[1])
            list_of.append(report[kind]["mrays_per_sec"] / rate)
        builds.append(report["build_secs"] * 1e3 / float(re.search(r"build_ms ([\d.]+)", text)[1]))
    print(folder)
    for kind, list_of in ratios.items():
        ours_last = report[kind]["mrays_per_sec"]
        print(f"  {kind}: {statistics.median(list_of):.2f} of Embree, {ours_last:.2f} Mrays/s")
    for kind in ("hemisphere", "shuffled"):
        print(f"  {kind}: {report[kind]['mrays_per_sec']:.2f} Mrays/s")
    build, size = report["build_secs"] * 1e3, report["bytes_per_particle"]
    print(f"  build {statistics.median(builds):.2f} of Embree's time, {build:.0f} ms, {size:.0f} bytes a particle")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    for folder in sys.argv[2:]:
        compare(sys.argv[1], folder)
