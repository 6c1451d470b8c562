#!/usr/bin/env bash
# Builds, checks and times everything on the graphics card of this machine, in one call:
#   benches/gpu.sh [FOLDER]
#   SMALL=1 MENISCUS_GPU=software benches/gpu.sh      small scenes, the dev profile, a few tests: to see
#                                                     that it works
# FOLDER (default target/gpu-bench) gets the scenes, the pictures of card and processor, and figures.md.
# Ends with 1 where a test fails or pictures of card and processor differ by more than the golden budget.
set -euo pipefail
cd "$(dirname "$0")/.."
folder="${1:-target/gpu-bench}"
mkdir -p "$folder"
figures="$folder/figures.md"
: >"$figures"

small="${SMALL:-}"
build=(--release) built=release
[ -n "$small" ] && build=() built=debug
cargo build ${build[@]+"${build[@]}"} -p meniscus-cli --locked
meniscus="${CARGO_TARGET_DIR:-target}/$built/meniscus"

say() { printf '%s\n' "$*" | tee -a "$figures"; }
failed=0

echo "== tests on the card"
tests=(--nocapture --include-ignored)
[ -n "$small" ] && tests=(--nocapture shaded_scenes)
# A failure is told at the end: figures are worth having all the same.
if ! MENISCUS_REQUIRE_GPU=1 cargo test ${build[@]+"${build[@]}"} -p meniscus-gpu --locked -- "${tests[@]}" \
  >"$folder/tests.log" 2>&1; then
  failed=1
  tail -n 40 "$folder/tests.log"
fi
grep -E '^test |answered by the CPU|test result' "$folder/tests.log" || true

large=1920x1080 middle=640x480
[ -n "$small" ] && large=96x54 middle=64x48
count() { # particles, or few of them
  if [ -n "$small" ]; then echo $(($1 / 200)); else echo "$1"; fi
}
scene() { # name, generator, particles
  [ -s "$folder/$1.toml" ] || "$meniscus" generate "$2" --count "$(count "$3")" -o "$folder/$1.npy" -q
}
scene pool-100k pool 100000
scene pool-1m pool 1000000
scene scattered-100k scattered 100000
scene splash-100k splash 100000

"$meniscus" bench "$folder/pool-100k.toml" --size 64x64 --repeats 1 --device gpu -v >/dev/null 2>"$folder/card.log"
say "$(sed -n 's/^.*\bon \(.*([a-z ]*,.*)\).*$/Card: \1/p' "$folder/card.log" | head -n 1)"
say "Processor: $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1), $(getconf _NPROCESSORS_ONLN) threads"
say ""
say "| scene | pass | card's own clock, Mrays/s | with transfers, Mrays/s | processor, Mrays/s |"
say "|---|---|---|---|---|"
for name in pool-100k pool-1m scattered-100k splash-100k; do
  size=$large
  [ "$name" = scattered-100k ] && size=$middle
  for device in gpu cpu; do
    "$meniscus" bench "$folder/$name.toml" --size "$size" --device "$device" --json -v >"$folder/$name-$device.json"
  done
  for pass in primary shadow hemisphere shuffled; do
    read -r own with <<<"$(python3 -c "
import json, sys
p = json.load(open(sys.argv[1]))[sys.argv[2]]
print(round(p.get('device_mrays_per_sec', float('nan')), 1), round(p['mrays_per_sec'], 1))" "$folder/$name-gpu.json" "$pass")"
    cpu="$(python3 -c "
import json, sys
print(round(json.load(open(sys.argv[1]))[sys.argv[2]]['mrays_per_sec'], 1))" "$folder/$name-cpu.json" "$pass")"
    say "| $name $size | $pass | $own | $with | $cpu |"
  done
done

# 1.2 M ellipsoids that move while the shutter is open.
[ -s "$folder/moving-1m2.toml" ] || "$meniscus" generate splash --count "$(count 1200000)" -o "$folder/moving-1m2.npz" -q

say ""
say "| structure of | builder | sent, ms | card's own build, ms | followed, ms (own) | frames/s of primary + shadow by the card's clock: tree stands / is built each frame |"
say "|---|---|---|---|---|---|"
for name in pool-1m scattered-100k moving-1m2; do
  size=$large
  [ "$name" = scattered-100k ] && size=$middle
  more=()
  [ "$name" = moving-1m2 ] && more=(--anisotropy estimate --shutter 0.5)
  for builder in sah morton device; do
    file="$folder/$name-$builder-built.json"
    "$meniscus" bench "$folder/$name.toml" --size "$size" --device gpu --set "engine.builder=$builder" \
      ${more[@]+"${more[@]}"} --json >"$file"
    say "$(python3 - "$file" "$name $size" "$builder" <<'P'
import json, sys
report = json.load(open(sys.argv[1]))
card = {key: 1e3 * secs for key, secs in report["on_card"].items()}
own = lambda p: p["rays"] / (p["device_mrays_per_sec"] * 1e6)
traced = own(report["primary"]) + own(report["shadow"])
# Built by the processor, the tree has to come over the bus; its build beside that is the pipeline's.
built = card["own_build_secs"] if sys.argv[3] == "device" else card["send_secs"]
print(f"| {sys.argv[2]} | {sys.argv[3]} | {card['send_secs']:.2f} | {card['own_build_secs']:.2f} "
      f"| {card['update_secs']:.2f} ({card['own_update_secs']:.2f}) | {1 / traced:.1f} / {1 / (traced + built / 1e3):.1f} |")
P
)"
  done
done

say ""
say "| scene, engine peel | variant | primary, Mrays/s by the card's own clock | lists, ms | sprites, ms | solve, ms | left to the tree |"
say "|---|---|---|---|---|---|---|"
for name in pool-100k pool-1m scattered-100k splash-100k; do
  size=$large
  [ "$name" = scattered-100k ] && size=$middle
  for variant in tiles sprites; do
    "$meniscus" bench "$folder/$name.toml" --size "$size" --device gpu --engine peel --set "engine.peel=$variant" \
      --json >"$folder/$name-peel-$variant.json"
    say "$(python3 -c "
import json, sys
report = json.load(open(sys.argv[1]))
primary, peel = report['primary'], report['peel']
millis = ' | '.join(f'{peel[stage] * 1e3:.3f}' for stage in ('lists_secs', 'sprites_secs', 'solve_secs'))
own = round(primary.get('device_mrays_per_sec', float('nan')), 1)
print(f\"| {sys.argv[2]} | {sys.argv[3]} | {own} | {millis} | {peel['left_fraction']:.1e} |\")" \
      "$folder/$name-peel-$variant.json" "$name $size" "$variant")"
  done
done

say ""
say "\`\`\`"
[ -n "$small" ] || "$meniscus" bench paper kanamori-gpu --device gpu | tee -a "$figures"
say "\`\`\`"

# Pixels of two PNGs that differ by more than 2 of 255; exit code 1 beyond the golden budget.
cat >"$folder/compare.py" <<'P'
import struct, sys, zlib

def pixels(path):
    data = open(path, "rb").read()
    at, parts = 8, []
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack(">IIBB", body[:10])
        if kind == b"IDAT":
            parts.append(body)
        at += 12 + size
    n = {2: 3, 6: 4}[color]
    raw, stride = zlib.decompress(b"".join(parts)), width * n
    before, rows = bytearray(stride), []
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for x in range(stride):
            a = row[x - n] if x >= n else 0
            b, c = before[x], before[x - n] if x >= n else 0
            if kind == 1:
                row[x] = row[x] + a & 255
            elif kind == 2:
                row[x] = row[x] + b & 255
            elif kind == 3:
                row[x] = row[x] + (a + b) // 2 & 255
            elif kind == 4:
                p = a + b - c
                near = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
                row[x] = row[x] + near & 255
        rows.append(row)
        before = row
    return width * height, n, b"".join(map(bytes, rows))

count, n, ours = pixels(sys.argv[1])
_, m, theirs = pixels(sys.argv[2])
apart = [abs(ours[i * n + k] - theirs[i * m + k]) for i in range(count) for k in range(3)]
differ = sum(max(apart[i:i + 3]) > 2 for i in range(0, len(apart), 3))
print(f"{differ} of {count}")
sys.exit(differ > 1e-3 * count or sum(apart) > 0.05 * len(apart))
P
differ() { # picture of the card, of the processor
  python3 "$folder/compare.py" "$1" "$2" >"$folder/differ" || { failed=1; echo "$1 is not $2" >&2; }
}

# Whole pictures by the card's stages; shaded with one sample is primary + shadow with all shading.
say ""
say "| scene, $large | integrator, samples | card's own clock, ms | frames/s by it | whole picture, s | processor, s | samples that the processor did | pixels that differ |"
say "|---|---|---|---|---|---|---|---|"
for name in pool-100k pool-1m; do
  for way in shaded:1 shaded:16 ao:4 whitted:1 path:4; do
    for device in gpu cpu; do
      "$meniscus" render "$folder/$name.toml" -o "$folder/$name-${way%:*}-$device.png" --size "$large" \
        --integrator "${way%:*}" --spp "${way#*:}" --device "$device" -v \
        --stats "$folder/$name-stages-$device.json" 2>"$folder/$name-stages-$device.log"
    done
    differ "$folder/$name-${way%:*}-gpu.png" "$folder/$name-${way%:*}-cpu.png"
    say "$(python3 - "$folder/$name-stages" "$name" "$way" "$(cat "$folder/differ")" <<'P'
import json, re, sys
gpu, cpu = [json.load(open(f"{sys.argv[1]}-{device}.json")) for device in ("gpu", "cpu")]
log = open(sys.argv[1] + "-gpu.log").read()
redone = re.search(r"shaded on the card, (\d+) of them", log) or re.search(r"(shaded by the processor.*)", log)
own = gpu.get("device_secs") or float("nan")
print(f"| {sys.argv[2]} | {sys.argv[3].replace(':', ', ')} | {1e3 * own:.2f} | {1 / own:.1f} "
      f"| {gpu['render_secs']:.3f} | {cpu['render_secs']:.3f} | {redone.group(1)} | {sys.argv[4]} |")
P
)"
  done
done

say ""
say "| picture, $large, 4 samples | card, s | processor, s | pixels that differ by more than 2 of 255 |"
say "|---|---|---|---|"
for name in pool-100k pool-1m splash-100k; do
  for device in gpu cpu; do
    "$meniscus" render "$folder/$name.toml" -o "$folder/$name-$device.png" --size "$large" --spp 4 \
      --device "$device" --stats "$folder/$name-$device-picture.json" -q
  done
  differ "$folder/$name-gpu.png" "$folder/$name-cpu.png"
  say "$(python3 - "$folder/$name" "$(cat "$folder/differ")" <<'P'
import json, sys
name, differ = sys.argv[1:]
secs = [json.load(open(f"{name}-{device}-picture.json"))["render_secs"] for device in ("gpu", "cpu")]
print(f"| {name.split('/')[-1]} | {secs[0]:.3f} | {secs[1]:.3f} | {differ} |")
P
)"
done
echo "figures are in $figures"
if [ "$failed" != 0 ]; then
  echo "some checks failed: see above and $folder/tests.log" >&2
  exit 1
fi
