#include "learn/threads.h"

#include <ATen/Parallel.h>

#include <algorithm>
#include <thread>

namespace pleat::learn {

void use_threads(int threads) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  at::set_num_threads(threads > 0 ? threads : cores);
}

}  // namespace pleat::learn
