#include "core/progress.h"

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <utility>

namespace pleat {
namespace {

volatile std::sig_atomic_t g_is_interrupted = 0;

extern "C" void note_interrupt(int) {
  g_is_interrupted = 1;
  std::signal(SIGINT, SIG_DFL);  // the next one ends the program
  std::signal(SIGTERM, SIG_DFL);
}

double seconds_since(std::chrono::steady_clock::time_point time) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - time).count();
}

}  // namespace

std::string duration_text(double seconds) {
  const int64_t whole = static_cast<int64_t>(seconds + 0.5);
  char text[64];
  if (whole >= 3600) {
    const int64_t minutes = (whole + 30) / 60;
    std::snprintf(text, sizeof text, "%lld h %02lld min", static_cast<long long>(minutes / 60),
                  static_cast<long long>(minutes % 60));
  } else if (whole >= 60) {
    std::snprintf(text, sizeof text, "%lld min %02lld s", static_cast<long long>(whole / 60),
                  static_cast<long long>(whole % 60));
  } else {
    std::snprintf(text, sizeof text, "%lld s", static_cast<long long>(whole));
  }
  return text;
}

Progress::Progress(std::string stage, int64_t total, std::string unit)
    : stage_(std::move(stage)),
      unit_(std::move(unit)),
      total_(total),
      start_(std::chrono::steady_clock::now()),
      last_print_(start_),
      is_terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() { print(/*is_last=*/true); }

void Progress::advance(int64_t count, const std::string& remark) {
  done_ += count;
  if (!remark.empty()) remark_ = remark;
  const double interval = is_terminal_ ? 0.1 : 10.0;  // s
  if (seconds_since(last_print_) >= interval) print(/*is_last=*/false);
}

void Progress::print(bool is_last) {
  last_print_ = std::chrono::steady_clock::now();
  const double elapsed = seconds_since(start_);
  const double rate = elapsed > 0 ? done_ / elapsed : 0;  // 1/s
  std::string line = stage_ + ": " + std::to_string(done_);
  if (total_ > 0) line += " of " + std::to_string(total_);
  line += " " + unit_;
  if (done_ > 0) {
    char text[64];
    if (rate >= 1) {
      std::snprintf(text, sizeof text, ", %.3g a second", rate);
    } else {
      std::snprintf(text, sizeof text, ", %.3g s each", 1 / rate);
    }
    line += text;
  }
  if (is_last) {
    line += ", took " + duration_text(elapsed);
  } else if (done_ > 0 && total_ > done_) {
    line += ", " + duration_text((total_ - done_) / rate) + " left";
  }
  if (!remark_.empty()) line += ", " + remark_;
  if (is_terminal_) {
    std::fprintf(stderr, "\r%s\x1b[K%s", line.c_str(), is_last ? "\n" : "");
  } else {
    std::fprintf(stderr, "%s\n", line.c_str());
  }
  std::fflush(stderr);
}

void catch_interrupts() {
  std::signal(SIGINT, note_interrupt);
  std::signal(SIGTERM, note_interrupt);
}

bool is_interrupted() { return g_is_interrupted != 0; }

}  // namespace pleat
