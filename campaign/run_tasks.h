// Runs what a manifest asks for and no file holds yet. A file under its key is done: files appear
// whole or not at all.
#pragma once

#include <map>
#include <string>

#include "campaign/manifest.h"

namespace pleat::campaign {

struct RunReport {
  int made = 0, kept = 0;                   // garments or chains: made now, found done
  int64_t frames = 0, accepted = 0;         // of all chains, made now or before
  std::map<std::string, int64_t> rejected;  // frames by reason
  double drape_seconds = 0;     // processor time of all frames' drapes, easing in included
  bool is_interrupted = false;  // by the user: run again to go on
};

// Reads the body, every motion and every shape as the runs below will, so that a bad one is known
// before hours of work. InputError.
void check_inputs(const Campaign& campaign);

// Each design, sewn and settled on the mean body: folder/garments/<key>.h5. threads 0: all cores,
// one garment each.
RunReport settle_garments(const Campaign& campaign, const Manifest& manifest,
                          const std::string& folder, uint64_t seed, int threads);

// Each chain: folder/shards/<key>.h5. A chain takes one thread; which one, and in which order,
// changes no bit.
RunReport run_chains(const Campaign& campaign, const Manifest& manifest, const std::string& folder,
                     uint64_t seed, int threads);

}  // namespace pleat::campaign
