#pragma once

namespace pleat::learn {

// How many threads LibTorch computes with, 0: one a core. Results may differ in the last bits
// between numbers.
void use_threads(int threads);

}  // namespace pleat::learn
