// One face over a campaign's shards, written once all of them are there and whole.
//   index.h5          /chains/KEY shows the shard of that name; HDF5 readers follow the links
//   index.json        counts and the content hash
//   SHA256SUMS        of every file, for `sha256sum -c`
//   README.md         data card
//   croissant.json    what files there are, in Croissant's JSON-LD
#pragma once

#include <set>
#include <string>
#include <vector>

#include "campaign/frame_counts.h"

namespace pleat::campaign {

struct IndexConfig {
  // What a data set may be without: reasons of rejected frames, "failed" for chains that came to
  // nothing, "missing" for such as are not simulated, "any" for all of these.
  std::set<std::string> accept;
};

struct IndexReport : FrameCounts {
  int chains = 0;
  std::string
      content_hash;  // of all drapes: the same wherever and in whichever order they were made
};

// InputError that names what is missing, damaged or rejected and not accepted; then nothing is
// written.
IndexReport write_index(const std::string& folder, const IndexConfig& config);

}  // namespace pleat::campaign
