#include "core/guarded_read.h"

#include <signal.h>
#include <unistd.h>

#include <cstring>

namespace pleat {
namespace {

thread_local const char* now_read = nullptr;

int out_of_time() { return SIGRTMIN + 5; }

// Only what a signal handler may call.
void give_up(const char* path, const char* why) {
  for (const char* text : {path, ": given up: ", why, "; it is damaged, or made to\n"})
    if (write(STDERR_FILENO, text, std::strlen(text)) < 0) break;
  _exit(2);
}

void on_time(int, siginfo_t* info, void*) {
  give_up(static_cast<const char*>(info->si_value.sival_ptr), "it takes too long to read");
}

void on_crash(int number, siginfo_t*, void*) {
  if (now_read) give_up(now_read, "the library that reads it has crashed");
  signal(number, SIG_DFL);  // another's fault: it happens again, and ends as ever
}

bool set_handlers() {
  struct sigaction action = {};
  action.sa_flags = SA_SIGINFO;
  action.sa_sigaction = on_crash;
  if (sigaction(SIGSEGV, &action, nullptr) != 0 || sigaction(SIGBUS, &action, nullptr) != 0)
    return false;
  action.sa_sigaction = on_time;
  return sigaction(out_of_time(), &action, nullptr) == 0;
}

}  // namespace

GuardedRead::GuardedRead(const std::string& path, double seconds) : outer_(now_read) {
  static const bool is_ready = set_handlers();
  now_read = path.c_str();
  sigevent event = {};
  event.sigev_notify = SIGEV_SIGNAL;
  event.sigev_signo = out_of_time();
  event.sigev_value.sival_ptr = const_cast<char*>(path.c_str());
  is_set_ = is_ready && timer_create(CLOCK_THREAD_CPUTIME_ID, &event, &timer_) == 0;
  if (!is_set_) return;  // no timers left: it has to be endured
  itimerspec time = {};
  time.it_value.tv_sec = static_cast<time_t>(seconds);
  time.it_value.tv_nsec =
      static_cast<long>(1e9 * (seconds - static_cast<double>(time.it_value.tv_sec)));
  timer_settime(timer_, 0, &time, nullptr);
}

GuardedRead::~GuardedRead() {
  if (is_set_) timer_delete(timer_);
  now_read = outer_;
}

}  // namespace pleat
