#include "campaign/folder.h"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "core/error.h"

namespace pleat::campaign {
namespace fs = std::filesystem;

std::string garment_path(const std::string& folder, const std::string& key) {
  return folder + "/garments/" + key + ".h5";
}
std::string shard_path(const std::string& folder, const std::string& key) {
  return folder + "/shards/" + key + ".h5";
}
std::string parts_path(const std::string& folder, const std::string& key) {
  return folder + "/parts/" + key;
}
std::string part_path(const std::string& folder, const std::string& key, int first_frame) {
  char name[16];
  std::snprintf(name, sizeof name, "%07d.h5", first_frame);
  return parts_path(folder, key) + "/" + name;
}
std::string failure_path(const std::string& folder, const std::string& key) {
  return folder + "/failures/" + key + ".json";
}

bool has_failed(const std::string& folder, const std::string& key, const std::string& garment_key) {
  return fs::exists(failure_path(folder, key)) || (fs::exists(failure_path(folder, garment_key)) &&
                                                   !fs::exists(garment_path(folder, garment_key)));
}

std::string set_aside(const std::string& folder, const std::string& path) {
  fs::create_directories(folder + "/set_aside");
  const std::string name = fs::path(path).filename().string();
  for (int k = 1;; ++k) {
    const std::string target = folder + "/set_aside/" + std::to_string(k) + "_" + name;
    if (fs::exists(target)) continue;
    if (::renameat2(AT_FDCWD, path.c_str(), AT_FDCWD, target.c_str(), RENAME_NOREPLACE) == 0)
      return target;
    if (errno == EEXIST) continue;
    if (errno == ENOENT) return target;  // another process has done it
    std::error_code error;
    if (errno == EINVAL) fs::rename(path, target, error);  // a file system that cannot
    if (errno != EINVAL || error)
      throw InputError(path + ": cannot be moved to set_aside/: " + std::strerror(errno));
    return target;
  }
}

std::vector<std::string> names_in(const std::string& folder, const std::string& ending) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ending) names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> leftovers(const std::string& folder) {
  const auto limit = fs::file_time_type::clock::now() - std::chrono::hours(1);
  std::vector<std::string> paths;
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    std::error_code gone;
    const std::string path = at->path().string();
    const bool is_temporary = at->path().filename().string().find(".tmp-") != std::string::npos &&
                              at->is_regular_file(gone);
    if (is_temporary && fs::last_write_time(path, gone) < limit && !gone) paths.push_back(path);
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string size_text(double bytes) {
  const bool is_large = bytes >= 1e9;
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %s", bytes * (is_large ? 1e-9 : 1e-6),
                is_large ? "GB" : "MB");
  return text;
}

void require_space(const std::string& folder, double bytes, int min_free_mb) {
  const double reserve = 1e6 * min_free_mb;
  std::error_code error;
  const double available = static_cast<double>(fs::space(folder, error).available);
  if (error || bytes + reserve <= available) return;
  throw ResourceError(
      folder + ": " + size_text(available) + " are free, about " + size_text(bytes) +
      " are needed and " + size_text(reserve) +
      " to stay free (limits.min_free_disk_mb); make room and give the same command "
      "again");
}

}  // namespace pleat::campaign
