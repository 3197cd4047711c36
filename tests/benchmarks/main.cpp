// pleat-bench: speed of the parts, one row a figure. scripts/bench builds and runs it.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/heap.h"
#include "core/profile.h"
#include "core/provenance.h"
#include "tests/benchmarks/bench.h"

namespace pleat::bench {

void Report::time(const std::string& name, int n, const std::function<void()>& action) {
  add({name, "ms", 1e3 * median_seconds(n, action), n});
}

void Report::time_each(const std::string& name, int n, size_t count,
                       const std::function<void()>& action) {
  add({name, "ns", 1e9 / static_cast<double>(count) * median_seconds(n, action), n});
}

void Report::rate(const std::string& name, int n, size_t count,
                  const std::function<void()>& action) {
  add({name, "1/s", static_cast<double>(count) / median_seconds(n, action), n});
}

double Report::median_seconds(int n, const std::function<void()>& action) {
  if (n > 1) action();
  std::vector<double> seconds(n);
  for (double& value : seconds) {
    const auto start = std::chrono::steady_clock::now();
    action();
    value = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  std::sort(seconds.begin(), seconds.end());
  return 0.5 * (seconds[(n - 1) / 2] + seconds[n / 2]);
}

void Report::add(const std::string& name, double value, const std::string& unit) {
  add({name, unit, value, 1});
}

void Report::add(const Row& row) {
  rows_.push_back(row);
  std::printf("%-44s %12.4g %-8s n = %d\n", row.name.c_str(), row.value, row.unit.c_str(), row.n);
  std::fflush(stdout);
}

}  // namespace pleat::bench

int main(int argc, char** argv) try {
  pleat::enter_profile("native", argv);
  pleat::give_large_blocks_back();  // as `pleat` does
  using pleat::bench::Report;
  const std::map<std::string, void (*)(Report&)> areas = {
#ifdef PLEAT_BENCH_LEARN
      {"learn", pleat::bench::bench_learn},
#else
      {"campaign", pleat::bench::bench_campaign},
      {"codec", pleat::bench::bench_codec},
      {"core", pleat::bench::bench_core},
      {"sim", pleat::bench::bench_sim},
#endif
  };
  std::string json_path, area;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    if (argument == "--json" && k + 1 < argc) {
      json_path = argv[++k];
    } else if (area.empty() && areas.count(argument) > 0) {
      area = argument;
    } else {
      std::string names;
      for (const auto& [name, run] : areas) names += (names.empty() ? "" : "|") + name;
      std::fprintf(stderr, "usage: pleat-bench [%s] [--json OUT]\n", names.c_str());
      return 2;
    }
  }

  Report report;
  for (const auto& [name, run] : areas) {
    if (area.empty() || area == name) run(report);
  }
  if (!json_path.empty()) {
    nlohmann::json rows = nlohmann::json::array();
    for (const pleat::bench::Row& row : report.rows()) {
      rows.push_back({{"name", row.name},
                      {"value", row.value},
                      {"unit", row.unit},
                      {"n", row.n},
                      {"machine", pleat::machine()}});
    }
    pleat::write_file_atomically(json_path, rows.dump(2) + "\n");
  }
  return 0;
} catch (const pleat::InputError& error) {
  std::fprintf(stderr, "pleat-bench: %s\n", error.what());
  return 2;
}
