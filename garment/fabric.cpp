#include "garment/fabric.h"

#include <cmath>
#include <iomanip>
#include <sstream>

#include "core/error.h"
#include "core/random.h"
#include "garment/fabric_file.h"

namespace pleat::garment {
namespace {

void check(const std::string& key, double value, bool is_good, const char* expected) {
  if (is_good && std::isfinite(value)) return;
  std::ostringstream message;
  message << key << " = " << value << "; expected " << expected;
  throw InputError(message.str());
}

// Every number that may be given: visit(key, range in the section, number in the fabric).
template <typename Config, typename FabricType, typename Visit>
void for_each_number(Config& config, FabricType&& fabric, const Visit& visit) {
  visit("density_kg_per_m2", config.density_kg_per_m2, fabric.density_kg_per_m2);
  visit("youngs_modulus_N_per_m", config.youngs_modulus_N_per_m, fabric.youngs_modulus_N_per_m);
  visit("poisson_ratio", config.poisson_ratio, fabric.poisson_ratio);
  visit("bending_N_m", config.bending_N_m, fabric.bending_N_m);
  visit("friction", config.friction, fabric.friction);
}

template <typename Table>
void scale(Table& table, double factor) {
  for (auto& row : table)
    for (double& number : row) number *= factor;
}

// pick(key, range) chooses a number of the range.
template <typename Pick>
Fabric make_fabric(const FabricConfig& config, const Pick& pick) {
  Fabric fabric;
  for_each_number(config, fabric,
                  [&](const char* key, const std::optional<Range>& range, double& number) {
                    if (range) number = pick(key, *range);
                  });
  const double stretching = pick("stretching_scale", config.stretching_scale);
  const double bending = pick("bending_scale", config.bending_scale);
  fabric.youngs_modulus_N_per_m *= stretching;
  fabric.bending_N_m *= bending;
  fabric.tables = config.tables;
  if (fabric.tables) {
    scale(fabric.tables->stretching, stretching);
    scale(fabric.tables->bending, bending);
  }
  fabric.membrane = membrane_model(config.membrane).value_or(fabric.membrane);
  return fabric;
}

template <typename Table>
void write_table(std::ostream& text, const char* key, const Table& table) {
  text << "  " << key << ":\n";
  for (const auto& row : table) {
    text << "    - [";
    for (size_t c = 0; c < row.size(); ++c) text << (c > 0 ? ", " : "") << row[c];
    text << "]\n";
  }
}

}  // namespace

const char* name_of(MembraneModel model) {
  return model == MembraneModel::kNeoHookean ? "neo_hookean" : "stvk";
}
std::optional<MembraneModel> membrane_model(const std::string& name) {
  for (const MembraneModel model : {MembraneModel::kStVenantKirchhoff, MembraneModel::kNeoHookean})
    if (name == name_of(model)) return model;
  return std::nullopt;
}

void validate(const FabricTables& tables) {
  const auto name = [](const char* table, size_t row, size_t column) {
    return std::string(table) + "[" + std::to_string(row) + "][" + std::to_string(column) + "]";
  };
  for (size_t r = 0; r < tables.stretching.size(); ++r)
    for (size_t c = 0; c < tables.stretching[r].size(); ++c) {
      const bool must_hold = c == 0 || c == 2 || (r == 0 && c == 3);
      const double stiffness = tables.stretching[r][c];
      check(name("stretching", r, c), stiffness, !must_hold || stiffness > 0,
            must_hold ? "> 0, N/m" : "a finite number, N/m");
    }
  for (size_t r = 0; r < tables.bending.size(); ++r)
    for (size_t c = 0; c < tables.bending[r].size(); ++c)
      check(name("bending", r, c), tables.bending[r][c], tables.bending[r][c] >= 0, ">= 0, N m");
}

void validate(const Fabric& fabric) {
  const auto check_key = [](const char* key, double value, bool is_good, const char* expected) {
    check(std::string("fabric.") + key, value, is_good, expected);
  };
  check_key("density_kg_per_m2", fabric.density_kg_per_m2, fabric.density_kg_per_m2 > 0, "> 0");
  check_key("friction", fabric.friction, fabric.friction >= 0, ">= 0");
  check_key("youngs_modulus_N_per_m", fabric.youngs_modulus_N_per_m,
            fabric.youngs_modulus_N_per_m > 0, "> 0");
  check_key("poisson_ratio", fabric.poisson_ratio,
            fabric.poisson_ratio >= 0 && fabric.poisson_ratio < 0.5, "0 .. < 0.5");
  check_key("bending_N_m", fabric.bending_N_m, fabric.bending_N_m >= 0, ">= 0");
  if (fabric.tables) validate(*fabric.tables);
}

std::string to_text(const Fabric& fabric) {
  std::ostringstream text;
  text << std::setprecision(17) << "fabric:\n  density_kg_per_m2: " << fabric.density_kg_per_m2
       << "\n  friction: " << fabric.friction << "\n";
  if (fabric.tables) {
    write_table(text, "stretching", fabric.tables->stretching);
    write_table(text, "bending", fabric.tables->bending);
    return text.str();
  }
  text << "  membrane: " << name_of(fabric.membrane)
       << "\n  youngs_modulus_N_per_m: " << fabric.youngs_modulus_N_per_m
       << "\n  poisson_ratio: " << fabric.poisson_ratio << "\n  bending_N_m: " << fabric.bending_N_m
       << "\n";
  return text.str();
}

void complete(FabricConfig& config) {
  const bool is_measured = !config.file.empty() || !config.name.empty();
  if (is_measured) {
    const std::string key = config.file.empty() ? "fabric.name" : "fabric.file";
    if (!config.file.empty() && !config.name.empty())
      throw InputError("fabric.name: give a fabric's `name` or its `file`, not both");
    if (config.youngs_modulus_N_per_m || config.poisson_ratio || config.bending_N_m ||
        config.membrane != FabricConfig{}.membrane)
      throw InputError(key +
                       ": a measured fabric comes with its own stretching and bending; only "
                       "density_kg_per_m2, friction, stretching_scale and bending_scale change it");
    try {
      const MeasuredFabric measured =
          read_fabric_file(config.file.empty() ? shipped_fabric(config.name) : config.file);
      config.tables = measured.tables;
      if (!config.density_kg_per_m2) config.density_kg_per_m2 = measured.density_kg_per_m2;
    } catch (const InputError& error) {
      throw InputError(key + ": " + error.what());
    }
  }
  if (!config.friction) config.friction = Fabric{}.friction;
  if (is_measured) return;
  for_each_number(config, Fabric{}, [](const char*, std::optional<Range>& range, double number) {
    if (!range) range = number;
  });
}

void validate(const FabricConfig& config) {
  if (!membrane_model(config.membrane))
    throw InputError("fabric.membrane = " + config.membrane + "; expected stvk or neo_hookean");
  const auto check_order = [](const char* key, const Range& range) {
    if (std::isfinite(range.low) && std::isfinite(range.high) && range.low > range.high)
      check(std::string("fabric.") + key, range.low, false, "the lower end of the range first");
  };
  for_each_number(config, Fabric{},
                  [&](const char* key, const std::optional<Range>& range, double) {
                    if (range) check_order(key, *range);
                  });
  for (const auto& [key, range] : {std::pair("stretching_scale", config.stretching_scale),
                                   std::pair("bending_scale", config.bending_scale)}) {
    check(std::string("fabric.") + key, range.low, range.low > 0, "> 0");
    check(std::string("fabric.") + key, range.high, range.high > 0, "> 0");
    check_order(key, range);
  }
  validate(make_fabric(config, [](const char*, const Range& range) { return range.low; }));
  validate(make_fabric(config, [](const char*, const Range& range) { return range.high; }));
}

Fabric middle_fabric(const FabricConfig& config) {
  return make_fabric(config, [](const char*, const Range& range) {
    return range.low + 0.5 * (range.high - range.low);
  });
}

Fabric draw_fabric(const FabricConfig& config, uint64_t seed, const std::string& chain) {
  return make_fabric(config, [&](const std::string& key, const Range& range) {
    if (range.low == range.high) return range.low;
    RandomStream random(seed, "fabric/" + chain + "/" + key);
    return range.low + random.uniform() * (range.high - range.low);
  });
}

}  // namespace pleat::garment
