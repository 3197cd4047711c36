#include "campaign/run_tasks.h"

#include <unistd.h>

#include <filesystem>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "body/body_file.h"
#include "core/error.h"
#include "core/hdf5_file.h"
#include "core/progress.h"
#include "garment/clip.h"
#include "garment/garment_file.h"

namespace pleat::campaign {
namespace {

namespace fs = std::filesystem;

Provenance provenance_of(const Campaign& campaign, const std::string& stage,
                         const std::string& config, uint64_t seed) {
  Provenance provenance;
  provenance.stage = stage;
  provenance.config = config;
  provenance.seed = seed;
  provenance.inputs["body"] = sha256_of_file(campaign.body_file);
  return provenance;
}

// Whether the file is there and whole. One that is damaged is set aside.
bool is_done(const std::string& folder, const std::string& path) {
  const std::string damage = Hdf5File::damage_of(path);
  if (damage == "missing") return false;
  if (damage.empty()) return true;
  set_aside(folder, path);
  return false;
}

std::vector<Chain> rows_of(const Manifest& manifest, const TaskSlice& slice) {
  std::vector<Chain> rows;
  for (size_t i = slice.index; i < manifest.chains.size(); i += slice.count)
    rows.push_back(manifest.chains[i]);
  return rows;
}

// What there is of a chain that is not finished: parts that are whole and lead from one to the
// next.
struct Parts {
  std::vector<std::string> paths;
  int frames = 0;  // that they hold
  std::optional<garment::ClipState> end;
};

// The state at the end of the part of this chain that begins at first_frame from a state of this
// hash; none where there is no such part, or another process takes it away meanwhile.
std::optional<garment::ClipState> end_of_part(const std::string& path, const std::string& key,
                                              int first_frame, const std::string& from,
                                              int frames) {
  try {
    if (!Hdf5File::damage_of(path).empty() || garment::clip_key(path) != key) return {};
    garment::Clip part = garment::read_clip(path);
    const int end = first_frame + static_cast<int>(part.poses.size());
    if (part.first_frame != first_frame || part.from_sha256 != from || end > frames ||
        part.states.size() != 1 || part.states[0].frame != end)
      return {};
    return std::move(part.states[0]);
  } catch (const InputError&) {
    return {};
  }
}

Parts parts_of(const std::string& folder, const std::string& key, int frames) {
  Parts parts;
  std::string from;
  while (parts.frames < frames) {
    const std::string path = part_path(folder, key, parts.frames);
    std::optional<garment::ClipState> end = end_of_part(path, key, parts.frames, from, frames);
    if (!end) break;
    parts.paths.push_back(path);
    parts.frames = end->frame;
    from = garment::state_hash(*end);
    parts.end = std::move(end);
  }
  return parts;
}

std::string remark_of(const std::map<std::string, int64_t>& rejected) {
  std::string text;
  for (const auto& [reason, count] : rejected)
    text += (text.empty() ? "rejected: " : ", ") + std::to_string(count) + " " + reason;
  return text;
}

// What all chains of a run share.
struct Run {
  const Campaign& campaign;
  const Manifest& manifest;
  const RunOptions& options;
  body::BodyModel model;
  std::vector<body::Motion> motions;  // those that are needed
  Crew crew;
  RunReport report;
  std::map<std::string, int64_t> rejected = {};  // frames by reason, for the progress line
  std::mutex mutex = {};
};

void write_failure(const std::string& folder, const std::string& key, const std::string& design,
                   const std::string& what) {
  const nlohmann::ordered_json json = {
      {"key", key},           {"design", design},
      {"what", what},         {"commit", commit()},
      {"machine", machine()}, {"again", "pleat rerun " + folder + " --failed"}};
  fs::create_directories(folder + "/failures");
  write_file_atomically(failure_path(folder, key), json.dump(2) + "\n");
}

// Simulates what is missing of one chain, part by part. False where it was stopped: by the user, or
// because another process works on the same chain and was faster.
bool add_parts(Run& run, const Chain& chain, const garment::Garment& garment, const Parts& parts,
               Progress& progress) {
  const RunOptions& options = run.options;
  const Campaign& campaign = run.campaign;
  const std::string shard = shard_path(options.folder, chain.key);
  const int frames = static_cast<int>(run.motions[chain.motion].frames.size());
  const garment::Fabric fabric = fabric_of(campaign, chain);
  Provenance provenance = provenance_of(campaign, "simulate",
                                        garment::to_text(fabric) + campaign.settings +
                                            campaign.motions[chain.motion].settings +
                                            "profile: " + campaign.profile + "\n",
                                        options.seed);
  provenance.inputs["motion"] = sha256_of_file(campaign.motions[chain.motion].file);

  bool is_overtaken = false;
  sim::Supervision supervision;
  supervision.max_seconds_per_drape = options.limits.max_seconds_per_drape;
  supervision.should_stop = [&] { return is_overtaken || run.crew.should_stop(); };
  supervision.on_frame = [&](const garment::Certificate& certificate) {
    is_overtaken = fs::exists(shard);
    const std::lock_guard<std::mutex> lock(run.mutex);
    if (!certificate.is_accepted) ++run.rejected[certificate.reason];
    progress.advance(1, remark_of(run.rejected));
  };
  supervision.on_part = [&](const garment::Clip& part) {
    if (is_overtaken) return;
    // A part that another process has put there since, from the same state, stays: where it ends in
    // another (its clock cut a frame short, say), the chain goes on from there.
    const std::string path = part_path(options.folder, chain.key, part.first_frame);
    if (const auto theirs =
            end_of_part(path, chain.key, part.first_frame, part.from_sha256, frames)) {
      is_overtaken = garment::state_hash(*theirs) != garment::state_hash(part.states.front());
      return;
    }
    require_space(options.folder,
                  2 * shard_bytes(static_cast<int>(part.poses.size()),
                                  static_cast<int>(part.positions.front().rows()), 1),
                  options.limits.min_free_disk_mb);
    fs::create_directories(parts_path(options.folder, chain.key));
    garment::write_clip(path, part, chain.key, provenance);
  };
  return sim::simulate_parts(garment, run.model, campaign.shapes[chain.shape],
                             run.motions[chain.motion], fabric, campaign.simulation,
                             parts.end ? &*parts.end : nullptr, supervision);
}

// Takes the parts of a finished chain away, at once for others who look.
void remove_parts(const std::string& folder, const std::string& key) {
  const std::string parts = parts_path(folder, key);
  const std::string gone = parts + ".tmp-" + std::to_string(::getpid());
  std::error_code error;
  fs::rename(parts, gone, error);
  fs::remove_all(gone, error);
}

// False where the user stopped it before the end.
bool finish_chain(Run& run, const Chain& chain, Progress& progress) {
  const RunOptions& options = run.options;
  const int frames = static_cast<int>(run.motions[chain.motion].frames.size());
  const std::string shard = shard_path(options.folder, chain.key);
  const garment::Garment garment =
      garment::read_garment(garment_path(options.folder, run.manifest.garment_keys[chain.design]));
  while (!fs::exists(shard)) {
    const Parts parts = parts_of(options.folder, chain.key, frames);
    if (parts.frames < frames) {
      add_parts(run, chain, garment, parts, progress);
      if (run.crew.should_stop()) return false;
      continue;
    }
    require_space(options.folder,
                  shard_bytes(frames, static_cast<int>(garment.t_pose.rows()),
                              run.campaign.simulation.checkpoint_frames),
                  options.limits.min_free_disk_mb);
    garment::join_clips(parts.paths, shard);
  }
  remove_parts(options.folder, chain.key);
  return true;
}

// The same, where other processes may take away what it reads and writes: then the shard is there.
void run_chain(Run& run, const Chain& chain, Progress& progress) {
  const std::string shard = shard_path(run.options.folder, chain.key);
  try {
    if (!finish_chain(run, chain, progress)) return;
  } catch (const fs::filesystem_error& error) {
    if (!fs::exists(shard)) throw ResourceError(error.what());
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    if (!fs::exists(shard)) throw;
  }
  const garment::Clip clip = garment::read_clip_head(shard);
  const std::lock_guard<std::mutex> lock(run.mutex);
  run.report.add(clip.certificates);
  ++run.report.made;
}

}  // namespace

std::vector<int> check_inputs(const Campaign& campaign) {
  const body::BodyModel model = body::read_body(campaign.body_file);
  for (const Eigen::VectorXd& shape : campaign.shapes) body::shape_body(model, shape);
  std::vector<int> frames;
  for (const MotionSource& source : campaign.motions)
    frames.push_back(
        static_cast<int>(body::load_motion(source.file, model, source.config).frames.size()));
  return frames;
}

double shard_bytes(int frames, int garment_vertices, int checkpoint_frames) {
  const double vertices = garment_vertices;
  const double of_a_frame = 12 * vertices + 1500, of_a_state = 40 * vertices;
  return 50e3 + frames * (of_a_frame + of_a_state / checkpoint_frames);
}

RunReport settle_garments(const Campaign& campaign, const Manifest& manifest,
                          const RunOptions& options) {
  fs::create_directories(options.folder + "/garments");
  RunReport report;
  std::set<int> designs;
  for (const Chain& chain : rows_of(manifest, options.slice)) designs.insert(chain.design);
  std::vector<int> missing;
  for (int d : designs) {
    const std::string& key = manifest.garment_keys[d];
    if (is_done(options.folder, garment_path(options.folder, key)))
      ++report.kept;
    else if (fs::exists(failure_path(options.folder, key)))
      ++report.failed;
    else
      missing.push_back(d);
  }
  if (missing.empty()) return report;

  const body::BodyModel model = body::read_body(campaign.body_file);
  const garment::GarmentTopology topology = garment::make_topology(campaign.garment_vertices);
  const garment::Fabric fabric = garment::middle_fabric(campaign.fabric);
  const Provenance provenance =
      provenance_of(campaign, "dress", garment::to_text(fabric) + campaign.settings, options.seed);
  Progress progress("dress", static_cast<int64_t>(missing.size()), "garments");
  std::mutex mutex;
  Crew crew(options.threads, options.limits, campaign.garment_vertices);
  const int count = static_cast<int>(missing.size());
  crew.run(count, [&](int i) {
    const int d = missing[(i + options.slice.index) % count];  // tasks begin at different ones
    const garment::Design& design = campaign.designs[d];
    const std::string& key = manifest.garment_keys[d];
    if (fs::exists(garment_path(options.folder, key))) {  // another task was faster
      const std::lock_guard<std::mutex> lock(mutex);
      ++report.kept;
      progress.advance(1, design.name);
      return;
    }
    std::string failure;
    garment::Garment garment;
    try {
      garment = sim::settle_garment(design, topology, model, fabric, campaign.simulation,
                                    [&] { return crew.should_stop(); });
    } catch (const InputError& error) {  // this design does not settle: the others go on
      failure = error.what();
    }
    if (!failure.empty() && crew.should_stop()) return;
    if (failure.empty())
      garment::write_garment(garment_path(options.folder, key), garment, provenance);
    else
      write_failure(options.folder, key, design.name, failure);
    const std::lock_guard<std::mutex> lock(mutex);
    ++(failure.empty() ? report.made : report.failed);
    progress.advance(1, failure.empty() ? design.name : failure);
  });
  report.is_interrupted = is_interrupted();
  return report;
}

RunReport run_chains(const Campaign& campaign, const Manifest& manifest,
                     const RunOptions& options) {
  fs::create_directories(options.folder + "/shards");
  RunReport report;
  std::vector<Chain> missing;
  for (const Chain& chain : rows_of(manifest, options.slice)) {
    const std::string path = shard_path(options.folder, chain.key);
    if (is_done(options.folder, path)) {
      report.add(garment::read_clip_head(path).certificates);
      ++report.kept;
    } else if (has_failed(options.folder, chain.key, manifest.garment_keys[chain.design])) {
      ++report.failed;
    } else {
      missing.push_back(chain);
    }
  }
  if (missing.empty()) return report;

  Run run{campaign,
          manifest,
          options,
          body::read_body(campaign.body_file),
          std::vector<body::Motion>(campaign.motions.size()),
          Crew(options.threads, options.limits, campaign.garment_vertices),
          report};
  int64_t frames = 0;
  double bytes = 0;
  for (const Chain& chain : missing) {
    body::Motion& motion = run.motions[chain.motion];
    const MotionSource& source = campaign.motions[chain.motion];
    if (motion.frames.empty()) motion = body::load_motion(source.file, run.model, source.config);
    motion.name = source.name;
    const int length = static_cast<int>(motion.frames.size());
    frames += length - parts_of(options.folder, chain.key, length).frames;
    bytes += shard_bytes(length, campaign.garment_vertices, campaign.simulation.checkpoint_frames);
  }
  require_space(options.folder, bytes, options.limits.min_free_disk_mb);
  run.rejected = report.rejected;
  Progress progress("simulate", frames, "frames");
  // Tasks that share a folder begin at different rows.
  const int count = static_cast<int>(missing.size());
  run.crew.run(
      count, [&](int i) { run_chain(run, missing[(i + options.slice.index) % count], progress); });
  run.report.is_interrupted = is_interrupted();
  return run.report;
}

}  // namespace pleat::campaign
