// SHA-256, in hexadecimal digits: of texts, of files, of what comes bit by bit.
#pragma once

#include <cstdint>
#include <string>

struct evp_md_ctx_st;

namespace pleat {

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;
  void add(const void* bytes, size_t count);
  std::string hex();  // ends it

 private:
  evp_md_ctx_st* context_;
};

std::string sha256(const std::string& bytes);
// Of the bytes from `first` on. InputError where it cannot be read.
std::string sha256_of_file(const std::string& path, int64_t first = 0);

}  // namespace pleat
