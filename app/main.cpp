// `pleat` itself: everything but learning. LibTorch takes a second and 160 MB to load, so commands
// that learn are those of `pleat-learn`, which lies beside this program.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <system_error>

#include "app/program.h"

namespace {

void go_on_as_learner(int argc, char** argv) {
  const std::set<std::string> learning = {"run", "train", "sample", "evaluate"};
  if (argc < 2 || !learning.count(argv[1])) return;
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return;
  // OpenMP's threads spin at barriers unless told otherwise before the process starts, which slows
  // learning several-fold where anything else wants a core.
  setenv("OMP_WAIT_POLICY", "passive", 0);
  execv((self.parent_path() / "pleat-learn").c_str(), argv);  // returns only where there is none
}

}  // namespace

int main(int argc, char** argv) {
  go_on_as_learner(argc, argv);
  return pleat::app::run_program(argc, argv, {});
}
