#include "garment/fabric.h"

#include <cmath>
#include <sstream>

#include "core/error.h"

namespace pleat::garment {
namespace {

void check(const char* key, double value, bool is_good, const char* expected) {
  if (is_good && std::isfinite(value)) return;
  std::ostringstream message;
  message << "fabric." << key << " = " << value << "; expected " << expected;
  throw InputError(message.str());
}

void check_positive(const char* key, double value) { check(key, value, value > 0, "> 0"); }

}  // namespace

void validate(const FabricConfig& config) {
  check_positive("density_kg_per_m2", config.density_kg_per_m2);
  check_positive("youngs_modulus_N_per_m", config.youngs_modulus_N_per_m);
  check("poisson_ratio", config.poisson_ratio,
        config.poisson_ratio >= 0 && config.poisson_ratio < 0.5, "0 .. < 0.5");
  check("bending_N_m", config.bending_N_m, config.bending_N_m >= 0, ">= 0");
  check("friction", config.friction, config.friction >= 0, ">= 0");
}

}  // namespace pleat::garment
