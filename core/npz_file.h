// NumPy .npz archives, read lazily, key by key: SMPL-X files hold pickled arrays that must not be
// touched.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace pleat {

// A NumPy array in C order, whatever the order and number type in the file.
struct NpyArray {
  std::vector<int64_t> shape;
  std::vector<double> values;
  int64_t size() const;
};

class NpzFile {
 public:
  // Throws InputError for a missing, truncated or foreign file.
  explicit NpzFile(std::string path);
  ~NpzFile();
  NpzFile(const NpzFile&) = delete;
  NpzFile& operator=(const NpzFile&) = delete;

  const std::string& path() const { return path_; }
  std::vector<std::string> keys() const;  // sorted, without ".npy"
  bool has(const std::string& key) const;
  std::vector<int64_t> shape(const std::string& key) const;
  // Numbers and booleans as double. Throws InputError naming file and key: missing, truncated,
  // pickled (object dtype), or larger than the archive says.
  NpyArray read(const std::string& key) const;
  // Zero-dimensional or single text value stored as <U or |S.
  std::string read_text(const std::string& key) const;
  bool is_text(const std::string& key) const;

 private:
  std::string path_;
  void* archive_ = nullptr;  // zip_t
};

// One array to write: float64 ("<f8"), float32 ("<f4"), int32 ("<i4"), uint32 ("<u4") or text.
struct NpzEntry {
  std::string key;
  std::string dtype;  // one of the above; "text" writes `text` as <U
  NpyArray array;
  std::string text;
};
// Stored deflated, with fixed times, so equal content gives equal bytes. Temporary file, fsync,
// rename.
void write_npz(const std::string& path, const std::vector<NpzEntry>& entries);

}  // namespace pleat
