// What a campaign costs besides its drapes: planning, looking at, and indexing many chains.
#include <sys/resource.h>

#include <chrono>
#include <filesystem>
#include <functional>

#include "campaign/check.h"
#include "campaign/estimate.h"
#include "campaign/index.h"
#include "campaign/run_tasks.h"
#include "campaign/status.h"
#include "tests/benchmarks/bench.h"
#include "tests/campaign/campaign_files.h"

namespace pleat::bench {
namespace {

double seconds_of(const std::function<void()>& action) {
  const auto start = std::chrono::steady_clock::now();
  action();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss * 1e-3;
}

// So many designs, shapes and motions on the box body.
campaign::Campaign many(const campaign::CampaignFiles& files, int designs, int shapes,
                        int motions) {
  campaign::Campaign campaign = files.campaign;
  campaign.designs.clear();
  campaign.shapes.clear();
  campaign.motions.clear();
  for (int k = 0; k < designs; ++k)
    campaign.designs.push_back({"design" + std::to_string(k), 0.3, 0.2, 0.01 * k, false});
  for (int k = 0; k < shapes; ++k) campaign.shapes.push_back(Vec<3>(0.01 * k, 0, 0));
  for (int k = 0; k < motions; ++k) {
    campaign::MotionSource source = files.campaign.motions[0];
    source.name = "motion" + std::to_string(k);
    campaign.motions.push_back(source);
  }
  campaign.fabric.friction = garment::Range(0.2, 0.5);  // drawn for each chain
  return campaign;
}

}  // namespace

void bench_campaign(Report& report) {
  const campaign::CampaignFiles files;
  {
    const campaign::Campaign campaign = many(files, 20, 100, 50);
    const std::string folder = files.scratch.path("plan");
    std::filesystem::create_directories(folder);
    const double before = memory_mb();
    report.add("campaign.plan_100k.s", seconds_of([&] {
                 const campaign::Manifest manifest = campaign::plan(campaign);
                 campaign::estimate(campaign, manifest, campaign::check_inputs(campaign), folder,
                                    "");
                 campaign::write_manifest(folder, campaign, manifest);
               }),
               "s");
    report.add("campaign.plan_100k.memory_mb", memory_mb() - before, "MB");
  }
  const campaign::Campaign campaign = many(files, 10, 20, 10);
  const campaign::Manifest manifest = campaign::plan(campaign);
  const std::string folder = files.scratch.path("shards_2000");
  std::filesystem::create_directories(folder + "/garments");
  campaign::write_manifest(folder, campaign, manifest);
  garment::Clip clip;
  for (int t = 0; t < 20; ++t) {
    clip.poses.emplace_back();
    clip.positions.push_back(Points3::Random(1000, 3));
    clip.certificates.emplace_back();
    clip.certificates.back().is_accepted = true;
  }
  clip.shape = Vec<3>(0, 0, 0);
  std::filesystem::create_directories(folder + "/shards");
  for (const campaign::Chain& chain : manifest.chains)
    garment::write_clip(campaign::shard_path(folder, chain.key), clip, chain.key, {});
  report.add("campaign.status_2000.s", seconds_of([&] { campaign::status_of(folder); }), "s");
  report.add("campaign.check_2000.s", seconds_of([&] { campaign::check(folder); }), "s");
  report.add("campaign.index_2000.s", seconds_of([&] { campaign::write_index(folder, {{"any"}}); }),
             "s");
}

}  // namespace pleat::bench
