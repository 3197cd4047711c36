#pragma once

namespace pleat::garment {

struct FabricConfig {  // section `fabric`; a light cotton jersey
  double density_kg_per_m2 = 0.15;
  double youngs_modulus_N_per_m = 300;  // membrane, modulus times thickness
  double poisson_ratio = 0.3;
  double bending_N_m = 1e-5;  // flexural rigidity
  double friction = 0.4;      // Coulomb, cloth on body
};
void validate(const FabricConfig& config);

}  // namespace pleat::garment
