#include "show/page/line_chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "core/error.h"
#include "show/page/html_text.h"

namespace pleat::show {
namespace {

// The drawing area in the units of the SVG, which are pixels at full width.
constexpr double kWidth = 480, kHeight = 270;
constexpr double kLeft = 54, kRight = 12, kTop = 30, kBottom = 44;
constexpr int kColors = 6;            // classes s0 .. s5 of the style sheet
constexpr size_t kMostPoints = 1600;  // a series of more is thinned, keeping its extremes

struct Axis {
  double low = 0, high = 1;  // of the value, or of its log10
  bool is_log = false;
  std::vector<double> ticks;  // values, not logs

  double position(double value) const {  // 0 .. 1
    return ((is_log ? std::log10(value) : value) - low) / (high - low);
  }
};

bool is_drawn(double x, double y, bool has_log_y) {
  return std::isfinite(x) && std::isfinite(y) && !(has_log_y && y <= 0);
}

Axis make_axis(double low, double high, bool is_log, int tick_count) {
  Axis axis;
  axis.is_log = is_log;
  if (is_log) low = std::log10(low), high = std::log10(high);
  if (!(high - low >
        1e-12 * std::max(std::abs(low), std::abs(high)))) {  // one value: room around it
    const double room = is_log ? 0.5 : (low != 0 ? 0.1 * std::abs(low) : 1);
    low -= room, high += room;
  }
  axis.low = low, axis.high = high;
  if (!is_log) {
    axis.ticks = tick_values(low, high, tick_count);
    return axis;
  }
  // Few decades: 1, 2, 5 times powers of ten. Many: powers alone, at most about tick_count of them.
  const double stride = std::max(1.0, std::ceil((high - low) / tick_count));
  for (double power = std::floor(low); power <= high; power += stride) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      if (factor > 1 && high - low > 2) continue;
      const double tick = factor * std::pow(10, power);
      if (std::log10(tick) >= low - 1e-9 && std::log10(tick) <= high + 1e-9) {
        axis.ticks.push_back(tick);
      }
    }
  }
  return axis;
}

// In each of equally many stretches of points: the lowest and the highest, in their order.
std::vector<size_t> thinned(const Series& series) {
  std::vector<size_t> kept;
  const size_t count = series.y.size();
  if (count <= kMostPoints) {
    for (size_t i = 0; i < count; ++i) kept.push_back(i);
    return kept;
  }
  const size_t buckets = kMostPoints / 2;
  for (size_t b = 0; b < buckets; ++b) {
    const size_t begin = count * b / buckets, end = count * (b + 1) / buckets;
    size_t lowest = begin, highest = begin;
    for (size_t i = begin; i < end; ++i) {
      if (!(series.y[i] >= series.y[lowest])) lowest = i;  // NaN counts as both: the gap stays
      if (!(series.y[i] <= series.y[highest])) highest = i;
    }
    kept.push_back(std::min(lowest, highest));
    if (lowest != highest) kept.push_back(std::max(lowest, highest));
  }
  return kept;
}

std::string coordinate(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

class Plot {
 public:
  Plot(Axis x, Axis y) : x_(std::move(x)), y_(std::move(y)) {}

  double column(double x) const { return kLeft + x_.position(x) * (kWidth - kLeft - kRight); }
  double row(double y) const {
    return kHeight - kBottom - y_.position(y) * (kHeight - kTop - kBottom);
  }

  void draw_axes(std::ostream& out, const LineChart& chart) const {
    for (const double tick : y_.ticks) {
      const std::string y = coordinate(row(tick));
      out << "<line class=\"gridline\" x1=\"" << kLeft << "\" x2=\"" << kWidth - kRight
          << "\" y1=\"" << y << "\" y2=\"" << y
          << "\"/><text class=\"tick\" text-anchor=\"end\" x=\"" << kLeft - 7 << "\" y=\""
          << coordinate(row(tick) + 4) << "\">" << format_number(tick, 4) << "</text>";
    }
    const double bottom = kHeight - kBottom;
    out << "<line class=\"axis\" x1=\"" << kLeft << "\" x2=\"" << kWidth - kRight << "\" y1=\""
        << bottom << "\" y2=\"" << bottom << "\"/>";
    for (const double tick : x_.ticks) {
      const std::string x = coordinate(column(tick));
      out << "<line class=\"axis\" x1=\"" << x << "\" x2=\"" << x << "\" y1=\"" << bottom
          << "\" y2=\"" << bottom + 4 << "\"/><text class=\"tick\" text-anchor=\"middle\" x=\"" << x
          << "\" y=\"" << bottom + 18 << "\">" << format_number(tick, 5) << "</text>";
    }
    out << "<text class=\"label\" text-anchor=\"end\" x=\"" << kWidth - kRight << "\" y=\""
        << kHeight - 8 << "\">" << escape_html(chart.x_label) << "</text>"
        << "<text class=\"label\" x=\"2\" y=\"14\">" << escape_html(chart.y_label) << "</text>";
  }

  void draw_series(std::ostream& out, const Series& series, size_t index, bool has_log_y) const {
    const std::string color = "s" + std::to_string(index % kColors);
    std::string path;
    std::ostringstream dots;
    size_t run = 0;  // points since the last gap
    std::string x, y;
    const auto end_run = [&] {  // a point between gaps has no line, so it gets a dot
      if (run == 1) {
        dots << "<circle class=\"dot " << color << "\" r=\"3\" cx=\"" << x << "\" cy=\"" << y
             << "\"/>";
      }
      run = 0;
    };
    for (const size_t i : thinned(series)) {
      if (!is_drawn(series.x[i], series.y[i], has_log_y)) {
        end_run();
        continue;
      }
      x = coordinate(column(series.x[i])), y = coordinate(row(series.y[i]));
      path += (run++ ? "L" : "M") + x + " " + y;
    }
    end_run();
    out << "<path class=\"line " << color << "\" d=\"" << path << "\"><title>"
        << escape_html(series.name) << "</title></path>" << dots.str();
  }

 private:
  Axis x_, y_;
};

}  // namespace

std::vector<double> tick_values(double low, double high, int count) {
  const double rough = (high - low) / std::max(count, 1);
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= rough * (1 - 1e-9)) step = factor * power;
  }
  std::vector<double> ticks;
  const double first = std::ceil(low / step - 1e-9);
  for (double k = first; k * step <= high + 1e-9 * step && ticks.size() < 64; ++k) {
    ticks.push_back(k == 0 ? 0.0 : k * step);
  }
  return ticks;
}

std::string line_chart_html(const LineChart& chart) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double x_low = kInfinity, x_high = -kInfinity, y_low = kInfinity, y_high = -kInfinity;
  for (const Series& series : chart.series) {
    if (series.x.size() != series.y.size()) {
      throw InputError("chart series " + series.name + " has " + std::to_string(series.x.size()) +
                       " x for " + std::to_string(series.y.size()) + " y");
    }
    for (size_t i = 0; i < series.x.size(); ++i) {
      if (!is_drawn(series.x[i], series.y[i], chart.has_log_y)) continue;
      x_low = std::min(x_low, series.x[i]), x_high = std::max(x_high, series.x[i]);
      y_low = std::min(y_low, series.y[i]), y_high = std::max(y_high, series.y[i]);
    }
  }
  const bool has_points = x_low <= x_high;
  // Heights compare from 0, where the data come near it.
  if (has_points && !chart.has_log_y && y_low > 0 && y_low < 0.5 * y_high) y_low = 0;

  std::ostringstream out;
  out << "<figure class=\"chart\"><svg role=\"img\" viewBox=\"0 0 " << kWidth << ' ' << kHeight
      << "\" aria-label=\"" << escape_html(chart.y_label + " over " + chart.x_label) << "\">";
  if (has_points) {
    const Plot plot(make_axis(x_low, x_high, false, 7),
                    make_axis(y_low, y_high, chart.has_log_y, 6));
    plot.draw_axes(out, chart);
    for (size_t i = 0; i < chart.series.size(); ++i) {
      plot.draw_series(out, chart.series[i], i, chart.has_log_y);
    }
  } else {
    out << "<text class=\"label\" text-anchor=\"middle\" x=\"" << kWidth / 2 << "\" y=\""
        << kHeight / 2 << "\">no data</text>";
  }
  out << "</svg>";
  if (chart.series.size() > 1) {
    out << "<ul class=\"legend\">";
    for (size_t i = 0; i < chart.series.size(); ++i) {
      out << "<li><i class=\"s" << i % kColors << "\"></i>" << escape_html(chart.series[i].name)
          << "</li>";
    }
    out << "</ul>";
  }
  if (!chart.caption.empty())
    out << "<figcaption>" << escape_html(chart.caption) << "</figcaption>";
  out << "</figure>\n";
  return out.str();
}

}  // namespace pleat::show
