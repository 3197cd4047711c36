#include "core/provenance.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "core/commit.h"  // written by cmake/WriteCommit.cmake at each build
#include "core/error.h"
#include "core/hdf5_file.h"
#include "core/profile.h"

namespace pleat {

// The seed is text: attributes hold signed numbers, and a seed uses all 64 bits.
void write_provenance(Hdf5File& file, const Provenance& provenance) {
  file.write_attribute("/", "stage", provenance.stage);
  file.write_attribute("/", "config", provenance.config);
  file.write_attribute("/", "seed", std::to_string(provenance.seed));
  file.write_attribute("/", "inputs", nlohmann::json(provenance.inputs).dump());
  file.write_attribute("/", "version", version());
  file.write_attribute("/", "commit", commit());
  file.write_attribute("/", "machine", machine());
  file.write_attribute("/", "profile", current_profile());
}

Provenance read_provenance(const Hdf5File& file) {
  Provenance result;
  result.stage = file.text_attribute("/", "stage");
  result.config = file.text_attribute("/", "config");
  const std::string seed = file.text_attribute("/", "seed");
  try {
    size_t end = 0;
    result.seed = std::stoull(seed, &end);
    if (end != seed.size()) throw std::invalid_argument(seed);
  } catch (const std::logic_error&) {
    throw InputError(file.path() + ": attribute seed = '" + seed + "'; expected a whole number");
  }
  try {
    result.inputs = nlohmann::json::parse(file.text_attribute("/", "inputs"))
                        .get<std::map<std::string, std::string>>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(file.path() + ": attribute inputs is not a JSON object of sha256 texts");
  }
  return result;
}

std::string provenance_json(const Provenance& provenance) {
  return nlohmann::json{{"stage", provenance.stage}, {"config", provenance.config},
                        {"seed", provenance.seed},   {"inputs", provenance.inputs},
                        {"version", version()},      {"commit", commit()},
                        {"machine", machine()}}
      .dump(2);
}

std::string version() { return PLEAT_VERSION; }

std::string commit() { return PLEAT_COMMIT; }

std::string machine() {
  std::string model = "unknown processor";
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    const size_t colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) {
      model = line.substr(colon + 2);
      break;
    }
  }
  return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores, compiler " +
         __VERSION__;
}

}  // namespace pleat
