#pragma once

#include <string>

#include "core/provenance.h"
#include "garment/template.h"

namespace pleat::garment {

// One settled garment as HDF5: arrays of Garment under their field names, design as attributes.
void write_garment(const std::string& path, const Garment& garment, const Provenance& provenance);
Garment read_garment(const std::string& path);  // InputError naming file and array

}  // namespace pleat::garment
