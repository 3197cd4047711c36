#include "garment/fabric_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "core/error.h"

namespace pleat::garment {
namespace {

using Json = nlohmann::json;

constexpr double kMost = 1e9;  // of any number: aluminium foil has 2e6 N/m

double number(const Json& json, const std::string& key, double least, const char* expected) {
  if (!json.is_number()) throw InputError(key + ": is not a number; expected " + expected);
  const double value = json.get<double>();
  if (value >= least && value <= kMost) return value;
  std::ostringstream message;
  message << key << " = " << value << "; expected " << expected;
  throw InputError(message.str());
}

template <size_t Rows, size_t Columns>
void read_table(const Json& json, const std::string& key,
                std::array<std::array<double, Columns>, Rows>& table) {
  const std::string shape =
      std::to_string(Rows) + " lists of " + std::to_string(Columns) + " numbers";
  if (!json.is_array() || json.size() != Rows)
    throw InputError(key + ": is not a list of " + shape);
  for (size_t r = 0; r < Rows; ++r) {
    const std::string row = key + "[" + std::to_string(r) + "]";
    if (!json[r].is_array() || json[r].size() != Columns)
      throw InputError(row + ": " + key + " has " + shape);
    for (size_t c = 0; c < Columns; ++c)
      table[r][c] = number(json[r][c], row + "[" + std::to_string(c) + "]", -kMost,
                           "a number of -1e9 .. 1e9");
  }
}

const Json& required(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end()) throw InputError(std::string(key) + ": missing");
  return *found;
}

// ARCSim's scene files scale a material; here the file itself may.
double multiplier(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found == json.end() ? 1 : number(*found, key, 1e-9, "> 0");
}

MeasuredFabric parse(const std::string& text) {
  const Json json = Json::parse(text, nullptr, true, /*ignore_comments=*/true);
  if (!json.is_object()) throw InputError("is not a map of keys and values");
  for (const auto& [key, value] : json.items()) {
    // The second row is about motion and plasticity, or for people.
    static const char* const kKnown[] = {
        "density",      "stretching",    "bending",      "density_mult",  "stretching_mult",
        "bending_mult", "thicken",       "damping",      "strain_limits", "yield_curv",
        "weakening",    "yield_stretch", "plastic_flow", "plastic_limit", "name",
        "description",  "source",        "composition"};
    if (std::find(std::begin(kKnown), std::end(kKnown), key) == std::end(kKnown))
      throw InputError(key +
                       ": is no known key; a measured fabric has density, stretching, "
                       "bending, and its multipliers");
  }
  MeasuredFabric fabric;
  const double thicken = multiplier(json, "thicken");
  fabric.density_kg_per_m2 = number(required(json, "density"), "density", 1e-6, "> 0, kg/m^2") *
                             multiplier(json, "density_mult") * thicken;
  read_table(required(json, "stretching"), "stretching", fabric.tables.stretching);
  read_table(required(json, "bending"), "bending", fabric.tables.bending);
  validate(fabric.tables);
  const double stretching = multiplier(json, "stretching_mult") * thicken;
  const double bending = multiplier(json, "bending_mult") * thicken;
  for (auto& row : fabric.tables.stretching)
    for (double& stiffness : row) stiffness *= stretching;
  for (auto& row : fabric.tables.bending)
    for (double& rigidity : row) rigidity *= bending;
  return fabric;
}

std::string read_text(const std::string& path) {
  constexpr uintmax_t kMostBytes = 1 << 20;
  std::error_code error;
  const uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw InputError("cannot be read: " + error.message());
  if (size > kMostBytes) throw InputError("is larger than a fabric can be (1 MiB)");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError("cannot be read");
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

}  // namespace

MeasuredFabric read_fabric_file(const std::string& path) {
  try {
    return parse(read_text(path));
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what());
  } catch (const Json::exception& error) {
    throw InputError(path + ": not valid JSON: " + error.what());
  }
}

std::string shipped_fabric(const std::string& name) {
  std::vector<std::string> known;
  for (const char* folder : {PLEAT_FABRICS_SOURCE, PLEAT_FABRICS_INSTALLED}) {
    std::error_code error;
    for (std::filesystem::directory_iterator file(folder, error), end; !error && file != end;
         file.increment(error)) {
      if (file->path().extension() != ".json") continue;
      known.push_back(file->path().stem().string());
      if (known.back() == name) return file->path().string();
    }
    if (!known.empty()) break;
  }
  std::sort(known.begin(), known.end());
  std::string list;
  for (const std::string& fabric : known) list += (list.empty() ? "" : ", ") + fabric;
  throw InputError("no fabric of the name '" + name + "' ships with this program; known: " + list);
}

}  // namespace pleat::garment
