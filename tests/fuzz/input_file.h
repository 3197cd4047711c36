// What the fuzz targets share: loaders take paths, so each input is a file for a moment.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/error.h"

namespace pleat::fuzz {

// In memory where there is such a folder.
inline std::string write_input(const uint8_t* data, size_t size, const std::string& ending) {
  static const std::string folder = ::access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp";
  const std::string path = folder + "/pleat-fuzz-" + std::to_string(::getpid()) + ending;
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (!file || std::fwrite(data, 1, size, file) != size || std::fclose(file) != 0) std::abort();
  return path;
}

// A loader may refuse, as it refuses a user. Any other exception ends the process: a finding.
template <typename Load>
void load(const Load& load) {
  try {
    load();
  } catch (const InputError&) {
  }
}

}  // namespace pleat::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);
