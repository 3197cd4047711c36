// What lies where in a campaign's folder.
//   manifest.jsonl            what there is to be
//   garments/KEY.h5           a design, settled on the mean body
//   shards/KEY.h5             a chain: its drapes
//   parts/KEY/FRAME.h5        what there is of a chain that is not finished
//   failures/KEY.json         why a design came to nothing
//   set_aside/                damaged and superseded files; nothing reads them
#pragma once

#include <string>
#include <vector>

namespace pleat::campaign {

std::string garment_path(const std::string& folder, const std::string& key);
std::string shard_path(const std::string& folder, const std::string& key);
std::string parts_path(const std::string& folder, const std::string& key);
std::string part_path(const std::string& folder, const std::string& key, int first_frame);
std::string failure_path(const std::string& folder, const std::string& key);
// A chain came to nothing where it or its garment did.
bool has_failed(const std::string& folder, const std::string& key, const std::string& garment_key);

// Moves a file to set_aside/ under a name that is free there. Returns that.
std::string set_aside(const std::string& folder, const std::string& path);

// Names without folder and ending of the files with that ending, sorted; none where the folder is
// not there.
std::vector<std::string> names_in(const std::string& folder, const std::string& ending);

// Files that a process which died left half written, an hour old or more.
std::vector<std::string> leftovers(const std::string& folder);

std::string size_text(double bytes);  // "1.25 GB", "300 MB"

// Throws ResourceError where writing `bytes` to the folder would leave less than so much free.
void require_space(const std::string& folder, double bytes, int min_free_mb);

}  // namespace pleat::campaign
