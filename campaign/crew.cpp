#include "campaign/crew.h"

#include <omp.h>
#include <sys/resource.h>

#include <algorithm>
#include <exception>
#include <mutex>
#include <new>

#include "core/error.h"
#include "core/progress.h"

namespace pleat::campaign {

void validate(const Limits& limits) {
  if (!(limits.max_seconds_per_drape >= 0))
    throw InputError("limits.max_seconds_per_drape must be >= 0 (0: any)");
  if (limits.max_memory_mb < 0) throw InputError("limits.max_memory_mb must be >= 0 (0: any)");
  if (limits.min_free_disk_mb < 0) throw InputError("limits.min_free_disk_mb must be >= 0");
}

Crew::Crew(int threads, const Limits& limits, int garment_vertices)
    : threads_(threads > 0 ? threads : omp_get_num_procs()) {
  if (limits.max_memory_mb == 0) return;
  const double shared = 250, of_a_chain = 0.025 * garment_vertices;  // MB: docs/campaigns.md
  threads_ =
      std::clamp(static_cast<int>((limits.max_memory_mb - shared) / of_a_chain), 1, threads_);
  rlimit bound{};
  ::getrlimit(RLIMIT_DATA, &bound);
  bound.rlim_cur = std::min(bound.rlim_max, static_cast<rlim_t>(limits.max_memory_mb) * 1000000);
  ::setrlimit(RLIMIT_DATA, &bound);
}

void Crew::run(int count, const std::function<void(int)>& task) {
  std::exception_ptr failure;
  std::mutex mutex;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads_)
  for (int i = 0; i < count; ++i) {
    if (should_stop()) continue;
    try {
      task(i);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (!failure) failure = std::current_exception();
      has_failed_ = true;
    }
  }
  if (!failure) return;
  try {
    std::rethrow_exception(failure);
  } catch (const std::bad_alloc&) {
    throw ResourceError(
        "memory is short; raise limits.max_memory_mb or lower `threads`, and give the same command "
        "again");
  }
}

bool Crew::should_stop() const { return has_failed_ || is_interrupted(); }

}  // namespace pleat::campaign
