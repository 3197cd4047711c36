#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/hdf5_file.h"
#include "core/random.h"
#include "garment/clip.h"
#include "garment/garment_file.h"
#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat::garment {
namespace {

Garment example() {
  Garment garment;
  garment.design = {"tee", 0.3, 0.25, 0.2, true};
  garment.topology = make_topology(500);
  garment.panels = cut_panels(garment.topology, garment.design);
  const int count = garment.topology.vertex_count;
  garment.t_pose.resize(count, 3);
  RandomStream random(0, "example");
  for (Eigen::Index i = 0; i < garment.t_pose.size(); ++i)
    garment.t_pose.data()[i] = random.normal();
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(count, 24);
  weights.col(3).setConstant(0.25);
  weights.col(9).setConstant(0.75);
  garment.weights = weights.sparseView();
  return garment;
}

Clip example_clip() {
  Clip clip;
  clip.design = {"tee", 0.3, 0.25, 0.2, true};
  clip.motion_name = "walk";
  clip.frame_rate_hz = 15;
  clip.fabric.friction = 0.35;
  clip.fabric.membrane = MembraneModel::kNeoHookean;
  clip.shape = Eigen::VectorXd::LinSpaced(10, -1, 1);
  RandomStream random(0, "clip");
  for (int t = 0; t < 3; ++t) {
    body::Pose pose;
    for (Eigen::Index i = 0; i < pose.rotations.size(); ++i)
      pose.rotations.data()[i] = random.normal();
    pose.translation << t, 1, 2;
    clip.poses.push_back(pose);
    Points3 x(20, 3);
    for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] = random.normal();
    clip.positions.push_back(x);
    Certificate c;
    c.residual = 1e-4 * t;
    c.min_gap_m = -0.001;
    c.self_intersections = t;
    c.iterations = 12;
    c.is_accepted = t != 1;
    c.reason = t == 1 ? "too much strain" : "";
    clip.certificates.push_back(c);
  }
  return clip;
}

TEST(GarmentFile, GivesBackWhatWasWritten) {
  const Scratch scratch;
  const Garment garment = example();
  write_garment(scratch.path("tee.h5"), garment, {"settle", "a: 1\n", 7, {}});
  const Garment again = read_garment(scratch.path("tee.h5"));
  EXPECT_EQ(again.design.name, "tee");
  EXPECT_EQ(again.design.sleeve, 0.25);
  EXPECT_TRUE(again.design.is_held_out);
  EXPECT_EQ(again.topology.faces, garment.topology.faces);
  EXPECT_EQ(again.topology.panel_faces, garment.topology.panel_faces);
  EXPECT_EQ(again.topology.sewn_vertex, garment.topology.sewn_vertex);
  EXPECT_EQ(again.topology.panel_of_vertex, garment.topology.panel_of_vertex);
  EXPECT_EQ(again.topology.uv, garment.topology.uv);
  EXPECT_EQ(again.topology.vertex_count, garment.topology.vertex_count);
  EXPECT_EQ(again.panels, garment.panels);
  EXPECT_EQ(again.t_pose, garment.t_pose);
  EXPECT_EQ(Eigen::MatrixXd(again.weights), Eigen::MatrixXd(garment.weights));
  // And is cut to another design as the topology that it came from.
  const Design other{"", 1, 0, 1, false};
  EXPECT_EQ(cut_panels(again.topology, other), cut_panels(garment.topology, other));
}

TEST(GarmentFile, RefusesHostileFiles) {
  const Scratch scratch;
  const std::string path = scratch.path("tee.h5");
  const auto refused = [&](const auto& spoil, std::initializer_list<std::string> parts) {
    Garment garment = example();
    spoil(garment);
    write_garment(path, garment, {});
    expect_input_error([&] { read_garment(path); }, parts, "read_garment", __FILE__, __LINE__);
  };
  refused([](Garment& g) { g.topology.faces(3, 1) = 1 << 30; }, {"tee.h5", "faces"});
  refused([](Garment& g) { g.topology.panel_faces(0, 0) = -1; }, {"tee.h5", "panel_faces"});
  refused([](Garment& g) { std::swap(g.topology.faces(3, 1), g.topology.faces(3, 2)); },
          {"faces", "disagrees"});
  refused([](Garment& g) { g.topology.sewn_vertex[5] = g.topology.vertex_count; }, {"sewn_vertex"});
  refused([](Garment& g) { g.topology.uv(0, 0) = 1.5; }, {"uv"});
  refused([](Garment& g) { g.panels(2, 1) = std::nan(""); }, {"panels", "finite"});
  refused([](Garment& g) { g.panels.conservativeResize(10, 2); }, {"panels", "shape"});
  refused([](Garment& g) { g.t_pose(0, 2) = std::numeric_limits<double>::infinity(); },
          {"t_pose", "finite"});
  refused([](Garment& g) { g.weights *= 0.5; }, {"weights", "sum to 1"});
  refused([](Garment& g) { g.design.sleeve = 3; }, {"tee.h5", "sleeve"});
  refused([](Garment& g) { g.topology.panel_of_vertex[0] = static_cast<Panel>(9); },
          {"panel_of_vertex"});
  EXPECT_INPUT_ERROR(read_garment(scratch.path("absent.h5")), "absent.h5");
  write_garment(path, example(), {});
  const std::string bytes = read_bytes(path);
  write_bytes(path, bytes.substr(0, bytes.size() / 2));
  EXPECT_INPUT_ERROR(read_garment(path), "tee.h5");
  write_clip(path, example_clip(), "key", {});
  EXPECT_INPUT_ERROR(read_garment(path), "tee.h5");  // a clip is no garment
}

TEST(ClipFile, GivesBackWhatWasWritten) {
  const Scratch scratch;
  const std::string path = scratch.path("clip.h5");
  const Clip clip = example_clip();
  write_clip(path, clip, "abc123", {"simulate", "", 1, {}});
  EXPECT_EQ(clip_key(path), "abc123");
  const Clip again = read_clip(path);
  EXPECT_EQ(again.design.name, "tee");
  EXPECT_EQ(again.motion_name, "walk");
  EXPECT_EQ(again.frame_rate_hz, 15);
  EXPECT_EQ(to_text(again.fabric), to_text(clip.fabric));
  EXPECT_EQ(again.shape, clip.shape);
  ASSERT_EQ(again.positions.size(), 3u);
  ASSERT_EQ(again.poses.size(), 3u);
  ASSERT_EQ(again.certificates.size(), 3u);
  for (size_t t = 0; t < 3; ++t) {
    EXPECT_EQ(again.poses[t].rotations, clip.poses[t].rotations);
    EXPECT_EQ(again.poses[t].translation, clip.poses[t].translation);
    EXPECT_LT((again.positions[t] - clip.positions[t]).cwiseAbs().maxCoeff(), 4e-7);  // float
    EXPECT_EQ(again.certificates[t].residual, clip.certificates[t].residual);
    EXPECT_EQ(again.certificates[t].min_gap_m, clip.certificates[t].min_gap_m);
    EXPECT_EQ(again.certificates[t].self_intersections, clip.certificates[t].self_intersections);
    EXPECT_EQ(again.certificates[t].iterations, 12);
    EXPECT_EQ(again.certificates[t].is_accepted, clip.certificates[t].is_accepted);
    EXPECT_EQ(again.certificates[t].reason, clip.certificates[t].reason);
  }
}

TEST(ClipFile, PartsJoinToTheWholeClip) {
  const Scratch scratch;
  Clip whole = example_clip();
  const Eigen::Index vertices = whole.positions[0].rows();
  const auto state_of = [&](int frame) {
    return ClipState{frame, frame == 3, Points3::Random(vertices, 3),
                     Eigen::VectorXi::LinSpaced(vertices, -1, 7), Points3::Random(vertices, 3)};
  };
  const ClipState second = state_of(2), last = state_of(3);
  Clip a = whole, b = whole;
  a.poses.resize(2);
  a.positions.resize(2);
  a.certificates.resize(2);
  a.states = {second};
  b.first_frame = 2;
  b.positions.erase(b.positions.begin(), b.positions.begin() + 2);
  b.poses.erase(b.poses.begin(), b.poses.begin() + 2);
  b.certificates.erase(b.certificates.begin(), b.certificates.begin() + 2);
  b.states = {last};
  whole.states = {second};
  write_clip(scratch.path("a.h5"), a, "key", {"simulate", "", 1, {}});
  write_clip(scratch.path("b.h5"), b, "key", {"simulate", "", 1, {}});
  write_clip(scratch.path("whole.h5"), whole, "key", {"simulate", "", 1, {}});
  join_clips({scratch.path("a.h5"), scratch.path("b.h5")}, scratch.path("joined.h5"));
  EXPECT_EQ(read_bytes(scratch.path("joined.h5")), read_bytes(scratch.path("whole.h5")));
  const Clip again = read_clip(scratch.path("joined.h5"));
  ASSERT_EQ(again.states.size(), 1u);
  EXPECT_EQ(again.states[0].frame, 2);
  EXPECT_FALSE(again.states[0].is_sound);
  EXPECT_EQ(again.states[0].positions, second.positions);
  EXPECT_EQ(again.states[0].anchor_faces, second.anchor_faces);
  EXPECT_EQ(again.states[0].anchor_barycentrics, second.anchor_barycentrics);
  const Clip head = read_clip_head(scratch.path("joined.h5"));
  EXPECT_TRUE(head.positions.empty());
  EXPECT_EQ(head.certificates.size(), 3u);
  EXPECT_EQ(head.frame_sha256, again.frame_sha256);
  EXPECT_INPUT_ERROR(join_clips({scratch.path("b.h5"), scratch.path("a.h5")}, scratch.path("x.h5")),
                     "a.h5", "first_frame");
}

// The hash tells frames apart by what they say, not by when they were made.
TEST(ClipFile, FramesHashTheirContentWithoutTheirSeconds) {
  Clip clip = example_clip();
  const std::string before = frame_hash(clip, 1);
  clip.certificates[1].seconds += 1;
  EXPECT_EQ(frame_hash(clip, 1), before);
  Clip other = clip;
  other.certificates[1].iterations += 1;
  EXPECT_NE(frame_hash(other, 1), before);
  other = clip;
  other.positions[1](2, 1) += 1e-6;
  EXPECT_NE(frame_hash(other, 1), before);
  other = clip;
  other.poses[1].translation[0] += 1e-12;
  EXPECT_NE(frame_hash(other, 1), before);
  EXPECT_NE(content_hash("a", {before}), content_hash("b", {before}));
}

TEST(ClipFile, KeepsAMeasuredFabric) {
  const Scratch scratch;
  const std::string path = scratch.path("clip.h5");
  Clip clip = example_clip();
  FabricTables tables;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 4; ++c) tables.stretching[r][c] = 1 + 4 * r + c;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 5; ++c) tables.bending[r][c] = 1e-6 * (5 * r + c);
  clip.fabric.tables = tables;
  clip.fabric.density_kg_per_m2 = 0.3;
  write_clip(path, clip, "key", {});
  EXPECT_EQ(to_text(read_clip(path).fabric), to_text(clip.fabric));
}

TEST(ClipFile, RefusesHostileFiles) {
  const Scratch scratch;
  const std::string path = scratch.path("clip.h5");
  const auto refused = [&](const auto& spoil, std::initializer_list<std::string> parts) {
    Clip clip = example_clip();
    spoil(clip);
    write_clip(path, clip, "key", {});
    expect_input_error([&] { read_clip(path); }, parts, "read_clip", __FILE__, __LINE__);
  };
  refused([](Clip& c) { c.positions[1](4, 2) = std::nan(""); },
          {"clip.h5", "positions", "frame 1"});
  refused([](Clip& c) { c.poses[2].rotations(0, 0) = std::nan(""); }, {"rotations", "frame 2"});
  refused([](Clip& c) { c.shape[0] = std::nan(""); }, {"shape"});
  refused([](Clip& c) { c.frame_rate_hz = 0; }, {"frame_rate_hz"});
  refused([](Clip& c) { c.certificates[0].iterations = -1; }, {"certificates"});
  refused([](Clip& c) { c.fabric.friction = -1; }, {"clip.h5", "friction"});
  refused([](Clip& c) { c.fabric.bending_N_m = std::nan(""); }, {"bending_N_m"});
  refused([](Clip& c) { c.fabric.tables = FabricTables{}; }, {"clip.h5", "stretching[0][0]"});
  write_garment(path, example(), {});
  EXPECT_INPUT_ERROR(read_clip(path), "clip.h5");
  EXPECT_INPUT_ERROR(clip_key(path), "clip.h5");
  EXPECT_THROW(write_clip(scratch.path("none.h5"), Clip{}, "key", {}), std::invalid_argument);
  EXPECT_EQ(scratch.files(), std::vector<std::string>{"clip.h5"});
}

}  // namespace
}  // namespace pleat::garment
