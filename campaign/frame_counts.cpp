#include "campaign/frame_counts.h"

namespace pleat::campaign {

void FrameCounts::add(const std::vector<garment::Certificate>& certificates) {
  for (const garment::Certificate& c : certificates) {
    ++frames;
    drape_seconds += c.seconds;
    if (c.is_accepted)
      ++accepted;
    else
      ++rejected[c.reason];
    retried += c.attempts > 1;
  }
}

}  // namespace pleat::campaign
