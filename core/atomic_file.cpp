#include "core/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <random>

#include "core/error.h"

namespace pleat {
namespace {

[[noreturn]] void fail(const std::string& path, int error) {
  if (error == ENOSPC || error == EDQUOT)
    throw ResourceError(path + ": cannot be written: " + std::strerror(error) +
                        "; make room and give the same command again");
  throw InputError(path + ": cannot be written: " + std::strerror(error));
}

// fsync by path: HDF5 and others keep their descriptors to themselves.
int sync_path(const std::string& path, int flags) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC);
  if (descriptor < 0) return errno;
  // Some file systems cannot sync a folder and say EINVAL; the rename stands all the same.
  const int error = ::fsync(descriptor) != 0 && errno != EINVAL ? errno : 0;
  ::close(descriptor);
  return error;
}

}  // namespace

std::string make_temporary_file(const std::string& path) {
  if (std::filesystem::is_directory(path)) fail(path, EISDIR);
  std::random_device random;  // not a result: only a name that no other process has
  for (int attempt = 0; attempt < 100; ++attempt) {
    char suffix[32];
    std::snprintf(suffix, sizeof suffix, ".tmp-%08x%08x", random(), random());
    const std::string temporary_path = path + suffix;
    const int descriptor =
        ::open(temporary_path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
      ::close(descriptor);
      return temporary_path;
    }
    if (errno != EEXIST) fail(path, errno);
  }
  fail(path, EEXIST);
}

void publish_file(const std::string& temporary_path, const std::string& path) {
  int error = sync_path(temporary_path, O_RDONLY);
  if (error == 0 && std::rename(temporary_path.c_str(), path.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(temporary_path.c_str());
    fail(path, error);
  }
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  error = sync_path(folder.empty() ? "." : folder.string(), O_RDONLY | O_DIRECTORY);
  if (error != 0) fail(path, error);
}

void write_file_atomically(const std::string& path, const std::string& bytes) {
  const std::string temporary_path = make_temporary_file(path);
  std::FILE* file = std::fopen(temporary_path.c_str(), "wb");
  int error = file == nullptr ? errno : 0;
  if (file != nullptr) {
    if (std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size()) error = errno;
    if (std::fclose(file) != 0 && error == 0) error = errno;
  }
  if (error != 0) {
    ::unlink(temporary_path.c_str());
    fail(path, error);
  }
  publish_file(temporary_path, path);
}

}  // namespace pleat
