#include "app/lists.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "core/error.h"
#include "core/number_text.h"
#include "core/random.h"

namespace pleat::app {
namespace {

[[noreturn]] void refuse(const std::string& key, const std::string& value,
                         const std::string& expected) {
  throw InputError(key + " = " + value + "; expected " + expected);
}

void check_count(const std::string& key, int64_t count, int64_t most) {
  if (count < 1 || count > most) refuse(key, std::to_string(count), "1 .. " + std::to_string(most));
}

void check_numbers(const std::string& key, int64_t shapes, int64_t betas) {
  if (shapes * betas > kMostNumbers)
    throw InputError(key + ": " + std::to_string(shapes) + " shapes of " + std::to_string(betas) +
                     " betas; expected at most " + std::to_string(kMostNumbers) +
                     " betas altogether");
}

void check_axis(const std::string& key, std::vector<double> values, double low, double high) {
  if (values.empty()) throw InputError(key + ": the list is empty; give at least one value");
  for (double value : values)
    if (!(value >= low && value <= high))
      refuse(key, shortest_text(value), shortest_text(low) + " .. " + shortest_text(high));
  std::sort(values.begin(), values.end());
  const auto twice = std::adjacent_find(values.begin(), values.end());
  if (twice != values.end())
    throw InputError(key + ": " + shortest_text(*twice) + " is given twice");
}

void check_range(const std::string& key, const garment::Range& range) {
  if (!(range.low >= 0 && range.low <= range.high && range.high <= 1))
    refuse(key, "[" + shortest_text(range.low) + ", " + shortest_text(range.high) + "]",
           "[low, high] with 0 <= low <= high <= 1");
}

int64_t combination_count(const std::string& key, const std::vector<std::vector<double>>& axes) {
  int64_t count = 1;
  for (const std::vector<double>& axis : axes) {
    count *= static_cast<int64_t>(axis.size());
    if (count > kMostItems)
      throw InputError(key + ": has more than " + std::to_string(kMostItems) + " combinations");
  }
  return count;
}

// Counts through the axes as through digits, the last one fastest.
std::vector<std::vector<double>> combinations(const std::vector<std::vector<double>>& axes,
                                              int64_t count) {
  std::vector<std::vector<double>> result(count, std::vector<double>(axes.size()));
  for (int64_t i = 0; i < count; ++i) {
    int64_t rest = i;
    for (size_t a = axes.size(); a-- > 0;) {
      const auto size = static_cast<int64_t>(axes[a].size());
      result[i][a] = axes[a][rest % size];
      rest /= size;
    }
  }
  return result;
}

double draw_uniform(RandomStream& random, const garment::Range& range) {
  return std::min(range.low + random.uniform() * (range.high - range.low), range.high);
}

double draw_normal(RandomStream& random, double sigma, double limit) {
  double value;
  do {
    value = sigma * random.normal();
  } while (std::abs(value) > limit);
  return value;
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// AMASS keeps a subject's shape and its first stage of fitting beside the motions.
bool is_motion(const std::filesystem::path& path) {
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  const std::string extension = std::filesystem::path(name).extension().string();
  if (extension != ".npz") return extension == ".bvh";
  return name != "shape.npz" && !ends_with(name, "_stagei.npz");
}

std::vector<MotionEntry> find_motions(const std::string& folder) {
  namespace fs = std::filesystem;
  std::vector<MotionEntry> motions;
  std::error_code error, ignored;
  for (fs::recursive_directory_iterator file(folder, error), end; !error && file != end;
       file.increment(error)) {
    if (!is_motion(file->path()) || file->is_directory(ignored)) continue;
    MotionEntry motion;
    motion.file = file->path().string();
    motion.name = file->path().lexically_relative(folder).replace_extension().generic_string();
    motions.push_back(motion);
    if (motions.size() > kMostItems)
      throw InputError("motions.folder: " + folder + ": holds more than " +
                       std::to_string(kMostItems) + " motions");
  }
  if (error) throw InputError("motions.folder: " + folder + ": " + error.message());
  return motions;
}

// motions: sorted by name.
void hold_out(std::vector<MotionEntry>& motions, const MotionFolder& folder) {
  for (const std::string& name : folder.held_out) {
    const auto motion =
        std::lower_bound(motions.begin(), motions.end(), name,
                         [](const MotionEntry& m, const std::string& n) { return m.name < n; });
    if (motion == motions.end() || motion->name != name)
      throw InputError("motions.held_out: " + folder.folder + " has no motion '" + name +
                       "'; names are paths from there without the ending, such as '" +
                       motions.front().name + "'");
    motion->held_out = true;
  }
}

}  // namespace

std::vector<garment::Design> designs_of(const DesignGrid& grid) {
  check_axis("designs.grid.length", grid.length, 0, 1);
  check_axis("designs.grid.sleeve", grid.sleeve, 0, 1);
  check_axis("designs.grid.cleavage", grid.cleavage, 0, 1);
  const std::vector<std::vector<double>> axes = {grid.length, grid.sleeve, grid.cleavage};
  std::vector<garment::Design> designs;
  for (const std::vector<double>& p : combinations(axes, combination_count("designs.grid", axes)))
    designs.push_back(
        {"l" + shortest_text(p[0]) + "_s" + shortest_text(p[1]) + "_c" + shortest_text(p[2]), p[0],
         p[1], p[2], false});
  return designs;
}

std::vector<garment::Design> designs_of(const RandomDesigns& random, uint64_t seed) {
  check_count("designs.random.count", random.count, kMostItems);
  check_range("designs.random.length", random.length);
  check_range("designs.random.sleeve", random.sleeve);
  check_range("designs.random.cleavage", random.cleavage);
  if (random.held_out < 0 || random.held_out >= random.count)
    refuse("designs.random.held_out", std::to_string(random.held_out),
           "0 or more, but less than count");
  std::vector<garment::Design> designs(random.count);
  for (int k = 0; k < random.count; ++k) {
    RandomStream stream(seed, "design/" + std::to_string(k));
    designs[k].name = "random_" + std::to_string(k);
    designs[k].length = draw_uniform(stream, random.length);
    designs[k].sleeve = draw_uniform(stream, random.sleeve);
    designs[k].cleavage = draw_uniform(stream, random.cleavage);
    designs[k].is_held_out = k < random.held_out;
  }
  return designs;
}

std::vector<std::vector<double>> shapes_of(const ShapeGrid& grid) {
  if (grid.betas.empty())
    throw InputError("shapes.grid.betas: the list is empty; give a list of values for each beta");
  for (size_t b = 0; b < grid.betas.size(); ++b)
    check_axis("shapes.grid.betas[" + std::to_string(b) + "]", grid.betas[b], -kMostBeta,
               kMostBeta);
  const int64_t count = combination_count("shapes.grid", grid.betas);
  check_numbers("shapes.grid", count, static_cast<int64_t>(grid.betas.size()));
  return combinations(grid.betas, count);
}

std::vector<std::vector<double>> shapes_of(const RandomShapes& random, uint64_t seed) {
  check_count("shapes.random.count", random.count, kMostItems);
  check_count("shapes.random.betas", random.betas, kMostNumbers);
  check_numbers("shapes.random", random.count, random.betas);
  if (!(random.sigma > 0 && std::isfinite(random.sigma)))
    refuse("shapes.random.sigma", shortest_text(random.sigma), "> 0");
  if (!(random.limit >= random.sigma / 10 && random.limit <= kMostBeta))  // one draw in 12 is kept
    refuse("shapes.random.limit", shortest_text(random.limit),
           "sigma / 10 .. " + shortest_text(kMostBeta));
  std::vector<std::vector<double>> shapes(random.count, std::vector<double>(random.betas));
  for (int k = 0; k < random.count; ++k) {
    RandomStream stream(seed, "shape/" + std::to_string(k));
    for (double& beta : shapes[k]) beta = draw_normal(stream, random.sigma, random.limit);
  }
  return shapes;
}

std::vector<MotionEntry> motions_of(const MotionFolder& folder) {
  std::vector<MotionEntry> motions = find_motions(folder.folder);
  if (motions.empty())
    throw InputError("motions.folder: " + folder.folder + ": holds no AMASS .npz or .bvh file");
  std::sort(motions.begin(), motions.end(),
            [](const MotionEntry& a, const MotionEntry& b) { return a.name < b.name; });
  const auto twice = std::adjacent_find(
      motions.begin(), motions.end(),
      [](const MotionEntry& a, const MotionEntry& b) { return a.name == b.name; });
  if (twice != motions.end())
    throw InputError("motions.folder: " + folder.folder + ": two files of the name '" +
                     twice->name + "' differ in their ending only; keep one");
  hold_out(motions, folder);
  return motions;
}

}  // namespace pleat::app
