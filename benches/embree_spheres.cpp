// Embree on plain spheres: the ceiling that BENCHMARKS.md measures Meniscus against.
//
//   apt-get install libembree-dev g++
//   g++ -O3 -march=native -std=c++17 benches/embree_spheres.cpp -o embree_spheres -lembree3 -pthread
//   ./embree_spheres points.npy RADIUS THREADS REPEATS eye.x eye.y eye.z look.x look.y look.z up.x up.y up.z VFOV light.x light.y light.z
//
// points.npy: (N, 3) float32, C order. One ray at a time (rtcIntersect1, rtcOccluded1), 640x480 pixel
// centres. A primary pass counts ray generation, traversal, hit point and normal, as `meniscus bench`
// does. Prints build milliseconds and median million rays a second: primary, shadow.
#include <embree3/rtcore.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

struct V { float x, y, z; };
static V operator+(V a, V b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static V operator-(V a, V b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static V operator*(V a, float s) { return {a.x * s, a.y * s, a.z * s}; }
static float dot(V a, V b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static V cross(V a, V b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static V unit(V a) { return a * (1.0f / std::sqrt(dot(a, a))); }
static double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

int main(int argc, char** argv) {
  if (argc != 18) { std::fprintf(stderr, "usage: see the head of the source\n"); return 2; }
  FILE* file = std::fopen(argv[1], "rb");
  if (!file) { std::perror(argv[1]); return 1; }
  std::fseek(file, 0, SEEK_END);
  std::vector<unsigned char> bytes(std::ftell(file));
  std::rewind(file);
  if (std::fread(bytes.data(), 1, bytes.size(), file) != bytes.size()) return 1;
  std::fclose(file);
  const size_t head = 10 + bytes[8] + 256 * bytes[9], count = (bytes.size() - head) / 12;
  auto number = [&](int i) { return float(std::atof(argv[i])); };
  auto vector = [&](int i) { return V{number(i), number(i + 1), number(i + 2)}; };
  const float radius = number(2);
  const int threads = std::atoi(argv[3]), repeats = std::atoi(argv[4]);
  const V eye = vector(5), look = vector(8), up = vector(11), light = unit(vector(15));
  const float tangent = std::tan(number(14) * float(M_PI) / 360);
  const int width = 640, height = 480;

  RTCDevice device = rtcNewDevice(("threads=" + std::to_string(threads)).c_str());
  double start = now();
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
  float* spheres = (float*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 16, count);
  for (size_t i = 0; i < count; i++) {
    std::memcpy(spheres + 4 * i, bytes.data() + head + 12 * i, 12);
    spheres[4 * i + 3] = radius;
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  std::printf("build_ms %.2f\n", (now() - start) * 1e3);

  const V forward = unit(look - eye), right = unit(cross(forward, up)), above = cross(right, forward);
  std::vector<V> points(width * height), normals(width * height);
  std::vector<char> hit(width * height);
  auto parallel = [&](auto rows) {
    std::vector<std::thread> pool;
    for (int t = 0; t < threads; t++) pool.emplace_back([&, t] { for (int y = t; y < height; y += threads) rows(y); });
    for (auto& thread : pool) thread.join();
  };
  std::vector<double> primary, shadow;
  size_t hits = 0, shadows = 0;
  for (int repeat = 0; repeat < repeats; repeat++) {
    start = now();
    parallel([&](int y) {
      for (int x = 0; x < width; x++) {
        const V d = unit(forward + right * ((2 * (x + 0.5f) / width - 1) * tangent * width / height) + above * ((1 - 2 * (y + 0.5f) / height) * tangent));
        RTCRayHit ray{};
        ray.ray = {eye.x, eye.y, eye.z, 0, d.x, d.y, d.z, 0, INFINITY, ~0u, 0, 0};
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene, &context, &ray);
        const int i = y * width + x;
        hit[i] = ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        if (hit[i]) {
          points[i] = eye + d * ray.ray.tfar;
          normals[i] = unit({ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z});
        }
      }
    });
    primary.push_back(now() - start);
    hits = std::count(hit.begin(), hit.end(), 1);
    std::vector<size_t> traced(threads);
    start = now();
    parallel([&](int y) {
      size_t n = 0;
      for (int x = 0; x < width; x++) {
        const int i = y * width + x;
        if (!hit[i] || dot(normals[i], light) <= 0) continue;
        RTCRay ray = {points[i].x, points[i].y, points[i].z, radius * 1e-3f, light.x, light.y, light.z, 0, INFINITY, ~0u, 0, 0};
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(scene, &context, &ray);
        n++;
      }
      traced[y % threads] += n;
    });
    shadow.push_back(now() - start);
    shadows = 0;
    for (size_t n : traced) shadows += n;
  }
  auto median = [](std::vector<double> v) { std::sort(v.begin(), v.end()); return v[v.size() / 2]; };
  std::printf("primary %.3f Mrays/s (hit fraction %.3f)\nshadow %.3f Mrays/s (%zu rays)\n", width * height / median(primary) / 1e6,
              double(hits) / (width * height), shadows / median(shadow) / 1e6, shadows);
}
