#include "show/export.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/mesh_file.h"

namespace pleat::show {
namespace {

class Export : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("pleat_export_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    // Two triangles sewn along an edge: 4 vertices, 6 UVs.
    mesh_.vertices.resize(4, 3);
    mesh_.vertices << 0, 0, 0, 1, 0, 0.25, 1, 1, 0, 0, 1, 0.5;
    mesh_.faces.resize(2, 3);
    mesh_.faces << 0, 1, 2, 0, 2, 3;
    mesh_.uv.resize(6, 2);
    mesh_.uv << 0, 0, 0.25, 0, 0.25, 0.5, 0.5, 0.5, 0.75, 1, 0.5, 1;
    mesh_.uv_faces.resize(2, 3);
    mesh_.uv_faces << 0, 1, 2, 3, 4, 5;
    for (int i = 0; i < 3; ++i) {
      Points3 frame = mesh_.vertices;
      frame.array() += 0.125 * i;
      frame(2, 2) -= 0.5 * i;
      frames_.push_back(frame);
    }
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return folder_ / name; }
  std::string bytes(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }

  std::filesystem::path folder_;
  TriangleMesh mesh_;
  std::vector<Points3> frames_;
};

template <typename T>
T read_at(const std::string& bytes, size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

TEST_F(Export, ObjSequenceReadsBackFrameByFrame) {
  const std::vector<std::string> paths = write_obj_sequence(path("walk"), "tee", mesh_, frames_);
  ASSERT_EQ(paths.size(), 3U);
  EXPECT_EQ(std::filesystem::path(paths[2]).filename(), "tee_0002.obj");
  for (int i = 0; i < 3; ++i) {
    const TriangleMesh read = read_mesh(paths[i]);
    ASSERT_EQ(read.vertices.rows(), 4);
    ASSERT_EQ(read.faces.rows(), 2);
    for (int f = 0; f < 2; ++f) {
      for (int k = 0; k < 3; ++k) {  // by corner: a reader may number vertices its own way
        EXPECT_LT((read.vertices.row(read.faces(f, k)) - frames_[i].row(mesh_.faces(f, k))).norm(),
                  1e-6);
        EXPECT_LT((read.uv.row(read.uv_faces(f, k)) - mesh_.uv.row(mesh_.uv_faces(f, k))).norm(),
                  1e-6);
      }
    }
  }
}

TEST_F(Export, Pc2HasTheHeaderAndSizeOfTheFormat) {
  write_pc2(path("tee.pc2"), frames_, 7);
  const std::string file = bytes("tee.pc2");
  ASSERT_EQ(file.size(), 32U + 3 * 4 * 3 * 4);
  EXPECT_EQ(file.substr(0, 12), std::string("POINTCACHE2\0", 12));
  EXPECT_EQ(read_at<int32_t>(file, 12), 1);  // version
  EXPECT_EQ(read_at<int32_t>(file, 16), 4);  // points
  EXPECT_EQ(read_at<float>(file, 20), 7);    // start frame
  EXPECT_EQ(read_at<float>(file, 24), 1);    // sample rate
  EXPECT_EQ(read_at<int32_t>(file, 28), 3);  // samples
  EXPECT_EQ(read_at<float>(file, 32 + 48 + 4 * 5), float(frames_[1](1, 2)));
}

TEST_F(Export, Pc2ReadsBack) {
  write_pc2(path("tee.pc2"), frames_, 7);
  const PointCache cache = read_pc2(path("tee.pc2"));
  EXPECT_EQ(cache.start_frame, 7);
  ASSERT_EQ(cache.frames.size(), 3U);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(cache.frames[i], frames_[i]);  // eighths are exact in float
}

TEST_F(Export, Pc2ReaderRefusesBrokenFiles) {
  write_pc2(path("tee.pc2"), frames_);
  const std::string good = bytes("tee.pc2");
  const auto refuses = [&](const std::string& content) {
    write("bad.pc2", content);
    EXPECT_THROW(read_pc2(path("bad.pc2")), InputError) << content.size() << " bytes";
  };
  refuses("");
  refuses(good.substr(0, 31));
  refuses(good.substr(0, good.size() - 4));
  refuses(good + "more");
  refuses("POINTCACHE3" + good.substr(11));
  std::string huge = good;
  const int32_t many = std::numeric_limits<int32_t>::max();
  std::memcpy(&huge[16], &many, 4);
  std::memcpy(&huge[28], &many, 4);
  refuses(huge);
  std::string negative = good;
  const int32_t minus = -4;
  std::memcpy(&negative[16], &minus, 4);
  refuses(negative);
  std::string nan = good;
  const float not_a_number = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(&nan[40], &not_a_number, 4);
  refuses(nan);
  EXPECT_THROW(read_pc2(path("absent.pc2")), InputError);
}

TEST_F(Export, GlbReadsBackAsTheFirstFrame) {
  write_glb(path("tee.glb"), mesh_, frames_, 30);
  const TriangleMesh read = read_mesh(path("tee.glb"));
  ASSERT_EQ(read.faces.rows(), 2);
  for (int f = 0; f < 2; ++f) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT((read.vertices.row(read.faces(f, k)) - frames_[0].row(mesh_.faces(f, k))).norm(),
                1e-6);
      EXPECT_LT((read.uv.row(read.uv_faces(f, k)) - mesh_.uv.row(mesh_.uv_faces(f, k))).norm(),
                1e-6);
    }
  }
}

// Plays the file as a viewer does: base + sum of weights x targets at each key.
TEST_F(Export, GlbAnimationPlaysEveryFrame) {
  write_glb(path("tee.glb"), mesh_, frames_, 25);
  const std::string file = bytes("tee.glb");
  ASSERT_EQ(file.substr(0, 4), "glTF");
  EXPECT_EQ(read_at<uint32_t>(file, 4), 2U);
  EXPECT_EQ(read_at<uint32_t>(file, 8), file.size());
  const uint32_t json_size = read_at<uint32_t>(file, 12);
  EXPECT_EQ(json_size % 4, 0U);
  const nlohmann::json gltf = nlohmann::json::parse(file.substr(20, json_size));
  const size_t binary = 20 + json_size + 8;
  EXPECT_EQ(read_at<uint32_t>(file, binary - 8), file.size() - binary);
  EXPECT_EQ(gltf["buffers"][0]["byteLength"], file.size() - binary);

  const auto floats = [&](int accessor) {
    const nlohmann::json& a = gltf["accessors"][accessor];
    const nlohmann::json& view = gltf["bufferViews"][a["bufferView"].get<int>()];
    EXPECT_EQ(a["componentType"], 5126);
    std::vector<float> values(view["byteLength"].get<size_t>() / 4);
    std::memcpy(values.data(), file.data() + binary + view["byteOffset"].get<size_t>(),
                4 * values.size());
    return values;
  };
  const nlohmann::json& primitive = gltf["meshes"][0]["primitives"][0];
  const std::vector<float> base = floats(primitive["attributes"]["POSITION"]);
  ASSERT_EQ(base.size(), 3U * 6);  // seam vertices twice
  const nlohmann::json& sampler = gltf["animations"][0]["samplers"][0];
  const std::vector<float> times = floats(sampler["input"]), weights = floats(sampler["output"]);
  ASSERT_EQ(times.size(), 3U);
  ASSERT_EQ(weights.size(), 3U * 2);
  EXPECT_FLOAT_EQ(times[2], 2 / 25.0F);
  for (int t = 0; t < 3; ++t) {
    std::vector<float> shown = base;
    for (int k = 0; k < 2; ++k) {
      const std::vector<float> target = floats(primitive["targets"][k]["POSITION"]);
      for (size_t i = 0; i < shown.size(); ++i) shown[i] += weights[2 * t + k] * target[i];
    }
    for (int corner = 0; corner < 6; ++corner) {  // glTF vertices are numbered by first use here
      for (int c = 0; c < 3; ++c) {
        EXPECT_FLOAT_EQ(shown[3 * corner + c],
                        float(frames_[t](mesh_.faces(corner / 3, corner % 3), c)));
      }
    }
  }
}

TEST_F(Export, RefusesFramesThatDoNotFit) {
  EXPECT_THROW(write_pc2(path("a.pc2"), {}), InputError);
  frames_[1].conservativeResize(3, 3);
  EXPECT_THROW(write_pc2(path("a.pc2"), frames_), InputError);
  EXPECT_THROW(write_obj_sequence(path("a"), "a", mesh_, frames_), InputError);
  EXPECT_THROW(write_glb(path("a.glb"), mesh_, frames_, 30), InputError);
  frames_[1] = frames_[0];
  frames_[1](0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(write_pc2(path("a.pc2"), frames_), InputError);
  EXPECT_THROW(write_glb(path("a.glb"), mesh_, {frames_[0]}, 0), InputError);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));  // nothing half written
}

}  // namespace
}  // namespace pleat::show
