// Many tasks, one thread each, within the bounds that the user sets.
#pragma once

#include <atomic>
#include <functional>

namespace pleat::campaign {

struct Limits {                      // section `limits`; no drape depends on them
  double max_seconds_per_drape = 0;  // processor time; 0: any
  int max_memory_mb = 0;             // of the process; 0: any
  int min_free_disk_mb = 200;        // stop while so much is left
};
void validate(const Limits& limits);

class Crew {
 public:
  // threads 0: all cores, and no more than max_memory_mb lets.
  Crew(int threads, const Limits& limits, int garment_vertices);

  // task(0) .. task(count - 1), until all are done, the user interrupts, or one throws; that is
  // then thrown here, bad_alloc as ResourceError.
  void run(int count, const std::function<void(int)>& task);

  // For tasks to ask now and then.
  bool should_stop() const;

 private:
  int threads_ = 1;
  std::atomic<bool> has_failed_ = false;
};

}  // namespace pleat::campaign
