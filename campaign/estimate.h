// How long a campaign will take and how much it will fill, before it runs.
#pragma once

#include <string>
#include <vector>

#include "campaign/manifest.h"

namespace pleat::campaign {

struct Estimate {
  int64_t chains = 0, frames = 0;
  double core_hours = 0;  // for what is not there yet
  double bytes = 0;       // of all shards
  int64_t chains_left = 0;
  std::string source;  // where the seconds a frame are from
};

// frames: of each motion. bench: a file that `scripts/bench sim --json` wrote, or empty. Seconds a
// frame are those of the folder's own shards where there are some, else those of the bench file,
// else those of docs/performance.md.
Estimate estimate(const Campaign& campaign, const Manifest& manifest,
                  const std::vector<int>& frames, const std::string& folder,
                  const std::string& bench);

}  // namespace pleat::campaign
