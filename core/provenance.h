// What produced a file: kept as attributes in every output.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/atomic_file.h"  // write_file_atomically
#include "core/sha256.h"

namespace pleat {

class Hdf5File;

struct Provenance {
  std::string stage;                          // "simulate", "encode", ...
  std::string config;                         // effective configuration, YAML
  uint64_t seed = 0;
  std::map<std::string, std::string> inputs;  // role or path -> sha256 of the content
};

void write_provenance(Hdf5File& file, const Provenance& provenance);  // attributes of "/"
Provenance read_provenance(const Hdf5File& file);
std::string provenance_json(const Provenance& provenance);

std::string version();       // "0.1.0"
std::string commit();        // git commit this was built from, "unknown" without git
std::string machine();       // processor model, cores, compiler

}  // namespace pleat
