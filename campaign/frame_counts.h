// What the frames of some chains came to.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "garment/clip.h"

namespace pleat::campaign {

struct FrameCounts {
  int64_t frames = 0, accepted = 0;
  int64_t retried = 0;                      // accepted in another way than the first
  std::map<std::string, int64_t> rejected;  // by reason
  double drape_seconds = 0;                 // processor time, easing in included

  void add(const std::vector<garment::Certificate>& certificates);
};

}  // namespace pleat::campaign
