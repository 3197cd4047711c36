// How far a campaign is, from its folder alone.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "campaign/frame_counts.h"

namespace pleat::campaign {

struct Failure {  // a chain that came to nothing
  std::string key, motion, design, what;
};

struct Status : FrameCounts {  // of chains that are done; drape_seconds of the others too
  std::string folder;
  int chains = 0, done = 0, under_way = 0;
  std::vector<Failure> failures;
  std::vector<std::string> unreadable;  // shards
  int64_t frames_under_way = 0;         // in parts of the others
};

// InputError where the folder holds no manifest.
Status status_of(const std::string& folder);
std::string to_text(const Status& status);  // for people, several lines
std::string to_json(const Status& status);

}  // namespace pleat::campaign
