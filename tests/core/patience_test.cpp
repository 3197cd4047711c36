#include "core/patience.h"

#include <gtest/gtest.h>

#include <ctime>

namespace pleat {
namespace {

void compute_for(double seconds) {
  const std::clock_t start = std::clock();
  while (static_cast<double>(std::clock() - start) < seconds * CLOCKS_PER_SEC) {
  }
}

TEST(Patience, EndsTheProcessWithTheFilesName) {
  EXPECT_EXIT(
      {
        const std::string path = "hostile.h5";
        const Patience patience(path, 0.05);
        compute_for(10);
      },
      testing::ExitedWithCode(2), "hostile.h5: given up: it takes too long to read");
}

TEST(Patience, EndsWithItsScope) {
  const std::string path = "good.h5";
  { const Patience patience(path, 0.05); }
  compute_for(0.1);  // what comes after it may take as long as it likes
  const Patience again(path, 100);
  compute_for(0.1);
}

}  // namespace
}  // namespace pleat
