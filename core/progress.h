// One live line a stage: done, rate, time left. On a terminal it is redrawn; in a log a line every few seconds.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace pleat {

class Progress {
 public:
  Progress(std::string stage, int64_t total, std::string unit);
  ~Progress();  // ends the line
  void advance(int64_t count = 1, const std::string& remark = "");

 private:
  void print(bool is_last);
  std::string stage_, unit_, remark_;
  int64_t total_ = 0, done_ = 0;
  std::chrono::steady_clock::time_point start_, last_print_;
  bool is_terminal_ = false;
};

// "2 h 05 min", "3 min 20 s", "12 s"
std::string duration_text(double seconds);

// Ctrl-C (SIGINT) and SIGTERM: the first asks the loops to stop at the next safe place, the second ends the program.
void catch_interrupts();
bool is_interrupted();

}  // namespace pleat
