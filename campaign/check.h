// Which files of a campaign are truncated, altered or missing, by their checksums.
#pragma once

#include <string>
#include <vector>

namespace pleat::campaign {

struct Damage {
  std::string file;  // in the campaign's folder
  std::string what;  // missing, truncated, altered, without a checksum, of another chain, left over
};

struct CheckReport {
  int files = 0;  // that are whole
  std::vector<Damage> damages;
};

// Reads every garment, shard and part of the manifest. Parts need not be there.
CheckReport check(const std::string& folder);

// Moves what is damaged to set_aside/, and removes what dead processes left half written, so that
// the next run makes it again.
void repair(const std::string& folder, const CheckReport& report);

}  // namespace pleat::campaign
