// Archives changed by hand: entries of a good file to alter, and arrays that the product never
// writes.
#pragma once

#include <gtest/gtest.h>
#include <zip.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/npz_file.h"

namespace pleat::body {

inline std::vector<NpzEntry> entries_of(const std::string& path) {
  const NpzFile file(path);
  std::vector<NpzEntry> entries;
  for (const std::string& key : file.keys()) {
    if (file.is_text(key)) {
      entries.push_back({key, "text", {}, file.read_text(key)});
    } else {
      entries.push_back({key, "<f8", file.read(key), ""});
    }
  }
  return entries;
}

inline NpyArray& array_of(std::vector<NpzEntry>& entries, const std::string& key) {
  return std::find_if(entries.begin(), entries.end(),
                      [&](const NpzEntry& e) { return e.key == key; })
      ->array;
}

inline void remove_entry(std::vector<NpzEntry>& entries, const std::string& key) {
  entries.erase(std::remove_if(entries.begin(), entries.end(),
                               [&](const NpzEntry& e) { return e.key == key; }),
                entries.end());
}

// Adds key.npy of any dtype, such as '|S6' (bytes) or '|O' (a pickle).
inline void add_raw(const std::string& path, const std::string& key, const std::string& dtype,
                    const std::string& data) {
  const std::string header = "{'descr': '" + dtype + "', 'fortran_order': False, 'shape': (), }\n";
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size());
  bytes += '\0';
  bytes += header + data;
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE, nullptr);
  zip_file_add(archive, (key + ".npy").c_str(),
               zip_source_buffer(archive, bytes.data(), bytes.size(), 0), 0);
  ASSERT_EQ(zip_close(archive), 0);
}

}  // namespace pleat::body
