#include "core/profile.h"

#include <dlfcn.h>
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
constexpr const char* kCoreVariable = "OPENBLAS_CORETYPE";

// OpenBLAS has its slowest code for processors that are newer than itself. Names the core whose
// code suits this one instead; null where OpenBLAS knew, or was told by the user.
const char* core_to_name() {
  if (std::getenv(kCoreVariable)) return nullptr;
  const auto core = reinterpret_cast<char* (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_corename"));
  if (!core || std::strcmp(core(), kCore) != 0) return nullptr;
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? "Haswell" : nullptr;
}

}  // namespace

bool is_profile(const std::string& name) { return name == "native" || name == "portable"; }

std::string current_profile() {
  const char* name = std::getenv(kVariable);
  return name && std::string(name) == "portable" ? "portable" : "native";
}

void enter_profile(const std::string& name, char** argv) {
  if (name == current_profile()) {
    const char* core = name == "native" ? core_to_name() : nullptr;
    if (!core) return;
    setenv(kCoreVariable, core, 1);
  } else if (name == "portable") {
    setenv(kVariable, "portable", 1);
    setenv("GLIBC_TUNABLES", kTunables, 1);
    setenv(kCoreVariable, kCore, 1);
  } else {
    unsetenv(kVariable);
    unsetenv("GLIBC_TUNABLES");
    unsetenv(kCoreVariable);
  }
  ::execv("/proc/self/exe", argv);  // returns only where it fails
  throw std::runtime_error(std::string("cannot start again for `profile: ") + name +
                           "`: " + std::strerror(errno));
}

}  // namespace pleat
