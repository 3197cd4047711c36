#include "campaign/status.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "campaign/folder.h"
#include "campaign/manifest.h"
#include "core/error.h"
#include "core/progress.h"
#include "garment/clip.h"

namespace pleat::campaign {
namespace {

// Of the chain, or else of its garment.
Failure read_failure(const std::string& folder, const ManifestRow& row) {
  std::ifstream stream(failure_path(folder, row.key));
  if (!stream) stream.open(failure_path(folder, row.garment_key));
  const nlohmann::json json = nlohmann::json::parse(stream, nullptr, false);
  const bool is_readable = json.is_object() && json.contains("what") && json["what"].is_string();
  return {row.key, row.motion, row.design,
          is_readable ? json["what"].get<std::string>() : "its record cannot be read"};
}

// None where the file cannot be read, which `unreadable` is told.
std::vector<garment::Certificate> certificates_of(const std::string& path,
                                                  std::vector<std::string>& unreadable) {
  try {
    return garment::read_clip_head(path).certificates;
  } catch (const InputError&) {
    unreadable.push_back(path);
    return {};
  }
}

std::string line(const char* name, const std::string& text) {
  char head[32];
  std::snprintf(head, sizeof head, "  %-16s", name);
  return head + text + "\n";
}

}  // namespace

Status status_of(const std::string& folder) {
  Status status;
  std::vector<std::string> gone;  // parts that became a shard while we looked
  status.folder = folder;
  const ManifestFile manifest = read_manifest(folder);
  const auto set_of = [&](const char* name, const char* ending) {
    const std::vector<std::string> names = names_in(folder + name, ending);
    return std::set<std::string>(names.begin(), names.end());
  };
  const std::set<std::string> shards = set_of("/shards", ".h5"), parts = set_of("/parts", ""),
                              failures = set_of("/failures", ".json");
  status.chains = static_cast<int>(manifest.chains.size());
  for (const ManifestRow& row : manifest.chains) {
    if (shards.count(row.key)) {
      ++status.done;
      status.add(certificates_of(shard_path(folder, row.key), status.unreadable));
    } else if (failures.count(row.key) ||
               (failures.count(row.garment_key) && has_failed(folder, row.key, row.garment_key))) {
      status.failures.push_back(read_failure(folder, row));
    } else if (parts.count(row.key)) {
      ++status.under_way;
      FrameCounts counts;
      for (const std::string& name : names_in(parts_path(folder, row.key), ".h5"))
        counts.add(certificates_of(parts_path(folder, row.key) + "/" + name + ".h5", gone));
      status.frames_under_way += counts.frames;
      status.drape_seconds += counts.drape_seconds;
    }
  }
  return status;
}

std::string to_text(const Status& status) {
  const auto number = [](int64_t count) { return std::to_string(count); };
  const int left = status.chains - status.done - static_cast<int>(status.failures.size());
  std::string text = status.folder + "\n";
  text += line("chains", number(status.done) + " of " + number(status.chains) + " done, " +
                             number(status.under_way) + " under way, " +
                             number(static_cast<int64_t>(status.failures.size())) + " failed");
  char share[32] = "";
  if (status.frames > 0)
    std::snprintf(share, sizeof share, " (%.1f %%)", 100.0 * status.accepted / status.frames);
  text += line("frames", number(status.frames) + " in chains that are done, " +
                             number(status.accepted) + " accepted" + share);
  for (const auto& [reason, count] : status.rejected)
    text += line("", number(count) + " " + reason);
  if (status.retried > 0)
    text += line("", number(status.retried) + " accepted in another way than the first");
  const int64_t frames = status.frames + status.frames_under_way;
  if (frames > 0) {
    char seconds[96];
    std::snprintf(seconds, sizeof seconds, "%s of one core, %.2f s a frame",
                  duration_text(status.drape_seconds).c_str(), status.drape_seconds / frames);
    text += line("time", seconds);
  }
  if (status.done > 0 && left > 0) {
    const double a_chain = status.drape_seconds / (status.done + 0.5 * status.under_way);
    text += line("left",
                 number(left) + " chains, about " + duration_text(left * a_chain) + " of one core");
  }
  for (const Failure& failure : status.failures)
    text += line("failed", failure.key + " (" + failure.motion + ", " + failure.design +
                               "): " + failure.what);
  for (const std::string& path : status.unreadable)
    text += line("damaged", path + "; pleat check " + status.folder + " --repair");
  const std::string next = left > 0                   ? "pleat simulate " + status.folder
                           : !status.failures.empty() ? "pleat rerun " + status.folder + " --failed"
                                                      : "pleat index " + status.folder;
  return text + line("next", next);
}

std::string to_json(const Status& status) {
  nlohmann::ordered_json json = {{"folder", status.folder},
                                 {"chains", status.chains},
                                 {"done", status.done},
                                 {"under_way", status.under_way},
                                 {"failed", status.failures.size()},
                                 {"frames", status.frames},
                                 {"accepted", status.accepted},
                                 {"retried", status.retried},
                                 {"frames_under_way", status.frames_under_way},
                                 {"drape_seconds", status.drape_seconds}};
  json["rejected"] = nlohmann::ordered_json::object();
  for (const auto& [reason, count] : status.rejected) json["rejected"][reason] = count;
  json["unreadable"] = status.unreadable;
  json["failures"] = nlohmann::ordered_json::array();
  for (const Failure& f : status.failures)
    json["failures"].push_back(
        {{"key", f.key}, {"motion", f.motion}, {"design", f.design}, {"what", f.what}});
  return json.dump(2) + "\n";
}

}  // namespace pleat::campaign
