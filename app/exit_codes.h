// What the program's exit codes say to who or what started it. docs/campaigns.md.
#pragma once

namespace pleat::app {

constexpr int kDone = 0;
constexpr int kFailed = 1;         // something did not come out: the message says what
constexpr int kBadInput = 2;       // the same again would end the same
constexpr int kTryAgain = 75;      // disk or memory is short: the same again, later, goes on
constexpr int kInterrupted = 130;  // the same again goes on

}  // namespace pleat::app
