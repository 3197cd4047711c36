#include "body/body_file.h"

#include <gtest/gtest.h>

#include <limits>

#include "body/skinning.h"
#include "tests/body/archive.h"
#include "tests/body/synthetic_body.h"
#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat::body {
namespace {

BodyModel full_body() {
  BodyModel model = box_body();
  add_pose_directions(model);
  bind_in_a_pose(model);
  return model;
}

// A loose tetrahedron that hangs on the left eye's joint.
void add_eyeball(BodyModel& model) {
  const auto first = static_cast<int>(model.template_vertices.rows());
  const auto extend = [&](Points3& points, const Vec<3>& at, double size) {
    points.conservativeResize(first + 4, 3);
    for (int k = 0; k < 4; ++k) {
      points.row(first + k) = at;
      if (k > 0) points(first + k, k - 1) += size;
    }
  };
  extend(model.template_vertices, {0, 0.7, 0.1}, 0.02);
  for (Points3& direction : model.shape_directions) extend(direction, {0, 0, 0}, 0);
  model.weights.conservativeResize(first + 4, model.weights.cols());
  for (int k = 0; k < 4; ++k) model.weights.coeffRef(first + k, 23) = 1;
  Eigen::SparseMatrix<double, Eigen::RowMajor> regressor = model.joint_regressor;
  regressor.conservativeResize(model.joint_count(), first + 4);
  model.joint_regressor = regressor;
  model.faces.conservativeResize(model.faces.rows() + 4, 3);
  Faces ball(4, 3);
  ball << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  model.faces.bottomRows(4) = ball.array() + first;
}

TEST(BodyFile, GivesBackWhatWasWritten) {
  const Scratch scratch;
  const BodyModel model = full_body();
  write_body(scratch.path("body.npz"), model);
  const BodyModel read = read_body(scratch.path("body.npz"));
  EXPECT_EQ(read.name, "box");
  EXPECT_EQ(read.template_vertices, model.template_vertices);
  ASSERT_EQ(read.shape_directions.size(), model.shape_directions.size());
  for (size_t k = 0; k < read.shape_directions.size(); ++k) {
    EXPECT_EQ(read.shape_directions[k], model.shape_directions[k]);
  }
  EXPECT_EQ(read.pose_directions, model.pose_directions);
  EXPECT_EQ(Eigen::MatrixXd(read.joint_regressor), Eigen::MatrixXd(model.joint_regressor));
  EXPECT_EQ(Eigen::MatrixXd(read.weights), Eigen::MatrixXd(model.weights));
  EXPECT_EQ(read.parents, model.parents);
  EXPECT_EQ(read.bind_pose, model.bind_pose);
  EXPECT_EQ(read.faces, model.faces);
}

// As SMPL comes: no bind_pose, no name, root parent 4294967295, posedirs absent or empty, arrays
// that Pleat has no use for.
TEST(BodyFile, ReadsSmplWithoutPoseDirections) {
  const Scratch scratch;
  const std::string path = scratch.path("smpl.npz");
  write_body(path, box_body());
  std::vector<NpzEntry> entries = entries_of(path);
  EXPECT_EQ(array_of(entries, "kintree_table").values[0], 4294967295.0);
  remove_entry(entries, "bind_pose");
  remove_entry(entries, "name");
  for (const bool has_empty : {false, true}) {
    if (has_empty) entries.push_back({"posedirs", "<f8", {{0}, {}}, ""});
    write_npz(path, entries);
    add_raw(path, "bs_style", "|S3", "lbs");
    const BodyModel model = read_body(path);
    EXPECT_EQ(model.name, "smpl");
    EXPECT_EQ(model.pose_directions.size(), 0);
    EXPECT_TRUE(model.bind_pose.isZero());
    EXPECT_EQ(model.parents[0], -1);
  }
}

TEST(BodyFile, KeepsTenOfManyShapeDirections) {
  const Scratch scratch;
  const std::string path = scratch.path("body.npz");
  write_body(path, box_body());
  std::vector<NpzEntry> entries = entries_of(path);
  const int64_t vertices = array_of(entries, "v_template").shape[0];
  for (const auto& [stored, kept] : {std::pair<int64_t, size_t>{16, 16}, {300, 10}}) {
    NpyArray shape{{vertices, 3, stored},
                   std::vector<double>(static_cast<size_t>(3 * vertices * stored))};
    for (size_t i = 0; i < shape.values.size(); ++i)
      shape.values[i] = static_cast<double>(i % stored);
    array_of(entries, "shapedirs") = shape;
    write_npz(path, entries);
    const BodyModel model = read_body(path);
    ASSERT_EQ(model.shape_directions.size(), kept);
    EXPECT_TRUE((model.shape_directions[7].array() == 7).all());
  }
}

// SMPL-X: 55 joints, eyeballs apart from the skin, an open mouth, pickled arrays beside the plain
// ones.
TEST(BodyFile, ClosesTheHeadOfSmplx) {
  const Scratch scratch;
  const std::string path = scratch.path("smplx.npz");
  BodyModel whole = box_body(55);
  const int mouth = 100, foot = 300;  // two faces far apart
  for (int v : {whole.faces(mouth, 0), whole.faces(mouth, 1), whole.faces(mouth, 2)}) {
    for (SkinWeights::InnerIterator it(whole.weights, v); it; ++it) it.valueRef() = 0;
    whole.weights.coeffRef(v, 15) = 0.4;
    whole.weights.coeffRef(v, 22) = 0.6;
    ASSERT_FALSE((whole.faces.row(foot).array() == v).any());
  }
  const Eigen::Index skin_faces = whole.faces.rows(),
                     skin_vertices = whole.template_vertices.rows();
  add_eyeball(whole);
  write_body(path, whole);
  std::vector<NpzEntry> entries = entries_of(path);
  NpyArray& faces = array_of(entries, "f");
  const std::vector<double> all = faces.values;
  faces.values.erase(faces.values.begin() + 3 * mouth, faces.values.begin() + 3 * mouth + 3);
  --faces.shape[0];
  write_npz(path, entries);
  add_raw(path, "joint2num", "|O", "\x80\x03}q.");
  const BodyModel model = read_body(path);
  EXPECT_EQ(model.faces.rows(), skin_faces);
  EXPECT_LT(model.faces.maxCoeff(), skin_vertices);
  EXPECT_EQ(model.template_vertices.rows(), skin_vertices + 4);  // vertices keep their numbers
  EXPECT_EQ(model.joint_count(), 55);

  // The same hole in a foot is a fault.
  faces.values = all;
  faces.values.erase(faces.values.begin() + 3 * foot, faces.values.begin() + 3 * foot + 3);
  write_npz(path, entries);
  EXPECT_INPUT_ERROR(read_body(path), "smplx.npz", "f is not a closed surface");
}

TEST(BodyFile, RefusesAHole) {
  const Scratch scratch;
  const std::string path = scratch.path("torn.npz");
  write_body(path, box_body());
  std::vector<NpzEntry> entries = entries_of(path);
  NpyArray& faces = array_of(entries, "f");
  faces.values.resize(faces.values.size() - 3);
  --faces.shape[0];
  write_npz(path, entries);
  EXPECT_INPUT_ERROR(read_body(path), "torn.npz", "f is not a closed surface",
                     "3 edges with one face");
}

TEST(BodyFile, NamesFileAndArrayAtFault) {
  const Scratch scratch;
  const std::string good = scratch.path("good.npz"), bad = scratch.path("bad.npz");
  write_body(good, box_body());
  for (const char* key :
       {"v_template", "shapedirs", "J_regressor", "weights", "kintree_table", "f"}) {
    std::vector<NpzEntry> entries = entries_of(good);
    remove_entry(entries, key);
    write_npz(bad, entries);
    EXPECT_INPUT_ERROR(read_body(bad), "bad.npz", key);

    entries = entries_of(good);
    NpyArray& array = array_of(entries, key);
    array.values[array.values.size() / 2] = std::numeric_limits<double>::quiet_NaN();
    write_npz(bad, entries);
    EXPECT_INPUT_ERROR(read_body(bad), "bad.npz", key);

    entries = entries_of(good);
    NpyArray& flat = array_of(entries, key);
    flat.shape = {flat.size()};
    write_npz(bad, entries);
    EXPECT_INPUT_ERROR(read_body(bad), "bad.npz", key, "expected");
  }
  std::vector<NpzEntry> entries = entries_of(good);
  array_of(entries, "f").values[4] = 1e9;
  write_npz(bad, entries);
  EXPECT_INPUT_ERROR(read_body(bad), "bad.npz", "f names vertex 1000000000");
  entries = entries_of(good);
  array_of(entries, "kintree_table").values[5] = 0.5;
  write_npz(bad, entries);
  EXPECT_INPUT_ERROR(read_body(bad), "bad.npz", "kintree_table");
}

TEST(BodyFile, RefusesPicklesAndTruncatedFiles) {
  const Scratch scratch;
  EXPECT_INPUT_ERROR(read_body(scratch.path("SMPL_NEUTRAL.pkl")), "SMPL_NEUTRAL.pkl", "pickle",
                     "numpy", "scipy", "chumpy", "np.savez");
  const std::string path = scratch.path("body.npz");
  write_body(path, box_body());
  const std::string bytes = read_bytes(path);
  write_bytes(path, bytes.substr(0, bytes.size() / 2));
  EXPECT_INPUT_ERROR(read_body(path), "body.npz");
  EXPECT_INPUT_ERROR(read_body(scratch.path("none.npz")), "none.npz");
  // A J_regressor left as a scipy matrix is an object array.
  write_body(path, box_body());
  std::vector<NpzEntry> entries = entries_of(path);
  remove_entry(entries, "J_regressor");
  write_npz(path, entries);
  add_raw(path, "J_regressor", "|O", "\x80\x03cscipy");
  EXPECT_INPUT_ERROR(read_body(path), "body.npz", "J_regressor");
}

}  // namespace
}  // namespace pleat::body
