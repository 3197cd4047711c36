#include "core/provenance.h"

#include <openssl/evp.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "core/commit.h"  // written by cmake/WriteCommit.cmake at each build
#include "core/error.h"
#include "core/hdf5_file.h"

namespace pleat {
namespace {

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    check(context_ != nullptr && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
  }
  void add(const void* bytes, size_t count) {
    check(EVP_DigestUpdate(context_.get(), bytes, count) == 1);
  }
  std::string hex() {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    check(EVP_DigestFinal_ex(context_.get(), digest, &size) == 1);
    std::string result;
    for (unsigned int k = 0; k < size; ++k) {
      char pair[3];
      std::snprintf(pair, sizeof pair, "%02x", digest[k]);
      result += pair;
    }
    return result;
  }

 private:
  static void check(bool is_good) {
    if (!is_good) throw std::runtime_error("OpenSSL offers no SHA-256");
  }
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_;
};

}  // namespace

// The seed is text: attributes hold signed numbers, and a seed uses all 64 bits.
void write_provenance(Hdf5File& file, const Provenance& provenance) {
  file.write_attribute("/", "stage", provenance.stage);
  file.write_attribute("/", "config", provenance.config);
  file.write_attribute("/", "seed", std::to_string(provenance.seed));
  file.write_attribute("/", "inputs", nlohmann::json(provenance.inputs).dump());
  file.write_attribute("/", "version", version());
  file.write_attribute("/", "commit", commit());
  file.write_attribute("/", "machine", machine());
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

std::string sha256(const std::string& bytes) {
  Sha256 hash;
  hash.add(bytes.data(), bytes.size());
  return hash.hex();
}

std::string sha256_of_file(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             std::fclose);
  const auto fail = [&] { throw InputError(path + ": cannot be read: " + std::strerror(errno)); };
  if (!file) fail();
  Sha256 hash;
  std::vector<char> block(1 << 16);
  while (const size_t count = std::fread(block.data(), 1, block.size(), file.get())) {
    hash.add(block.data(), count);
  }
  if (std::ferror(file.get())) fail();
  return hash.hex();
}

}  // namespace pleat
