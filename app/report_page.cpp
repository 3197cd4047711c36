#include "app/report_page.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>

#include "app/yaml_reader.h"
#include "body/skinning.h"
#include "core/progress.h"
#include "encode/dataset.h"
#include "encode/error_summary.h"
#include "garment/clip.h"
#include "show/page/page.h"
#include "show/render.h"

namespace pleat::app {
namespace {

using show::format_number;

constexpr double kPictureHeight = 2.05;  // m that a picture shows from bottom to top
constexpr double kTextureScale = 0.08;   // m: full colour of an offset texture
constexpr double kFullError = 20;        // mm: end of the error colours

show::RenderConfig picture_config(const ReportConfig& config) {
  show::RenderConfig render;
  render.width = config.picture_width;
  render.height = config.picture_height;
  return render;
}

// A frame of the dataset with its body, and the camera from which it is shown.
class Scene {
 public:
  Scene(const encode::Dataset& dataset, int64_t row, const body::BodyModel& model,
        const ReportConfig& config)
      : faces_(dataset.garment(row).topology.faces),
        body_(show::body_mesh(encode::posed_body(dataset, row, model), model.faces)),
        config_(picture_config(config)) {
    const Vec<3> low = body_.vertices.colwise().minCoeff().transpose(),
                 high = body_.vertices.colwise().maxCoeff().transpose();
    target_ = 0.5 * (low + high);
    yaw_ = show::facing_yaw(dataset.row(row).pose.rotations.row(0).transpose());
    config_.ground_height_m = std::min(0.0, low.y());
  }

  show::Image picture(const Points3& cloth, const show::Color& color,
                      show::View view = show::View::kThreeQuarter) const {
    return shoot(show::cloth_mesh(cloth, faces_, color), view);
  }
  show::Image error_picture(const Points3& cloth, const Points3& truth) const {
    show::RenderMesh mesh = show::cloth_mesh(cloth, faces_);
    mesh.vertex_colors = show::heat_colors(encode::vertex_distances_mm(cloth, truth), kFullError);
    return shoot(mesh, show::View::kThreeQuarter);
  }

 private:
  show::Image shoot(const show::RenderMesh& cloth, show::View view) const {
    return show::render({body_, cloth}, show::view_camera(view, target_, yaw_, kPictureHeight),
                        config_);
  }

  Faces faces_;
  show::RenderMesh body_;
  show::RenderConfig config_;
  Vec<3> target_;
  double yaw_ = 0;
};

// `count` of the sampled rows, evenly spread, held-out ones where there are any; each with its
// first sample.
std::vector<std::pair<int64_t, int64_t>> rows_to_show(const encode::Dataset& dataset,
                                                      const encode::Samples& samples, int count) {
  std::map<int64_t, int64_t> held_out, all;
  for (int64_t k = 0; k < samples.count(); ++k) {
    all.emplace(samples.row(k), k);
    if (dataset.row(samples.row(k)).split != encode::kTrain) held_out.emplace(samples.row(k), k);
  }
  const auto& from = held_out.empty() ? all : held_out;
  const std::vector<std::pair<int64_t, int64_t>> rows(from.begin(), from.end());
  std::vector<std::pair<int64_t, int64_t>> chosen;
  const int shown = std::min<int>(count, static_cast<int>(rows.size()));
  for (int i = 0; i < shown; ++i) chosen.push_back(rows[(2 * i + 1) * rows.size() / (2 * shown)]);
  return chosen;
}

show::Section drapes_section(const encode::Dataset& dataset, const encode::Samples& samples,
                             const body::BodyModel& model, const StudyConfig& study,
                             const ReportInputs& inputs, Progress& progress) {
  show::PictureGrid drapes, textures;
  drapes.caption = "Frames that the model was not trained on, in the wearer's three-quarter view.";
  drapes.column_titles = {"simulated", "from its texture", "sampled", "error of the sample"};
  drapes.color_bar =
      show::ColorBar{"distance to the simulated vertex", "0", format_number(kFullError) + " mm"};
  textures.caption =
      "Their offset textures: x, y, z as red, green, blue; grey is no offset, full colour " +
      format_number(1000 * kTextureScale) + " mm.";
  textures.column_titles = {"simulated", "sampled"};
  textures.is_pixelated = true;
  for (const auto& [row, sample] : rows_to_show(dataset, samples, study.report.frames)) {
    if (is_interrupted()) break;
    const encode::DatasetRow& r = dataset.row(row);
    const garment::Clip clip = garment::read_clip(inputs.shard_of_key(r.clip_key));
    const Points3& simulated = clip.positions.at(r.frame);
    const encode::Texture truth = dataset.texture(row), drawn = samples.texture(sample);
    const Points3 reconstructed = encode::decode_posed(dataset, row, truth, model);
    const Points3 sampled = encode::decode_posed(dataset, row, drawn, model);
    const Scene scene(dataset, row, model, study.report);
    const auto mean_mm = [&](const Points3& points) {
      return format_number(encode::vertex_distances_mm(points, simulated).mean()) +
             " mm mean error";
    };
    const std::string title = dataset.contents().sequences[r.sequence].name + ", frame " +
                              std::to_string(r.frame) + ", " + dataset.garment(row).design.name;
    drapes.rows.push_back(
        {title,
         {show::picture(scene.picture(simulated, show::kSimulatedColor)),
          show::picture(scene.picture(reconstructed, show::kReconstructedColor),
                        mean_mm(reconstructed)),
          show::picture(scene.picture(sampled, show::kSampledColor), mean_mm(sampled)),
          show::picture(scene.error_picture(sampled, simulated))}});
    textures.rows.push_back(
        {title,
         {show::picture(show::texture_image(truth.values, truth.size, kTextureScale)),
          show::picture(show::texture_image(drawn.values, drawn.size, kTextureScale))}});
    progress.advance();
  }
  return {"Simulated, encoded, sampled", {drapes, textures}};
}

// The middle one of each design's frames from three sides.
show::Section designs_section(const encode::Dataset& dataset, const body::BodyModel& model,
                              const StudyConfig& study, Progress& progress) {
  show::PictureGrid grid;
  grid.caption = "Every design, decoded from its texture, in one frame of the motion.";
  grid.column_titles = {"front", "side", "back"};
  const int designs = static_cast<int>(dataset.contents().garments.size());
  for (int d = 0; d < designs && !is_interrupted(); ++d) {
    std::vector<int64_t> rows;
    for (int64_t row = 0; row < dataset.row_count(); ++row)
      if (dataset.row(row).design == d) rows.push_back(row);
    progress.advance();
    if (rows.empty()) continue;
    const int64_t row = rows[rows.size() / 2];
    const Scene scene(dataset, row, model, study.report);
    const Points3 cloth = encode::decode_posed(dataset, row, dataset.texture(row), model);
    const garment::Design& design = dataset.contents().garments[d].design;
    const std::string p = "length " + format_number(design.length) + ", sleeve " +
                          format_number(design.sleeve) + ", cleavage " +
                          format_number(design.cleavage) + (design.is_held_out ? "; held out" : "");
    show::PictureRow pictures{design.name + " (" + p + ")", {}};
    for (const show::View view : {show::View::kFront, show::View::kSide, show::View::kBack})
      pictures.pictures.push_back(show::picture(scene.picture(cloth, show::kSimulatedColor, view)));
    grid.rows.push_back(pictures);
  }
  return {"Designs", {grid}};
}

show::LineChart loss_chart(const std::string& csv) {
  show::Series loss{"training", {}, {}}, validation{"held out", {}, {}};
  std::ifstream stream(csv);
  std::string line;
  std::getline(stream, line);  // step, loss, validation_loss, seconds
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    std::string step, a, b;
    std::getline(cells, step, ',');
    std::getline(cells, a, ',');
    std::getline(cells, b, ',');
    const auto number = [](const std::string& text) {
      return text.empty() ? std::numeric_limits<double>::quiet_NaN()
                          : std::strtod(text.c_str(), nullptr);
    };
    loss.x.push_back(number(step));
    loss.y.push_back(number(a));
    if (!std::isfinite(number(b))) continue;
    validation.x.push_back(number(step));
    validation.y.push_back(number(b));
  }
  show::LineChart chart;
  chart.caption = "Loss of the diffusion model.";
  chart.x_label = "step";
  chart.y_label = "loss";
  chart.series = {loss, validation};
  chart.has_log_y = true;
  return chart;
}

show::Table error_table(const evaluate::Evaluation& evaluation) {
  show::Table table;
  table.caption =
      "Distance of sampled vertices to the simulated ones, beside two ways of guessing without a "
      "model.";
  table.columns = {{"frames", "", false},
                   {"rows", ""},
                   {"sampled, mean", "mm"},
                   {"sampled, 95th percentile", "mm"},
                   {"sampled, max", "mm"},
                   {"mean texture", "mm"},
                   {"nearest training pose", "mm"},
                   {"velocity", "mm/s"},
                   {"vertices inside the body", "%"}};
  for (const evaluate::SplitEvaluation& split : evaluation.splits)
    table.rows.push_back(
        {split.split, std::to_string(split.rows), format_number(split.error.mean_mm),
         format_number(split.error.p95_mm), format_number(split.error.max_mm),
         format_number(split.mean_texture.mean_mm),
         split.nearest_pose_rows ? format_number(split.nearest_pose.mean_mm) : "",
         split.velocity_pairs ? format_number(split.velocity_error_mm_per_s) : "",
         split.sampled.count ? format_number(100 * split.sampled.inside_share) : ""});
  return table;
}

show::LineChart frame_errors(const evaluate::Evaluation& evaluation) {
  show::LineChart chart;
  chart.caption = "Mean vertex error of each sampled frame.";
  chart.x_label = "frame";
  chart.y_label = "error (mm)";
  std::map<std::string, show::Series> series;
  for (const evaluate::RowEvaluation& row : evaluation.rows) {
    if (row.split == encode::kTrain || row.samples.empty()) continue;
    show::Series& s = series[row.sequence + ", " + row.design];
    s.x.push_back(row.frame);
    s.y.push_back(row.samples.front().error.mean_mm);
  }
  for (auto& [name, s] : series) {
    s.name = name;
    if (chart.series.size() < 6) chart.series.push_back(s);
  }
  return chart;
}

struct Drapes {
  show::Table table;
  int64_t frames = 0, accepted = 0;
  double seconds = 0;
};

Drapes drape_table(const std::vector<std::string>& shards) {
  Drapes drapes;
  drapes.table.caption = "Static drapes, one a frame, each with its certificate.";
  drapes.table.columns = {{"motion", "", false},
                          {"design", "", false},
                          {"frames", ""},
                          {"accepted", ""},
                          {"time a drape", "core-s"},
                          {"worst residual", "of the weight"},
                          {"smallest gap", "mm"},
                          {"strain, 95th percentile", "%"},
                          {"crossings with the body", ""},
                          {"crossings with itself", ""}};
  for (const std::string& path : shards) {
    const garment::Clip clip = garment::read_clip(path);
    int64_t accepted = 0, body = 0, self = 0;
    double seconds = 0, residual = 0, gap = 1, strain = 0;
    for (const garment::Certificate& c : clip.certificates) {
      accepted += c.is_accepted;
      seconds += c.seconds;
      residual = std::max(residual, c.residual);
      gap = std::min(gap, c.min_gap_m);
      strain = std::max(strain, c.strain_95);
      body += c.body_intersections;
      self += c.self_intersections;
    }
    const double frames = static_cast<double>(clip.certificates.size());
    drapes.table.rows.push_back(
        {clip.motion_name, clip.design.name, format_number(frames), format_number(accepted),
         format_number(seconds / frames), format_number(residual), format_number(1000 * gap),
         format_number(100 * strain), std::to_string(body), std::to_string(self)});
    drapes.frames += static_cast<int64_t>(clip.certificates.size());
    drapes.accepted += accepted;
    drapes.seconds += seconds;
  }
  return drapes;
}

show::Table timing_table(const ReportInputs& inputs) {
  show::Table table;
  table.caption = "Wall time of each stage, and what it made.";
  table.columns = {{"stage", "", false}, {"time", "s"}, {"result", "", false}};
  for (const auto& [stage, record] : inputs.stages)
    table.rows.push_back({stage, format_number(record.seconds), record.summary});
  return table;
}

}  // namespace

bool write_report_page(const StudyConfig& study, const ReportInputs& inputs,
                       const evaluate::Evaluation& evaluation, const Provenance& provenance,
                       const std::string& path) {
  const encode::Dataset dataset(inputs.dataset);
  const encode::Samples samples(inputs.samples, dataset);
  const body::BodyModel model = encode::read_body_of(dataset, study.body.file);
  const Drapes drapes = drape_table(inputs.shard_files);
  Progress progress("report", study.report.frames + static_cast<int64_t>(study.designs.size()),
                    "pictures");

  show::Page page;
  page.title = "Pleat: garments by physics, and a model that learned from them";
  page.subtitle = std::to_string(drapes.frames) + " static drapes of " +
                  std::to_string(study.designs.size()) + " designs in " +
                  std::to_string(study.motions.size()) + " motions";
  const evaluate::SplitEvaluation& all = evaluation.splits.back();
  page.sections.push_back(
      {"",
       {show::Headline{
           {{"drapes accepted",
             std::to_string(drapes.accepted) + " of " + std::to_string(drapes.frames)},
            {"core-seconds a drape",
             format_number(drapes.seconds / std::max<int64_t>(1, drapes.frames))},
            {"mean error of samples", format_number(all.error.mean_mm) + " mm"},
            {"of the mean texture", format_number(all.mean_texture.mean_mm) + " mm"}}}}});
  page.sections.push_back(drapes_section(dataset, samples, model, study, inputs, progress));
  page.sections.push_back(designs_section(dataset, model, study, progress));
  page.sections.push_back(
      {"Learning",
       {loss_chart(inputs.loss_csv), frame_errors(evaluation), error_table(evaluation)}});
  page.sections.push_back({"Simulation", {drapes.table}});
  page.sections.push_back(
      {"Run", {timing_table(inputs), show::Details{"Configuration", to_yaml(study)}}});
  page.footer = show::provenance_facts(provenance);
  if (is_interrupted()) return false;
  show::write_page(path, page);
  return true;
}

}  // namespace pleat::app
