#include "show/export.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "core/mesh_file.h"
#include "core/provenance.h"

namespace pleat::show {
namespace {

void check_frames(const std::string& path, const std::vector<Points3>& frames,
                  Eigen::Index vertex_count) {
  if (frames.empty()) throw InputError(path + ": no frame to write");
  for (size_t i = 0; i < frames.size(); ++i) {
    const std::string frame = path + ": frame " + std::to_string(i);
    if (frames[i].rows() != vertex_count) {
      throw InputError(frame + " has " + std::to_string(frames[i].rows()) + " vertices; expected " +
                       std::to_string(vertex_count));
    }
    if (!frames[i].cast<float>().allFinite()) {
      throw InputError(frame + " has a vertex that is not finite");
    }
  }
}

// ---- bytes: both formats are little-endian, like every processor that this builds for

static_assert(sizeof(float) == 4 && std::numeric_limits<float>::is_iec559);

template <typename T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

using FloatPoints3 = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

template <typename Matrix>
void append_matrix(std::string& bytes, const Matrix& matrix) {
  static_assert(Matrix::IsRowMajor);
  bytes.append(reinterpret_cast<const char*>(matrix.data()),
               sizeof(typename Matrix::Scalar) * size_t(matrix.size()));
}

// The header of a .pc2 file.
struct Pc2Header {
  char magic[12];  // "POINTCACHE2", 0
  int32_t version;
  int32_t point_count;
  float start_frame;
  float sample_rate;
  int32_t sample_count;
};
static_assert(sizeof(Pc2Header) == 32);
constexpr char kPc2Magic[12] = "POINTCACHE2";

// ---- glTF: its vertices carry one UV each, so a sewn vertex is as many of them as it has UVs

struct SplitVertices {
  std::vector<int> vertex, uv;    // of each glTF vertex; uv is -1 where the mesh has none
  std::vector<uint32_t> corners;  // 3 a face
};

SplitVertices split_at_seams(const TriangleMesh& mesh) {
  SplitVertices split;
  std::map<std::pair<int, int>, uint32_t> number;
  const bool has_uv = mesh.uv_faces.rows() > 0;
  for (int f = 0; f < mesh.faces.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const std::pair<int, int> corner(mesh.faces(f, k), has_uv ? mesh.uv_faces(f, k) : -1);
      const auto [place, is_new] = number.emplace(corner, uint32_t(split.vertex.size()));
      if (is_new) {
        split.vertex.push_back(corner.first);
        split.uv.push_back(corner.second);
      }
      split.corners.push_back(place->second);
    }
  }
  return split;
}

FloatPoints3 gather(const Points3& points, const std::vector<int>& rows) {
  FloatPoints3 gathered(rows.size(), 3);
  for (size_t i = 0; i < rows.size(); ++i) gathered.row(i) = points.row(rows[i]).cast<float>();
  return gathered;
}

// The binary part and the JSON that says what lies where in it.
struct GltfBuffer {
  std::string bytes;
  nlohmann::json views = nlohmann::json::array();
  nlohmann::json accessors = nlohmann::json::array();

  enum Target { kNone = 0, kVertices = 34962, kIndices = 34963 };

  template <typename Matrix>
  int add(const Matrix& matrix, int component_type, const char* type, Target target,
          bool has_bounds = false) {
    nlohmann::json view = {{"buffer", 0}, {"byteOffset", bytes.size()}};
    append_matrix(bytes, matrix);
    view["byteLength"] = bytes.size() - view["byteOffset"].get<size_t>();
    if (target != kNone) view["target"] = int(target);
    nlohmann::json accessor = {
        {"bufferView", views.size()},
        {"componentType", component_type},
        {"count", std::strcmp(type, "SCALAR") ? matrix.rows() : matrix.size()},
        {"type", type}};
    if (has_bounds) {
      for (int c = 0; c < matrix.cols(); ++c) {
        accessor["min"].push_back(matrix.col(c).minCoeff());
        accessor["max"].push_back(matrix.col(c).maxCoeff());
      }
    }
    views.push_back(view);
    accessors.push_back(accessor);
    return int(accessors.size()) - 1;
  }
};
constexpr int kUnsigned = 5125, kFloat = 5126;  // glTF component types

}  // namespace

std::vector<std::string> write_obj_sequence(const std::string& folder, const std::string& name,
                                            const TriangleMesh& mesh,
                                            const std::vector<Points3>& frames) {
  check_frames(folder + "/" + name, frames, mesh.vertices.rows());
  std::filesystem::create_directories(folder);
  std::vector<std::string> paths;
  TriangleMesh posed = mesh;
  for (size_t i = 0; i < frames.size(); ++i) {
    char number[32];
    std::snprintf(number, sizeof number, "_%04zu.obj", i);
    paths.push_back((std::filesystem::path(folder) / (name + number)).string());
    posed.vertices = frames[i];
    write_obj(paths.back(), posed);
  }
  return paths;
}

void write_pc2(const std::string& path, const std::vector<Points3>& frames, double start_frame) {
  check_frames(path, frames, frames.empty() ? 0 : frames[0].rows());
  Pc2Header header{};
  std::copy(std::begin(kPc2Magic), std::end(kPc2Magic), header.magic);
  header.version = 1;
  header.point_count = int32_t(frames[0].rows());
  header.start_frame = float(start_frame);
  header.sample_rate = 1;
  header.sample_count = int32_t(frames.size());
  std::string bytes;
  append(bytes, header);
  for (const Points3& frame : frames) append_matrix(bytes, FloatPoints3(frame.cast<float>()));
  write_file_atomically(path, bytes);
}

PointCache read_pc2(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path + ": cannot be opened for reading");
  Pc2Header header{};
  if (!file.read(reinterpret_cast<char*>(&header), sizeof header) ||
      std::memcmp(header.magic, kPc2Magic, sizeof kPc2Magic) != 0 || header.version != 1) {
    throw InputError(path + ": not a PC2 point cache (version 1)");
  }
  if (header.point_count < 0 || header.sample_count < 0) {
    throw InputError(path + ": header counts " + std::to_string(header.point_count) + " points, " +
                     std::to_string(header.sample_count) + " samples; expected 0 or more");
  }
  const uint64_t frame_bytes = uint64_t(header.point_count) * 3 * sizeof(float);
  const uint64_t size = std::filesystem::file_size(path);
  // Divide rather than multiply: a hostile header could overflow the product.
  const uint64_t data_bytes = size - sizeof header;
  const bool fits = frame_bytes ? data_bytes % frame_bytes == 0 &&
                                      data_bytes / frame_bytes == uint64_t(header.sample_count)
                                : data_bytes == 0;
  if (!fits) {
    throw InputError(path + ": " + std::to_string(size) + " bytes do not hold " +
                     std::to_string(header.sample_count) + " samples of " +
                     std::to_string(header.point_count) + " points; is the file truncated?");
  }
  PointCache cache{header.start_frame, header.sample_rate, {}};
  if (!frame_bytes) return cache;
  FloatPoints3 frame(header.point_count, 3);
  for (int32_t i = 0; i < header.sample_count; ++i) {
    if (!file.read(reinterpret_cast<char*>(frame.data()), std::streamsize(frame_bytes))) {
      throw InputError(path + ": cannot be read to its end");
    }
    if (!frame.allFinite()) {
      throw InputError(path + ": sample " + std::to_string(i) + " has a point that is not finite");
    }
    cache.frames.emplace_back(frame.cast<double>());
  }
  return cache;
}

void write_glb(const std::string& path, const TriangleMesh& mesh,
               const std::vector<Points3>& frames, double frame_rate_hz) {
  check_frames(path, frames, mesh.vertices.rows());
  if (mesh.faces.rows() == 0) throw InputError(path + ": a mesh without faces");
  if (!(frame_rate_hz > 0)) {
    throw InputError(path + ": frame_rate_hz = " + std::to_string(frame_rate_hz) +
                     "; expected > 0");
  }
  using Row = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const SplitVertices split = split_at_seams(mesh);
  GltfBuffer buffer;
  const Eigen::Map<const Eigen::Matrix<uint32_t, Eigen::Dynamic, 1>> corners(
      split.corners.data(), Eigen::Index(split.corners.size()));
  nlohmann::json primitive;
  primitive["indices"] =
      buffer.add(Eigen::Matrix<uint32_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>(corners),
                 kUnsigned, "SCALAR", GltfBuffer::kIndices);
  const FloatPoints3 first = gather(frames[0], split.vertex);
  const FloatPoints3 first_normals = gather(vertex_normals(frames[0], mesh.faces), split.vertex);
  primitive["attributes"]["POSITION"] =
      buffer.add(first, kFloat, "VEC3", GltfBuffer::kVertices, true);
  primitive["attributes"]["NORMAL"] =
      buffer.add(first_normals, kFloat, "VEC3", GltfBuffer::kVertices);
  if (mesh.uv_faces.rows() > 0) {
    Row uv(split.uv.size(), 2);
    for (size_t i = 0; i < split.uv.size(); ++i) {  // glTF counts v from the top
      uv.row(i) << float(mesh.uv(split.uv[i], 0)), float(1 - mesh.uv(split.uv[i], 1));
    }
    primitive["attributes"]["TEXCOORD_0"] = buffer.add(uv, kFloat, "VEC2", GltfBuffer::kVertices);
  }
  primitive["material"] = 0;

  nlohmann::json node = {{"mesh", 0}}, shape, animation;
  if (frames.size() > 1) {
    const int targets = int(frames.size()) - 1;  // frame 0 is the mesh itself
    for (int t = 1; t <= targets; ++t) {
      const FloatPoints3 move = gather(frames[t], split.vertex) - first;
      const FloatPoints3 turn =
          gather(vertex_normals(frames[t], mesh.faces), split.vertex) - first_normals;
      primitive["targets"].push_back(
          {{"POSITION", buffer.add(move, kFloat, "VEC3", GltfBuffer::kVertices, true)},
           {"NORMAL", buffer.add(turn, kFloat, "VEC3", GltfBuffer::kVertices)}});
    }
    shape["weights"] = std::vector<float>(targets, 0.0F);
    Row times(targets + 1, 1), weights = Row::Zero(targets + 1, targets);
    for (int t = 0; t <= targets; ++t) {
      times(t, 0) = float(t / frame_rate_hz);
      if (t > 0) weights(t, t - 1) = 1;
    }
    const int input = buffer.add(times, kFloat, "SCALAR", GltfBuffer::kNone, true);
    const int output = buffer.add(weights, kFloat, "SCALAR", GltfBuffer::kNone);
    animation = {
        {"samplers", {{{"input", input}, {"output", output}, {"interpolation", "LINEAR"}}}},
        {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}};
  }
  shape["primitives"] = nlohmann::json::array({primitive});

  nlohmann::json gltf = {{"asset", {{"version", "2.0"}, {"generator", "pleat " + version()}}},
                         {"scene", 0},
                         {"scenes", {{{"nodes", {0}}}}},
                         {"nodes", nlohmann::json::array({node})},
                         {"meshes", nlohmann::json::array({shape})},
                         {"materials",
                          {{{"doubleSided", true},
                            {"pbrMetallicRoughness",
                             {{"baseColorFactor", {0.08, 0.18, 0.39, 1.0}},
                              {"metallicFactor", 0},
                              {"roughnessFactor", 0.9}}}}}},
                         {"bufferViews", buffer.views},
                         {"accessors", buffer.accessors},
                         {"buffers", {{{"byteLength", buffer.bytes.size()}}}}};
  if (!animation.is_null()) gltf["animations"] = nlohmann::json::array({animation});

  std::string text = gltf.dump();
  text.append((4 - text.size() % 4) % 4,
              ' ');  // chunks are multiples of 4; the binary one is already
  const uint64_t total = 12 + 8 + text.size() + 8 + buffer.bytes.size();
  if (total > std::numeric_limits<uint32_t>::max()) {
    throw InputError(path + ": " + std::to_string(frames.size()) +
                     " frames need more than the 4 GiB of a .glb file; write fewer, or PC2");
  }
  std::string bytes;
  for (const uint32_t word :
       {0x46546C67U, 2U, uint32_t(total), uint32_t(text.size()), 0x4E4F534AU}) {
    append(bytes, word);  // "glTF", version, length; length and "JSON"
  }
  bytes += text;
  append(bytes, uint32_t(buffer.bytes.size()));
  append(bytes, 0x004E4942U);  // "BIN"
  bytes += buffer.bytes;
  write_file_atomically(path, bytes);
}

}  // namespace pleat::show
