#!/usr/bin/env python3
"""What light costs: rays of `ao` and `path` beside the engine's own rate, and table 2 of Gourmel et
al. 2010 (hard shadows, then 1 and 3 levels of mirrors, over ray casting).

  cargo build --release
  python3 benches/light.py [--program target/release/meniscus] [--rounds 5] [--size 640x480] [--spp 16]
                           [--small]

All parts of a row are run interleaved, two threads, medians of the rounds; --small is a quick try.
"""

import argparse
import json
import os
import statistics
import subprocess
import tempfile
import tomllib

THREADS = "2"

# Gourmel et al. 2010, table 2, frames a second: ray cast, + hard shadows, + 1, + 3 levels.
PAPER = {"molecule": (22.3, 17.7, 12.7, 8.2), "tornado": (5.7, 4.9, 3.4, 2.5)}

SETS = [
    ("tornado", 4_000), ("tornado", 128_000), ("molecule", 5_440), ("pool", 10_000),
    ("scattered", 30_000), ("scattered", 100_000),
]


class Bench:
    def __init__(self, words, folder):
        self.program, self.size, self.rounds = os.path.abspath(words.program), words.size, words.rounds
        self.folder = folder

    def run(self, *words):
        return subprocess.run([self.program, *words], check=True, capture_output=True, text=True).stdout

    def scene(self, name, count):
        """The generator's own scene, as a table."""
        points = f"{self.folder}/{name}_{count}.vtk"
        if not os.path.exists(points):
            self.run("generate", name, "-o", points, "--count", str(count), "-q")
        with open(points.replace(".vtk", ".toml"), "rb") as file:
            return tomllib.load(file)

    def write(self, name, scene):
        path = f"{self.folder}/{name}.json"
        with open(path, "w") as file:
            json.dump(scene, file)
        return path

    def render(self, scene, spp):
        """Statistics of one rendering."""
        stats = f"{self.folder}/stats.json"
        self.run("render", scene, "-o", f"{self.folder}/picture.png", "-q", "--stats", stats,
                 "--size", self.size, "--threads", THREADS, "--spp", str(spp))
        with open(stats) as file:
            return json.load(file)

    def engine(self, scene):
        """The engine's own millions of rays a second: the eye's, and hemisphere rays."""
        out = json.loads(self.run("bench", scene, "--json", "--threads", THREADS))
        return [out[kind]["mrays_per_sec"] for kind in ("primary", "hemisphere")]


def rates(bench, count, spp):
    """Rays a second of whole pictures over the engine's hemisphere rays a second."""
    scene = bench.scene("pool", count)
    kinds = {
        "ao": ({"type": "ao", "samples": 16}, "diffuse"),
        "path, diffuse": ({"type": "path", "depth": 8}, "diffuse"),
        "path, plastic": ({"type": "path", "depth": 8}, "plastic"),
        "path, water": ({"type": "path", "depth": 8}, "water"),
    }
    files = {}
    for name, (integrator, material) in kinds.items():
        scene["integrator"] = integrator
        scene["material"] = {"it": {"type": material}}
        for surface in scene["surface"]:
            surface["material"] = "it"
        files[name] = bench.write(f"rate_{len(files)}", scene)
    found = {name: [] for name in kinds} | {"hemisphere": []}
    secondary = {name: [] for name in kinds}
    counts = {}
    for _ in range(bench.rounds):
        eye_rate, hemisphere_rate = bench.engine(next(iter(files.values())))
        found["hemisphere"].append(hemisphere_rate)
        for name, file in files.items():
            stats = bench.render(file, spp)
            counts[name] = rays = stats["rays"]
            found[name].append(sum(rays.values()) / stats["render_secs"] / 1e6)
            # The eye's rays go together and are faster: what they take at the engine's rate is left out.
            others = sum(rays.values()) - rays["primary"]
            secondary[name].append(others / (stats["render_secs"] * 1e6 - rays["primary"] / eye_rate))
    engine = statistics.median(found["hemisphere"])
    print(f"pool of {count}, {bench.size}, {spp} samples a pixel; bench: {engine:.2f} M hemisphere rays/s")
    for name in kinds:
        ratio = lambda rates: statistics.median(a / b for a, b in zip(rates, found["hemisphere"]))
        rate = statistics.median(found[name])
        by_kind = ", ".join(f"{kind} {n / 1e6:.2f} M" for kind, n in counts[name].items() if n)
        print(f"  {name}: {rate:.2f} Mrays/s, {ratio(found[name]):.2f} of it, "
              f"without the eye's own {ratio(secondary[name]):.2f} ({by_kind})")


def effects(bench, sets):
    """Table 2: what shadows and mirrors cost."""
    print("ray cast, then the cost over it of hard shadows, + 1 level, + 3 levels (paper's in brackets)")
    for name, count in sets:
        scene = bench.scene(name, count)
        for surface in scene["surface"]:
            surface["material"] = "it"
        # Diffuse with a coat that mirrors 0.44 head on, so that no branch is too weak to be followed.
        scene["material"] = {"it": {"type": "plastic", "color": [0.6, 0.6, 0.6], "ior": 5, "roughness": 0.3}}
        lights = scene["light"]
        files = []
        for step, depth in enumerate((1, 1, 2, 4)):
            scene["integrator"] = {"type": "whitted", "depth": depth}
            scene["light"] = [light for light in lights if step > 0 or light["type"] != "sun"]
            files.append(bench.write(f"{name}_{count}_{step}", scene))
        times = [[] for _ in files]
        for _ in range(bench.rounds):
            for step, file in enumerate(files):
                times[step].append(bench.render(file, 1)["render_secs"])
        cast = statistics.median(times[0])
        costs = [statistics.median(b / a for a, b in zip(times[0], of_step)) for of_step in times[1:]]
        paper = PAPER.get(name)
        theirs = [f" ({paper[0] / fps:.2f})" for fps in paper[1:]] if paper else [""] * 3
        row = ", ".join(f"{cost:.2f}{their}" for cost, their in zip(costs, theirs))
        print(f"  {name} of {count}: {cast:.3f} s; {row}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--program", default="target/release/meniscus")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--spp", type=int, default=16, help="samples a pixel of the rates")
    parser.add_argument("--small", action="store_true", help="small sets, one round")
    words = parser.parse_args()
    if words.small:
        words.rounds, words.size = 1, "160x120"
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(words, folder)
        rates(bench, 5_000 if words.small else 100_000, words.spp)
        effects(bench, [(name, 2_000) for name, _ in SETS[::2]] if words.small else SETS)


if __name__ == "__main__":
    main()
