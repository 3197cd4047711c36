// Reading garments and clips from files that are hostile until checked.
#pragma once

#include <string>

#include "core/hdf5_file.h"
#include "garment/design.h"
#include "garment/fabric.h"

namespace pleat::garment {

// InputError "file: array: what".
[[noreturn]] void refuse(const Hdf5File& file, const std::string& array, const std::string& what);

// The array's dimensions; -1 in `expected` stands for any size but 0.
Dims checked_dims(const Hdf5File& file, const std::string& name, const Dims& expected);

// # x n numbers, all finite; n as Matrix fixes it, rows = -1 for any number.
template <typename Matrix>
Matrix read_reals(const Hdf5File& file, const std::string& name, int64_t rows) {
  const Dims dims = checked_dims(file, name, {rows, Matrix::ColsAtCompileTime});
  const std::vector<double> values = file.read<double>(name);
  const Matrix matrix = Eigen::Map<const Matrix>(values.data(), dims[0], dims[1]);
  if (!matrix.allFinite()) refuse(file, name, "holds a value that is not finite");
  return matrix;
}

// A design, as attributes of the file.
void write_design(Hdf5File& file, const Design& design);
Design read_design(const Hdf5File& file);

// A fabric, as attributes and, where it is measured, its two tables.
void write_fabric(Hdf5File& file, const Fabric& fabric);
Fabric read_fabric(const Hdf5File& file);

}  // namespace pleat::garment
