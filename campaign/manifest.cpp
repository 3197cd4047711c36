#include "campaign/manifest.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/number_text.h"
#include "core/provenance.h"

namespace pleat::campaign {
namespace {

// Raised by hand when the numbers that simulation gives change for the same configuration.
constexpr int kNumericsVersion = 14;

constexpr size_t kKeyLength = 16;  // hexadecimal digits, 64 bits

std::string key_of(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += std::to_string(part.size()) + ":" + part + "\n";
  return sha256(text).substr(0, kKeyLength);
}

template <typename Named>
void check_names(const std::vector<Named>& items, const std::string& what) {
  std::set<std::string> names;
  for (const Named& item : items)
    if (!names.insert(item.name).second)
      throw InputError(what + ": the name '" + item.name +
                       "' is used twice; give each its own `name`");
}

// Every number of the wearer's shape, for keys and streams.
std::string shape_text(const Eigen::VectorXd& shape) {
  std::string text;
  for (double beta : shape) text += shortest_text(beta) + " ";
  return text;
}

}  // namespace

garment::Fabric fabric_of(const Campaign& campaign, const Chain& chain) {
  return garment::draw_fabric(campaign.fabric, campaign.seed,
                              campaign.motions[chain.motion].name + "/" +
                                  campaign.designs[chain.design].name + "/" +
                                  shape_text(campaign.shapes[chain.shape]));
}

Manifest plan(const Campaign& campaign) {
  check_names(campaign.designs, "designs");
  check_names(campaign.motions, "motions");
  const std::string body = sha256_of_file(campaign.body_file);
  const std::string settled = garment::to_text(garment::middle_fabric(campaign.fabric));
  Manifest manifest;
  for (const garment::Design& design : campaign.designs)
    manifest.garment_keys.push_back(
        key_of({"garment", std::to_string(kNumericsVersion), campaign.profile, body, settled,
                campaign.settings, std::to_string(campaign.garment_vertices), design.name,
                shortest_text(design.length), shortest_text(design.sleeve),
                shortest_text(design.cleavage)}));
  std::vector<std::string> shapes;
  for (const Eigen::VectorXd& shape : campaign.shapes) shapes.push_back(shape_text(shape));
  for (size_t m = 0; m < campaign.motions.size(); ++m) {
    const std::string motion = sha256_of_file(campaign.motions[m].file);
    for (size_t d = 0; d < campaign.designs.size(); ++d)
      for (size_t s = 0; s < campaign.shapes.size(); ++s) {
        Chain chain{"", static_cast<int>(d), static_cast<int>(s), static_cast<int>(m)};
        chain.key =
            key_of({"chain", manifest.garment_keys[d], shapes[s], campaign.motions[m].name, motion,
                    campaign.motions[m].settings, garment::to_text(fabric_of(campaign, chain))});
        manifest.chains.push_back(std::move(chain));
      }
  }
  std::set<std::string> keys;
  for (const Chain& chain : manifest.chains)
    if (!keys.insert(chain.key).second)
      throw InputError("shapes: one is given twice; every chain must differ from all others");
  return manifest;
}

void write_manifest(const std::string& folder, const Campaign& campaign, const Manifest& manifest) {
  nlohmann::ordered_json head = {{"pleat", version()},
                                 {"numerics", kNumericsVersion},
                                 {"profile", campaign.profile},
                                 {"chains", manifest.chains.size()}};
  for (size_t d = 0; d < campaign.designs.size(); ++d) {
    const garment::Design& design = campaign.designs[d];
    head["designs"].push_back({{"name", design.name},
                               {"length", design.length},
                               {"sleeve", design.sleeve},
                               {"cleavage", design.cleavage},
                               {"held_out", design.is_held_out},
                               {"garment", manifest.garment_keys[d]}});
  }
  std::string text = head.dump() + "\n";
  for (const Chain& chain : manifest.chains) {
    const Eigen::VectorXd& shape = campaign.shapes[chain.shape];
    const nlohmann::ordered_json row = {{"key", chain.key},
                                        {"garment", manifest.garment_keys[chain.design]},
                                        {"motion", campaign.motions[chain.motion].name},
                                        {"design", campaign.designs[chain.design].name},
                                        {"shape", std::vector<double>(shape.begin(), shape.end())}};
    text += row.dump() + "\n";
  }
  write_file_atomically(folder + "/manifest.jsonl", text);
}

namespace {

// Keys become parts of paths.
void check_key(const std::string& key) {
  if (key.size() != kKeyLength || key.find_first_not_of("0123456789abcdef") != std::string::npos)
    throw InputError("key = '" + key + "'; expected " + std::to_string(kKeyLength) +
                     " hexadecimal digits");
}

}  // namespace

ManifestFile read_manifest(const std::string& folder) {
  const std::string path = folder + "/manifest.jsonl";
  std::ifstream stream(path);
  if (!stream)
    throw InputError(path + ": cannot be read; is " + folder + " the folder of a campaign?");
  ManifestFile manifest;
  int number = 0;
  size_t planned = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    try {
      const nlohmann::json json = nlohmann::json::parse(line);
      if (number == 1) {
        manifest.profile = json.at("profile");
        planned = json.at("chains");
        for (const nlohmann::json& design : json.at("designs")) {
          manifest.garment_keys.push_back(design.at("garment"));
          check_key(manifest.garment_keys.back());
        }
        continue;
      }
      ManifestRow row{json.at("key"), json.at("garment"), json.at("motion"), json.at("design"),
                      json.at("shape")};
      check_key(row.key);
      check_key(row.garment_key);
      manifest.chains.push_back(std::move(row));
    } catch (const nlohmann::json::exception&) {
      throw InputError(path + ":" + std::to_string(number) + ": is no row of a manifest");
    } catch (const InputError& error) {
      throw InputError(path + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  if (number == 0) throw InputError(path + ": is empty");
  if (manifest.chains.size() != planned)
    throw InputError(path + ": holds " + std::to_string(manifest.chains.size()) + " of " +
                     std::to_string(planned) + " chains; `pleat plan` writes it anew");
  return manifest;
}

}  // namespace pleat::campaign
