#include "core/npz_file.h"

#include <zip.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>

#include "core/atomic_file.h"
#include "core/error.h"

namespace pleat {
namespace {

// The .npy format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
constexpr char kMagic[] = "\x93NUMPY";
constexpr size_t kMagicSize = 6;
constexpr size_t kMaxHeaderSize = 1 << 16;
constexpr size_t kMaxRank = 32;  // NumPy's own

struct ElementType {
  char kind = 0;    // as NumPy's: f i u b, U and S texts, O pickled Python objects, V structures
  size_t size = 0;  // bytes
  bool is_big_endian = false;
};

struct NpyHeader {
  ElementType type;
  bool is_fortran_order = false;
  std::vector<int64_t> shape;
  uint64_t count = 1;  // elements
};

// Reads the Python literal of an .npy header: a dict of text, bool and tuple.
class HeaderParser {
 public:
  HeaderParser(const std::string& text, const std::string& where) : text_(text), where_(where) {}

  NpyHeader parse() {
    NpyHeader header;
    bool has_type = false, has_order = false, has_shape = false;
    expect('{');
    while (!accept('}')) {
      const std::string key = quoted();
      expect(':');
      if (key == "descr") {
        header.type = element_type();
        has_type = true;
      } else if (key == "fortran_order") {
        header.is_fortran_order = boolean();
        has_order = true;
      } else if (key == "shape") {
        header.shape = tuple();
        has_shape = true;
      } else {
        fail();
      }
      if (!accept(',')) {
        expect('}');
        break;
      }
    }
    if (!has_type || !has_order || !has_shape) fail();
    for (const int64_t extent : header.shape) {
      if (extent != 0 && header.count > (uint64_t{1} << 60) / static_cast<uint64_t>(extent)) fail();
      header.count *= static_cast<uint64_t>(extent);
    }
    return header;
  }

 private:
  [[noreturn]] void fail() const { throw InputError(where_ + " has a damaged NumPy header"); }

  void skip_spaces() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n')) ++at_;
  }
  bool accept(char c) {
    skip_spaces();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void expect(char c) {
    if (!accept(c)) fail();
  }
  std::string quoted() {
    const char quote = accept('\'') ? '\'' : '"';
    if (quote == '"') expect('"');
    const size_t end = text_.find(quote, at_);
    if (end == std::string::npos) fail();
    const std::string result = text_.substr(at_, end - at_);
    at_ = end + 1;
    return result;
  }
  bool boolean() {
    skip_spaces();
    for (const auto& [word, value] : {std::pair{"True", true}, std::pair{"False", false}}) {
      if (text_.compare(at_, std::strlen(word), word) == 0) {
        at_ += std::strlen(word);
        return value;
      }
    }
    fail();
  }
  int64_t number() {
    skip_spaces();
    int64_t value = 0;
    const size_t begin = at_;
    while (at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9') {
      if (at_ - begin >= 18) fail();
      value = 10 * value + (text_[at_++] - '0');
    }
    if (at_ == begin) fail();
    accept('L');  // as Python 2 wrote long integers
    return value;
  }
  std::vector<int64_t> tuple() {
    std::vector<int64_t> result;
    expect('(');
    while (!accept(')')) {
      if (result.size() == kMaxRank) fail();
      result.push_back(number());
      if (!accept(',')) {
        expect(')');
        break;
      }
    }
    return result;
  }
  ElementType element_type() {
    skip_spaces();
    if (at_ < text_.size() && text_[at_] == '[') {  // structure: skip to the matching bracket
      int depth = 0;
      for (; at_ < text_.size(); ++at_) {
        depth += (text_[at_] == '[') - (text_[at_] == ']');
        if (depth == 0) break;
      }
      if (depth != 0) fail();
      ++at_;
      return {'V', 0, false};
    }
    const std::string code = quoted();
    if (code.size() < 2 || std::strchr("<>|=", code[0]) == nullptr) fail();
    ElementType type{code[1], 0, code[0] == '>'};
    for (size_t k = 2; k < code.size(); ++k) {
      if (code[k] < '0' || code[k] > '9' || k > 9) return {'V', 0, false};  // such as <M8[ns]
      type.size = 10 * type.size + (code[k] - '0');
    }
    if (type.kind == 'U') type.size *= 4;  // UTF-32
    return type;
  }

  const std::string& text_;
  const std::string& where_;
  size_t at_ = 0;
};

bool is_text_kind(char kind) { return kind == 'U' || kind == 'S'; }

// One member of the archive, opened just after its .npy header.
class Member {
 public:
  Member(zip_t* archive, const std::string& path, const std::string& key)
      : where_(path + ": array '" + key + "'") {
    const zip_int64_t index = zip_name_locate(archive, (key + ".npy").c_str(), 0);
    if (index < 0) throw InputError(where_ + " is missing");
    zip_stat_t stat;
    constexpr zip_uint64_t kWanted = ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE;
    if (zip_stat_index(archive, index, 0, &stat) != 0 || (stat.valid & kWanted) != kWanted) {
      throw InputError(where_ + " has no readable size");
    }
    // Deflate reaches 1032 to 1; what claims more would only fill the memory.
    std::error_code error;
    const uint64_t file_size = std::filesystem::file_size(path, error);
    if (error || stat.comp_size > file_size || stat.size / 1100 > stat.comp_size + 1) {
      throw InputError(where_ + " claims " + std::to_string(stat.size) +
                       " bytes, more than the archive can hold; the file is damaged");
    }
    file_ = zip_fopen_index(archive, index, 0);
    if (file_ == nullptr) {
      throw InputError(where_ + " cannot be opened: " + zip_strerror(archive));
    }
    try {
      read_header(stat.size);
    } catch (...) {
      zip_fclose(file_);
      throw;
    }
  }
  ~Member() { zip_fclose(file_); }
  Member(const Member&) = delete;
  Member& operator=(const Member&) = delete;

  const NpyHeader& header() const { return header_; }
  const std::string& where() const { return where_; }

  void read(void* bytes, uint64_t size) {
    char* at = static_cast<char*>(bytes);
    while (size > 0) {
      const zip_int64_t count = zip_fread(file_, at, size);
      if (count <= 0)
        throw InputError(where_ + " cannot be read; the file is truncated or damaged");
      at += count;
      size -= static_cast<uint64_t>(count);
    }
  }

  // libzip compares the checksum when it meets the end.
  void expect_end() {
    char byte;
    if (zip_fread(file_, &byte, 1) != 0) {
      throw InputError(where_ + " has a wrong checksum; the file is damaged");
    }
  }

 private:
  void read_header(uint64_t member_size) {
    const auto require = [&](bool is_good) {
      if (!is_good) throw InputError(where_ + " is not a NumPy array");
    };
    require(member_size >= kMagicSize + 6);
    unsigned char start[kMagicSize + 6];
    read(start, kMagicSize + 4);
    require(std::memcmp(start, kMagic, kMagicSize) == 0);
    const int major = start[kMagicSize];
    require(major >= 1 && major <= 3);
    size_t header_size = start[8] | start[9] << 8;
    size_t offset = kMagicSize + 4;
    if (major >= 2) {
      read(start + 10, 2);
      header_size |= static_cast<size_t>(start[10]) << 16 | static_cast<size_t>(start[11]) << 24;
      offset += 2;
    }
    require(header_size <= kMaxHeaderSize && header_size <= member_size - offset);
    std::string text(header_size, '\0');
    read(text.data(), text.size());
    header_ = HeaderParser(text, where_).parse();
    if (header_.type.kind == 'O' || header_.type.kind == 'V') return;  // shape only
    const uint64_t data_size = member_size - offset - header_size;
    const bool is_whole =
        header_.type.size == 0 || header_.count == 0
            ? data_size == 0
            : data_size % header_.type.size == 0 && data_size / header_.type.size == header_.count;
    if (!is_whole) {
      throw InputError(where_ + " has " + std::to_string(data_size) +
                       " bytes of data, which is not what its shape needs; the file is damaged");
    }
  }

  std::string where_;
  zip_file_t* file_ = nullptr;
  NpyHeader header_;
};

template <typename T>
double number_at(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

using ToNumber = double (*)(const char*);

// Null for element types that are not numbers.
ToNumber number_reader(const ElementType& type) {
  switch (type.kind) {
    case 'f':
      return type.size == 4 ? number_at<float> : type.size == 8 ? number_at<double> : nullptr;
    case 'b':
      return type.size == 1 ? number_at<uint8_t> : nullptr;
    case 'i':
      return type.size == 1   ? number_at<int8_t>
             : type.size == 2 ? number_at<int16_t>
             : type.size == 4 ? number_at<int32_t>
             : type.size == 8 ? number_at<int64_t>
                              : nullptr;
    case 'u':
      return type.size == 1   ? number_at<uint8_t>
             : type.size == 2 ? number_at<uint16_t>
             : type.size == 4 ? number_at<uint32_t>
             : type.size == 8 ? number_at<uint64_t>
                              : nullptr;
    default:
      return nullptr;
  }
}

std::vector<double> to_c_order(const std::vector<double>& values,
                               const std::vector<int64_t>& shape) {
  std::vector<double> result(values.size());
  std::vector<int64_t> index(shape.size(), 0);
  for (const double value : values) {  // the first index runs fastest
    int64_t position = 0;
    for (size_t k = 0; k < shape.size(); ++k) position = position * shape[k] + index[k];
    result[position] = value;
    for (size_t k = 0; k < shape.size() && ++index[k] == shape[k]; ++k) index[k] = 0;
  }
  return result;
}

[[noreturn]] void refuse_objects(const std::string& where) {
  throw InputError(where +
                   " is pickled (dtype object): reading it could run code, so Pleat does not. "
                   "Where you trust the "
                   "file, re-save its numbers in Python: d = np.load('in.npz', allow_pickle=True); "
                   "np.savez('out.npz', **{k: d[k] for k in d.files if d[k].dtype != object})");
}

void append_utf8(std::string& text, uint32_t c) {
  if (c < 0x80) {
    text += static_cast<char>(c);
  } else if (c < 0x800) {
    text += static_cast<char>(0xC0 | c >> 6);
    text += static_cast<char>(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    text += static_cast<char>(0xE0 | c >> 12);
    text += static_cast<char>(0x80 | (c >> 6 & 0x3F));
    text += static_cast<char>(0x80 | (c & 0x3F));
  } else {
    text += static_cast<char>(0xF0 | c >> 18);
    text += static_cast<char>(0x80 | (c >> 12 & 0x3F));
    text += static_cast<char>(0x80 | (c >> 6 & 0x3F));
    text += static_cast<char>(0x80 | (c & 0x3F));
  }
}

// Code points of UTF-8 that this program made or was configured with; anything else is refused.
std::vector<uint32_t> code_points(const std::string& text) {
  std::vector<uint32_t> result;
  for (size_t at = 0; at < text.size();) {
    const unsigned char lead = text[at];
    const int extra = lead < 0x80       ? 0
                      : lead >> 5 == 6  ? 1
                      : lead >> 4 == 14 ? 2
                      : lead >> 3 == 30 ? 3
                                        : -1;
    if (extra < 0 || at + extra >= text.size()) throw InputError("text to store is not UTF-8");
    uint32_t c = extra == 0 ? lead : lead & (0x3F >> extra);
    for (int k = 1; k <= extra; ++k) c = c << 6 | (text[at + k] & 0x3F);
    result.push_back(c);
    at += extra + 1;
  }
  return result;
}

template <typename T>
void append_numbers(std::string& bytes, const std::vector<double>& values, const std::string& key) {
  for (const double value : values) {
    if (std::is_integral_v<T> && !(value == std::floor(value) &&
                                   value >= static_cast<double>(std::numeric_limits<T>::min()) &&
                                   value <= static_cast<double>(std::numeric_limits<T>::max()))) {
      throw InputError("array '" + key + "' holds " + std::to_string(value) +
                       ", which does not fit the integer type to store");
    }
    const T number = static_cast<T>(value);
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
}

// The .npy file of an entry.
std::string npy_bytes(const NpzEntry& entry) {
  std::string data, type = entry.dtype;
  std::vector<int64_t> shape = entry.array.shape;
  if (entry.dtype == "text") {
    const std::vector<uint32_t> points = code_points(entry.text);
    data.assign(reinterpret_cast<const char*>(points.data()), 4 * points.size());
    type = "<U" + std::to_string(points.size());
    shape.clear();
  } else {
    if (entry.array.size() != static_cast<int64_t>(entry.array.values.size())) {
      throw std::invalid_argument("array '" + entry.key + "' has " +
                                  std::to_string(entry.array.values.size()) + " values for " +
                                  std::to_string(entry.array.size()) + " places");
    }
    if (type == "<f8") {
      append_numbers<double>(data, entry.array.values, entry.key);
    } else if (type == "<f4") {
      append_numbers<float>(data, entry.array.values, entry.key);
    } else if (type == "<i4") {
      append_numbers<int32_t>(data, entry.array.values, entry.key);
    } else if (type == "<u4") {
      append_numbers<uint32_t>(data, entry.array.values, entry.key);
    } else {
      throw std::invalid_argument("array '" + entry.key + "': no dtype " + type);
    }
  }
  std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (";
  for (size_t k = 0; k < shape.size(); ++k) {
    header += (k ? ", " : "") + std::to_string(shape[k]) + (shape.size() == 1 ? "," : "");
  }
  header += "), }";
  constexpr size_t kAlignment = 64;
  const size_t unpadded = kMagicSize + 4 + header.size() + 1;
  header.append((kAlignment - unpadded % kAlignment) % kAlignment, ' ');
  header += '\n';
  std::string bytes(kMagic, kMagicSize);
  bytes += '\x01';
  bytes += '\x00';
  bytes += static_cast<char>(header.size() & 0xFF);
  bytes += static_cast<char>(header.size() >> 8);
  return bytes + header + data;
}

}  // namespace

int64_t NpyArray::size() const {
  int64_t result = 1;
  for (const int64_t extent : shape) result *= extent;
  return result;
}

NpzFile::NpzFile(std::string path) : path_(std::move(path)) {
  std::error_code error;
  if (!std::filesystem::exists(path_, error)) throw InputError(path_ + ": no such file");
  if (!std::filesystem::is_regular_file(path_, error)) throw InputError(path_ + ": is not a file");
  int code = 0;
  archive_ = zip_open(path_.c_str(), ZIP_RDONLY, &code);
  if (archive_ != nullptr) return;
  char start[2] = {};
  std::ifstream(path_, std::ios::binary).read(start, sizeof start);
  if (start[0] == '\x80' || (start[0] == 'c' && start[1] == 'c') ||
      (start[0] == '(' && start[1] == 'd')) {
    throw InputError(
        path_ +
        ": is a Python pickle: reading it could run code, so Pleat does not. Where you trust the "
        "file, "
        "convert it in Python: d = pickle.load(open('in.pkl', 'rb'), encoding='latin1'); "
        "np.savez('out.npz', **{k: np.asarray(getattr(v, 'toarray', lambda: v)()) for k, v in "
        "d.items()})");
  }
  throw InputError(path_ + ": is not a NumPy .npz archive, or is truncated");
}

NpzFile::~NpzFile() { zip_discard(static_cast<zip_t*>(archive_)); }

std::vector<std::string> NpzFile::keys() const {
  zip_t* archive = static_cast<zip_t*>(archive_);
  std::vector<std::string> result;
  const std::string ending = ".npy";
  for (zip_int64_t k = 0; k < zip_get_num_entries(archive, 0); ++k) {
    const char* name = zip_get_name(archive, k, 0);
    std::string key = name == nullptr ? "" : name;
    if (key.size() <= ending.size()) continue;
    if (key.compare(key.size() - ending.size(), ending.size(), ending) != 0) continue;
    key.resize(key.size() - ending.size());
    result.push_back(key);
  }
  std::sort(result.begin(), result.end());
  return result;
}

bool NpzFile::has(const std::string& key) const {
  return zip_name_locate(static_cast<zip_t*>(archive_), (key + ".npy").c_str(), 0) >= 0;
}

std::vector<int64_t> NpzFile::shape(const std::string& key) const {
  return Member(static_cast<zip_t*>(archive_), path_, key).header().shape;
}

bool NpzFile::is_text(const std::string& key) const {
  return is_text_kind(Member(static_cast<zip_t*>(archive_), path_, key).header().type.kind);
}

NpyArray NpzFile::read(const std::string& key) const {
  Member member(static_cast<zip_t*>(archive_), path_, key);
  const NpyHeader& header = member.header();
  if (header.type.kind == 'O') refuse_objects(member.where());
  const ToNumber to_number = number_reader(header.type);
  if (to_number == nullptr) {
    throw InputError(member.where() +
                     " holds no numbers of a type that Pleat reads (float32, "
                     "float64, integers, bool)");
  }
  NpyArray array{header.shape, {}};
  array.values.reserve(header.count);
  constexpr uint64_t kBlock = 8192;  // elements
  const size_t size = header.type.size;
  std::vector<char> bytes(kBlock * size);
  for (uint64_t done = 0; done < header.count;) {
    const uint64_t count = std::min(kBlock, header.count - done);
    member.read(bytes.data(), count * size);
    for (uint64_t k = 0; k < count; ++k) {
      char* element = bytes.data() + k * size;
      if (header.type.is_big_endian) std::reverse(element, element + size);
      array.values.push_back(to_number(element));
    }
    done += count;
  }
  member.expect_end();
  if (header.is_fortran_order) array.values = to_c_order(array.values, array.shape);
  return array;
}

std::string NpzFile::read_text(const std::string& key) const {
  Member member(static_cast<zip_t*>(archive_), path_, key);
  const NpyHeader& header = member.header();
  if (header.type.kind == 'O') refuse_objects(member.where());
  if (!is_text_kind(header.type.kind) || header.count != 1) {
    throw InputError(member.where() + " is not a single text");
  }
  std::string bytes(header.type.size, '\0');
  member.read(bytes.data(), bytes.size());
  member.expect_end();
  if (header.type.kind == 'S') {
    bytes.erase(bytes.find_last_not_of('\0') + 1);
    return bytes;
  }
  std::string text;
  for (size_t at = 0; at + 4 <= bytes.size(); at += 4) {
    if (header.type.is_big_endian) std::reverse(&bytes[at], &bytes[at] + 4);
    uint32_t c;
    std::memcpy(&c, &bytes[at], 4);
    if (c == 0) break;
    if (c > 0x10FFFF || (c >= 0xD800 && c < 0xE000)) {
      throw InputError(member.where() + " holds a character that is not Unicode");
    }
    append_utf8(text, c);
  }
  return text;
}

void write_npz(const std::string& path, const std::vector<NpzEntry>& entries) {
  const auto fail = [&path](const char* reason) {
    throw InputError(path + ": cannot be written: " + reason);
  };
  assert(!entries.empty());  // libzip makes no archive of nothing
  std::vector<std::string> members;
  for (const NpzEntry& entry : entries) members.push_back(npy_bytes(entry));

  // The archive is made in memory, then written in one piece.
  const std::unique_ptr<zip_source_t, void (*)(zip_source_t*)> buffer(
      zip_source_buffer_create(nullptr, 0, 0, nullptr), zip_source_free);
  if (!buffer) fail("out of memory");
  zip_source_keep(buffer.get());  // one for the archive, one for reading it back
  zip_t* archive = zip_open_from_source(buffer.get(), ZIP_TRUNCATE, nullptr);
  if (archive == nullptr) {
    zip_source_free(buffer.get());
    fail("out of memory");
  }
  constexpr zip_uint16_t kFirstOfJanuary1980 = 1 << 5 | 1;  // MS-DOS date; no clock, no time zone
  for (size_t k = 0; k < entries.size(); ++k) {
    zip_source_t* source = zip_source_buffer(archive, members[k].data(), members[k].size(), 0);
    const zip_int64_t index =
        zip_file_add(archive, (entries[k].key + ".npy").c_str(), source, ZIP_FL_ENC_UTF_8);
    if (index < 0) {
      const std::string reason = zip_strerror(archive);
      zip_source_free(source);
      zip_discard(archive);
      fail((entries[k].key + ": " + reason).c_str());
    }
    zip_set_file_compression(archive, index, ZIP_CM_DEFLATE, 6);
    zip_file_set_dostime(archive, index, 0, kFirstOfJanuary1980, 0);
  }
  if (zip_close(archive) != 0) {
    const std::string reason = zip_strerror(archive);
    zip_discard(archive);
    fail(reason.c_str());
  }
  zip_stat_t stat;
  std::string bytes;
  if (zip_source_open(buffer.get()) != 0 || zip_source_stat(buffer.get(), &stat) != 0) {
    fail("the archive cannot be read back");
  }
  bytes.resize(stat.size);
  const zip_int64_t count = zip_source_read(buffer.get(), bytes.data(), bytes.size());
  zip_source_close(buffer.get());
  if (count != static_cast<zip_int64_t>(bytes.size())) fail("the archive cannot be read back");
  write_file_atomically(path, bytes);
}

}  // namespace pleat
