#include "show/render.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "core/error.h"
#include "core/mesh.h"

namespace pleat::show {
namespace {

// The studio: one broad key light above the camera's left shoulder and a sky, over a floor that
// reflects some of it. Strengths are such that a white surface facing the key light is just short
// of full.
const Vec<3> kKeyDirection = Vec<3>(-0.66, 0.72, 0.42).normalized();  // camera's right, up, back
constexpr double kKeyAngularRadius = 0.16;                            // rad: penumbra
constexpr double kKeyStrength = 1.05;
constexpr double kSkyZenith = 0.48;
constexpr double kSkyHorizon = 0.30;
constexpr double kFloorBounce = 0.20;
constexpr double kBetweenSurfaces = 0.14;  // light that one surface sends to another, per albedo
constexpr double kGroundShadow = 0.5;      // how much of a shadow the floor shows
constexpr double kRayOffset_m = 1e-4;      // beyond float rounding, below any gap to be seen

// ---- sampling: the pattern is fixed, so a picture depends on nothing but its input

// A bijection without visible structure (Wellons 2018, "lowbias32").
uint32_t mix_bits(uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352dU;
  x = (x ^ (x >> 15)) * 0x846ca68bU;
  return x ^ (x >> 16);
}

// Point i of the first two Sobol dimensions, its bits flipped by the scramble (Kollig and Keller
// 2002): any 2^k points are stratified in both.
std::array<double, 2> sobol_point(uint32_t i, uint32_t scramble_x, uint32_t scramble_y) {
  uint32_t x = 0, y = 0;
  uint32_t direction = 1U << 31;
  for (uint32_t bit = 1U << 31, k = i; k; k >>= 1, bit >>= 1, direction ^= direction >> 1) {
    if (k & 1U) {
      x ^= bit;
      y ^= direction;
    }
  }
  constexpr double kScale = 1.0 / 4294967296.0;
  return {(x ^ scramble_x) * kScale, (y ^ scramble_y) * kScale};
}

// What one pixel draws: a stream of stratified points for each purpose.
struct PixelSampler {
  uint32_t seed;
  std::array<double, 2> point(uint32_t purpose, uint32_t i) const {
    const uint32_t scramble = mix_bits(seed ^ (purpose * 0x9e3779b9U));
    return sobol_point(i, scramble, mix_bits(scramble));
  }
};

struct Frame {
  Vec<3> tangent, bitangent, normal;
};
Frame frame_around(const Vec<3>& n) {  // Duff et al. 2017
  const double sign = std::copysign(1.0, n[2]);
  const double a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
  return {
      {1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]}, {b, sign + n[1] * n[1] * a, -n[1]}, n};
}

// Equal areas of the square go to equal areas of the disc. The angle is one of kAngles: a table
// costs less than its sine.
std::array<double, 2> disc_point(const std::array<double, 2>& u) {
  constexpr int kAngles = 2048;
  static const auto table = [] {
    std::array<std::array<double, 2>, kAngles> unit;
    for (int i = 0; i < kAngles; ++i) {
      const double phi = 2 * M_PI * (i + 0.5) / kAngles;
      unit[i] = {std::cos(phi), std::sin(phi)};
    }
    return unit;
  }();
  const double r = std::sqrt(u[0]);
  const auto& [x, y] = table[int(u[1] * kAngles)];
  return {r * x, r * y};
}

Vec<3> cosine_direction(const Frame& frame, const std::array<double, 2>& u) {
  const auto [x, y] = disc_point(u);
  return x * frame.tangent + y * frame.bitangent +
         std::sqrt(std::max(0.0, 1 - x * x - y * y)) * frame.normal;
}

// ---- geometry

struct Ray {
  Vec<3> origin, direction;  // direction of unit length
};

struct ShadedMesh {
  const RenderMesh* mesh;
  Points3 normals;
  Color color, inside_color;         // linear light
  std::vector<Color> vertex_colors;  // linear light
};

struct Surface {  // what a camera ray sees
  Vec<3> position;
  Vec<3> geometric_normal, normal;  // both towards the viewer
  Vec<3> shadow_origin;             // where rays to the lights start
  Color albedo;
  double sheen;
};

class Scene {
 public:
  explicit Scene(const std::vector<RenderMesh>& meshes)
      // One thread: a build by several may order the tree, and so equal hits, differently.
      : device_(rtcNewDevice("threads=1,set_affinity=0"), rtcReleaseDevice) {
    if (!device_) throw std::runtime_error("Embree does not start on this processor");
    scene_ = {rtcNewScene(device_.get()), rtcReleaseScene};
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    for (const RenderMesh& mesh : meshes) add(mesh);
    rtcCommitScene(scene_.get());
    if (rtcGetDeviceError(device_.get()) != RTC_ERROR_NONE) {
      throw std::runtime_error("Embree could not build its tree; is there enough memory?");
    }
  }

  bool intersect(const Ray& ray, Surface& surface) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit hit{};
    hit.ray = rtc_ray(ray);
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_.get(), &context, &hit);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    surface = surface_at(meshes_[hit.hit.geomID], int(hit.hit.primID), hit.hit.u, hit.hit.v, ray);
    return true;
  }

  bool is_occluded(const Ray& ray) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay shadow = rtc_ray(ray);
    rtcOccluded1(scene_.get(), &context, &shadow);
    return shadow.tfar < 0;
  }

 private:
  static RTCRay rtc_ray(const Ray& ray) {
    RTCRay r{};
    r.org_x = float(ray.origin[0]), r.org_y = float(ray.origin[1]), r.org_z = float(ray.origin[2]);
    r.dir_x = float(ray.direction[0]), r.dir_y = float(ray.direction[1]);
    r.dir_z = float(ray.direction[2]);
    r.tfar = std::numeric_limits<float>::infinity();
    r.mask = ~0U;
    return r;
  }

  void add(const RenderMesh& mesh) {
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    const size_t vertices = size_t(mesh.vertices.rows()), faces = size_t(mesh.faces.rows());
    if (vertices && faces) {
      auto* xyz = static_cast<float*>(rtcSetNewGeometryBuffer(
          geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices));
      auto* corners = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
          geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), faces));
      if (!xyz || !corners) throw std::bad_alloc();
      std::transform(mesh.vertices.data(), mesh.vertices.data() + 3 * vertices, xyz,
                     [](double value) { return float(value); });
      std::transform(mesh.faces.data(), mesh.faces.data() + 3 * faces, corners,
                     [](int vertex) { return unsigned(vertex); });
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_.get(), geometry);  // numbered 0, 1, ... in this order
    rtcReleaseGeometry(geometry);

    ShadedMesh shaded{&mesh,
                      vertex_normals(mesh.vertices, mesh.faces),
                      linear_from_srgb(mesh.color),
                      linear_from_srgb(mesh.inside_color.value_or(mesh.color)),
                      {}};
    for (const Color& color : mesh.vertex_colors) {
      shaded.vertex_colors.push_back(linear_from_srgb(color));
    }
    meshes_.push_back(std::move(shaded));
  }

  static Surface surface_at(const ShadedMesh& shaded, int face, double u, double v,
                            const Ray& ray) {
    const RenderMesh& mesh = *shaded.mesh;
    const std::array<int, 3> corner = {mesh.faces(face, 0), mesh.faces(face, 1),
                                       mesh.faces(face, 2)};
    const Vec<3> weight(1 - u - v, u, v);
    std::array<Vec<3>, 3> x, n;
    Surface surface;
    surface.position.setZero();
    surface.normal.setZero();
    for (int k = 0; k < 3; ++k) {
      x[k] = mesh.vertices.row(corner[k]);
      n[k] = shaded.normals.row(corner[k]);
      surface.position += weight[k] * x[k];
      surface.normal += weight[k] * n[k];
    }
    surface.geometric_normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
    const bool is_inside = surface.geometric_normal.dot(ray.direction) > 0;
    const double side = is_inside ? -1 : 1;
    surface.geometric_normal *= side;
    surface.normal *= side;
    if (!(surface.normal.norm() > 1e-6)) surface.normal = surface.geometric_normal;
    surface.normal.normalize();

    // Shadow rays start from the smooth surface that the normals pretend, or each flat face would
    // show its own edge of shadow (Hanika 2021, "Hacking the shadow terminator").
    surface.shadow_origin = surface.position + kRayOffset_m * surface.geometric_normal;
    for (int k = 0; k < 3; ++k) {
      const double below = std::min(0.0, side * n[k].dot(surface.position - x[k]));
      surface.shadow_origin -= weight[k] * below * side * n[k];
    }

    surface.albedo = shaded.color;
    if (is_inside) surface.albedo = shaded.inside_color;
    const bool has_own_inside = is_inside && mesh.inside_color;
    if (!shaded.vertex_colors.empty() && !has_own_inside) {
      surface.albedo.setZero();
      for (int k = 0; k < 3; ++k) surface.albedo += weight[k] * shaded.vertex_colors[corner[k]];
    }
    surface.sheen = mesh.sheen;
    return surface;
  }

  std::unique_ptr<std::remove_pointer_t<RTCDevice>, decltype(&rtcReleaseDevice)> device_;
  std::unique_ptr<std::remove_pointer_t<RTCScene>, decltype(&rtcReleaseScene)> scene_{
      nullptr, rtcReleaseScene};
  std::vector<ShadedMesh> meshes_;
};

// ---- camera

struct CameraFrame {
  Camera camera;
  Vec<3> right, up, back;
  double half_height;  // m, or at distance 1

  explicit CameraFrame(const Camera& c) : camera(c) {
    half_height = c.orthographic_height_m > 0 ? c.orthographic_height_m / 2
                                              : std::tan(c.field_of_view_rad / 2);
    back = (c.eye - c.target).normalized();
    right = c.up.cross(back).normalized();
    up = back.cross(right);
    if (!(back.norm() > 0.5) || !(right.norm() > 0.5)) {  // Eigen leaves a zero vector as it is
      throw InputError("camera: eye and target must differ, and up must not point along them");
    }
  }

  // x to the right, y up, in halves of the picture's height, 0 in the middle.
  Ray ray(double x, double y) const {
    const Vec<3> across = half_height * (x * right + y * up);
    if (camera.orthographic_height_m > 0) return {camera.eye + across, -back};
    return {camera.eye, (across - back).normalized()};
  }
};

// ---- light

struct Light {
  Frame key;  // normal: towards the light
  double sky(const Vec<3>& direction) const {
    return direction[1] >= 0 ? kSkyHorizon + (kSkyZenith - kSkyHorizon) * direction[1]
                             : kFloorBounce;
  }
};

enum Purpose : uint32_t { kPixel = 1, kAmbient = 2, kKey = 3 };

struct Shading {
  const Scene& scene;
  const Light& light;
  const RenderConfig& config;
  const PixelSampler& sampler;
  uint32_t sample;  // of the pixel

  template <typename Function>
  void for_each_key_direction(Function function) const {
    for (int i = 0; i < config.key_samples; ++i) {
      const auto [x, y] = disc_point(sampler.point(kKey, sample * config.key_samples + i));
      const Vec<3> across = x * light.key.tangent + y * light.key.bitangent;
      function(Vec<3>((light.key.normal + kKeyAngularRadius * across).normalized()));
    }
  }

  template <typename Function>
  void for_each_ambient_direction(const Vec<3>& normal, Function function) const {
    const Frame frame = frame_around(normal);
    for (int i = 0; i < config.ambient_samples; ++i) {
      const auto point = sampler.point(kAmbient, sample * config.ambient_samples + i);
      function(cosine_direction(frame, point));
    }
  }

  double key_light(const Vec<3>& origin, const Vec<3>& normal) const {
    double sum = 0;
    for_each_key_direction([&](const Vec<3>& direction) {
      const double cosine = normal.dot(direction);
      if (cosine > 0 && !scene.is_occluded({origin, direction})) sum += cosine;
    });
    return kKeyStrength * sum / config.key_samples;
  }

  // What is hidden from the sky sees other cloth or skin of about this albedo, lit about as well as
  // anything: so folds darken with their colour, not to black.
  Color sky_light(const Vec<3>& origin, const Vec<3>& normal, const Color& albedo) const {
    Color sum = Color::Zero();
    for_each_ambient_direction(normal, [&](const Vec<3>& direction) {
      if (scene.is_occluded({origin, direction})) {
        sum += kBetweenSurfaces * albedo;
      } else {
        sum += Color::Constant(light.sky(direction));
      }
    });
    return sum / config.ambient_samples;
  }

  Color surface_light(const Surface& surface, const Vec<3>& view) const {
    const double key = key_light(surface.shadow_origin, surface.normal);
    const Color ambient = sky_light(surface.shadow_origin, surface.normal, surface.albedo);
    const Color received = Color::Constant(key) + ambient;
    const double grazing = 1 - std::clamp(surface.normal.dot(view), 0.0, 1.0);
    const double sheen = surface.sheen * grazing * grazing * grazing;
    return received.cwiseProduct(surface.albedo + 0.35 * sheen * (Color::Ones() - surface.albedo));
  }

  // Share of the light on the open floor that something hides from this point of it.
  double floor_shadow(const Vec<3>& position) const {
    const Vec<3> up(0, 1, 0);
    const Vec<3> origin = position + kRayOffset_m * up;
    double open = 0, hidden = 0;
    for_each_key_direction([&](const Vec<3>& direction) {
      const double light_here = kKeyStrength * std::max(0.0, direction[1]) / config.key_samples;
      open += light_here;
      if (scene.is_occluded({origin, direction})) hidden += light_here;
    });
    for_each_ambient_direction(up, [&](const Vec<3>& direction) {
      const double light_here = light.sky(direction) / config.ambient_samples;
      open += light_here;
      if (scene.is_occluded({origin, direction})) hidden += light_here;
    });
    return hidden / open;
  }
};

void check(const RenderMesh& mesh, size_t index) {
  const std::string name = "render: mesh " + std::to_string(index);
  if (!mesh.vertices.allFinite()) throw InputError(name + " has a vertex that is not finite");
  if (mesh.faces.size() &&
      (mesh.faces.minCoeff() < 0 || mesh.faces.maxCoeff() >= mesh.vertices.rows())) {
    throw InputError(name + " has a face with vertex " + std::to_string(mesh.faces.maxCoeff()) +
                     " of " + std::to_string(mesh.vertices.rows()));
  }
  if (!mesh.vertex_colors.empty() && mesh.vertex_colors.size() != size_t(mesh.vertices.rows())) {
    throw InputError(name + " has " + std::to_string(mesh.vertex_colors.size()) + " colours for " +
                     std::to_string(mesh.vertices.rows()) + " vertices");
  }
}

}  // namespace

RenderMesh body_mesh(const Eigen::Ref<const Points3>& vertices, const Faces& faces) {
  RenderMesh mesh;
  mesh.vertices = vertices;
  mesh.faces = faces;
  return mesh;
}

RenderMesh cloth_mesh(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
                      const Color& color) {
  RenderMesh mesh = body_mesh(vertices, faces);
  mesh.color = color;
  mesh.inside_color = 0.45 * color + 0.55 * Color(0.93, 0.84, 0.62);  // paler and warmer
  mesh.sheen = 0.6;
  return mesh;
}

Camera view_camera(View view, const Vec<3>& target, double yaw_rad, double height_m) {
  constexpr double kElevation = 0.14;  // rad; enough to see the floor and the shadow
  double turn = 0;
  switch (view) {
    case View::kFront:
      turn = 0;
      break;
    case View::kSide:
      turn = M_PI / 2;
      break;
    case View::kBack:
      turn = M_PI;
      break;
    case View::kThreeQuarter:
      turn = M_PI / 5;
      break;
  }
  Camera camera;
  camera.target = target;
  const double distance = height_m / 2 / std::tan(camera.field_of_view_rad / 2);
  const double azimuth = yaw_rad + turn;
  camera.eye =
      target + distance * Vec<3>(std::cos(kElevation) * std::sin(azimuth), std::sin(kElevation),
                                 std::cos(kElevation) * std::cos(azimuth));
  return camera;
}

double facing_yaw(const Vec<3>& root_rotation) {
  const double angle = root_rotation.norm();
  const Vec<3> forward(0, 0, 1);
  Vec<3> facing = forward;
  if (angle > 0) {  // Rodrigues
    const Vec<3> axis = root_rotation / angle;
    facing = std::cos(angle) * forward + std::sin(angle) * axis.cross(forward) +
             (1 - std::cos(angle)) * axis.dot(forward) * axis;
  }
  return std::hypot(facing[0], facing[2]) > 1e-9 ? std::atan2(facing[0], facing[2]) : 0;
}

void validate(const RenderConfig& config) {
  const auto require = [](bool is_good, const std::string& key, double value,
                          const char* expected) {
    if (!is_good) {
      throw InputError("render." + key + " = " + std::to_string(value) + "; expected " + expected);
    }
  };
  const auto is_size = [](int pixels) { return pixels >= 16 && pixels <= 8192; };
  require(is_size(config.width), "width", config.width, "16 .. 8192 pixels");
  require(is_size(config.height), "height", config.height, "16 .. 8192 pixels");
  const int side = int(std::lround(std::sqrt(std::max(0, config.samples_per_pixel))));
  require(side >= 1 && side <= 32 && side * side == config.samples_per_pixel, "samples_per_pixel",
          config.samples_per_pixel, "a square number, 1 .. 1024");
  require(config.ambient_samples >= 1 && config.ambient_samples <= 1024, "ambient_samples",
          config.ambient_samples, "1 .. 1024");
  require(config.key_samples >= 1 && config.key_samples <= 1024, "key_samples", config.key_samples,
          "1 .. 1024");
  require(std::isfinite(config.ground_height_m), "ground_height_m", config.ground_height_m,
          "a height in metres");
  for (int c = 0; c < 3; ++c) {
    require(config.background[c] >= 0 && config.background[c] <= 1, "background",
            config.background[c], "0 .. 1");
  }
}

Image render(const std::vector<RenderMesh>& meshes, const Camera& camera,
             const RenderConfig& config) {
  validate(config);
  for (size_t i = 0; i < meshes.size(); ++i) check(meshes[i], i);
  const Scene scene(meshes);
  const CameraFrame frame(camera);
  const Light light{frame_around(
      (kKeyDirection[0] * frame.right + kKeyDirection[1] * frame.up + kKeyDirection[2] * frame.back)
          .normalized())};
  const Color background = linear_from_srgb(config.background);
  const int side = int(std::lround(std::sqrt(config.samples_per_pixel)));
  Image image{config.width, config.height,
              std::vector<uint8_t>(size_t(3) * config.width * config.height)};

  // open_pixels: how many pixels to the left of this one saw no shadow on the floor.
  const auto pixel_light = [&](int column, int row, int& open_pixels) {
    const PixelSampler sampler{mix_bits(uint32_t(row) * uint32_t(config.width) + uint32_t(column))};
    Color sum = Color::Zero();
    int floor_samples = 0;
    bool is_in_shadow = open_pixels < 16;
    bool is_open = true;
    for (int i = 0; i < config.samples_per_pixel; ++i) {
      const auto [u, v] = sampler.point(kPixel, uint32_t(i));
      const double x = column + (i % side + u) / side, y = row + (i / side + v) / side;
      const Ray ray = frame.ray((2 * x - config.width) / config.height,
                                (config.height - 2 * y) / config.height);
      const Shading shading{scene, light, config, sampler, uint32_t(i)};
      Surface surface;
      if (scene.intersect(ray, surface)) {
        sum += shading.surface_light(surface, -ray.direction);
        continue;
      }
      // The floor shows shadows only; elsewhere it has the background's colour. Most of it lies in
      // the open: far from any shadow, a few samples look whether another one begins.
      double shadow = 0;
      const double distance = (config.ground_height_m - ray.origin[1]) / ray.direction[1];
      const bool sees_floor = config.has_ground && ray.direction[1] < 0 && distance > 0;
      if (sees_floor && (is_in_shadow || floor_samples < 4)) {
        shadow = shading.floor_shadow(ray.origin + distance * ray.direction);
        if (shadow > 0) is_in_shadow = true, is_open = false;
        ++floor_samples;
      }
      sum += background * (1 - kGroundShadow * shadow);
    }
    open_pixels = is_open ? open_pixels + 1 : 0;
    return Color(sum / config.samples_per_pixel);
  };

#pragma omp parallel for schedule(dynamic, 4)
  for (int row = 0; row < config.height; ++row) {
    int open_pixels = 0;
    for (int column = 0; column < config.width; ++column) {
      const Color color = srgb_from_linear(pixel_light(column, row, open_pixels));
      uint8_t* pixel = &image.rgb[3 * (size_t(row) * config.width + column)];
      for (int c = 0; c < 3; ++c) pixel[c] = uint8_t(std::lround(255 * color[c]));
    }
  }
  return image;
}

}  // namespace pleat::show
