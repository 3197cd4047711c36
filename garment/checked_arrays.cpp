#include "garment/checked_arrays.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "core/error.h"

namespace pleat::garment {

void refuse(const Hdf5File& file, const std::string& array, const std::string& what) {
  throw InputError(file.path() + ": " + array + ": " + what);
}

Dims checked_dims(const Hdf5File& file, const std::string& name, const Dims& expected) {
  const Dims dims = file.dims(name);
  bool fits = dims.size() == expected.size();
  for (size_t i = 0; fits && i < dims.size(); ++i)
    fits = expected[i] < 0 ? dims[i] > 0 && dims[i] <= (1 << 26) : dims[i] == expected[i];
  if (fits) return dims;
  std::string text;
  for (const int64_t d : expected)
    text += (text.empty() ? "" : ", ") + (d < 0 ? "n" : std::to_string(d));
  refuse(file, name, "its shape is not [" + text + "]");
}

void write_design(Hdf5File& file, const Design& design) {
  file.write_attribute("/", "name", design.name);
  file.write_attribute("/", "length", design.length);
  file.write_attribute("/", "sleeve", design.sleeve);
  file.write_attribute("/", "cleavage", design.cleavage);
  file.write_attribute("/", "is_held_out", static_cast<int64_t>(design.is_held_out));
}

Design read_design(const Hdf5File& file) {
  Design design;
  design.name = file.text_attribute("/", "name");
  design.length = file.number_attribute("/", "length");
  design.sleeve = file.number_attribute("/", "sleeve");
  design.cleavage = file.number_attribute("/", "cleavage");
  design.is_held_out = file.number_attribute("/", "is_held_out") != 0;
  try {
    validate(design);
  } catch (const InputError& error) {
    throw InputError(file.path() + ": " + error.what());
  }
  return design;
}

namespace {

constexpr const char* kMeasured = "measured";
constexpr const char* kStretching = "fabric_stretching";
constexpr const char* kBending = "fabric_bending";

template <size_t Rows, size_t Columns>
void write_table(Hdf5File& file, const char* name,
                 const std::array<std::array<double, Columns>, Rows>& table) {
  std::vector<double> values;
  for (const auto& row : table) values.insert(values.end(), row.begin(), row.end());
  file.write(name, values, {Rows, Columns});
}
template <size_t Rows, size_t Columns>
void read_table(const Hdf5File& file, const char* name,
                std::array<std::array<double, Columns>, Rows>& table) {
  checked_dims(file, name, {Rows, Columns});
  const std::vector<double> values = file.read<double>(name);
  for (size_t r = 0; r < Rows; ++r)
    std::copy_n(values.begin() + r * Columns, Columns, table[r].begin());
}

}  // namespace

void write_fabric(Hdf5File& file, const Fabric& fabric) {
  file.write_attribute("/", "density_kg_per_m2", fabric.density_kg_per_m2);
  file.write_attribute("/", "friction", fabric.friction);
  file.write_attribute("/", "membrane",
                       std::string(fabric.tables ? kMeasured : name_of(fabric.membrane)));
  if (fabric.tables) {
    write_table(file, kStretching, fabric.tables->stretching);
    write_table(file, kBending, fabric.tables->bending);
  } else {
    file.write_attribute("/", "youngs_modulus_N_per_m", fabric.youngs_modulus_N_per_m);
    file.write_attribute("/", "poisson_ratio", fabric.poisson_ratio);
    file.write_attribute("/", "bending_N_m", fabric.bending_N_m);
  }
}

Fabric read_fabric(const Hdf5File& file) {
  Fabric fabric;
  fabric.density_kg_per_m2 = file.number_attribute("/", "density_kg_per_m2");
  fabric.friction = file.number_attribute("/", "friction");
  const std::string membrane = file.text_attribute("/", "membrane");
  if (membrane == kMeasured) {
    fabric.tables.emplace();
    read_table(file, kStretching, fabric.tables->stretching);
    read_table(file, kBending, fabric.tables->bending);
  } else {
    const std::optional<MembraneModel> model = membrane_model(membrane);
    if (!model) refuse(file, "membrane", "is no known law: " + membrane);
    fabric.membrane = *model;
    fabric.youngs_modulus_N_per_m = file.number_attribute("/", "youngs_modulus_N_per_m");
    fabric.poisson_ratio = file.number_attribute("/", "poisson_ratio");
    fabric.bending_N_m = file.number_attribute("/", "bending_N_m");
  }
  try {
    validate(fabric);
  } catch (const InputError& error) {
    throw InputError(file.path() + ": " + error.what());
  }
  return fabric;
}

}  // namespace pleat::garment
