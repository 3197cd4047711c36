// What a garment is cut from: the section `fabric` of a study, and one fabric drawn from it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace pleat::garment {

enum class MembraneModel { kStVenantKirchhoff, kNeoHookean };
const char* name_of(MembraneModel model);                              // stvk, neo_hookean
std::optional<MembraneModel> membrane_model(const std::string& name);  // none: unknown

// How a measured fabric stretches and bends. docs/fabrics.md says what rows and columns are.
struct FabricTables {
  std::array<std::array<double, 4>, 6> stretching;  // k_uu, k_uv, k_vv, k_shear, N/m
  std::array<std::array<double, 5>, 3> bending;     // N m
};
void validate(const FabricTables& tables);  // InputError naming the number

// One fabric, by its numbers. The defaults are those of a light cotton jersey.
struct Fabric {
  double density_kg_per_m2 = 0.15;
  double youngs_modulus_N_per_m = 100;  // membrane, modulus times thickness
  double poisson_ratio = 0.3;
  double bending_N_m = 1e-5;  // flexural rigidity
  double friction = 0.4;      // Coulomb, cloth on body
  MembraneModel membrane = MembraneModel::kStVenantKirchhoff;
  std::optional<FabricTables>
      tables;  // measured: they stand for membrane, modulus, ratio, rigidity
};
void validate(const Fabric& fabric);  // InputError naming the key

// All that a drape depends on as YAML, exact to the last bit: for keys and for the record.
std::string to_text(const Fabric& fabric);

// One number, or any from low to high.
struct Range {
  double low = 0, high = 0;
  Range() = default;
  Range(double number) : low(number), high(number) {}  // NOLINT(google-explicit-constructor)
  Range(double lowest, double highest) : low(lowest), high(highest) {}
};

struct FabricConfig {             // section `fabric`
  std::string file;               // JSON of a measured fabric
  std::string name;               // or one of those that ship, configs/fabrics
  std::string membrane = "stvk";  // or neo_hookean
  // Not given: the file's, else Fabric's.
  std::optional<Range> density_kg_per_m2, youngs_modulus_N_per_m, poisson_ratio, bending_N_m,
      friction;
  Range stretching_scale = 1, bending_scale = 1;  // times the stiffness given or measured
  std::optional<FabricTables> tables;             // those of the file
};

// Reads the file, if one is named, and fills in what was not given. InputError naming file and key.
void complete(FabricConfig& config);
void validate(const FabricConfig& config);  // InputError naming the key

// The fabric in the middle of every range.
Fabric middle_fabric(const FabricConfig& config);
// The fabric of one chain: each range gives a number of its own stream, uniformly.
Fabric draw_fabric(const FabricConfig& config, uint64_t seed, const std::string& chain);

}  // namespace pleat::garment
