// HDF5 files, the only place that speaks to libhdf5. A new file is written under a temporary name
// in the same folder and renamed by commit(), so that a reader never sees half a file
// (docs/architecture.md, Files). Its first 512 bytes, which HDF5 leaves to the user, hold the size
// and the SHA-256 of the rest, so that every file can be checked by itself.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/types.h"

namespace pleat {

enum class Hdf5Type { kInt8, kUInt8, kInt16, kInt32, kInt64, kFloat32, kFloat64 };

template <typename T>
Hdf5Type hdf5_type();
template <>
inline Hdf5Type hdf5_type<int8_t>() {
  return Hdf5Type::kInt8;
}
template <>
inline Hdf5Type hdf5_type<uint8_t>() {
  return Hdf5Type::kUInt8;
}
template <>
inline Hdf5Type hdf5_type<int16_t>() {
  return Hdf5Type::kInt16;
}
template <>
inline Hdf5Type hdf5_type<int32_t>() {
  return Hdf5Type::kInt32;
}
template <>
inline Hdf5Type hdf5_type<int64_t>() {
  return Hdf5Type::kInt64;
}
template <>
inline Hdf5Type hdf5_type<float>() {
  return Hdf5Type::kFloat32;
}
template <>
inline Hdf5Type hdf5_type<double>() {
  return Hdf5Type::kFloat64;
}

using Dims = std::vector<int64_t>;

class Hdf5File {
 public:
  static Hdf5File open(
      const std::string& path);  // to read; InputError where missing, truncated, not HDF5
  static Hdf5File create(const std::string& path);  // to write; nothing at `path` until commit()
  Hdf5File(Hdf5File&& other) noexcept;
  Hdf5File& operator=(Hdf5File&&) = delete;
  ~Hdf5File();  // without commit(), the temporary file is removed

  // What is wrong with a file that commit() wrote: "missing", "truncated", "altered" or "without
  // a checksum"; empty where it is whole. Reads all of it.
  static std::string damage_of(const std::string& path);

  const std::string& path() const { return path_; }
  // Closes, fsyncs, renames, fsyncs the folder.
  void commit();

  // Names are paths such as "garment/faces"; groups on the way are made.
  // Elements are converted by HDF5 from T to `stored`, row-major.
  template <typename T>
  void write(const std::string& name, const T* data, const Dims& dims,
             Hdf5Type stored = hdf5_type<T>()) {
    write_raw(name, data, hdf5_type<T>(), dims, stored);
  }
  template <typename T>
  void write(const std::string& name, const std::vector<T>& data, const Dims& dims) {
    check_size(name, data.size(), dims);
    write_raw(name, data.data(), hdf5_type<T>(), dims, hdf5_type<T>());
  }
  void write(const std::string& name,
             const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic,
                                                  Eigen::RowMajor>>& matrix,
             Hdf5Type stored = Hdf5Type::kFloat64);
  void write(const std::string& name, const std::vector<std::string>& texts);

  // A dataset to be filled row by row (along the first dimension). chunk_rows > 0 makes it chunked.
  void create_dataset(const std::string& name, const Dims& dims, Hdf5Type stored,
                      int64_t chunk_rows = 0, int gzip_level = 0);
  template <typename T>
  void write_rows(const std::string& name, int64_t first_row, int64_t row_count, const T* data) {
    write_rows_raw(name, first_row, row_count, data, hdf5_type<T>());
  }

  // Makes `name` show what `object` of another file is. `file` is relative to this file's folder.
  void link(const std::string& name, const std::string& file, const std::string& object);

  bool has(const std::string& name) const;
  std::vector<std::string> list(const std::string& group) const;  // sorted
  Dims dims(const std::string& name) const;  // InputError naming file and array
  template <typename T>
  std::vector<T> read(const std::string& name) const {
    const Dims d = dims(name);
    std::vector<T> data(static_cast<size_t>(count(d)));
    read_raw(name, data.data(), hdf5_type<T>());
    return data;
  }
  // Rows first_row .. first_row + row_count - 1, into data.
  template <typename T>
  void read_rows(const std::string& name, int64_t first_row, int64_t row_count, T* data) const {
    read_rows_raw(name, first_row, row_count, data, hdf5_type<T>());
  }
  Eigen::MatrixXd read_matrix(const std::string& name) const;  // two-dimensional
  std::vector<std::string> read_texts(const std::string& name) const;

  // Attributes of a dataset or group; "/" is the file itself.
  void write_attribute(const std::string& object, const std::string& name, const std::string& text);
  void write_attribute(const std::string& object, const std::string& name, double number);
  void write_attribute(const std::string& object, const std::string& name, int64_t number);
  void write_attribute(const std::string& object, const std::string& name, int number) {
    write_attribute(object, name, static_cast<int64_t>(number));
  }
  // So that viewers show a two-dimensional array as a picture (HDF5 Image and Palette Specification
  // 1.2).
  void mark_as_image(const std::string& name);
  bool has_attribute(const std::string& object, const std::string& name) const;
  std::string text_attribute(const std::string& object, const std::string& name) const;
  double number_attribute(const std::string& object, const std::string& name) const;

 private:
  Hdf5File(std::string path, std::string temporary_path, int64_t handle);
  static int64_t count(const Dims& dims);
  void check_size(const std::string& name, size_t size, const Dims& dims) const;
  void write_raw(const std::string& name, const void* data, Hdf5Type memory, const Dims& dims,
                 Hdf5Type stored);
  void write_rows_raw(const std::string& name, int64_t first, int64_t rows, const void* data,
                      Hdf5Type memory);
  void read_raw(const std::string& name, void* data, Hdf5Type memory) const;
  void read_rows_raw(const std::string& name, int64_t first, int64_t rows, void* data,
                     Hdf5Type memory) const;

  std::string path_, temporary_path_;  // the second is empty in a file opened to read
  int64_t handle_ = -1;
};

}  // namespace pleat
