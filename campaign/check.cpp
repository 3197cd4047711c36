#include "campaign/check.h"

#include <filesystem>

#include "campaign/folder.h"
#include "campaign/manifest.h"
#include "core/error.h"
#include "core/hdf5_file.h"
#include "garment/clip.h"

namespace pleat::campaign {
namespace {

constexpr const char* kMissing = "missing";
constexpr const char* kLeftOver = "left over";

// A whole file under a name that is not its own is as bad as a damaged one.
std::string damage_of_clip(const std::string& path, const std::string& key) {
  const std::string damage = Hdf5File::damage_of(path);
  if (!damage.empty()) return damage;
  try {
    return garment::clip_key(path) == key ? "" : "of another chain";
  } catch (const InputError&) {
    return "no clip";
  }
}

}  // namespace

CheckReport check(const std::string& folder) {
  CheckReport report;
  const ManifestFile manifest = read_manifest(folder);
  const auto note = [&](const std::string& path, const std::string& damage) {
    if (damage.empty())
      ++report.files;
    else
      report.damages.push_back({path.substr(folder.size() + 1), damage});
  };
  for (const std::string& key : manifest.garment_keys) {
    const std::string path = garment_path(folder, key);
    note(path, Hdf5File::damage_of(path));
  }
  for (const ManifestRow& row : manifest.chains) {
    const std::string path = shard_path(folder, row.key);
    note(path, damage_of_clip(path, row.key));
    for (const std::string& name : names_in(parts_path(folder, row.key), ".h5")) {
      const std::string part = parts_path(folder, row.key) + "/" + name + ".h5";
      note(part, damage_of_clip(part, row.key));
    }
  }
  for (const std::string& path : leftovers(folder)) note(path, kLeftOver);
  return report;
}

void repair(const std::string& folder, const CheckReport& report) {
  for (const Damage& damage : report.damages) {
    const std::string path = folder + "/" + damage.file;
    if (damage.what == kLeftOver)
      std::filesystem::remove(path);
    else if (damage.what != kMissing)
      set_aside(folder, path);
  }
}

}  // namespace pleat::campaign
