#include "core/profile.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace pleat {
namespace {

constexpr const char* kVariable = "PLEAT_PROFILE";
// What the libraries read as they are loaded. No FMA and AVX2: glibc has other code for exp, log,
// pow, sin, cos, tan, atan with these.
constexpr const char* kTunables = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F";
constexpr const char* kCore = "Prescott";

}  // namespace

bool is_profile(const std::string& name) { return name == "native" || name == "portable"; }

std::string current_profile() {
  const char* name = std::getenv(kVariable);
  return name && std::string(name) == "portable" ? "portable" : "native";
}

void enter_profile(const std::string& name, char** argv) {
  if (name == current_profile()) return;
  if (name == "portable") {
    setenv(kVariable, "portable", 1);
    setenv("GLIBC_TUNABLES", kTunables, 1);
    setenv("OPENBLAS_CORETYPE", kCore, 1);
  } else {
    unsetenv(kVariable);
    unsetenv("GLIBC_TUNABLES");
    unsetenv("OPENBLAS_CORETYPE");
  }
  ::execv("/proc/self/exe", argv);  // returns only where it fails
  throw std::runtime_error(std::string("cannot start again for `profile: ") + name +
                           "`: " + std::strerror(errno));
}

}  // namespace pleat
