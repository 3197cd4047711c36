#include "core/guarded_read.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <ctime>

namespace pleat {
namespace {

void compute_for(double seconds) {
  const std::clock_t start = std::clock();
  while (static_cast<double>(std::clock() - start) < seconds * CLOCKS_PER_SEC) {
  }
}

TEST(GuardedRead, EndsWhatTakesTooLong) {
  EXPECT_EXIT(
      {
        const std::string path = "hostile.h5";
        const GuardedRead guard(path, 0.05);
        compute_for(10);
      },
      testing::ExitedWithCode(2), "hostile.h5: given up: it takes too long to read");
}

void crash_between_guards() {
  const std::string outer = "hostile.h5", inner = "good.h5";
  const GuardedRead guard(outer, 100);
  { const GuardedRead another(inner, 100); }
  raise(SIGSEGV);
}

TEST(GuardedRead, EndsWhatCrashes) {
  EXPECT_EXIT(crash_between_guards(), testing::ExitedWithCode(2),
              "hostile.h5: given up: the library that reads it has crashed");
}

TEST(GuardedRead, EndsWithItsScope) {
  const std::string path = "good.h5";
  { const GuardedRead guard(path, 0.05); }
  compute_for(0.1);  // what comes after it may take as long as it likes
  EXPECT_EXIT(
      {
        { const GuardedRead guard(path, 100); }
        signal(SIGSEGV, SIG_DFL);
        raise(SIGSEGV);
      },
      testing::KilledBySignal(SIGSEGV), "");
}

}  // namespace
}  // namespace pleat
