#include "campaign/index.h"

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "campaign/folder.h"
#include "campaign/manifest.h"
#include "core/error.h"
#include "core/hdf5_file.h"
#include "core/provenance.h"
#include "garment/clip.h"

namespace pleat::campaign {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Everything that the files below tell.
struct Contents {
  ManifestFile manifest;
  std::vector<const ManifestRow*> rows;  // whose shards there are
  std::set<std::string> motions, designs, machines, commits;
  double frame_rate_hz = 0;
  int64_t vertices = 0;
  IndexReport report;
};

// Counts of what there is not, by class.
struct Lacks {
  std::map<std::string, int64_t> counts;
  std::map<std::string, std::string> first;  // where the first of each is
  void add(const std::string& what, const std::string& where) {
    if (counts[what]++ == 0) first[what] = where;
  }
};

void refuse_lacks(const std::string& folder, const Lacks& lacks, const IndexConfig& config) {
  std::string text, options;
  for (const auto& [what, count] : lacks.counts) {
    if (config.accept.count(what) || config.accept.count("any")) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + what +
            " (first: " + lacks.first.at(what) + ")";
    options += " --accept '" + what + "'";
  }
  if (text.empty()) return;
  throw InputError(folder + ": " + text +
                   ". Run `pleat simulate` or `pleat rerun` for what is "
                   "missing or failed; to have an index all the same: pleat index " +
                   folder + options);
}

Contents read_contents(const std::string& folder, const IndexConfig& config) {
  Contents contents;
  contents.manifest = read_manifest(folder);
  Lacks lacks;
  std::string damaged, hashes;
  for (const ManifestRow& row : contents.manifest.chains) {
    const std::string path = shard_path(folder, row.key);
    const std::string damage = Hdf5File::damage_of(path);
    if (damage == "missing") {
      lacks.add(has_failed(folder, row.key, row.garment_key) ? "failed" : "missing", row.key);
      continue;
    }
    if (!damage.empty()) {
      damaged += (damaged.empty() ? "" : ", ") + row.key + " " + damage;
      continue;
    }
    const Hdf5File file = Hdf5File::open(path);
    if (file.text_attribute("/", "key") != row.key) {
      damaged += (damaged.empty() ? "" : ", ") + row.key + " of another chain";
      continue;
    }
    const garment::Clip clip = garment::read_clip_head(path);
    contents.rows.push_back(&row);
    contents.motions.insert(row.motion);
    contents.designs.insert(row.design);
    contents.machines.insert(file.text_attribute("/", "machine"));
    contents.commits.insert(file.text_attribute("/", "commit"));
    contents.frame_rate_hz = clip.frame_rate_hz;
    contents.vertices = file.dims("positions")[1];
    IndexReport& report = contents.report;
    ++report.chains;
    report.add(clip.certificates);
    for (size_t t = 0; t < clip.certificates.size(); ++t)
      if (!clip.certificates[t].is_accepted)
        lacks.add(clip.certificates[t].reason, row.key + ":" + std::to_string(t));
    hashes += row.key + " " + garment::content_hash(row.key, clip.frame_sha256) + "\n";
  }
  for (const std::string& key : contents.manifest.garment_keys) {
    const std::string damage = Hdf5File::damage_of(garment_path(folder, key));
    if (damage.empty() || fs::exists(failure_path(folder, key))) continue;
    if (damage == "missing")
      lacks.add("missing", "garment " + key);
    else
      damaged += (damaged.empty() ? "" : ", ") + key + " " + damage;
  }
  if (!damaged.empty())
    throw InputError(folder + ": damaged: " + damaged + "; pleat check " + folder +
                     " --repair sets them aside, and pleat simulate makes them again");
  refuse_lacks(folder, lacks, config);
  if (contents.rows.empty()) throw InputError(folder + ": there is no shard to index");
  contents.report.content_hash = sha256(hashes);
  return contents;
}

std::string join(const std::set<std::string>& items) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : ", ") + item;
  return text;
}

std::string data_card(const Contents& contents) {
  const IndexReport& report = contents.report;
  const auto row = [](const std::string& name, const std::string& value) {
    return "| " + name + " | " + value + " |\n";
  };
  char share[32], seconds[32], rate[32];
  std::snprintf(share, sizeof share, "%.2f %%", 100.0 * report.accepted / report.frames);
  std::snprintf(seconds, sizeof seconds, "%.2f", report.drape_seconds / report.frames);
  std::snprintf(rate, sizeof rate, "%g", contents.frame_rate_hz);
  std::string text =
      "# Static drapes of garments\n\n"
      "Made by Pleat " +
      version() +
      ". Each shard is one design on one body shape through one "
      "motion: for every frame the static equilibrium of the garment, with its certificate. Open "
      "`index.h5`: `/chains/KEY` is the shard of that key, SI units, y up.\n\n"
      "| | |\n| --- | --- |\n";
  text += row("chains", std::to_string(report.chains) + " of " +
                            std::to_string(contents.manifest.chains.size()) + " planned");
  text += row("frames", std::to_string(report.frames) + " at " + rate + " Hz");
  text += row("accepted", std::to_string(report.accepted) + " (" + share + ")");
  for (const auto& [reason, count] : report.rejected)
    text += row("rejected: " + reason, std::to_string(count));
  text += row("vertices", std::to_string(contents.vertices));
  text += row("designs", std::to_string(contents.designs.size()) + ": " + join(contents.designs));
  text += row("motions", std::to_string(contents.motions.size()) + ": " + join(contents.motions));
  text += row("core-seconds a frame", seconds);
  text += row("arithmetic", contents.manifest.profile);
  text += row("machines", join(contents.machines));
  text += row("commits", join(contents.commits));
  text += row("content hash", "`" + report.content_hash + "`");
  text +=
      "\nA frame is to be trusted where `is_accepted` is 1: in equilibrium (`certificates`, column "
      "0: force imbalance over weight), stable, free of intersections by exact tests, not "
      "overstretched. Rejected frames are kept with their reason; leave them out of training.\n\n"
      "`sha256sum -c SHA256SUMS` checks every file. `config.yaml` is all that is needed to make "
      "the same drapes again, besides the body and the motions, whose hashes each shard holds. The "
      "licences of those two decide about passing this data set on.\n";
  return text;
}

Json croissant(const Contents& contents,
               const std::vector<std::pair<std::string, std::string>>& sums,
               const std::string& folder) {
  Json json = {{"@context",
                {{"@language", "en"},
                 {"@vocab", "https://schema.org/"},
                 {"sc", "https://schema.org/"},
                 {"cr", "http://mlcommons.org/croissant/"},
                 {"dct", "http://purl.org/dc/terms/"},
                 {"conformsTo", "dct:conformsTo"},
                 {"fileObject", "cr:fileObject"}}},
               {"@type", "sc:Dataset"},
               {"conformsTo", "http://mlcommons.org/croissant/1.0"},
               {"name", fs::path(folder).filename().string()},
               {"description", std::to_string(contents.report.frames) +
                                   " static drapes of parametric garments on posed bodies, each "
                                   "with its certificate."},
               {"version", version()}};
  for (const auto& [file, sum] : sums) {
    Json object = {{"@type", "cr:FileObject"},
                   {"@id", file},
                   {"name", file},
                   {"contentUrl", file},
                   {"contentSize", std::to_string(fs::file_size(folder + "/" + file)) + " B"},
                   {"encodingFormat", file.size() > 3 && file.substr(file.size() - 3) == ".h5"
                                          ? "application/x-hdf5"
                                          : "text/plain"},
                   {"sha256", sum}};
    json["distribution"].push_back(std::move(object));
  }
  return json;
}

}  // namespace

IndexReport write_index(const std::string& folder, const IndexConfig& config) {
  const Contents contents = read_contents(folder, config);
  const IndexReport& report = contents.report;

  Hdf5File face = Hdf5File::create(folder + "/index.h5");
  std::vector<std::string> keys, motions, designs;
  for (const ManifestRow* row : contents.rows) {
    face.link("chains/" + row->key, "shards/" + row->key + ".h5", "/");
    keys.push_back(row->key);
    motions.push_back(row->motion);
    designs.push_back(row->design);
  }
  face.write("key", keys);
  face.write("motion", motions);
  face.write("design", designs);
  face.write_attribute("/", "content_sha256", report.content_hash);
  face.commit();

  Json json = {{"chains", report.chains},
               {"frames", report.frames},
               {"accepted", report.accepted},
               {"rejected", Json::object()},
               {"profile", contents.manifest.profile},
               {"content_sha256", report.content_hash}};
  for (const auto& [reason, count] : report.rejected) json["rejected"][reason] = count;
  write_file_atomically(folder + "/index.json", json.dump(2) + "\n");
  write_file_atomically(folder + "/README.md", data_card(contents));

  std::vector<std::pair<std::string, std::string>> sums;
  const auto add = [&](const std::string& file) {
    if (fs::exists(folder + "/" + file))
      sums.emplace_back(file, sha256_of_file(folder + "/" + file));
  };
  for (const char* file : {"config.yaml", "manifest.jsonl", "index.h5", "index.json", "README.md"})
    add(file);
  for (const std::string& key : contents.manifest.garment_keys) add("garments/" + key + ".h5");
  for (const ManifestRow* row : contents.rows) add("shards/" + row->key + ".h5");
  std::string text;
  for (const auto& [file, sum] : sums) text += sum + "  " + file + "\n";
  write_file_atomically(folder + "/SHA256SUMS", text);
  write_file_atomically(folder + "/croissant.json",
                        croissant(contents, sums, folder).dump(2) + "\n");
  return report;
}

}  // namespace pleat::campaign
