#include "core/hdf5_file.h"

#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <utility>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/guarded_read.h"
#include "core/sha256.h"

namespace pleat {
namespace {

// An HDF5 identifier, closed at the end of its scope.
class Id {
 public:
  Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Id() {
    if (id_ >= 0) close_(id_);
  }
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
  operator hid_t() const { return id_; }
  bool is_valid() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// HDF5 prints its error stack by default, and keeps that setting per thread. At the end of the
// process it would close again what it could not close on a full disk, and crash.
void keep_quiet() {
  static const bool is_told = H5dont_atexit() >= 0;
  static_cast<void>(is_told);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw InputError(path + ": " + what);
}

hid_t memory_type(Hdf5Type type) {
  switch (type) {
    case Hdf5Type::kInt8:
      return H5T_NATIVE_INT8;
    case Hdf5Type::kUInt8:
      return H5T_NATIVE_UINT8;
    case Hdf5Type::kInt16:
      return H5T_NATIVE_INT16;
    case Hdf5Type::kInt32:
      return H5T_NATIVE_INT32;
    case Hdf5Type::kInt64:
      return H5T_NATIVE_INT64;
    case Hdf5Type::kFloat32:
      return H5T_NATIVE_FLOAT;
    case Hdf5Type::kFloat64:
      return H5T_NATIVE_DOUBLE;
  }
  return H5I_INVALID_HID;
}

hid_t file_type(Hdf5Type type) {
  switch (type) {
    case Hdf5Type::kInt8:
      return H5T_STD_I8LE;
    case Hdf5Type::kUInt8:
      return H5T_STD_U8LE;
    case Hdf5Type::kInt16:
      return H5T_STD_I16LE;
    case Hdf5Type::kInt32:
      return H5T_STD_I32LE;
    case Hdf5Type::kInt64:
      return H5T_STD_I64LE;
    case Hdf5Type::kFloat32:
      return H5T_IEEE_F32LE;
    case Hdf5Type::kFloat64:
      return H5T_IEEE_F64LE;
  }
  return H5I_INVALID_HID;
}

std::vector<hsize_t> extents(const Dims& dims) { return {dims.begin(), dims.end()}; }

Id make_space(const Dims& dims) {
  if (dims.empty()) return Id(H5Screate(H5S_SCALAR), H5Sclose);
  return Id(H5Screate_simple(static_cast<int>(dims.size()), extents(dims).data(), nullptr),
            H5Sclose);
}

std::string dims_text(const Dims& dims) {
  std::string text = "[";
  for (size_t k = 0; k < dims.size(); ++k) text += (k ? ", " : "") + std::to_string(dims[k]);
  return text + "]";
}

// Properties of a transfer that stops where a number does not fit an integer type, instead of
// clipping it as HDF5 does by default. `is_misfit` is set when that happens.
H5T_conv_ret_t stop_at_misfit(H5T_conv_except_t kind, hid_t, hid_t destination, void*, void*,
                              void* is_misfit) {
  if (kind == H5T_CONV_EXCEPT_PRECISION || H5Tget_class(destination) != H5T_INTEGER) {
    return H5T_CONV_UNHANDLED;
  }
  *static_cast<bool*>(is_misfit) = true;
  return H5T_CONV_ABORT;
}

Id make_transfer(bool* is_misfit) {
  const hid_t transfer = H5Pcreate(H5P_DATASET_XFER);
  H5Pset_type_conv_cb(transfer, stop_at_misfit, is_misfit);
  return Id(transfer, H5Pclose);
}

Id text_type(H5T_cset_t cset = H5T_CSET_UTF8) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, cset);
  return Id(type, H5Tclose);
}

Id link_creation() {
  const hid_t properties = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(properties, 1);
  return Id(properties, H5Pclose);
}

Id dataset_creation() {
  const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(properties, false);  // equal content gives equal bytes
  return Id(properties, H5Pclose);
}

// libhdf5 1.10 goes round in circles on some files, and crashes on others. Seconds, of computing: a
// whole read of 10 GB takes less.
constexpr double kMostSeconds = 60;

// Texts of an attribute or dataset of `count` elements, of fixed or variable length. `read` fills a
// buffer laid out by the type that it is given.
template <typename Read>
bool read_texts_by(hid_t type, hid_t space, size_t count, Read read,
                   std::vector<std::string>& texts) {
  texts.clear();
  if (H5Tis_variable_str(type) > 0) {
    const Id memory = text_type(H5Tget_cset(type));
    std::vector<char*> pointers(count, nullptr);
    if (read(memory, pointers.data()) < 0) return false;
    for (const char* pointer : pointers) texts.emplace_back(pointer ? pointer : "");
    H5Dvlen_reclaim(memory, space, H5P_DEFAULT, pointers.data());
    return true;
  }
  const size_t size = H5Tget_size(type);
  std::vector<char> bytes(count * size);
  if (read(type, bytes.data()) < 0) return false;
  for (size_t k = 0; k < count; ++k) {
    std::string text(bytes.data() + k * size, size);
    text.erase(std::min(text.find('\0'), text.size()));
    if (H5Tget_strpad(type) == H5T_STR_SPACEPAD) text.erase(text.find_last_not_of(' ') + 1);
    texts.push_back(text);
  }
  return true;
}

// No more bytes than a file of this size could hold compressed (deflate reaches 1032 to 1), so that
// a damaged or hostile header cannot ask for all of the memory.
bool is_plausible(const Dims& dims, size_t element_size, uint64_t file_size) {
  const double limit = 2048.0 * static_cast<double>(file_size) + 0x1p28;
  double bytes = static_cast<double>(element_size);
  for (const int64_t dim : dims) bytes *= static_cast<double>(std::max<int64_t>(dim, 1));
  return bytes <= limit;
}

bool read_dims(hid_t space, Dims& dims) {
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 0 || H5Sget_simple_extent_type(space) == H5S_NULL) return false;
  std::vector<hsize_t> sizes(rank);
  H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
  dims.clear();
  for (const hsize_t size : sizes) {
    if (size > static_cast<hsize_t>(INT64_MAX)) return false;
    dims.push_back(static_cast<int64_t>(size));
  }
  return true;
}

bool is_number(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  return kind == H5T_INTEGER || kind == H5T_FLOAT || kind == H5T_ENUM;  // h5py's bool is an enum
}

// A dataset opened to read, with its checked dimensions.
struct Array {
  Array(hid_t file, const std::string& path, const std::string& name, bool is_own)
      : where(path + ": array '" + name + "'"),
        id(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose) {
    if (!id.is_valid()) throw InputError(where + " is missing");
    const Id space(H5Dget_space(id), H5Sclose);
    const Id type(H5Dget_type(id), H5Tclose);
    const Id owner(H5Iget_file_id(id), H5Fclose);  // another file where a link leads there
    hsize_t file_size = 0;
    if (!type.is_valid() || !read_dims(space, dims) || H5Fget_filesize(owner, &file_size) < 0) {
      throw InputError(where + " has no readable shape");
    }
    if (!is_own && !is_plausible(dims, H5Tget_size(type), file_size)) {
      throw InputError(where + " claims shape " + dims_text(dims) + ", more than a file of " +
                       std::to_string(file_size) + " bytes can hold; the file is damaged");
    }
  }
  std::string where;
  Id id;
  Dims dims;
};

Id select_rows(hid_t file_space, const Dims& dims, int64_t first, int64_t rows,
               const std::string& where) {
  if (dims.empty() || first < 0 || rows < 0 || first > dims[0] - rows) {
    throw InputError(where + " has shape " + dims_text(dims) + "; rows " + std::to_string(first) +
                     " to " + std::to_string(first + rows - 1) + " were asked for");
  }
  std::vector<hsize_t> start(dims.size(), 0), size = extents(dims);
  start[0] = first;
  size[0] = rows;
  H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr);
  return Id(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr), H5Sclose);
}

// HDF5 tells that it could not write, not why: nearly always for want of room.
[[noreturn]] void fail_to_write(const std::string& where) {
  throw ResourceError(where + " cannot be written: is the disk full? Make room and give the same " +
                      "command again");
}

// What was written may still lie in HDF5's buffers; whether it got through is known after a flush.
void check_written(hid_t array, herr_t status, bool is_misfit, const std::string& where) {
  if (is_misfit) throw InputError(where + ": a number does not fit the integer type to store");
  if (status < 0 || H5Dflush(array) < 0) fail_to_write(where);
}

constexpr int64_t kUserBlock = 512;  // bytes at the head of a file that HDF5 leaves alone

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using OpenFile = std::unique_ptr<std::FILE, FileCloser>;

// What the user block of a file of so many bytes says; zeros follow.
std::string checksum_line(int64_t bytes, const std::string& sha256) {
  return "Pleat: HDF5 after 512 bytes, size " + std::to_string(bytes) + ", sha256 " + sha256 + "\n";
}

// Signs a file that is closed. False where it cannot be written.
bool write_checksum(const std::string& path) {
  const OpenFile file(std::fopen(path.c_str(), "r+b"));
  if (!file) return false;
  const std::string line =
      checksum_line(static_cast<int64_t>(std::filesystem::file_size(path)) - kUserBlock,
                    sha256_of_file(path, kUserBlock));
  return std::fwrite(line.data(), 1, line.size(), file.get()) == line.size() &&
         std::fflush(file.get()) == 0;
}

void check_read(herr_t status, bool is_misfit, const std::string& where) {
  if (is_misfit) throw InputError(where + " holds a number that is not a whole number in range");
  if (status < 0) throw InputError(where + " cannot be read; the file is truncated or damaged");
}

void require_numbers(const Array& array) {
  const Id type(H5Dget_type(array.id), H5Tclose);
  if (!is_number(type)) throw InputError(array.where + " does not hold numbers");
}

Id open_object(hid_t file, const std::string& path, const std::string& object) {
  const hid_t id = H5Oopen(file, object.c_str(), H5P_DEFAULT);
  if (id < 0) fail(path, "'" + object + "' is missing");
  return Id(id, H5Oclose);
}

void write_scalar_attribute(hid_t file, const std::string& path, const std::string& object,
                            const std::string& name, hid_t stored, hid_t memory,
                            const void* value) {
  keep_quiet();
  const Id owner = open_object(file, path, object);
  if (H5Aexists(owner, name.c_str()) > 0) H5Adelete(owner, name.c_str());
  const Id space(H5Screate(H5S_SCALAR), H5Sclose);
  const Id attribute(H5Acreate2(owner, name.c_str(), stored, space, H5P_DEFAULT, H5P_DEFAULT),
                     H5Aclose);
  if (!attribute.is_valid() || H5Awrite(attribute, memory, value) < 0) {
    fail_to_write(path + ": attribute '" + name + "' of '" + object + "'");
  }
}

// An attribute opened to read that holds one element.
struct Attribute {
  Attribute(hid_t file, const std::string& path, const std::string& object, const std::string& name)
      : where(path + ": attribute '" + name + "' of '" + object + "'"),
        owner(open_object(file, path, object)),
        id(H5Aexists(owner, name.c_str()) > 0 ? H5Aopen(owner, name.c_str(), H5P_DEFAULT)
                                              : H5I_INVALID_HID,
           H5Aclose),
        space(id.is_valid() ? H5Aget_space(id) : H5I_INVALID_HID, H5Sclose),
        type(id.is_valid() ? H5Aget_type(id) : H5I_INVALID_HID, H5Tclose) {
    if (!id.is_valid()) throw InputError(where + " is missing");
    if (H5Sget_simple_extent_npoints(space) != 1) {
      throw InputError(where + " is not a single value");
    }
    const Id file_id(H5Iget_file_id(id), H5Fclose);
    hsize_t file_size = 0;
    if (H5Fget_filesize(file_id, &file_size) < 0 || H5Tget_size(type) > file_size + 64) {
      throw InputError(where + " is larger than its file; the file is damaged");
    }
  }
  std::string where;
  Id owner, id, space, type;
};

}  // namespace

Hdf5File::Hdf5File(std::string path, std::string temporary_path, int64_t handle)
    : path_(std::move(path)), temporary_path_(std::move(temporary_path)), handle_(handle) {}

Hdf5File::Hdf5File(Hdf5File&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_path_(std::exchange(other.temporary_path_, {})),
      handle_(std::exchange(other.handle_, -1)) {}

Hdf5File::~Hdf5File() {
  keep_quiet();
  if (handle_ >= 0) H5Fclose(handle_);
  if (!temporary_path_.empty()) ::unlink(temporary_path_.c_str());
}

Hdf5File Hdf5File::open(const std::string& path) {
  const GuardedRead guard(path, kMostSeconds);
  keep_quiet();
  std::error_code error;
  if (!std::filesystem::exists(path, error)) fail(path, "no such file");
  if (!std::filesystem::is_regular_file(path, error)) fail(path, "is not a file");
  if (H5Fis_hdf5(path.c_str()) <= 0) fail(path, "is not an HDF5 file, or cannot be read");
  const hid_t handle = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (handle < 0) fail(path, "cannot be opened as HDF5; it is truncated or damaged");
  return Hdf5File(path, "", handle);
}

Hdf5File Hdf5File::create(const std::string& path) {
  keep_quiet();
  const std::string temporary_path = make_temporary_file(path);
  const Id creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  H5Pset_userblock(creation, kUserBlock);
  const hid_t handle = H5Fcreate(temporary_path.c_str(), H5F_ACC_TRUNC, creation, H5P_DEFAULT);
  if (handle < 0) {
    ::unlink(temporary_path.c_str());
    fail_to_write(path);
  }
  return Hdf5File(path, temporary_path, handle);
}

std::string Hdf5File::damage_of(const std::string& path) {
  const OpenFile file(std::fopen(path.c_str(), "rb"));
  if (!file && errno == ENOENT) return "missing";
  std::error_code error;
  const int64_t size = static_cast<int64_t>(std::filesystem::file_size(path, error));
  // That it cannot be looked at does not make it a bad file.
  if (!file || error)
    fail(path, std::string("cannot be read: ") + (file ? error.message() : std::strerror(errno)));
  std::string head(kUserBlock, '\0');
  if (std::fread(head.data(), 1, head.size(), file.get()) != head.size()) return "truncated";
  head.erase(head.find_last_not_of('\0') + 1);
  long long told = -1;
  if (std::sscanf(head.c_str(), "Pleat: HDF5 after 512 bytes, size %lld", &told) != 1)
    return "without a checksum";
  if (size - kUserBlock < told) return "truncated";
  const bool is_whole =
      size - kUserBlock == told && head == checksum_line(told, sha256_of_file(path, kUserBlock));
  return is_whole ? "" : "altered";
}

void Hdf5File::commit() {
  keep_quiet();
  assert(handle_ >= 0 && !temporary_path_.empty());
  const herr_t flushed = H5Fflush(handle_, H5F_SCOPE_GLOBAL);
  const herr_t closed = H5Fclose(std::exchange(handle_, -1));
  if (flushed < 0 || closed < 0 || !write_checksum(temporary_path_)) fail_to_write(path_);
  publish_file(std::exchange(temporary_path_, {}), path_);
}

int64_t Hdf5File::count(const Dims& dims) {
  int64_t result = 1;
  for (const int64_t dim : dims) result *= dim;
  return result;
}

void Hdf5File::check_size(const std::string& name, size_t size, const Dims& dims) const {
  if (static_cast<int64_t>(size) != count(dims)) {
    throw std::invalid_argument(path_ + ": array '" + name + "' has " + std::to_string(size) +
                                " elements for shape " + dims_text(dims));
  }
}

void Hdf5File::write_raw(const std::string& name, const void* data, Hdf5Type memory,
                         const Dims& dims, Hdf5Type stored) {
  create_dataset(name, dims, stored);
  if (count(dims) == 0) return;
  const Id array(H5Dopen2(handle_, name.c_str(), H5P_DEFAULT), H5Dclose);
  bool is_misfit = false;
  const Id transfer = make_transfer(&is_misfit);
  const herr_t status = H5Dwrite(array, memory_type(memory), H5S_ALL, H5S_ALL, transfer, data);
  check_written(array, status, is_misfit, path_ + ": array '" + name + "'");
}

void Hdf5File::write(
    const std::string& name,
    const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>&
        matrix,
    Hdf5Type stored) {
  // A block of a larger matrix skips from row to row; the file holds plain rows.
  if (matrix.outerStride() == matrix.cols()) {
    return write_raw(name, matrix.data(), Hdf5Type::kFloat64, {matrix.rows(), matrix.cols()},
                     stored);
  }
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> plain = matrix;
  write_raw(name, plain.data(), Hdf5Type::kFloat64, {plain.rows(), plain.cols()}, stored);
}

void Hdf5File::write(const std::string& name, const std::vector<std::string>& texts) {
  keep_quiet();
  const std::string where = path_ + ": array '" + name + "'";
  const Id type = text_type(), links = link_creation(), creation = dataset_creation();
  const Id space = make_space({static_cast<int64_t>(texts.size())});
  const Id array(H5Dcreate2(handle_, name.c_str(), type, space, links, creation, H5P_DEFAULT),
                 H5Dclose);
  if (!array.is_valid()) throw InputError(where + " cannot be made; does it exist already?");
  if (texts.empty()) return;
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  const herr_t status = H5Dwrite(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data());
  check_written(array, status, false, where);
}

void Hdf5File::create_dataset(const std::string& name, const Dims& dims, Hdf5Type stored,
                              int64_t chunk_rows, int gzip_level) {
  keep_quiet();
  assert(gzip_level == 0 || chunk_rows > 0);
  const Id space = make_space(dims), links = link_creation(), creation = dataset_creation();
  if (chunk_rows > 0 && count(dims) > 0) {
    std::vector<hsize_t> chunk = extents(dims);
    chunk[0] = std::min<hsize_t>(chunk[0], chunk_rows);
    H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
    if (gzip_level > 0) {
      H5Pset_shuffle(creation);
      H5Pset_deflate(creation, gzip_level);
    }
  }
  const Id array(
      H5Dcreate2(handle_, name.c_str(), file_type(stored), space, links, creation, H5P_DEFAULT),
      H5Dclose);
  if (!array.is_valid()) {
    fail(path_, "array '" + name + "' cannot be made; does it exist already?");
  }
}

void Hdf5File::write_rows_raw(const std::string& name, int64_t first, int64_t rows,
                              const void* data, Hdf5Type memory) {
  keep_quiet();
  const Array array(handle_, path_, name, /*is_own=*/true);
  const Id file_space(H5Dget_space(array.id), H5Sclose);
  const Id memory_space = select_rows(file_space, array.dims, first, rows, array.where);
  bool is_misfit = false;
  const Id transfer = make_transfer(&is_misfit);
  const herr_t status =
      H5Dwrite(array.id, memory_type(memory), memory_space, file_space, transfer, data);
  check_written(array.id, status, is_misfit, array.where);
}

void Hdf5File::link(const std::string& name, const std::string& file, const std::string& object) {
  keep_quiet();
  const Id links = link_creation();
  if (H5Lcreate_external(file.c_str(), object.c_str(), handle_, name.c_str(), links, H5P_DEFAULT) <
      0)
    fail(path_, "link '" + name + "' cannot be made; does it exist already?");
}

bool Hdf5File::has(const std::string& name) const {
  const GuardedRead guard(path_, kMostSeconds);
  keep_quiet();
  for (size_t end = name.find('/', 1);; end = name.find('/', end + 1)) {
    const std::string prefix = name.substr(0, end);
    if (prefix != "/" && H5Lexists(handle_, prefix.c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) break;
  }
  return H5Oexists_by_name(handle_, name.c_str(), H5P_DEFAULT) > 0;  // false for a dangling link
}

std::vector<std::string> Hdf5File::list(const std::string& group) const {
  const GuardedRead guard(path_, kMostSeconds);
  keep_quiet();
  const Id id(H5Gopen2(handle_, group.c_str(), H5P_DEFAULT), H5Gclose);
  H5G_info_t info;
  if (!id.is_valid() || H5Gget_info(id, &info) < 0) {
    fail(path_, "group '" + group + "' is missing");
  }
  std::vector<std::string> names;
  for (hsize_t k = 0; k < info.nlinks; ++k) {
    const ssize_t size =
        H5Lget_name_by_idx(id, ".", H5_INDEX_NAME, H5_ITER_INC, k, nullptr, 0, H5P_DEFAULT);
    if (size < 0) fail(path_, "group '" + group + "' cannot be read; the file is damaged");
    std::vector<char> name(size + 1);
    H5Lget_name_by_idx(id, ".", H5_INDEX_NAME, H5_ITER_INC, k, name.data(), name.size(),
                       H5P_DEFAULT);
    names.emplace_back(name.data());
  }
  std::sort(names.begin(), names.end());
  return names;
}

Dims Hdf5File::dims(const std::string& name) const {
  const GuardedRead guard(path_, kMostSeconds);
  keep_quiet();
  return Array(handle_, path_, name, !temporary_path_.empty()).dims;
}

void Hdf5File::read_raw(const std::string& name, void* data, Hdf5Type memory) const {
  const GuardedRead guard(path_, kMostSeconds);
  keep_quiet();
  const Array array(handle_, path_, name, !temporary_path_.empty());
  require_numbers(array);
  bool is_misfit = false;
  const Id transfer = make_transfer(&is_misfit);
  const herr_t status = H5Dread(array.id, memory_type(memory), H5S_ALL, H5S_ALL, transfer, data);
  check_read(status, is_misfit, array.where);
}

void Hdf5File::read_rows_raw(const std::string& name, int64_t first, int64_t rows, void* data,
                             Hdf5Type memory) const {
  const GuardedRead guard(path_, kMostSeconds);
  keep_quiet();
  const Array array(handle_, path_, name, !temporary_path_.empty());
  require_numbers(array);
  const Id file_space(H5Dget_space(array.id), H5Sclose);
  const Id memory_space = select_rows(file_space, array.dims, first, rows, array.where);
  bool is_misfit = false;
  const Id transfer = make_transfer(&is_misfit);
  const herr_t status =
      H5Dread(array.id, memory_type(memory), memory_space, file_space, transfer, data);
  check_read(status, is_misfit, array.where);
}

Eigen::MatrixXd Hdf5File::read_matrix(const std::string& name) const {
  const Dims shape = dims(name);
  if (shape.size() != 2) {
    fail(path_, "array '" + name + "' has shape " + dims_text(shape) + "; expected 2 dimensions");
  }
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> matrix(shape[0], shape[1]);
  read_raw(name, matrix.data(), Hdf5Type::kFloat64);
  return matrix;
}

std::vector<std::string> Hdf5File::read_texts(const std::string& name) const {
  const GuardedRead guard(path_, kMostSeconds);
  keep_quiet();
  const Array array(handle_, path_, name, !temporary_path_.empty());
  const Id type(H5Dget_type(array.id), H5Tclose), space(H5Dget_space(array.id), H5Sclose);
  if (H5Tget_class(type) != H5T_STRING) throw InputError(array.where + " does not hold texts");
  std::vector<std::string> texts;
  const bool is_read = read_texts_by(
      type, space, static_cast<size_t>(count(array.dims)),
      [&](hid_t memory, void* data) {
        return H5Dread(array.id, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
      },
      texts);
  check_read(is_read ? 0 : -1, false, array.where);
  return texts;
}

// Variable length, which h5py gives back as str, and which has no 64 KB limit.
void Hdf5File::write_attribute(const std::string& object, const std::string& name,
                               const std::string& text) {
  const Id type = text_type();
  const char* pointer = text.c_str();
  write_scalar_attribute(handle_, path_, object, name, type, type, &pointer);
}

void Hdf5File::write_attribute(const std::string& object, const std::string& name, double number) {
  write_scalar_attribute(handle_, path_, object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &number);
}

void Hdf5File::write_attribute(const std::string& object, const std::string& name, int64_t number) {
  write_scalar_attribute(handle_, path_, object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &number);
}

void Hdf5File::mark_as_image(const std::string& name) {
  for (const auto& [attribute, text] :
       {std::pair<std::string, std::string>("CLASS", "IMAGE"),
        std::pair<std::string, std::string>("IMAGE_VERSION", "1.2"),
        std::pair<std::string, std::string>("IMAGE_SUBCLASS", "IMAGE_GRAYSCALE")}) {
    const Id type(H5Tcopy(H5T_C_S1), H5Tclose);  // of fixed length, as the specification has it
    H5Tset_size(type, text.size() + 1);
    write_scalar_attribute(handle_, path_, name, attribute, type, type, text.c_str());
  }
}

bool Hdf5File::has_attribute(const std::string& object, const std::string& name) const {
  const GuardedRead guard(path_, kMostSeconds);
  keep_quiet();
  return has(object) && H5Aexists_by_name(handle_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::string Hdf5File::text_attribute(const std::string& object, const std::string& name) const {
  const GuardedRead guard(path_, kMostSeconds);
  keep_quiet();
  const Attribute attribute(handle_, path_, object, name);
  if (H5Tget_class(attribute.type) != H5T_STRING) {
    throw InputError(attribute.where + " is not a text");
  }
  std::vector<std::string> texts;
  const bool is_read = read_texts_by(
      attribute.type, attribute.space, 1,
      [&](hid_t memory, void* data) { return H5Aread(attribute.id, memory, data); }, texts);
  check_read(is_read ? 0 : -1, false, attribute.where);
  return texts[0];
}

double Hdf5File::number_attribute(const std::string& object, const std::string& name) const {
  const GuardedRead guard(path_, kMostSeconds);
  keep_quiet();
  const Attribute attribute(handle_, path_, object, name);
  if (!is_number(attribute.type)) throw InputError(attribute.where + " is not a number");
  double number = 0;
  check_read(H5Aread(attribute.id, H5T_NATIVE_DOUBLE, &number), false, attribute.where);
  return number;
}

}  // namespace pleat
