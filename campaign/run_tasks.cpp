#include "campaign/run_tasks.h"

#include <omp.h>

#include <exception>
#include <filesystem>
#include <functional>
#include <mutex>

#include "body/body_file.h"
#include "core/error.h"
#include "core/progress.h"
#include "garment/clip.h"
#include "garment/garment_file.h"

namespace pleat::campaign {
namespace {

// Runs task(0) .. task(count - 1), one thread each, until done, interrupted, or one throws; that is
// then thrown here.
void for_each_task(int count, int threads, const std::function<void(int)>& task) {
  std::exception_ptr failure;
  std::mutex mutex;
#pragma omp parallel for schedule(dynamic, 1) \
    num_threads(threads > 0 ? threads : omp_get_num_procs())
  for (int i = 0; i < count; ++i) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      if (failure || is_interrupted()) continue;
    }
    try {
      task(i);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

Provenance provenance_of(const Campaign& campaign, const std::string& stage,
                         const std::string& config, uint64_t seed) {
  Provenance provenance;
  provenance.stage = stage;
  provenance.config = config;
  provenance.seed = seed;
  provenance.inputs["body"] = sha256_of_file(campaign.body_file);
  return provenance;
}

void count_frames(const garment::Clip& clip, RunReport& report) {
  for (const garment::Certificate& certificate : clip.certificates) {
    ++report.frames;
    report.drape_seconds += certificate.seconds;
    if (certificate.is_accepted)
      ++report.accepted;
    else
      ++report.rejected[certificate.reason];
  }
}

}  // namespace

void check_inputs(const Campaign& campaign) {
  const body::BodyModel model = body::read_body(campaign.body_file);
  for (const Eigen::VectorXd& shape : campaign.shapes) body::shape_body(model, shape);
  for (const MotionSource& source : campaign.motions)
    body::load_motion(source.file, model, source.config);
}

RunReport settle_garments(const Campaign& campaign, const Manifest& manifest,
                          const std::string& folder, uint64_t seed, int threads) {
  std::filesystem::create_directories(folder + "/garments");
  RunReport report;
  std::vector<int> missing;
  for (size_t d = 0; d < campaign.designs.size(); ++d)
    if (!std::filesystem::exists(garment_path(folder, manifest.garment_keys[d])))
      missing.push_back(static_cast<int>(d));
  report.kept = static_cast<int>(campaign.designs.size() - missing.size());
  if (missing.empty()) return report;

  const body::BodyModel model = body::read_body(campaign.body_file);
  const garment::GarmentTopology topology = garment::make_topology(campaign.garment_vertices);
  const garment::Fabric fabric = garment::middle_fabric(campaign.fabric);
  const Provenance provenance =
      provenance_of(campaign, "dress", garment::to_text(fabric) + campaign.settings, seed);
  Progress progress("dress", static_cast<int64_t>(missing.size()), "garments");
  std::mutex mutex;
  for_each_task(static_cast<int>(missing.size()), threads, [&](int i) {
    const garment::Design& design = campaign.designs[missing[i]];
    const garment::Garment garment =
        sim::settle_garment(design, topology, model, fabric, campaign.simulation);
    garment::write_garment(garment_path(folder, manifest.garment_keys[missing[i]]), garment,
                           provenance);
    const std::lock_guard<std::mutex> lock(mutex);
    ++report.made;
    progress.advance(1, design.name);
  });
  report.is_interrupted = is_interrupted();
  return report;
}

RunReport run_chains(const Campaign& campaign, const Manifest& manifest, const std::string& folder,
                     uint64_t seed, int threads) {
  std::filesystem::create_directories(folder + "/shards");
  RunReport report;
  std::vector<Chain> missing;
  for (const Chain& chain : manifest.chains) {
    const std::string path = shard_path(folder, chain.key);
    if (std::filesystem::exists(path)) {
      count_frames(garment::read_clip(path), report);
      ++report.kept;
    } else {
      missing.push_back(chain);
    }
  }
  if (missing.empty()) return report;

  const body::BodyModel model = body::read_body(campaign.body_file);
  std::vector<body::Motion> motions(campaign.motions.size());
  int64_t frames = 0;
  for (const Chain& chain : missing) {
    body::Motion& motion = motions[chain.motion];
    const MotionSource& source = campaign.motions[chain.motion];
    if (motion.frames.empty()) motion = body::load_motion(source.file, model, source.config);
    motion.name = source.name;
    frames += static_cast<int64_t>(motion.frames.size());
  }
  Progress progress("simulate", frames, "frames");
  std::mutex mutex;
  for_each_task(static_cast<int>(missing.size()), threads, [&](int i) {
    const Chain& chain = missing[i];
    const garment::Garment garment =
        garment::read_garment(garment_path(folder, manifest.garment_keys[chain.design]));
    const auto on_frame = [&](const garment::Certificate& certificate) {
      const std::lock_guard<std::mutex> lock(mutex);
      progress.advance(
          1, certificate.is_accepted ? "" : garment.design.name + ": " + certificate.reason);
      return !is_interrupted();
    };
    const body::Motion& motion = motions[chain.motion];
    const garment::Clip clip = sim::simulate(garment, model, campaign.shapes[chain.shape], motion,
                                             chain.fabric, campaign.simulation, on_frame);
    if (clip.positions.size() < motion.frames.size()) return;  // interrupted
    Provenance provenance = provenance_of(campaign, "simulate",
                                          garment::to_text(chain.fabric) + campaign.settings +
                                              campaign.motions[chain.motion].settings,
                                          seed);
    provenance.inputs["motion"] = sha256_of_file(campaign.motions[chain.motion].file);
    garment::write_clip(shard_path(folder, chain.key), clip, chain.key, provenance);
    const std::lock_guard<std::mutex> lock(mutex);
    count_frames(clip, report);
    ++report.made;
  });
  report.is_interrupted = is_interrupted();
  return report;
}

}  // namespace pleat::campaign
