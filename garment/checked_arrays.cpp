#include "garment/checked_arrays.h"

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

}  // namespace pleat::garment
