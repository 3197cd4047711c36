#include "app/campaign_commands.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>

#include "app/exit_codes.h"
#include "app/pipeline.h"
#include "app/yaml_reader.h"
#include "campaign/check.h"
#include "campaign/estimate.h"
#include "campaign/index.h"
#include "campaign/status.h"
#include "campaign/verify.h"
#include "core/error.h"
#include "core/profile.h"
#include "core/progress.h"
#include "core/provenance.h"
#include "garment/clip.h"

namespace pleat::app {
namespace {

// A campaign that has a folder, ready to make parts of it again.
struct Planned {
  StudyConfig study;
  campaign::Campaign campaign;
  campaign::Manifest manifest;
  campaign::RunOptions options;
};

// InputError where an input has changed since: its drapes have other keys now.
Planned read_planned(const std::string& folder, char** argv) {
  Planned planned;
  planned.study = read_study_or_folder(folder);
  enter_profile(planned.study.profile, argv);
  planned.campaign = campaign_of(planned.study);
  planned.manifest = campaign::plan(planned.campaign);
  planned.options = run_options_of(planned.study);
  const campaign::ManifestFile file = campaign::read_manifest(folder);
  std::set<std::string> keys;
  for (const campaign::ManifestRow& row : file.chains) keys.insert(row.key);
  for (const campaign::Chain& chain : planned.manifest.chains)
    if (!keys.count(chain.key))
      throw InputError(folder + "/manifest.jsonl: has no chain " + chain.key +
                       ", which the body, motions and this version of Pleat give now; `pleat "
                       "simulate " +
                       folder + "` makes what has changed");
  return planned;
}

int plan(const std::string& config, const std::string& bench, bool is_dry) {
  const StudyConfig study = read_study_or_folder(config);
  const campaign::Campaign campaign = campaign_of(study);
  const campaign::Manifest manifest = campaign::plan(campaign);
  const std::vector<int> frames = campaign::check_inputs(campaign);
  const campaign::Estimate e = campaign::estimate(campaign, manifest, frames, study.output, bench);
  if (!is_dry) write_plan(study, campaign, manifest);
  std::printf("%s\n", study.output.c_str());
  std::printf("  %-16s%lld: %zu designs x %zu shapes x %zu motions; %lld to do\n", "chains",
              static_cast<long long>(e.chains), campaign.designs.size(), campaign.shapes.size(),
              campaign.motions.size(), static_cast<long long>(e.chains_left));
  std::printf("  %-16s%lld\n", "frames", static_cast<long long>(e.frames));
  std::printf("  %-16s%.3g to do, by %s\n", "core-hours", e.core_hours, e.source.c_str());
  std::printf("  %-16sabout %s\n", "disk", campaign::size_text(e.bytes).c_str());
  std::printf("  %-16s%s, so that keys and bits hold for %s\n", "arithmetic", study.profile.c_str(),
              study.profile == "portable" ? "every x86-64 processor" : "processors like this one");
  if (is_dry)
    std::printf("  %-16snothing was written; without --dry-run the manifest is\n", "dry run");
  else
    std::printf("  %-16spleat simulate %s\n", "next", config.c_str());
  return kDone;
}

int simulate(const std::string& config, int index, int count, char** argv) {
  const campaign::TaskSlice slice = campaign::task_slice(index, count);
  const StudyConfig study = read_study_or_folder(config);
  enter_profile(study.profile, argv);
  if (run_stages(study, Stage::kSimulate, slice)) return kDone;
  spdlog::warn("interrupted; the same command goes on from the last checkpoint");
  return kInterrupted;
}

int check(const std::string& folder, bool is_repair) {
  const campaign::CheckReport report = campaign::check(folder);
  for (const campaign::Damage& damage : report.damages)
    std::printf("%s: %s\n", damage.file.c_str(), damage.what.c_str());
  std::printf("%d files are whole, %zu are not\n", report.files, report.damages.size());
  if (report.damages.empty()) return kDone;
  if (!is_repair) {
    std::printf("pleat check %s --repair sets them aside for the next run\n", folder.c_str());
    return kFailed;
  }
  campaign::repair(folder, report);
  std::printf("set aside; pleat simulate %s makes them again\n", folder.c_str());
  return kDone;
}

int verify(const std::string& folder, int sample, uint64_t seed, char** argv) {
  const Planned planned = read_planned(folder, argv);
  const std::vector<campaign::Piece> pieces =
      campaign::pieces_of(planned.manifest, folder, sample, seed);
  if (pieces.empty()) throw InputError(folder + ": no chain is simulated yet");
  const campaign::VerifyReport report =
      campaign::verify(planned.campaign, planned.manifest, planned.options, pieces);
  int different = 0;
  for (const campaign::Difference& d : report.differences) {
    different += !d.is_timed;
    std::printf("%s:%d differs%s\n", planned.manifest.chains[d.piece.chain].key.c_str(), d.frame,
                d.is_timed ? ", behind a frame that ran out of time" : "");
  }
  std::printf("%lld frames in %d of %zu pieces made again: %s\n",
              static_cast<long long>(report.frames), report.pieces, pieces.size(),
              different > 0                ? "not the same"
              : report.differences.empty() ? "the same bits"
                                           : "the same bits but where the clock decided");
  if (!report.machines.empty()) {
    std::printf("made on other machines:\n");
    for (const std::string& machine : report.machines) std::printf("  %s\n", machine.c_str());
    if (planned.study.profile != "portable")
      std::printf("with `profile: native` bits are promised on the same kind of processor only\n");
  }
  if (report.is_interrupted) return kInterrupted;
  return different > 0 ? kFailed : kDone;
}

void print_certificate(const char* name, const garment::Certificate& c) {
  std::printf(
      "  %-8s%s, residual %.3g, %s, gap %.3f mm, crossings %d body %d self, strain 95 %% %.3f, "
      "%d iterations, attempt %d, %.1f s\n",
      name, c.is_accepted ? "accepted" : c.reason.c_str(), c.residual,
      c.is_stable ? "stable" : "not known stable", 1e3 * c.min_gap_m, c.body_intersections,
      c.self_intersections, c.strain_95, c.iterations, c.attempts, c.seconds);
}

struct RerunRequest {
  std::string folder, only, reason;
  bool is_failed = false;
  double max_seconds_per_drape = -1;
};

int rerun(const RerunRequest& request, char** argv) {
  const int ways = !request.only.empty() + request.is_failed + !request.reason.empty();
  if (ways != 1)
    throw InputError("rerun: say one of --failed, --rejected REASON or --only KEY[:FRAME]");
  Planned planned = read_planned(request.folder, argv);
  if (request.max_seconds_per_drape >= 0)
    planned.options.limits.max_seconds_per_drape = request.max_seconds_per_drape;
  const size_t colon = request.only.find(':');
  const std::string key = request.only.substr(0, colon);
  std::vector<campaign::Chain>& chains = planned.manifest.chains;
  const auto path = [&](const campaign::Chain& chain) {
    return campaign::shard_path(request.folder, chain.key);
  };
  const auto garment_key = [&](const campaign::Chain& chain) {
    return planned.manifest.garment_keys[chain.design];
  };
  if (!request.only.empty()) {
    const auto chain = std::find_if(chains.begin(), chains.end(),
                                    [&](const campaign::Chain& c) { return c.key == key; });
    if (chain == chains.end())
      throw InputError(request.folder + "/manifest.jsonl: has no chain " + key);
    if (colon != std::string::npos) {
      const std::string frame = request.only.substr(colon + 1);
      if (frame.empty() || frame.size() > 7 ||
          frame.find_first_not_of("0123456789") != std::string::npos)
        throw InputError("--only " + request.only + ": '" + frame + "' is no frame");
      const campaign::FrameAgain again =
          campaign::run_frame_again(planned.campaign, planned.manifest, planned.options,
                                    static_cast<int>(chain - chains.begin()), std::stoi(frame));
      if (is_interrupted()) return kInterrupted;
      std::printf("%s\n", request.only.c_str());
      print_certificate("before", again.before);
      print_certificate("now", again.now);
      std::printf("  %s\n", again.is_same ? "the same bits" : "NOT the same bits");
      return again.is_same ? kDone : kFailed;
    }
  }
  const auto is_wanted = [&](const campaign::Chain& chain) {
    if (chain.key == key) return true;
    if (request.is_failed && campaign::has_failed(request.folder, chain.key, garment_key(chain)))
      return true;
    if (request.reason.empty() || !std::filesystem::exists(path(chain))) return false;
    const garment::Clip clip = garment::read_clip_head(path(chain));
    return std::any_of(clip.certificates.begin(), clip.certificates.end(),
                       [&](const garment::Certificate& c) { return c.reason == request.reason; });
  };
  chains.erase(std::remove_if(chains.begin(), chains.end(),
                              [&](const campaign::Chain& chain) { return !is_wanted(chain); }),
               chains.end());
  if (chains.empty()) {
    std::printf("there is nothing of that kind to run again\n");
    return kDone;
  }
  for (const campaign::Chain& chain : chains) {
    if (std::filesystem::exists(path(chain))) campaign::set_aside(request.folder, path(chain));
    const std::string parts = campaign::parts_path(request.folder, chain.key);
    if (std::filesystem::exists(parts)) campaign::set_aside(request.folder, parts);
    for (const std::string& failed : {chain.key, garment_key(chain)})
      std::filesystem::remove(campaign::failure_path(request.folder, failed));
  }
  spdlog::info("{} chains run again; what there was lies in {}/set_aside", chains.size(),
               request.folder);
  campaign::settle_garments(planned.campaign, planned.manifest, planned.options);
  const campaign::RunReport report =
      campaign::run_chains(planned.campaign, planned.manifest, planned.options);
  if (report.is_interrupted) {
    spdlog::warn("interrupted; pleat simulate {} goes on", request.folder);
    return kInterrupted;
  }
  std::printf("%lld of %lld frames accepted, %d chains came to nothing\n",
              static_cast<long long>(report.accepted), static_cast<long long>(report.frames),
              report.failed);
  return report.failed > 0 ? kFailed : kDone;
}

int index(const std::string& folder, const std::vector<std::string>& accept) {
  campaign::IndexConfig config;
  config.accept.insert(accept.begin(), accept.end());
  const campaign::IndexReport report = campaign::write_index(folder, config);
  std::printf("%s/index.h5: %d chains, %lld of %lld frames accepted\ncontent hash %s\n",
              folder.c_str(), report.chains, static_cast<long long>(report.accepted),
              static_cast<long long>(report.frames), report.content_hash.c_str());
  return kDone;
}

// Everything that the command line may say of these commands.
struct Arguments {
  std::string config, folder, bench;
  bool is_dry = false, is_json = false, is_repair = false;
  int index = -1, count = -1, sample = 0;
  uint64_t seed = 1;
  std::vector<std::string> accept;
  RerunRequest rerun;
};

}  // namespace

void add_campaign_commands(CLI::App& program, int& result, char** argv) {
  const auto a = std::make_shared<Arguments>();
  const auto add = [&](const std::string& name, const std::string& help, bool is_of_folder) {
    CLI::App* command = program.add_subcommand(name, help);
    if (is_of_folder)
      command->add_option("FOLDER", a->folder, "the study's output folder")
          ->required()
          ->transform([](const std::string& folder) {  // as Tab completes it
            const size_t end = folder.find_last_not_of('/');
            return end == std::string::npos ? folder : folder.substr(0, end + 1);
          });
    else
      command->add_option("STUDY", a->config, "the study's YAML file, or its output folder")
          ->required();
    return command;
  };

  CLI::App* command =
      add("plan", "what a study will simulate, how long that takes and how much it fills", false);
  command->add_flag("--dry-run", a->is_dry, "write nothing");
  command->add_option("--bench", a->bench,
                      "figures of this machine, by `scripts/bench sim --json FILE`");
  command->callback([a, &result] { result = plan(a->config, a->bench, a->is_dry); });

  command = add("simulate",
                "find the static drape of every frame: shards/\n"
                "Goes on where it was interrupted. Many processes may work on one study: give each "
                "its rows, here or by\nSLURM_ARRAY_TASK_ID, JOB_COMPLETION_INDEX or PARALLEL_SEQ "
                "(scripts/engines).",
                false);
  command->add_option("--task-index", a->index,
                      "do rows INDEX, INDEX + COUNT, ... of the manifest");
  command->add_option("--task-count", a->count, "COUNT of the above");
  command->callback([a, &result, argv] { result = simulate(a->config, a->index, a->count, argv); });

  command = add("status", "how far a study's simulation is, and what was rejected", true);
  command->add_flag("--json", a->is_json, "for programs");
  command->callback([a, &result] {
    const campaign::Status status = campaign::status_of(a->folder);
    std::printf("%s", (a->is_json ? to_json(status) : to_text(status)).c_str());
    result = kDone;
  });

  command = add("check", "name files that are truncated, altered or missing", true);
  command->add_flag("--repair", a->is_repair, "and set them aside for the next run");
  command->callback([a, &result] { result = check(a->folder, a->is_repair); });

  command = add("verify", "simulate again, and compare bit for bit", true);
  command
      ->add_option("--sample", a->sample,
                   "so many pieces only, drawn at random; a piece is what lies between two "
                   "checkpoints")
      ->check(CLI::PositiveNumber);
  command->add_option("--seed", a->seed, "of that draw")->capture_default_str();
  command->callback([a, &result, argv] { result = verify(a->folder, a->sample, a->seed, argv); });

  command = add("rerun", "simulate chains again that failed, or look again at one frame", true);
  command->add_flag("--failed", a->rerun.is_failed, "chains that came to nothing");
  command->add_option("--rejected", a->rerun.reason,
                      "chains with a frame rejected for this reason, such as 'out of time'");
  command->add_option("--only", a->rerun.only,
                      "KEY: this chain; KEY:FRAME: this frame alone, compared with what there is");
  command->add_option("--max-seconds-per-drape", a->rerun.max_seconds_per_drape,
                      "instead of limits.max_seconds_per_drape");
  command->callback([a, &result, argv] {
    a->rerun.folder = a->folder;
    result = rerun(a->rerun, argv);
  });

  command = add("index",
                "check every shard and write one face over them: index.h5, data card, "
                "checksums",
                true);
  command->add_option("--accept", a->accept,
                      "what the data set may lack: a reason of rejected frames, `failed`, "
                      "`missing`, `any`");
  command->callback([a, &result] { result = index(a->folder, a->accept); });
}

}  // namespace pleat::app
