#include "core/sha256.h"

#include <openssl/evp.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <vector>

#include "core/error.h"

namespace pleat {
namespace {

void check(bool is_good) {
  if (!is_good) throw std::runtime_error("OpenSSL offers no SHA-256");
}

}  // namespace

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  check(context_ != nullptr && EVP_DigestInit_ex(context_, EVP_sha256(), nullptr) == 1);
}

Sha256::~Sha256() { EVP_MD_CTX_free(context_); }

void Sha256::add(const void* bytes, size_t count) {
  check(EVP_DigestUpdate(context_, bytes, count) == 1);
}

std::string Sha256::hex() {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  check(EVP_DigestFinal_ex(context_, digest, &size) == 1);
  std::string result;
  for (unsigned int k = 0; k < size; ++k) {
    char pair[3];
    std::snprintf(pair, sizeof pair, "%02x", digest[k]);
    result += pair;
  }
  return result;
}

std::string sha256(const std::string& bytes) {
  Sha256 hash;
  hash.add(bytes.data(), bytes.size());
  return hash.hex();
}

std::string sha256_of_file(const std::string& path, int64_t first) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             std::fclose);
  const auto fail = [&] { throw InputError(path + ": cannot be read: " + std::strerror(errno)); };
  if (!file || ::fseeko(file.get(), first, SEEK_SET) != 0) fail();
  Sha256 hash;
  std::vector<char> block(1 << 16);
  while (const size_t count = std::fread(block.data(), 1, block.size(), file.get()))
    hash.add(block.data(), count);
  if (std::ferror(file.get())) fail();
  return hash.hex();
}

}  // namespace pleat
