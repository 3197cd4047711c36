#include "campaign/task_slice.h"

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>

#include "core/error.h"

namespace pleat::campaign {
namespace {

std::optional<int> from_environment(const char* name) {
  const char* text = std::getenv(name);
  if (!text || !*text) return std::nullopt;
  int number = 0;
  const char* end = text + std::strlen(text);
  const auto [at, error] = std::from_chars(text, end, number);
  if (error != std::errc() || at != end)
    throw InputError(std::string(name) + " = '" + text + "'; expected a whole number");
  return number;
}

int needed(const char* name, const std::string& why) {
  const std::optional<int> number = from_environment(name);
  if (!number) throw InputError(std::string(name) + " is not set; " + why);
  return *number;
}

TaskSlice checked(TaskSlice slice, const std::string& source) {
  if (slice.count < 1 || slice.index < 0 || slice.index >= slice.count)
    throw InputError(source + ": task " + std::to_string(slice.index) + " of " +
                     std::to_string(slice.count) + "; expected 0 <= index < count");
  return slice;
}

}  // namespace

TaskSlice task_slice(int index, int count) {
  if (index >= 0 || count >= 0) {
    if (index < 0 || count < 0)
      throw InputError("--task-index and --task-count go together; give both or none");
    return checked({index, count}, "--task-index, --task-count");
  }
  const std::string why = "say how many tasks there are";
  if (const auto id = from_environment("SLURM_ARRAY_TASK_ID")) {
    const int first = from_environment("SLURM_ARRAY_TASK_MIN").value_or(0);
    return checked({*id - first, needed("SLURM_ARRAY_TASK_COUNT", why)}, "SLURM_ARRAY_TASK_ID");
  }
  if (const auto completion = from_environment("JOB_COMPLETION_INDEX"))
    return checked({*completion, needed("PLEAT_TASK_COUNT", why)}, "JOB_COMPLETION_INDEX");
  if (const auto sequence = from_environment("PARALLEL_SEQ"))
    return checked({*sequence - 1, needed("PLEAT_TASK_COUNT", why)}, "PARALLEL_SEQ");
  return {};
}

}  // namespace pleat::campaign
