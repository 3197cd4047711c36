#include "campaign/task_slice.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <initializer_list>
#include <map>
#include <string>
#include <utility>

#include "tests/core/input_error.h"

namespace pleat::campaign {
namespace {

// Sets variables for as long as it lives.
class Environment {
 public:
  Environment(std::initializer_list<std::pair<const std::string, std::string>> variables)
      : variables_(variables) {
    for (const auto& [name, value] : variables_) setenv(name.c_str(), value.c_str(), 1);
  }
  ~Environment() {
    for (const auto& [name, value] : variables_) unsetenv(name.c_str());
  }

 private:
  std::map<std::string, std::string> variables_;
};

void expect_slice(const TaskSlice& slice, int index, int count) {
  EXPECT_EQ(slice.index, index);
  EXPECT_EQ(slice.count, count);
}

TEST(TaskSlice, IsEverythingWhereNothingSaysOtherwise) { expect_slice(task_slice(-1, -1), 0, 1); }

TEST(TaskSlice, FollowsTheFlagsBeforeTheEngine) {
  const Environment slurm{{"SLURM_ARRAY_TASK_ID", "7"}, {"SLURM_ARRAY_TASK_COUNT", "9"}};
  expect_slice(task_slice(2, 5), 2, 5);
  expect_slice(task_slice(-1, -1), 7, 9);
}

TEST(TaskSlice, FollowsEngines) {
  {
    const Environment slurm{{"SLURM_ARRAY_TASK_ID", "12"},
                            {"SLURM_ARRAY_TASK_MIN", "10"},
                            {"SLURM_ARRAY_TASK_COUNT", "4"}};
    expect_slice(task_slice(-1, -1), 2, 4);
  }
  {
    const Environment kubernetes{{"JOB_COMPLETION_INDEX", "0"}, {"PLEAT_TASK_COUNT", "3"}};
    expect_slice(task_slice(-1, -1), 0, 3);
  }
  const Environment parallel{{"PARALLEL_SEQ", "3"}, {"PLEAT_TASK_COUNT", "3"}};
  expect_slice(task_slice(-1, -1), 2, 3);
}

TEST(TaskSlice, RefusesWhatDoesNotFit) {
  EXPECT_INPUT_ERROR(task_slice(3, 3), "task 3 of 3");
  EXPECT_INPUT_ERROR(task_slice(0, -1), "--task-count");
  EXPECT_INPUT_ERROR(task_slice(-1, 4), "--task-index");
  EXPECT_INPUT_ERROR(task_slice(0, 0), "task 0 of 0");
  {
    const Environment alone{{"JOB_COMPLETION_INDEX", "0"}};
    EXPECT_INPUT_ERROR(task_slice(-1, -1), "PLEAT_TASK_COUNT");
  }
  const Environment wrong{{"SLURM_ARRAY_TASK_ID", "1x"}, {"SLURM_ARRAY_TASK_COUNT", "4"}};
  EXPECT_INPUT_ERROR(task_slice(-1, -1), "SLURM_ARRAY_TASK_ID", "'1x'");
}

}  // namespace
}  // namespace pleat::campaign
