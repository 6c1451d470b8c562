#!/usr/bin/env python3
"""Sheets one particle thick: holes and evenness of thickness, balls against `--anisotropy estimate` at
the same volume; and how far the estimate draws the surface of a full body in. Needs numpy.

  cargo build --release
  python3 benches/sheets.py [--program target/release/meniscus] [--out FOLDER] [--crown FRAME.vtk]

A map of rays crosses each sheet, outward from its middle or its axis. Holes: rays that miss within the
sheet's outline (in an open crown: misses that are not connected with what lies above the rim), as a
part of all rays within. Thickness: standard deviation over mean, row by row, holes counted as 0. The
ellipsoids have T = 0.6, the balls the threshold that gives them the same volume. With --out both pictures
of each sheet are kept.
"""

import argparse
import os
import subprocess
import tempfile

import numpy as np

BALLS, ESTIMATE = ["--anisotropy", "none"], ["--anisotropy", "estimate", "--weights", "ball-volume"]
THRESHOLD = 0.6
GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


def bell(count, thinning):
    """A dome of radius 1 down to 60 degrees; its particles are `thinning` times as far apart as at rest."""
    random = np.random.default_rng(1)
    place = np.arange(count) + 0.5
    height = 1 - place / count * (1 - np.cos(np.radians(60)))
    turn = GOLDEN_ANGLE * place
    flat = np.sqrt(1 - height**2)
    points = np.stack([flat * np.cos(turn), height, flat * np.sin(turn)], axis=1)
    spacing = np.sqrt(np.pi / count)  # the cap's area is pi
    points += random.normal(0, 0.2 * spacing, points.shape)
    points *= (1 + random.normal(0, 0.1 * spacing, (count, 1))) / np.linalg.norm(points, axis=1, keepdims=True)
    return points, 0.5 * spacing / thinning


def body(radius):
    """A ball of particles on a shaken grid of spacing 1."""
    random = np.random.default_rng(2)
    grid = np.stack(np.meshgrid(*[np.arange(-radius, radius + 1)] * 3), -1).reshape(-1, 3)
    grid = grid[np.linalg.norm(grid, axis=1) <= radius] + 0.0
    return grid + random.normal(0, 0.1, grid.shape), 0.5


def dome_rays(rows, columns, half_angle, reach):
    """From the middle: the rays, the power of r in a volume, whether the top is open."""
    polar = np.arccos(np.linspace(0.999, np.cos(np.radians(half_angle)), rows))[:, None]
    turn = np.linspace(0, 2 * np.pi, columns, endpoint=False)[None, :]
    directions = np.stack(
        [np.sin(polar) * np.cos(turn), np.cos(polar) + 0 * turn, np.sin(polar) * np.sin(turn)], -1
    )
    return with_ends(np.zeros_like(directions), directions, reach), 3, False


def axis_rays(rows, columns, heights, reach):
    """Outward from the axis at these heights, highest first."""
    height = np.linspace(heights[1], heights[0], rows)[:, None]
    turn = np.linspace(0, 2 * np.pi, columns, endpoint=False)[None, :]
    directions = np.stack([np.cos(turn) + 0 * height, 0 * turn + 0 * height, np.sin(turn) + 0 * height], -1)
    origins = np.zeros_like(directions)
    origins[..., 1] = height
    return with_ends(origins, directions, reach), 2, True


def with_ends(origins, directions, reach):
    ends = np.zeros(origins.shape[:2] + (2,))
    ends[..., 1] = reach
    return np.concatenate([origins, directions, ends], -1)


class Sheet:
    def __init__(self, words, folder, name, file, radius, rays):
        self.program, self.folder, self.name, self.file = os.path.abspath(words.program), folder, name, file
        self.radius = radius
        self.options = ["-r", f"{radius:.9f}"]
        self.rays, self.power, self.is_open = rays

    def run(self, *words):
        subprocess.run([self.program, *map(str, words), "-q"], check=True)

    def segments(self, shape, threshold, step=1):
        """For each ray its thickness, and its share of the volume."""
        rays = self.rays[::step, ::step]
        np.save(f"{self.folder}/rays.npy", rays.reshape(-1, 8))
        self.run("trace", self.file, "--rays", f"{self.folder}/rays.npy", "-o", f"{self.folder}/hits.npz",
                 "--all", "-t", threshold, *self.options, *shape)
        hits = np.load(f"{self.folder}/hits.npz")
        sign = np.where(hits["entering"], -1.0, 1.0)
        count = rays.shape[0] * rays.shape[1]
        # A ray that ends inside counts up to its end.
        inside = np.bincount(hits["ray"], sign, count) < 0
        total = lambda power: (np.bincount(hits["ray"], sign * hits["t"] ** power, count)
                               + inside * rays.reshape(-1, 8)[:, 7] ** power)
        return total(1).reshape(rays.shape[:2]), total(self.power).reshape(rays.shape[:2]) / self.power

    def volume(self, shape, threshold):
        return self.segments(shape, threshold, 3)[1].sum()

    def threshold_of(self, shape, volume):
        low, high = 0.02, 4.0
        for _ in range(12):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.volume(shape, middle) > volume else (low, middle)
        return 0.5 * (low + high)

    def figures(self, shape, threshold):
        thickness, _ = self.segments(shape, threshold)
        within = self.within(thickness > 0)
        holes = (within & (thickness <= 0)).sum() / within.sum()
        spread = [row[w].std() / row[w].mean() for row, w in zip(thickness, within) if w.sum() > 30]
        return holes, np.mean(spread), thickness[within].mean() / (2 * self.radius)

    def within(self, is_hit):
        """What lies within the outline: all, or all that is not connected with the outside above."""
        if not self.is_open:
            return np.ones_like(is_hit)
        outside = np.zeros_like(is_hit)
        outside[0] = ~is_hit[0]
        while True:
            grown = outside | np.roll(outside, 1, 1) | np.roll(outside, -1, 1)
            grown[1:] |= outside[:-1]
            grown[:-1] |= outside[1:]
            grown &= ~is_hit
            if (grown == outside).all():
                return ~outside
            outside = grown

    def report(self, words, camera):
        volume = self.volume(ESTIMATE, THRESHOLD)
        ratio = volume / self.volume(BALLS, THRESHOLD)
        threshold = self.threshold_of(BALLS, volume)
        for label, shape, t in [("balls", BALLS, threshold), ("estimate", ESTIMATE, THRESHOLD)]:
            holes, spread, mean = self.figures(shape, t)
            print(f"{self.name:8} {label:8} T {t:.3f}: holes {100 * holes:6.3f} %, thickness {spread:.3f}, "
                  f"mean {mean:.2f} spacings")
            if words.out:
                self.run("render", self.file, "-o", f"{words.out}/{self.name}-{label}.png", "-t", t,
                         "--size", "480x360", *self.options, *shape, *camera)
        print(f"{self.name:8} volume of the ellipsoids at T {THRESHOLD}: {ratio:.3f} of the balls'", flush=True)


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--program", default="target/release/meniscus")
    words.add_argument("--out")
    words.add_argument("--crown", metavar="FRAME.vtk", help="a frame of SPlisHSPlasH's crown, radius 0.02")
    words = words.parse_args()
    if words.out:
        os.makedirs(words.out, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        program = os.path.abspath(words.program)
        for thinning in (1.0, 1.3):
            points, radius = bell(6000, thinning)
            file = f"{folder}/bell.npy"
            np.save(file, points)
            name = "bell" if thinning == 1 else "thinned"
            sheet = Sheet(words, folder, name, file, radius, dome_rays(240, 600, 52, 2.0))
            sheet.report(words, ["--camera-eye", "1.1,2.1,1.6", "--camera-target", "0,0.75,0"])
        subprocess.run([program, "generate", "splash", "-o", f"{folder}/splash.vtk", "--count", "60000", "-q"], check=True)
        # The scene's own radius: half the spacing of the water.
        radius = 0.5 * float(spacing_of(f"{folder}/splash.toml"))
        sheet = Sheet(words, folder, "splash", f"{folder}/splash.vtk", radius, axis_rays(160, 900, (0.06, 0.42), 0.75))
        sheet.report(words, [])
        if words.crown:
            sheet = Sheet(words, folder, "crown", words.crown, 0.02, axis_rays(160, 900, (1.25, 1.6), 1.6))
            sheet.report(words, [])
        points, radius = body(14)
        np.save(f"{folder}/body.npy", points)
        sheet = Sheet(words, folder, "body", f"{folder}/body.npy", radius, dome_rays(40, 90, 170, 30.0))
        for label, shape in (("balls", BALLS), ("estimate", ESTIMATE)):
            for t in (0.6, 0.4, 0.2):
                thickness, _ = sheet.segments(shape, t)
                print(f"body     {label:8} T {t}: surface {thickness.mean() - 14:+.3f} spacings from the outermost centres")


def spacing_of(scene):
    import tomllib
    with open(scene, "rb") as file:
        return 2 * tomllib.load(file)["surface"][0]["radius"]


if __name__ == "__main__":
    main()
