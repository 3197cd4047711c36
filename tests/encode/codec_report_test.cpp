#include "encode/codec_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "body/body_file.h"
#include "garment/garment_file.h"
#include "tests/core/input_error.h"
#include "tests/encode/synthetic_body.h"

namespace pleat::encode {
namespace {

// The real layout, on a tube around the column.
garment::Garment garment_around(const garment::GarmentTopology& topology, const std::string& name) {
  garment::Garment garment;
  garment.design.name = name;
  garment.topology = topology;
  garment.panels = garment::cut_panels(topology, garment.design);
  garment.t_pose.resize(topology.vertex_count, 3);
  for (Eigen::Index m = 0; m < garment.panels.rows(); ++m) {
    const double angle = garment.panels(m, 0) / 0.2, height = 0.8 + 0.5 * garment.panels(m, 1);
    garment.t_pose.row(topology.sewn_vertex[m]) << 0.2 * std::cos(angle), height,
        0.2 * std::sin(angle);
  }
  garment.weights = spine_weights(garment.t_pose.col(1));
  return garment;
}

struct Drapes {
  TemporaryFolder folder;
  body::BodyModel model = column_body();
  DatasetInputs inputs;
  static constexpr int kFrames = 3;

  Drapes() {
    inputs.body_file = folder / "body.npz";
    body::write_body(inputs.body_file, model);
    const garment::GarmentTopology topology = garment::make_topology(600);
    for (const std::string name : {"tee", "dress"}) {
      const garment::Garment garment = garment_around(topology, name);
      inputs.garment_files.push_back(folder / (name + ".h5"));
      garment::write_garment(inputs.garment_files.back(), garment, {});
      garment::Clip clip;
      clip.design = garment.design;
      clip.motion_name = "walk";
      clip.shape = Eigen::VectorXd::Zero(2);
      const body::ShapedBody body = body::shape_body(model, clip.shape);
      for (int t = 0; t < kFrames; ++t) {
        Points3 unposed = garment.t_pose;
        for (int v = 0; v < unposed.rows(); ++v)
          unposed.row(v) +=
              Eigen::RowVector3d(0.01 * std::sin(20 * unposed(v, 1)), 0, 0.005 * (t + 1));
        clip.poses.push_back(spine_pose(0.3 * t));
        clip.positions.push_back(body::skin_linear(
            unposed, garment.weights, body::joint_transforms(model, body, clip.poses.back())));
        garment::Certificate certificate;
        certificate.is_accepted = name != "dress" || t > 0;
        if (!certificate.is_accepted) certificate.reason = "not settled";
        clip.certificates.push_back(certificate);
      }
      inputs.clip_files.push_back(folder / (name + "_walk.h5"));
      garment::write_clip(inputs.clip_files.back(), clip, name, {});
    }
  }
};

CodecReportConfig small() {
  CodecReportConfig config;
  config.texture_sizes = {64, 128};
  config.finer_vertices = 1200;
  return config;
}

TEST(CodecReport, MeasuresEveryPartOfTheRoundTrip) {
  const Drapes drapes;
  const CodecReport report = codec_report(drapes.inputs, small());
  EXPECT_FALSE(report.is_interrupted);
  ASSERT_EQ(report.designs, (std::vector<std::string>{"tee", "dress"}));
  EXPECT_EQ(report.frames, (std::vector<int64_t>{3, 2}));  // accepted ones
  ASSERT_EQ(report.variants.size(), 4u);
  for (const ErrorSummary& unposing : report.unposing_mm) EXPECT_LT(unposing.max(), 1e-9);
  for (const CodecVariant& variant : report.variants) {
    const CodecErrors all = variant.all();
    EXPECT_EQ(all.total_mm.count(), 5 * report.vertices);
    EXPECT_EQ(all.finer_mm.count(), 5 * report.finer_vertices);
    // Of a read of texels that are each off by half a step at most.
    EXPECT_GT(all.quantisation_mm.max(), 0);
    EXPECT_LE(all.quantisation_mm.max(), 1000 * variant.scale_m * 0.5 * std::sqrt(3.0) * 1.2);
    EXPECT_LE(all.total_mm.mean(), all.texture_mm.mean() + all.quantisation_mm.mean() + 1e-12);
    EXPECT_GT(all.normals_deg.mean(), 0);
    EXPECT_LT(all.normals_deg.mean(), 30);
    EXPECT_LT(all.finer_mm.mean(), 5);
  }
  const auto mean = [&](int size, Fill fill) {
    for (const CodecVariant& variant : report.variants)
      if (variant.texture_size == size && variant.fill == fill)
        return variant.all().texture_mm.mean();
    return -1.0;
  };
  EXPECT_LT(mean(128, Fill::kFitted), 0.1 * mean(128, Fill::kBarycentric));
  EXPECT_LT(mean(128, Fill::kBarycentric), mean(64, Fill::kBarycentric));
  ASSERT_EQ(report.worst_unposed.size(), 2u);  // one a clip, the worst first
  EXPECT_LE(report.worst_unposed[0].smallest_singular_value,
            report.worst_unposed[1].smallest_singular_value);
}

TEST(CodecReport, SpreadsTheFramesThatItMayTake) {
  const Drapes drapes;
  CodecReportConfig config = small();
  config.max_frames = 2;
  EXPECT_EQ(codec_report(drapes.inputs, config).frames, (std::vector<int64_t>{1, 1}));
}

TEST(CodecReport, SpeaksMarkdownAndJson) {
  const Drapes drapes;
  const CodecReport report = codec_report(drapes.inputs, small());
  const std::string text = to_markdown(report);
  EXPECT_NE(text.find("| 128 | fitted |"), std::string::npos) << text;
  EXPECT_NE(text.find("| dress | 2 |"), std::string::npos) << text;
  const nlohmann::json json = nlohmann::json::parse(to_json(report));
  EXPECT_EQ(json["variants"].size(), 4u);
  EXPECT_EQ(json["variants"][0]["designs"].size(), 2u);
  EXPECT_GT(json["variants"][0]["all"]["total_mm"]["mean"], 0.0);
}

TEST(CodecReport, RefusesDrapesOfNoneAccepted) {
  Drapes drapes;
  garment::Clip clip = garment::read_clip(drapes.inputs.clip_files[0]);
  for (garment::Certificate& certificate : clip.certificates) certificate.is_accepted = false;
  drapes.inputs.clip_files = {drapes.folder / "none.h5"};
  garment::write_clip(drapes.inputs.clip_files[0], clip, "none", {});
  EXPECT_INPUT_ERROR(codec_report(drapes.inputs, small()), "none of the frames was accepted");
}

}  // namespace
}  // namespace pleat::encode
