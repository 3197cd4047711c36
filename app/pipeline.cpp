#include "app/pipeline.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <tuple>

#include "app/report_page.h"
#include "app/stage_log.h"
#include "app/yaml_reader.h"
#include "campaign/run_tasks.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/provenance.h"
#include "encode/make_dataset.h"
#include "evaluate/report.h"

namespace pleat::app {
namespace {

std::string format(const char* pattern, double a, double b = 0) {
  char text[160];
  std::snprintf(text, sizeof text, pattern, a, b);
  return text;
}

std::string campaign_summary(const campaign::RunReport& report) {
  std::string text =
      std::to_string(report.accepted) + " of " + std::to_string(report.frames) + " drapes accepted";
  for (const auto& [reason, count] : report.rejected)
    text += "; " + std::to_string(count) + " " + reason;
  if (report.frames > 0)
    text += format("; %.2f core-s a drape", report.drape_seconds / report.frames);
  return text;
}

// So that it can be read from anywhere.
StudyConfig with_absolute_paths(StudyConfig study) {
  const auto make_absolute = [](std::string& path) {
    if (!path.empty()) path = std::filesystem::absolute(path).lexically_normal().string();
  };
  make_absolute(study.output);
  make_absolute(study.body.file);
  make_absolute(study.fabric.file);
  for (MotionEntry& motion : study.motions) make_absolute(motion.file);
  return study;
}

// One study being run: its folder, its keys, what is done.
class Pipeline {
 public:
  Pipeline(const StudyConfig& study, const campaign::TaskSlice& slice, const LearnStages& learning)
      : study_(study),
        learning_(learning),
        campaign_(campaign_of(study)),
        manifest_(campaign::plan(campaign_)),
        options_(run_options_of(study)),
        log_(study.output) {
    options_.slice = slice;
    std::string chains;
    for (const campaign::Chain& chain : manifest_.chains) chains += chain.key + "\n";
    for (const std::string& key : manifest_.garment_keys) chains += key + "\n";
    campaign_key_ = sha256(chains);
    encode_key_ = sha256(campaign_key_ + encode_settings(study));
    train_key_ = sha256(encode_key_ + train_settings(study));
    sample_key_ = sha256(train_key_ + sample_settings(study));
    evaluate_key_ = sha256(sample_key_ + evaluate_settings(study));
    report_key_ = sha256(evaluate_key_ + report_settings(study));
    if (!log_.find("dress", campaign_key_, in_output("garments")))
      campaign::check_inputs(campaign_);  // before anything is written
    write_plan(study, campaign_, manifest_);
  }

  bool run(Stage last) {
    const std::vector<std::function<bool()>> stages = {
        [&] { return dress(); }, [&] { return simulate(); }, [&] { return encode(); },
        [&] { return train(); }, [&] { return sample(); },   [&] { return evaluate(); },
        [&] { return report(); }};
    for (int s = 0; s <= static_cast<int>(last); ++s)
      if (!stages[s]() || is_interrupted()) return false;
    return true;
  }

 private:
  // Does `work` unless it was done for the same inputs. `work` returns a line for people, or
  // nothing where interrupted.
  bool once(const std::string& stage, const std::string& key, const std::string& file,
            const std::function<std::optional<std::string>()>& work) {
    if (const auto record = log_.find(stage, key, file)) {
      spdlog::info("{}: up to date ({})", stage, record->summary);
      return true;
    }
    const auto start = std::chrono::steady_clock::now();
    const std::optional<std::string> summary = work();
    if (!summary) return false;
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    log_.write(stage, {key, seconds, *summary});
    spdlog::info("{}: {} in {}", stage, *summary, duration_text(seconds));
    return true;
  }

  // The record of dressing or simulating, which look at every file themselves: a stage that made
  // nothing now took what it took before.
  void record(const std::string& stage, const std::string& folder, bool is_new,
              const std::string& summary, std::chrono::steady_clock::time_point start) {
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const auto before = log_.find(stage, campaign_key_, in_output(folder));
    if (options_.slice.count == 1)
      log_.write(stage, {campaign_key_, before && !is_new ? before->seconds : seconds, summary});
    spdlog::info("{}: {}{}", stage, is_new ? "" : "up to date: ", summary);
  }

  bool dress() {
    const auto start = std::chrono::steady_clock::now();
    const auto report = campaign::settle_garments(campaign_, manifest_, options_);
    if (report.is_interrupted) return false;
    if (report.failed > 0)
      spdlog::warn("{} designs do not settle on the mean body; {} says why", report.failed,
                   in_output("failures"));
    if (report.made + report.kept == 0)
      throw std::runtime_error("no design settles on the mean body");
    record("dress", "garments", report.made > 0,
           std::to_string(report.made + report.kept) + " designs settled on the mean body", start);
    return true;
  }

  bool simulate() {
    const auto start = std::chrono::steady_clock::now();
    const auto report = campaign::run_chains(campaign_, manifest_, options_);
    if (report.is_interrupted) return false;
    if (report.failed > 0)
      throw std::runtime_error(
          std::to_string(report.failed) + " chains came to nothing; `pleat status " +
          study_.output + "` names them, `pleat rerun " + study_.output + " --failed` tries again");
    record("simulate", "shards", report.made > 0, campaign_summary(report), start);
    return true;
  }

  bool encode() {
    return once("encode", encode_key_, dataset(), [&]() -> std::optional<std::string> {
      const auto report = encode::make_dataset(dataset_inputs(study_, manifest_), study_.encode,
                                               provenance("encode"), dataset());
      if (report.is_interrupted) return std::nullopt;
      return std::to_string(report.accepted_frames) + " frames, round trip " +
             format("%.3f mm mean, %.2f mm at the 99th percentile", report.round_trip_mean_mm,
                    report.round_trip_p99_mm);
    });
  }

  bool train() {
    return once("train", train_key_, models(), [&]() -> std::optional<std::string> {
      std::filesystem::create_directories(models());
      const std::optional<TrainSummary> trained = learning_.train(
          study_, dataset(), models(), provenance("train_design"), provenance("train"));
      if (!trained) return std::nullopt;
      return std::to_string(trained->steps) + " steps of " + std::to_string(trained->parameters) +
             " weights, validation loss " +
             format("%.4f; G_design %.2f mm on its training designs", trained->validation_loss,
                    trained->design_error_mm);
    });
  }

  bool sample() {
    return once("sample", sample_key_, samples(), [&]() -> std::optional<std::string> {
      std::vector<int64_t> rows;
      for (int split = 0; split < encode::kSplits; ++split) {
        const int count = split == encode::kTrain ? study_.rows.train : study_.rows.held_out;
        for (int64_t row : learning_.rows_of_split(dataset(), split, count)) rows.push_back(row);
      }
      if (rows.empty())
        throw InputError(
            "sample_rows: no row is asked for; raise sample_rows.held_out or sample_rows.train");
      const bool has_finished =
          learning_.sample_textures(models() + "/diffusion.h5", dataset(), rows, study_.sample,
                                    samples(), provenance("sample"));
      if (!has_finished) return std::nullopt;
      return std::to_string(rows.size()) + " rows, " +
             std::to_string(study_.sample.samples_per_row) + " each";
    });
  }

  bool evaluate() {
    return once(
        "evaluate", evaluate_key_, in_output("report.json"), [&]() -> std::optional<std::string> {
          evaluation_ = evaluate::evaluate(dataset(), samples(), study_.body.file, study_.evaluate);
          if (evaluation_->is_interrupted) return std::nullopt;
          evaluate::write_report(in_output("report.json"), *evaluation_, provenance("evaluate"));
          std::printf("%s\n", evaluate::summary(*evaluation_).c_str());
          return format("sampled drapes off by %.2f mm on average",
                        evaluation_->splits.back().error.mean_mm);
        });
  }

  bool report() {
    return once("report", report_key_, in_output("report.html"),
                [&]() -> std::optional<std::string> {
                  ReportInputs inputs;
                  inputs.output = study_.output;
                  inputs.dataset = dataset();
                  inputs.samples = samples();
                  inputs.loss_csv = models() + "/diffusion_loss.csv";
                  inputs.shard_of_key = [this](const std::string& key) {
                    return campaign::shard_path(study_.output, key);
                  };
                  for (const campaign::Chain& chain : manifest_.chains)
                    inputs.shard_files.push_back(inputs.shard_of_key(chain.key));
                  for (const auto& [stage, key, file] :
                       std::vector<std::tuple<std::string, std::string, std::string>>{
                           {"dress", campaign_key_, in_output("garments")},
                           {"simulate", campaign_key_, in_output("shards")},
                           {"encode", encode_key_, dataset()},
                           {"train", train_key_, models()},
                           {"sample", sample_key_, samples()},
                           {"evaluate", evaluate_key_, in_output("report.json")}})
                    if (const auto record = log_.find(stage, key, file))
                      inputs.stages.push_back({stage, *record});
                  if (!evaluation_)
                    evaluation_ =
                        evaluate::evaluate(dataset(), samples(), study_.body.file, study_.evaluate);
                  if (evaluation_->is_interrupted ||
                      !write_report_page(study_, inputs, *evaluation_, provenance("report"),
                                         in_output("report.html")))
                    return std::nullopt;
                  return in_output("report.html");
                });
  }

  std::string in_output(const std::string& name) const { return study_.output + "/" + name; }
  std::string dataset() const { return in_output("dataset.h5"); }
  std::string samples() const { return in_output("samples.h5"); }
  std::string models() const { return in_output("models/" + train_key_.substr(0, 16)); }
  Provenance provenance(const std::string& stage) const {
    Provenance provenance;
    provenance.stage = stage;
    provenance.config = to_yaml(with_absolute_paths(study_));
    provenance.seed = study_.seed;
    return provenance;
  }

  const StudyConfig& study_;
  const LearnStages& learning_;
  campaign::Campaign campaign_;
  campaign::Manifest manifest_;
  campaign::RunOptions options_;
  StageLog log_;
  std::optional<evaluate::Evaluation> evaluation_;  // of this run, for the report
  std::string campaign_key_, encode_key_, train_key_, sample_key_, evaluate_key_, report_key_;
};

}  // namespace

campaign::Campaign campaign_of(const StudyConfig& study) {
  campaign::Campaign campaign;
  campaign.designs = study.designs;
  for (const std::vector<double>& shape : study.shapes)
    campaign.shapes.push_back(Eigen::Map<const Eigen::VectorXd>(shape.data(), shape.size()));
  for (const MotionEntry& entry : study.motions) {
    campaign::MotionSource source{entry.name, entry.file, study.motion, ""};
    source.config.start_s = entry.start_s;
    source.config.duration_s = entry.duration_s;
    source.settings = motion_settings(source.config);
    campaign.motions.push_back(source);
  }
  campaign.garment_vertices = study.garment.vertices;
  campaign.fabric = study.fabric;
  campaign.simulation = study.simulation;
  campaign.body_file = study.body.file;
  campaign.profile = study.profile;
  campaign.settings = simulation_settings(study);
  campaign.seed = study.seed;
  return campaign;
}

encode::DatasetInputs dataset_inputs(const StudyConfig& study, const campaign::Manifest& manifest) {
  encode::DatasetInputs inputs;
  for (const campaign::Chain& chain : manifest.chains)
    inputs.clip_files.push_back(campaign::shard_path(study.output, chain.key));
  for (const std::string& key : manifest.garment_keys)
    inputs.garment_files.push_back(campaign::garment_path(study.output, key));
  inputs.body_file = study.body.file;
  return inputs;
}

campaign::RunOptions run_options_of(const StudyConfig& study) {
  campaign::RunOptions options;
  options.folder = study.output;
  options.seed = study.seed;
  options.threads = study.threads;
  options.limits = study.limits;
  return options;
}

void write_plan(const StudyConfig& study, const campaign::Campaign& campaign,
                const campaign::Manifest& manifest) {
  std::error_code error;
  std::filesystem::create_directories(study.output, error);
  if (error) throw InputError("output: " + study.output + ": " + error.message());
  write_file_atomically(study.output + "/config.yaml", to_yaml(with_absolute_paths(study)));
  campaign::write_manifest(study.output, campaign, manifest);
}

bool run_stages(const StudyConfig& study, Stage last, const campaign::TaskSlice& slice,
                const LearnStages& learning) {
  if (last >= Stage::kTrain && !learning.train)
    throw InputError(
        "this pleat was built without LibTorch (PLEAT_LEARN=OFF), or lies where pleat-learn does "
        "not; it ends with `pleat encode`");
  return Pipeline(study, slice, learning).run(last);
}

}  // namespace pleat::app
