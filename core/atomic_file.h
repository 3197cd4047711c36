// Files that appear whole or not at all: written under a temporary name, then renamed.
#pragma once

#include <string>

namespace pleat {

// What follows throws ResourceError where the disk is full.

// Makes an empty file of an unused name beside `path` and returns its name. InputError where it
// cannot.
std::string make_temporary_file(const std::string& path);

// fsync of the temporary file, rename to `path`, fsync of the folder. InputError naming `path`.
void publish_file(const std::string& temporary_path, const std::string& path);

// All of `bytes` at `path`, or what was there before.
void write_file_atomically(const std::string& path, const std::string& bytes);

}  // namespace pleat
