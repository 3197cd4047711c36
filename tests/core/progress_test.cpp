#include "core/progress.h"

#include <gtest/gtest.h>

#include <csignal>

namespace pleat {
namespace {

TEST(DurationText, SpeaksInTheUnitsOfItsLength) {
  EXPECT_EQ(duration_text(0), "0 s");
  EXPECT_EQ(duration_text(12.4), "12 s");
  EXPECT_EQ(duration_text(59.7), "1 min 00 s");
  EXPECT_EQ(duration_text(200), "3 min 20 s");
  EXPECT_EQ(duration_text(7500), "2 h 05 min");
  EXPECT_EQ(duration_text(3599.8), "1 h 00 min");
  EXPECT_EQ(duration_text(7199), "2 h 00 min");
}

TEST(Progress, EndsWithALineOfWhatWasDone) {
  testing::internal::CaptureStderr();
  {
    Progress progress("encode", 3, "frames");
    progress.advance(2);
    progress.advance(1, "all well");
  }
  const std::string line = testing::internal::GetCapturedStderr();
  EXPECT_NE(line.find("encode: 3 of 3 frames"), std::string::npos) << line;
  EXPECT_NE(line.find("all well"), std::string::npos) << line;
  EXPECT_EQ(line.find('\n'), line.size() - 1) << line;  // not a terminal: one plain line
}

TEST(Interrupts, AreNotedOnceAndThenEndTheProgram) {
  EXPECT_EXIT(
      {
        catch_interrupts();
        if (is_interrupted()) std::exit(1);
        std::raise(SIGTERM);
        if (!is_interrupted()) std::exit(2);
        std::raise(SIGINT);
        std::exit(3);
      },
      testing::KilledBySignal(SIGINT), "");
}

}  // namespace
}  // namespace pleat
