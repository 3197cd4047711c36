#include "core/patience.h"

#include <signal.h>
#include <unistd.h>

#include <cstring>

namespace pleat {
namespace {

int signal_number() { return SIGRTMIN + 5; }

// Only what a signal handler may call.
void say(const char* text) {
  if (write(STDERR_FILENO, text, std::strlen(text)) < 0) return;
}

void give_up(int, siginfo_t* info, void*) {
  say(static_cast<const char*>(info->si_value.sival_ptr));
  say(": given up: it takes too long to read; it is damaged, or made to\n");
  _exit(2);
}

}  // namespace

Patience::Patience(const std::string& path, double seconds) {
  static const bool is_ready = [] {
    struct sigaction action = {};
    action.sa_sigaction = give_up;
    action.sa_flags = SA_SIGINFO;
    return sigaction(signal_number(), &action, nullptr) == 0;
  }();
  sigevent event = {};
  event.sigev_notify = SIGEV_SIGNAL;
  event.sigev_signo = signal_number();
  event.sigev_value.sival_ptr = const_cast<char*>(path.c_str());
  is_set_ = is_ready && timer_create(CLOCK_THREAD_CPUTIME_ID, &event, &timer_) == 0;
  if (!is_set_) return;  // no timers left: it has to be endured
  itimerspec time = {};
  time.it_value.tv_sec = static_cast<time_t>(seconds);
  time.it_value.tv_nsec =
      static_cast<long>(1e9 * (seconds - static_cast<double>(time.it_value.tv_sec)));
  timer_settime(timer_, 0, &time, nullptr);
}

Patience::~Patience() {
  if (is_set_) timer_delete(timer_);
}

}  // namespace pleat
