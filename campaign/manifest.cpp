#include "campaign/manifest.h"

#include <iomanip>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "core/error.h"
#include "core/provenance.h"

namespace pleat::campaign {
namespace {

// Raised by hand when the numbers that simulation gives change for the same configuration.
constexpr int kNumericsVersion = 4;

constexpr size_t kKeyLength = 16;  // hexadecimal digits, 64 bits

std::string exact(double number) {
  std::ostringstream text;
  text << std::setprecision(17) << number;
  return text.str();
}

std::string key_of(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += std::to_string(part.size()) + ":" + part + "\n";
  return sha256(text).substr(0, kKeyLength);
}

// Of a measured fabric without its tables, which the clip holds.
nlohmann::ordered_json numbers_of(const garment::Fabric& fabric) {
  nlohmann::ordered_json json = {{"density_kg_per_m2", fabric.density_kg_per_m2},
                                 {"friction", fabric.friction}};
  if (fabric.tables) return json;
  json["membrane"] = garment::name_of(fabric.membrane);
  json["youngs_modulus_N_per_m"] = fabric.youngs_modulus_N_per_m;
  json["poisson_ratio"] = fabric.poisson_ratio;
  json["bending_N_m"] = fabric.bending_N_m;
  return json;
}

template <typename Named>
void check_names(const std::vector<Named>& items, const std::string& what) {
  std::set<std::string> names;
  for (const Named& item : items)
    if (!names.insert(item.name).second)
      throw InputError(what + ": the name '" + item.name +
                       "' is used twice; give each its own `name`");
}

}  // namespace

Manifest plan(const Campaign& campaign) {
  check_names(campaign.designs, "designs");
  check_names(campaign.motions, "motions");
  const std::string body = sha256_of_file(campaign.body_file);
  const std::string settled = garment::to_text(garment::middle_fabric(campaign.fabric));
  Manifest manifest;
  for (const garment::Design& design : campaign.designs)
    manifest.garment_keys.push_back(
        key_of({"garment", std::to_string(kNumericsVersion), body, settled, campaign.settings,
                std::to_string(campaign.garment_vertices), design.name, exact(design.length),
                exact(design.sleeve), exact(design.cleavage)}));
  for (size_t m = 0; m < campaign.motions.size(); ++m) {
    const std::string motion = sha256_of_file(campaign.motions[m].file);
    for (size_t d = 0; d < campaign.designs.size(); ++d)
      for (size_t s = 0; s < campaign.shapes.size(); ++s) {
        std::string shape;
        for (double beta : campaign.shapes[s]) shape += exact(beta) + " ";
        const garment::Fabric fabric = garment::draw_fabric(
            campaign.fabric, campaign.seed,
            campaign.motions[m].name + "/" + campaign.designs[d].name + "/" + shape);
        const std::string key =
            key_of({"chain", manifest.garment_keys[d], shape, campaign.motions[m].name, motion,
                    campaign.motions[m].settings, garment::to_text(fabric)});
        manifest.chains.push_back(
            {key, static_cast<int>(d), static_cast<int>(s), static_cast<int>(m), fabric});
      }
  }
  return manifest;
}

std::string garment_path(const std::string& folder, const std::string& key) {
  return folder + "/garments/" + key + ".h5";
}
std::string shard_path(const std::string& folder, const std::string& key) {
  return folder + "/shards/" + key + ".h5";
}

void write_manifest(const std::string& path, const Campaign& campaign, const Manifest& manifest) {
  nlohmann::ordered_json json;
  json["designs"] = nlohmann::ordered_json::array();
  for (size_t d = 0; d < campaign.designs.size(); ++d) {
    const garment::Design& design = campaign.designs[d];
    json["designs"].push_back({{"name", design.name},
                               {"length", design.length},
                               {"sleeve", design.sleeve},
                               {"cleavage", design.cleavage},
                               {"held_out", design.is_held_out},
                               {"garment", manifest.garment_keys[d]}});
  }
  json["chains"] = nlohmann::ordered_json::array();
  for (const Chain& chain : manifest.chains)
    json["chains"].push_back({{"key", chain.key},
                              {"motion", campaign.motions[chain.motion].name},
                              {"design", campaign.designs[chain.design].name},
                              {"shape", std::vector<double>(campaign.shapes[chain.shape].begin(),
                                                            campaign.shapes[chain.shape].end())},
                              {"fabric", numbers_of(chain.fabric)}});
  write_file_atomically(path, json.dump(2) + "\n");
}

}  // namespace pleat::campaign
