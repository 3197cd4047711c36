// Measured fabrics: JSON files in ARCSim's format; docs/fabrics.md.
#pragma once

#include <string>

#include "garment/fabric.h"

namespace pleat::garment {

struct MeasuredFabric {
  double density_kg_per_m2 = 0;
  FabricTables tables{};
};

// InputError naming file and key. Multipliers of the file are in its numbers.
MeasuredFabric read_fabric_file(const std::string& path);

// The file of a fabric that ships. InputError that lists them where none has the name.
std::string shipped_fabric(const std::string& name);

}  // namespace pleat::garment
