#include "campaign/estimate.h"

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "campaign/folder.h"
#include "campaign/frame_counts.h"
#include "campaign/run_tasks.h"
#include "core/error.h"
#include "garment/clip.h"

namespace pleat::campaign {
namespace {

// Of one core, at so many vertices.
struct Pace {
  double vertices = 5000;
  double s_a_frame = 1.5, s_a_start = 10;  // a start: into the first pose. docs/performance.md
  std::string source = "docs/performance.md; `scripts/bench sim --json FILE` measures this machine";
};

constexpr double kGrowth = 1.25;  // seconds go with vertices to this power
constexpr int kSampled = 50;      // shards looked at

// All frames of what is there, starts among them.
bool pace_of_shards(const std::string& folder, const std::set<std::string>& keys, Pace& pace) {
  FrameCounts counts;
  int shards = 0;
  for (const std::string& name : names_in(folder + "/shards", ".h5")) {
    if (!keys.count(name)) continue;
    try {
      counts.add(garment::read_clip_head(shard_path(folder, name)).certificates);
    } catch (const InputError&) {  // simulate makes it again
      continue;
    }
    if (++shards == kSampled) break;
  }
  if (counts.frames == 0) return false;
  pace.s_a_frame = counts.drape_seconds / static_cast<double>(counts.frames);
  pace.s_a_start = 0;
  pace.source = std::to_string(shards) + " of its own shards";
  return true;
}

void pace_of_bench(const std::string& file, Pace& pace) {
  std::ifstream stream(file);
  if (!stream) throw InputError(file + ": cannot be read");
  const nlohmann::json rows = nlohmann::json::parse(stream, nullptr, false);
  std::map<std::string, double> values;
  if (rows.is_array())
    for (const nlohmann::json& row : rows)
      if (row.is_object() && row.contains("name") && row.contains("value") &&
          row["name"].is_string() && row["value"].is_number())
        values[row["name"]] = row["value"];
  if (!values.count("sim.warm_5k.mean_core_s") || !values.count("sim.ease_in_5k.core_s"))
    throw InputError(file +
                     ": holds no rows sim.warm_5k.mean_core_s and sim.ease_in_5k.core_s; "
                     "`scripts/bench sim --json " +
                     file + "` writes them");
  pace.s_a_frame = values["sim.warm_5k.mean_core_s"];
  pace.s_a_start = values["sim.ease_in_5k.core_s"];
  pace.source = file;
}

}  // namespace

Estimate estimate(const Campaign& campaign, const Manifest& manifest,
                  const std::vector<int>& frames, const std::string& folder,
                  const std::string& bench) {
  std::set<std::string> keys;
  for (const Chain& chain : manifest.chains) keys.insert(chain.key);
  Pace pace;
  if (!bench.empty()) pace_of_bench(bench, pace);
  const bool is_own = pace_of_shards(folder, keys, pace);
  const double scale = is_own ? 1 : std::pow(campaign.garment_vertices / pace.vertices, kGrowth);

  Estimate result;
  result.source = pace.source;
  const std::vector<std::string> done = names_in(folder + "/shards", ".h5");
  const std::set<std::string> is_done(done.begin(), done.end());
  double seconds = 0;
  for (const Chain& chain : manifest.chains) {
    const int length = frames.at(chain.motion);
    ++result.chains;
    result.frames += length;
    result.bytes +=
        shard_bytes(length, campaign.garment_vertices, campaign.simulation.checkpoint_frames);
    if (is_done.count(chain.key)) continue;
    ++result.chains_left;
    seconds += scale * (pace.s_a_start + length * pace.s_a_frame);
  }
  result.core_hours = seconds / 3600;
  return result;
}

}  // namespace pleat::campaign
