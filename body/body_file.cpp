#include "body/body_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "body/fill_holes.h"
#include "core/error.h"
#include "core/npz_file.h"

namespace pleat::body {
namespace {

constexpr int kSmplxJoints = 55;
constexpr int kMostShapeDirections =
    16;  // SMPL+H; a model with more (SMPL-X: 300 and 100 of expression) gives its first 10
constexpr int kDefaultShapeDirections = 10;

[[noreturn]] void fail(const std::string& path, const std::string& message) {
  throw InputError(path + ": " + message);
}

std::string dims_text(const std::vector<int64_t>& shape) {
  std::string text;
  for (int64_t n : shape) text += (text.empty() ? "" : " x ") + std::to_string(n);
  return text.empty() ? "a single number" : text;
}

// expected: -1 stands for any size.
NpyArray read_array(const NpzFile& file, const std::string& key,
                    const std::vector<int64_t>& expected) {
  NpyArray array = file.read(key);
  bool fits = array.shape.size() == expected.size();
  for (size_t k = 0; fits && k < expected.size(); ++k)
    fits = expected[k] < 0 || array.shape[k] == expected[k];
  if (!fits) {
    std::string wanted;
    for (int64_t n : expected)
      wanted += (wanted.empty() ? "" : " x ") + (n < 0 ? std::string("any") : std::to_string(n));
    fail(file.path(), key + " is " + dims_text(array.shape) + "; expected " + wanted);
  }
  const int64_t columns =
      array.shape.empty()
          ? 1
          : std::max<int64_t>(1, array.size() / std::max<int64_t>(1, array.shape[0]));
  for (int64_t i = 0; i < array.size(); ++i) {
    if (!std::isfinite(array.values[i]))
      fail(file.path(), key + " row " + std::to_string(i / columns) + " is not finite");
  }
  return array;
}

SkinWeights sparse(const NpyArray& array) {
  using Dense = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const Dense> dense(array.values.data(), array.shape[0], array.shape[1]);
  SkinWeights result = dense.sparseView(1, 0);
  result.makeCompressed();
  return result;
}

NpyArray dense(const SkinWeights& matrix) {
  NpyArray array{{matrix.rows(), matrix.cols()},
                 std::vector<double>(static_cast<size_t>(matrix.rows() * matrix.cols()), 0.0)};
  for (int row = 0; row < matrix.rows(); ++row) {
    for (SkinWeights::InnerIterator it(matrix, row); it; ++it) {
      array.values[static_cast<size_t>(row * matrix.cols() + it.col())] = it.value();
    }
  }
  return array;
}

// A whole number, or InputError.
int index_at(const NpyArray& array, int64_t i, const std::string& path, const std::string& key) {
  const double value = array.values[static_cast<size_t>(i)];
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
    fail(path, key + " holds " + std::to_string(value) + "; expected an index");
  }
  return static_cast<int>(value);
}

// SMPL-X has eyeballs as loose surfaces and is open at the eyes and the mouth. What is loose goes,
// and openings all of whose vertices hang on head, jaw or eyes are closed; any other hole stays and
// is refused later.
void close_head(BodyModel& model) {
  std::vector<int> piece(static_cast<size_t>(model.template_vertices.rows()));
  for (size_t v = 0; v < piece.size(); ++v) piece[v] = static_cast<int>(v);
  const auto root = [&](int v) {
    while (piece[v] != v) v = piece[v] = piece[piece[v]];
    return v;
  };
  for (int f = 0; f < model.faces.rows(); ++f) {
    for (int c = 1; c < 3; ++c) piece[root(model.faces(f, c))] = root(model.faces(f, 0));
  }
  std::vector<int> size(piece.size(), 0);
  for (int f = 0; f < model.faces.rows(); ++f) ++size[root(model.faces(f, 0))];
  const int largest = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
  Faces skin(model.faces.rows(), 3);
  int count = 0;
  for (int f = 0; f < model.faces.rows(); ++f) {
    if (root(model.faces(f, 0)) == largest) skin.row(count++) = model.faces.row(f);
  }
  skin.conservativeResize(count, 3);

  for (const std::vector<int>& loop : boundary_loops(skin)) {
    const bool on_head = std::all_of(loop.begin(), loop.end(), [&](int v) {
      double weight = 0;
      for (int j : {15, 22, 23, 24}) weight += model.weights.coeff(v, j);
      return weight > 0.5;
    });
    if (on_head) skin = joined(skin, fill_hole(model.template_vertices, skin, loop));
  }
  model.faces = skin;
}

}  // namespace

BodyModel read_body(const std::string& path) {
  if (std::filesystem::path(path).extension() == ".pkl") {
    fail(path,
         "is a Python pickle, which Pleat does not open; convert it where numpy, scipy and chumpy "
         "are installed: "
         "python3 -c \"import pickle, numpy as np; m = pickle.load(open('model.pkl', 'rb'), "
         "encoding='latin1'); "
         "np.savez('model.npz', **{k: v.toarray() if hasattr(v, 'toarray') else "
         "np.array(getattr(v, 'r', v)) "
         "for k, v in m.items() if k in ('v_template', 'shapedirs', 'posedirs', 'J_regressor', "
         "'weights', "
         "'kintree_table', 'f')})\"");
  }
  const NpzFile file(path);
  BodyModel model;
  model.name =
      file.has("name") ? file.read_text("name") : std::filesystem::path(path).stem().string();

  const NpyArray vertices = read_array(file, "v_template", {-1, 3});
  const int64_t vertex_count = vertices.shape[0];
  model.template_vertices = Eigen::Map<const Points3>(vertices.values.data(), vertex_count, 3);

  const NpyArray tree = read_array(file, "kintree_table", {2, -1});
  const int64_t joint_count = tree.shape[1];
  model.parents.resize(joint_count);
  for (int64_t j = 0; j < joint_count; ++j) {
    // The root's parent is -1, in unsigned files 4294967295.
    model.parents[j] = j == 0 ? -1 : index_at(tree, j, path, "kintree_table");
  }

  const NpyArray shape = read_array(file, "shapedirs", {vertex_count, 3, -1});
  const int64_t directions = shape.shape[2];
  const int64_t kept = joint_count == kSmplxJoints || directions > kMostShapeDirections
                           ? std::min<int64_t>(directions, kDefaultShapeDirections)
                           : directions;
  for (int64_t k = 0; k < kept; ++k) {
    Points3 direction(vertex_count, 3);
    for (int64_t i = 0; i < direction.size(); ++i)
      direction.data()[i] = shape.values[static_cast<size_t>(i * directions + k)];
    model.shape_directions.push_back(std::move(direction));
  }

  const std::vector<int64_t> pose_shape =
      file.has("posedirs") ? file.shape("posedirs") : std::vector<int64_t>{0};
  if (std::count(pose_shape.begin(), pose_shape.end(), 0) == 0) {
    const NpyArray pose = read_array(file, "posedirs", {vertex_count, 3, 9 * (joint_count - 1)});
    using Dense = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    model.pose_directions =
        Eigen::Map<const Dense>(pose.values.data(), 3 * vertex_count, pose.shape[2]);
  }
  model.joint_regressor = sparse(read_array(file, "J_regressor", {joint_count, vertex_count}));
  model.weights = sparse(read_array(file, "weights", {vertex_count, joint_count}));
  model.bind_pose = Points3::Zero(joint_count, 3);
  if (file.has("bind_pose")) {
    const NpyArray bind = read_array(file, "bind_pose", {joint_count, 3});
    model.bind_pose = Eigen::Map<const Points3>(bind.values.data(), joint_count, 3);
  }

  const NpyArray faces = read_array(file, "f", {-1, 3});
  model.faces.resize(faces.shape[0], 3);
  for (int64_t i = 0; i < faces.size(); ++i) {
    const int vertex = index_at(faces, i, path, "f");
    if (vertex < 0 || vertex >= vertex_count) {
      fail(path, "f names vertex " + std::to_string(vertex) + "; v_template has " +
                     std::to_string(vertex_count));
    }
    model.faces.data()[i] = vertex;
  }
  if (joint_count == kSmplxJoints) {
    try {
      close_head(model);
    } catch (const InputError& error) {
      fail(path, std::string("f: ") + error.what());
    }
  }
  validate(model, path);
  return model;
}

void write_body(const std::string& path, const BodyModel& model) {
  validate(model, path);
  const auto points = [](const Points3& p) {
    return NpyArray{{p.rows(), 3}, std::vector<double>(p.data(), p.data() + p.size())};
  };
  const int64_t vertices = model.template_vertices.rows(), joints = model.joint_count();
  const auto directions = static_cast<int64_t>(model.shape_directions.size());
  NpyArray shape{{vertices, 3, directions},
                 std::vector<double>(static_cast<size_t>(3 * vertices * directions))};
  for (int64_t k = 0; k < directions; ++k) {
    for (int64_t i = 0; i < 3 * vertices; ++i) {
      shape.values[static_cast<size_t>(i * directions + k)] = model.shape_directions[k].data()[i];
    }
  }
  NpyArray tree{{2, joints}, std::vector<double>(static_cast<size_t>(2 * joints))};
  for (int64_t j = 0; j < joints; ++j) {
    tree.values[j] = j == 0 ? 4294967295.0 : model.parents[j];
    tree.values[joints + j] = static_cast<double>(j);
  }
  NpyArray faces{{model.faces.rows(), 3},
                 std::vector<double>(model.faces.data(), model.faces.data() + model.faces.size())};
  std::vector<NpzEntry> entries = {
      {"name", "text", {}, model.name},
      {"v_template", "<f8", points(model.template_vertices), ""},
      {"shapedirs", "<f8", shape, ""},
      {"J_regressor", "<f8", dense(model.joint_regressor), ""},
      {"weights", "<f8", dense(model.weights), ""},
      {"kintree_table", "<u4", tree, ""},
      {"f", "<u4", faces, ""},
      {"bind_pose", "<f8", points(model.bind_pose), ""},
  };
  if (model.pose_directions.size() > 0) {
    NpyArray pose{{vertices, 3, model.pose_directions.cols()}, {}};
    for (Eigen::Index row = 0; row < model.pose_directions.rows(); ++row) {
      for (Eigen::Index c = 0; c < model.pose_directions.cols(); ++c)
        pose.values.push_back(model.pose_directions(row, c));
    }
    entries.push_back({"posedirs", "<f8", pose, ""});
  }
  write_npz(path, entries);
}

}  // namespace pleat::body
