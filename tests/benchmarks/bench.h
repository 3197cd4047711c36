// What the areas of the benchmark report to.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace pleat::bench {

struct Row {
  std::string name, unit;
  double value = 0;  // median of n repeats, or a single figure
  int n = 1;
};

class Report {
 public:
  // Runs `action` n times on the clock, after one to warm up where n > 1. Row in ms.
  void time(const std::string& name, int n, const std::function<void()>& action);
  // The same of an action on `count` things; row in ns each.
  void time_each(const std::string& name, int n, size_t count, const std::function<void()>& action);
  // The same of an action on `count` things; row in things a second.
  void rate(const std::string& name, int n, size_t count, const std::function<void()>& action);
  void add(const std::string& name, double value, const std::string& unit);
  const std::vector<Row>& rows() const { return rows_; }

 private:
  double median_seconds(int n, const std::function<void()>& action);
  void add(const Row& row);
  std::vector<Row> rows_;
};

void bench_campaign(Report& report);
void bench_core(Report& report);
void bench_sim(Report& report);
void bench_codec(Report& report);
void bench_learn(Report& report);

}  // namespace pleat::bench
