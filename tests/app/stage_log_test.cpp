#include "app/stage_log.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/core/scratch.h"

namespace pleat::app {
namespace {

TEST(StageLog, FindsWhatFinishedForTheSameInputs) {
  const Scratch scratch;
  const std::string file = scratch.path("dataset.h5");
  const StageLog log(scratch.path(""));
  EXPECT_FALSE(log.find("encode", "key", file));
  log.write("encode", {"key", 12.5, "say \"500 frames\""});
  EXPECT_FALSE(log.find("encode", "key", file)) << "its file is not there";
  write_bytes(file, "data");
  const auto record = StageLog(scratch.path("")).find("encode", "key", file);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->seconds, 12.5);
  EXPECT_EQ(record->summary, "say \"500 frames\"");
  EXPECT_FALSE(log.find("encode", "other", file));
  EXPECT_FALSE(log.find("train", "key", file));
  log.write("encode", {"other", 1, ""});
  EXPECT_FALSE(log.find("encode", "key", file));
  std::filesystem::remove(file);
  EXPECT_FALSE(log.find("encode", "other", file));
}

TEST(StageLog, TakesADamagedRecordForNone) {
  const Scratch scratch;
  const std::string file = scratch.path("dataset.h5");
  write_bytes(file, "data");
  const StageLog log(scratch.path(""));
  log.write("encode", {"key", 1, ""});
  for (const std::string text :
       {"", "{\"key\": \"k", "[]", "{\"key\": 5}", "{\"key\": \"key\", \"seconds\": \"long\"}",
        "{\"key\": \"key\", \"summary\": [1]}"}) {
    write_bytes(scratch.path("stages/encode.json"), text);
    EXPECT_FALSE(log.find("encode", "key", file)) << text;
  }
}

}  // namespace
}  // namespace pleat::app
