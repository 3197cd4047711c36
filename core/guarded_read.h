// An end to what a library would do with a file that was made to harm it.
#pragma once

#include <ctime>
#include <string>

namespace pleat {

// While one lives, its thread may compute for so many seconds and must not crash; else the process
// names the file on stderr and ends with exit code 2. For libraries that a damaged or hostile file
// can send round in circles or out of bounds, where no exception leads back. `path` must outlive
// it. The first one sets the process's handlers of SIGSEGV, SIGBUS and one real-time signal.
class GuardedRead {
 public:
  GuardedRead(const std::string& path, double seconds);
  ~GuardedRead();
  GuardedRead(const GuardedRead&) = delete;
  GuardedRead& operator=(const GuardedRead&) = delete;

 private:
  const char* outer_;  // path of the one around it
  timer_t timer_;
  bool is_set_;
};

}  // namespace pleat
