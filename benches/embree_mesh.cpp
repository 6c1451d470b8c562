// A mesher's mesh to a picture with Embree: the second half of what whole_picture.py measures against.
//
//   apt-get install libembree-dev libpng-dev g++
//   g++ -O3 -march=native -std=c++17 benches/embree_mesh.cpp -o embree_mesh -lembree3 -lpng -pthread
//   ./embree_mesh mesh.ply picture.png THREADS eye.x eye.y eye.z look.x look.y look.z up.x up.y up.z VFOV light.x light.y light.z
//
// mesh.ply: binary, little endian; vertices of floats that begin with x, y, z; triangles with a count of
// one byte and indices of four, as pysplashsurf writes them. 640x480, one ray a pixel, one shadow ray,
// flat normals.
#include <embree3/rtcore.h>
#include <png.h>
#include <algorithm>
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

static int wrong(const char* words) { std::fprintf(stderr, "%s\n", words); return 1; }

int main(int argc, char** argv) {
  if (argc != 17) return wrong("usage: see the head of the source") + 1;
  FILE* file = std::fopen(argv[1], "rb");
  if (!file) { std::perror(argv[1]); return 1; }
  size_t vertices = 0, triangles = 0, floats = 0;
  bool in_vertices = false;
  char line[256];
  while (std::fgets(line, sizeof line, file) && std::strncmp(line, "end_header", 10)) {
    if (std::sscanf(line, "element vertex %zu", &vertices) == 1) in_vertices = true;
    else if (std::sscanf(line, "element face %zu", &triangles) == 1) in_vertices = false;
    else if (in_vertices && !std::strncmp(line, "property float", 14)) floats++;
  }
  if (floats < 3) return wrong("no float vertices");
  std::vector<float> places(vertices * floats);
  std::vector<unsigned char> faces(triangles * 13);
  if (std::fread(places.data(), 4 * floats, vertices, file) != vertices) return wrong("too few vertices");
  if (std::fread(faces.data(), 13, triangles, file) != triangles) return wrong("too few triangles");
  std::fclose(file);

  auto vector = [&](int i) { return V{float(std::atof(argv[i])), float(std::atof(argv[i + 1])), float(std::atof(argv[i + 2]))}; };
  const int threads = std::atoi(argv[3]), width = 640, height = 480;
  const V eye = vector(4), look = vector(7), up = vector(10), light = unit(vector(14));
  const float tangent = std::tan(float(std::atof(argv[13])) * float(M_PI) / 360);

  RTCDevice device = rtcNewDevice(("threads=" + std::to_string(threads)).c_str());
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  float* corners = (float*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices);
  for (size_t i = 0; i < vertices; i++) std::memcpy(corners + 3 * i, &places[floats * i], 12);
  unsigned* indices = (unsigned*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles);
  for (size_t i = 0; i < triangles; i++) std::memcpy(indices + 3 * i, &faces[13 * i + 1], 12);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);

  const V forward = unit(look - eye), right = unit(cross(forward, up)), above = cross(right, forward);
  std::vector<unsigned char> pixels(width * height * 3);
  std::vector<std::thread> pool;
  for (int t = 0; t < threads; t++) pool.emplace_back([&, t] {
    for (int y = t; y < height; y += threads) for (int x = 0; x < width; x++) {
      const V d = unit(forward + right * ((2 * (x + 0.5f) / width - 1) * tangent * width / height) + above * ((1 - 2 * (y + 0.5f) / height) * tangent));
      RTCRayHit ray{};
      ray.ray = {eye.x, eye.y, eye.z, 0, d.x, d.y, d.z, 0, INFINITY, ~0u, 0, 0};
      ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      rtcIntersect1(scene, &context, &ray);
      float shade = 1;
      if (ray.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
        V normal = unit({ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z});
        if (dot(normal, d) > 0) normal = normal * -1;
        shade = 0.1f;
        if (dot(normal, light) > 0) {
          const V point = eye + d * ray.ray.tfar;
          RTCRay shadow = {point.x, point.y, point.z, 1e-4f * ray.ray.tfar, light.x, light.y, light.z, 0, INFINITY, ~0u, 0, 0};
          rtcInitIntersectContext(&context);
          rtcOccluded1(scene, &context, &shadow);
          if (shadow.tfar >= 0) shade += 0.8f * dot(normal, light);
        }
      }
      const unsigned char level = (unsigned char)(255 * std::sqrt(std::min(shade, 1.0f)));
      std::memset(&pixels[3 * (y * width + x)], level, 3);
    }
  });
  for (auto& thread : pool) thread.join();

  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = PNG_FORMAT_RGB;
  if (!png_image_write_to_file(&image, argv[2], 0, pixels.data(), 0, nullptr)) return wrong(image.message);
}
