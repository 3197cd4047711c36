#include "campaign/crew.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/error.h"
#include "tests/core/input_error.h"

namespace pleat::campaign {
namespace {

TEST(Crew, DoesEveryTaskOnce) {
  for (const int threads : {1, 3}) {
    std::vector<std::atomic<int>> done(50);
    Crew(threads, {}, 600).run(50, [&](int i) { ++done[i]; });
    for (const std::atomic<int>& times : done) EXPECT_EQ(times, 1);
  }
}

TEST(Crew, ThrowsWhatATaskThrowsAndAsksTheOthersToStop) {
  Crew crew(1, {}, 600);
  int done = 0;
  EXPECT_INPUT_ERROR(crew.run(10,
                              [&](int i) {
                                if (i == 3) throw InputError("task 3");
                                ++done;
                              }),
                     "task 3");
  EXPECT_EQ(done, 3);
  EXPECT_TRUE(crew.should_stop());
}

TEST(Crew, HoldsTheProcessToItsMemory) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        Limits limits;
        limits.max_memory_mb = 200;
        std::string message;
        try {
          Crew(4, limits, 600).run(1, [](int) {
            std::vector<double> much(100'000'000, 1.0);  // 800 MB
            if (much[12345] > 2) std::abort();
          });
        } catch (const ResourceError& error) {
          message = error.what();
        }
        std::_Exit(message.find("limits.max_memory_mb") == std::string::npos ? 1 : 0);
      },
      testing::ExitedWithCode(0), "");
}

TEST(Crew, RefusesBoundsThatAreNone) {
  EXPECT_NO_THROW(validate(Limits{}));
  EXPECT_INPUT_ERROR(validate(Limits{-1, 0, 0}), "limits.max_seconds_per_drape");
  EXPECT_INPUT_ERROR(validate(Limits{0, -1, 0}), "limits.max_memory_mb");
  EXPECT_INPUT_ERROR(validate(Limits{0, 0, -1}), "limits.min_free_disk_mb");
}

}  // namespace
}  // namespace pleat::campaign
