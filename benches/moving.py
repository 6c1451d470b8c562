#!/usr/bin/env python3
"""What motion blur costs: rays a second of blobs that move while the shutter is open, beside the same
blobs at rest.

  cargo build --release
  python3 benches/moving.py FOLDER [--program target/release/meniscus] [--rounds 5]
      [--engines cells,particles] [--distances 1,3,10] [--bend 0.5]

FOLDER holds points.npy and meta.json as for whole_picture.py. The blobs move in a swirl with waves in it
and are accelerated, by `--bend` times as much per shutter squared; the distances are root mean squares
over the shutter, in spacings. `particles/bezier` is engine `particles` with engine.motion_bounds=bezier. All parts are run
interleaved, two threads, medians of the rounds; every moving ray has a time of its own. `cells still, one
by one` is what `cells` does with rays that it cannot trace in packets.
"""

import argparse
import json
import statistics
import subprocess
import tempfile

import numpy

PASSES = ("primary", "shadow", "hemisphere", "shuffled")


def moving(points, spacing, distance, bend):
    """Velocities and accelerations per second; a frame lasts 1/25 s."""
    size = numpy.ptp(points, axis=0).max()
    p = (points - points.mean(axis=0)) / size
    waves = numpy.sin(9.0 * p[:, [1, 2, 0]])
    velocity = numpy.stack([-p[:, 1], p[:, 0], 0.3 * p[:, 2]], axis=1) + 0.1 * waves
    acceleration = bend * numpy.stack([-p[:, 0], -p[:, 1], 0.2 * waves[:, 0]], axis=1)
    scale = distance * spacing / numpy.sqrt((velocity**2).sum(axis=1).mean())
    return velocity * scale * 25, acceleration * scale * 25**2


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--program", default="target/release/meniscus")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--engines", default="cells,particles")
    parser.add_argument("--distances", default="1,3,10")
    parser.add_argument("--bend", type=float, default=0.5)
    words = parser.parse_args()
    engines = words.engines.split(",")
    distances = [float(distance) for distance in words.distances.split(",")]

    def tracing(engine):
        name, _, bounds = engine.partition("/")
        return ["--engine", name] + (["--set", f"engine.motion_bounds={bounds}"] if bounds else [])

    with open(f"{words.folder}/meta.json") as file:
        meta = json.load(file)
    points = numpy.load(f"{words.folder}/points.npy")[:, :3]
    comma = lambda values: ",".join(map(str, values))
    camera = meta["cam"]
    common = [
        "--json", "-q", "--threads", "2", "--repeats", "3", "--support", str(meta["R"]), "-t", str(meta["T"]),
        "--kernel", "quartic", "--weights", "unit", "--up", "z", "--camera-eye", comma(camera["eye"]),
        "--camera-target", comma(camera["look"]), "--fov", str(camera["vfov"]), "--light", comma(meta["light"]),
    ]
    with tempfile.TemporaryDirectory() as folder:
        runs = {}
        for engine in engines:
            runs[engine, 0] = [f"{words.folder}/points.npy", *tracing(engine)]
        for distance in distances:
            velocity, acceleration = moving(points, meta["h"], distance, words.bend)
            path = f"{folder}/{distance}.npz"
            numpy.savez(path, position=points, velocity=velocity, acceleration=acceleration)
            for engine in engines:
                runs[engine, distance] = [path, *tracing(engine), "--shutter", "1"]
        results = {run: [] for run in runs}
        for _ in range(words.rounds):
            for run, arguments in runs.items():
                command = [words.program, "bench", *arguments, *common]
                output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
                results[run].append(json.loads(output))
    print("| engine | spacings | " + " | ".join(PASSES) + " | build, ms | bytes a particle |")
    print("|---" * (len(PASSES) + 4) + "|")
    for (engine, distance), rounds in results.items():
        median = lambda of: statistics.median(of(result) for result in rounds)
        rates = [median(lambda r, p=p: r[p]["mrays_per_sec"]) for p in PASSES]
        still = [statistics.median(r[p]["mrays_per_sec"] for r in results[engine, 0]) for p in PASSES]
        cells = [f"{a:.2f} ({a / b:.2f})" for a, b in zip(rates, still)]
        build = 1e3 * median(lambda r: r["build_secs"])
        size = median(lambda r: r["bytes_per_particle"])
        print(f"| {engine} | {distance:g} | " + " | ".join(cells) + f" | {build:.0f} | {size:.0f} |", flush=True)


if __name__ == "__main__":
    main()
