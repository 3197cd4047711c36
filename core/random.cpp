#include "core/random.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "core/provenance.h"

namespace pleat {
namespace {

uint64_t rotate_left(uint64_t x, int k) { return (x << k) | (x >> (64 - k)); }

// Natural logarithm from additions and products alone: the C library's differs between processors.
double portable_log(double x) {
  int exponent;
  double m = std::frexp(x, &exponent);  // [0.5, 1)
  if (m < 0.70710678118654752) {
    m *= 2;
    --exponent;
  }
  const double s = (m - 1) / (m + 1);  // log m = 2 artanh s, |s| < 0.172
  const double s2 = s * s;
  double series = 0;
  for (int k = 23; k >= 1; k -= 2) series = series * s2 + 1.0 / k;
  return exponent * 0.69314718055994531 + 2 * s * series;
}

}  // namespace

// The 256 bits of state are the SHA-256 of seed and name, so that any two streams are unrelated.
RandomStream::RandomStream(uint64_t seed, std::string_view name) {
  std::string bytes;
  for (int k = 0; k < 8; ++k) bytes.push_back(static_cast<char>(seed >> (8 * k)));
  bytes.append(name);
  const std::string digest = sha256(bytes);
  for (int k = 0; k < 4; ++k) state_[k] = std::stoull(digest.substr(16 * k, 16), nullptr, 16);
}

// xoshiro256**: Blackman and Vigna 2021, "Scrambled Linear Pseudorandom Number Generators".
uint64_t RandomStream::next() {
  const uint64_t result = rotate_left(state_[1] * 5, 7) * 9;
  const uint64_t t = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = rotate_left(state_[3], 45);
  return result;
}

double RandomStream::uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }

// Polar method (Marsaglia and Bray 1964): two values a round, the second kept.
double RandomStream::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  double u, v, square;
  do {
    u = 2 * uniform() - 1;
    v = 2 * uniform() - 1;
    square = u * u + v * v;
  } while (square >= 1 || square == 0);
  const double scale = std::sqrt(-2 * portable_log(square) / square);
  spare_ = v * scale;
  has_spare_ = true;
  return u * scale;
}

int64_t RandomStream::below(int64_t bound) {
  const uint64_t n = static_cast<uint64_t>(bound);
  const uint64_t limit = n * (UINT64_MAX / n);  // values from here up would favour small results
  uint64_t value;
  do {
    value = next();
  } while (value >= limit);
  return static_cast<int64_t>(value % n);
}

std::vector<int64_t> RandomStream::permutation(int64_t count) {
  std::vector<int64_t> result(count);
  std::iota(result.begin(), result.end(), 0);
  for (int64_t i = count - 1; i > 0; --i) std::swap(result[i], result[below(i + 1)]);
  return result;
}

}  // namespace pleat
