// An end to what a library would do for ever.
#pragma once

#include <ctime>
#include <string>

namespace pleat {

// While one lives, its thread may compute for so many seconds; then the process names the file on
// stderr and ends with exit code 2. For libraries that a damaged or hostile file can send round in
// circles, out of which no exception leads. `path` must outlive it.
class Patience {
 public:
  Patience(const std::string& path, double seconds);
  ~Patience();
  Patience(const Patience&) = delete;
  Patience& operator=(const Patience&) = delete;

 private:
  timer_t timer_;
  bool is_set_;
};

}  // namespace pleat
